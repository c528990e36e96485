/* SPDX-License-Identifier: Apache-2.0 */
/* Work that never asks whether it was interrupted, with a file and a folder open. */
#include <stdio.h>

#include "clock.h"
#include "folder.h"
#include "image.h"
#include "interrupt.h"
#include "replace.h"

int main(int argc, char **argv)
{
    char folder[4096], prefix[4096];
    struct os_replace file;
    os_interrupt_catch();
    snprintf(prefix, sizeof(prefix), "%.4000s/temporary-", argv[1]);
    snprintf(folder, sizeof(folder), "%.4000s/out.exr", argv[1]);
    if (argc != 2 || os_replace_open(&file, folder) != 0 ||
        os_folder_make_temporary(prefix, folder, sizeof(folder)) != 0)
        return 1;
    puts("ready");
    fflush(stdout);
    for (;;)
        os_sleep_s(1);
}
