/* SPDX-License-Identifier: Apache-2.0 */
/* Work that another thread may end early. */
#ifndef APP_STOP_H
#define APP_STOP_H

#include <stdbool.h>
#include <stddef.h>

/* `stop` is what the other thread sets; NULL: none does. */
static inline bool is_stopped(const bool *stop)
{
    return stop != NULL && __atomic_load_n(stop, __ATOMIC_RELAXED);
}

#endif
