/* SPDX-License-Identifier: Apache-2.0 */
#include "clean_up.h"

#include "folder.h"
#include "process.h"
#include "replace.h"

void os_clean_up(void)
{
    os_process_end_all(); /* first: they write into the folders */
    os_replace_remove_all();
    os_folder_remove_all();
}
