/* SPDX-License-Identifier: Apache-2.0 */
/* Threads, and how they wait for each other. */
#ifndef OS_THREAD_H
#define OS_THREAD_H

#include <stdbool.h>

/* None of these may be copied or moved between its begin and its end. */

struct os_thread {
    void *state[2]; /* the system's */
    void (*work)(void *user);
    void *user;
};

/* Runs work(user) on a thread of its own. 0 or errno; join it where it is 0. */
int os_thread_start(struct os_thread *thread, void (*work)(void *user), void *user);

/* Waits for its end. */
void os_thread_join(struct os_thread *thread);

/* What one thread holds at a time; not taken twice by the same. */
struct os_lock {
    void *state[8];
};

void os_lock_init(struct os_lock *lock);
void os_lock_destroy(struct os_lock *lock);
void os_lock_take(struct os_lock *lock);
void os_lock_release(struct os_lock *lock);

/* Threads wait for it with a lock, and look again at what they wait for when they are
 * woken: that may also happen for no reason. */
struct os_condition {
    void *state[8];
};

void os_condition_init(struct os_condition *condition);
void os_condition_destroy(struct os_condition *condition);

/* Releases the lock, waits, takes it again. */
void os_condition_wait(struct os_condition *condition, struct os_lock *lock);

/* The same until a time of os_clock_s(); false where that has passed. */
bool os_condition_wait_until(struct os_condition *condition, struct os_lock *lock,
                             double until_s);

/* Wakes all that wait. */
void os_condition_wake_all(struct os_condition *condition);

#endif
