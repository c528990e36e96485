/* SPDX-License-Identifier: Apache-2.0 */
#include "arguments.h"

#include <fcntl.h>
#include <io.h>
#include <stdio.h>
#include <stdlib.h>

#include "wide.h"

#include <shellapi.h> /* after windows.h */

/* Pictures and text leave as bytes, the same as elsewhere. */
static void use_bytes(void)
{
    FILE *const streams[] = {stdin, stdout, stderr};
    for (int i = 0; i < 3; i++)
        _setmode(_fileno(streams[i]), _O_BINARY);
    SetConsoleOutputCP(CP_UTF8);
}

char **os_arguments(int *argc, char **argv)
{
    int n = 0;
    use_bytes();
    wchar_t **wide = CommandLineToArgvW(GetCommandLineW(), &n);
    char **arguments = wide ? calloc((size_t)n + 1, sizeof(*arguments)) : NULL;
    bool is_complete = arguments != NULL;
    for (int i = 0; i < n && is_complete; i++)
        is_complete = (arguments[i] = os_narrow_text(wide[i])) != NULL;
    LocalFree(wide);
    if (!is_complete) {
        free(arguments);
        return argv;
    }
    *argc = n;
    return arguments;
}
