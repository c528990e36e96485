/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for the window. */
#ifndef VIEW_MEMORY_H
#define VIEW_MEMORY_H

#include <stddef.h>

/* Memory of n_items * item_bytes, zeroed; says so and ends the program where there is
 * none. */
void *need_memory(size_t n_items, size_t item_bytes);

#endif
