/* SPDX-License-Identifier: Apache-2.0 */
#include "memory.h"

#include <stdio.h>
#include <stdlib.h>

#include "report.h"

void *need_memory(size_t n_items, size_t item_bytes)
{
    struct image_error error;
    void *memory = app_memory(n_items, item_bytes, &error);
    if (!memory) {
        fprintf(stderr, "rackfocus: %s\n", error.message);
        exit(1);
    }
    return memory;
}
