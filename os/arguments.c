/* SPDX-License-Identifier: Apache-2.0 */
#include "arguments.h"

#include <errno.h>
#include <fcntl.h>
#include <unistd.h>

/*
 * A file, or the pipe of signals, that got number 0 to 2 would be read as the picture or
 * written over by messages. The null device is opened the wrong way round, so that who
 * reads or writes there is told: EBADF.
 */
static void open_closed_streams(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
        if (fcntl(fd, F_GETFD) >= 0 || errno != EBADF)
            continue;
        /* The lowest free number is this one: those below are open. */
        if (open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0)
            return; /* no null device: as the caller left it */
    }
}

char **os_arguments(int *argc, char **argv)
{
    (void)argc;
    open_closed_streams();
    return argv;
}
