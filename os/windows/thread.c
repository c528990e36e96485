/* SPDX-License-Identifier: Apache-2.0 */
#include "thread.h"

#include "clock.h"
#include "wide.h"

_Static_assert(sizeof(SRWLOCK) <= sizeof(struct os_lock) &&
                   sizeof(CONDITION_VARIABLE) <= sizeof(struct os_condition),
               "what the system has fits into our structs");

static SRWLOCK *lock_of(struct os_lock *lock)
{
    return (SRWLOCK *)(void *)lock->state;
}

static CONDITION_VARIABLE *variable_of(struct os_condition *condition)
{
    return (CONDITION_VARIABLE *)(void *)condition->state;
}

static DWORD WINAPI run(void *user)
{
    const struct os_thread *thread = user;
    thread->work(thread->user);
    return 0;
}

int os_thread_start(struct os_thread *thread, void (*work)(void *user), void *user)
{
    thread->work = work;
    thread->user = user;
    thread->state[0] = CreateThread(NULL, 0, run, thread, 0, NULL);
    return thread->state[0] ? 0 : os_last_error();
}

void os_thread_join(struct os_thread *thread)
{
    WaitForSingleObject((HANDLE)thread->state[0], INFINITE);
    CloseHandle((HANDLE)thread->state[0]);
}

void os_lock_init(struct os_lock *lock)
{
    InitializeSRWLock(lock_of(lock));
}

void os_lock_destroy(struct os_lock *lock)
{
    (void)lock; /* holds nothing */
}

void os_lock_take(struct os_lock *lock)
{
    AcquireSRWLockExclusive(lock_of(lock));
}

void os_lock_release(struct os_lock *lock)
{
    ReleaseSRWLockExclusive(lock_of(lock));
}

void os_condition_init(struct os_condition *condition)
{
    InitializeConditionVariable(variable_of(condition));
}

void os_condition_destroy(struct os_condition *condition)
{
    (void)condition; /* holds nothing */
}

void os_condition_wait(struct os_condition *condition, struct os_lock *lock)
{
    SleepConditionVariableSRW(variable_of(condition), lock_of(lock), INFINITE, 0);
}

bool os_condition_wait_until(struct os_condition *condition, struct os_lock *lock,
                             double until_s)
{
    const double left_s = until_s - os_clock_s();
    const DWORD left_ms = left_s > 0 ? (DWORD)(1000 * left_s + 0.999) : 0;
    return SleepConditionVariableSRW(variable_of(condition), lock_of(lock), left_ms, 0);
}

void os_condition_wake_all(struct os_condition *condition)
{
    WakeAllConditionVariable(variable_of(condition));
}
