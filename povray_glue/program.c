/* SPDX-License-Identifier: Apache-2.0 */
#include "program.h"

#include <stddef.h>
#include <string.h>
#include <strings.h>

#include "path.h"

/* Debian's; those of POV-Ray for Windows, whose installer leaves the PATH alone. */
static const char *const names[] = {
    "povray",
    "pvengine64",
    "pvengine",
    "C:/Program Files/POV-Ray/v3.7/bin/pvengine64.exe",
    "C:/Program Files/POV-Ray/v3.7/bin/pvengine.exe",
};

const char *program_name(const char *chosen, int i)
{
    if (chosen)
        return i == 0 ? chosen : NULL;
    return i < (int)(sizeof names / sizeof names[0]) ? names[i] : NULL;
}

bool program_has_window(const char *name)
{
    return strncasecmp(os_path_name(name), "pvengine", strlen("pvengine")) == 0;
}
