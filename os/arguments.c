/* SPDX-License-Identifier: Apache-2.0 */
#include "arguments.h"

char **os_arguments(int *argc, char **argv)
{
    (void)argc;
    return argv;
}
