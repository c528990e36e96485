/* SPDX-License-Identifier: Apache-2.0 */
#include "thread.h"

#include <pthread.h>
#include <stddef.h>
#include <string.h>
#include <time.h>

#include "clock.h"

_Static_assert(sizeof(pthread_t) <= sizeof(((struct os_thread *)0)->state) &&
                   sizeof(pthread_mutex_t) <= sizeof(struct os_lock) &&
                   sizeof(pthread_cond_t) <= sizeof(struct os_condition),
               "what the system has fits into our structs");

static pthread_mutex_t *mutex_of(struct os_lock *lock)
{
    return (pthread_mutex_t *)(void *)lock->state;
}

static pthread_cond_t *cond_of(struct os_condition *condition)
{
    return (pthread_cond_t *)(void *)condition->state;
}

static void *run(void *user)
{
    const struct os_thread *thread = user;
    thread->work(thread->user);
    return NULL;
}

int os_thread_start(struct os_thread *thread, void (*work)(void *user), void *user)
{
    pthread_t id;
    thread->work = work;
    thread->user = user;
    const int number = pthread_create(&id, NULL, run, thread);
    if (number == 0)
        memcpy(thread->state, &id, sizeof(id));
    return number;
}

void os_thread_join(struct os_thread *thread)
{
    pthread_t id;
    memcpy(&id, thread->state, sizeof(id));
    pthread_join(id, NULL);
}

void os_lock_init(struct os_lock *lock)
{
    pthread_mutex_init(mutex_of(lock), NULL);
}

void os_lock_destroy(struct os_lock *lock)
{
    pthread_mutex_destroy(mutex_of(lock));
}

void os_lock_take(struct os_lock *lock)
{
    pthread_mutex_lock(mutex_of(lock));
}

void os_lock_release(struct os_lock *lock)
{
    pthread_mutex_unlock(mutex_of(lock));
}

void os_condition_init(struct os_condition *condition)
{
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
#ifndef __APPLE__ /* has no such function; os_condition_wait_until() does without */
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
#endif
    pthread_cond_init(cond_of(condition), &attributes);
    pthread_condattr_destroy(&attributes);
}

void os_condition_destroy(struct os_condition *condition)
{
    pthread_cond_destroy(cond_of(condition));
}

void os_condition_wait(struct os_condition *condition, struct os_lock *lock)
{
    pthread_cond_wait(cond_of(condition), mutex_of(lock));
}

static struct timespec time_of(double seconds)
{
    const time_t whole = (time_t)seconds;
    return (struct timespec){whole, (long)(1e9 * (seconds - (double)whole))};
}

bool os_condition_wait_until(struct os_condition *condition, struct os_lock *lock,
                             double until_s)
{
#ifdef __APPLE__
    const double left_s = until_s - os_clock_s();
    const struct timespec left = time_of(left_s > 0 ? left_s : 0);
    return pthread_cond_timedwait_relative_np(cond_of(condition), mutex_of(lock),
                                              &left) == 0;
#else
    const struct timespec until = time_of(until_s);
    return pthread_cond_timedwait(cond_of(condition), mutex_of(lock), &until) == 0;
#endif
}

void os_condition_wake_all(struct os_condition *condition)
{
    pthread_cond_broadcast(cond_of(condition));
}
