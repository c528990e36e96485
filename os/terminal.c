/* SPDX-License-Identifier: Apache-2.0 */
#include "terminal.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

/* os_arguments() opens the null device in place of a closed one, for the other way. */
bool os_stream_is_open(FILE *stream)
{
    const int mode = fcntl(fileno(stream), F_GETFL);
    const int wrong = stream == stdin ? O_WRONLY : O_RDONLY;
    return mode >= 0 && (mode & O_ACCMODE) != wrong;
}

bool os_terminal_is_one(FILE *stream)
{
    return isatty(fileno(stream));
}

bool os_terminal_is_live(FILE *stream)
{
    const char *kind = getenv("TERM");
    return os_terminal_is_one(stream) && kind && *kind && strcmp(kind, "dumb") != 0;
}

int os_terminal_columns(FILE *stream)
{
    struct winsize size;
    if (ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
        return size.ws_col;
    return 80;
}
