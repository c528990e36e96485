/* SPDX-License-Identifier: Apache-2.0 */
#include "terminal.h"

#include <io.h>
#include <stdlib.h>

#include "wide.h"

static HANDLE handle_of(FILE *stream)
{
    return (HANDLE)_get_osfhandle(_fileno(stream));
}

/* -2 where the process has none; no file that is opened gets its number. */
bool os_stream_is_open(FILE *stream)
{
    const int fd = _fileno(stream);
    return fd >= 0 && _get_osfhandle(fd) >= 0;
}

/* _isatty() takes NUL for one, too. */
bool os_terminal_is_one(FILE *stream)
{
    DWORD mode;
    return GetConsoleMode(handle_of(stream), &mode) != 0;
}

bool os_terminal_is_live(FILE *stream)
{
    const DWORD escapes = 4; /* ENABLE_VIRTUAL_TERMINAL_PROCESSING, Windows 10 */
    DWORD mode;
    return GetConsoleMode(handle_of(stream), &mode) != 0 &&
           SetConsoleMode(handle_of(stream), mode | escapes) != 0;
}

int os_terminal_columns(FILE *stream)
{
    CONSOLE_SCREEN_BUFFER_INFO info;
    if (GetConsoleScreenBufferInfo(handle_of(stream), &info))
        return info.srWindow.Right - info.srWindow.Left + 1;
    return 80;
}
