/* SPDX-License-Identifier: Apache-2.0 */
#include "clean_up.h"

#include <errno.h>
#include <pthread.h>
#include <stddef.h>

#include "leftovers.h"
#include "process.h"
#include "replace.h"
#include "unfilled.h"

enum { MOST_OTHERS = 4 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static void (*others[MOST_OTHERS])(void);

int os_clean_up_also(void (*clean_up)(void))
{
    pthread_mutex_lock(&lock);
    int i = 0;
    while (i < MOST_OTHERS && others[i] && others[i] != clean_up)
        i++;
    if (i < MOST_OTHERS)
        others[i] = clean_up;
    pthread_mutex_unlock(&lock);
    return i < MOST_OTHERS ? 0 : ENOMEM;
}

void os_clean_up(void)
{
    for (int i = 0; i < MOST_OTHERS; i++)
        if (others[i])
            others[i]();
    os_process_end_all(); /* first: they write into the folders */
    os_replace_remove_all();
    os_leftovers_remove_own();
    os_unfilled_remove(); /* last: of half files, too, they are empty now */
}
