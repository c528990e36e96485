/* SPDX-License-Identifier: Apache-2.0 */
/* What systems do each in its own way with threads. */
#include "base/system_threads.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if !defined(RF_ONE_THREAD) && defined(__wasm__) && !defined(_REENTRANT)
#define RF_ONE_THREAD
#endif

#if defined(RF_ONE_THREAD)

/* Who is alone waits for nobody and wakes nobody. */
void rf_mutex_init(struct rf_mutex *mutex)
{
}

void rf_mutex_destroy(struct rf_mutex *mutex)
{
}

void rf_mutex_lock(struct rf_mutex *mutex)
{
}

void rf_mutex_unlock(struct rf_mutex *mutex)
{
}

void rf_condition_init(struct rf_condition *condition)
{
}

void rf_condition_destroy(struct rf_condition *condition)
{
}

void rf_condition_wait(struct rf_condition *condition, struct rf_mutex *mutex)
{
}

void rf_condition_wake(struct rf_condition *condition)
{
}

void rf_condition_wake_all(struct rf_condition *condition)
{
}

bool rf_thread_start(struct rf_thread *thread, void (*run)(void *data), void *data)
{
    return false;
}

void rf_thread_join(struct rf_thread *thread)
{
}

uint64_t rf_thread_self(void)
{
#ifdef __wasm_atomics__
    /* Several after all, the host's: each has variables of its own. */
    static _Thread_local char mark;
    return (uint64_t)(uintptr_t)&mark;
#else
    return 1;
#endif
}

int rf_system_processors(void)
{
    return 1;
}

int64_t rf_system_process(void)
{
    return 1;
}

#elif defined(_WIN32)

#define WIN32_LEAN_AND_MEAN
#include <process.h>
#include <windows.h>

_Static_assert(sizeof(SRWLOCK) <= sizeof(struct rf_mutex), "a mutex has room");
_Static_assert(sizeof(CONDITION_VARIABLE) <= sizeof(struct rf_condition),
               "a condition has room");
_Static_assert(sizeof(HANDLE) <= sizeof(uint64_t), "a thread has room");

enum { STACK_BYTES = 2 << 20 };

static SRWLOCK *lock_of(struct rf_mutex *mutex)
{
    return (SRWLOCK *)mutex->room;
}

static CONDITION_VARIABLE *variable_of(struct rf_condition *condition)
{
    return (CONDITION_VARIABLE *)condition->room;
}

void rf_mutex_init(struct rf_mutex *mutex)
{
    InitializeSRWLock(lock_of(mutex));
}

void rf_mutex_destroy(struct rf_mutex *mutex)
{
}

void rf_mutex_lock(struct rf_mutex *mutex)
{
    AcquireSRWLockExclusive(lock_of(mutex));
}

void rf_mutex_unlock(struct rf_mutex *mutex)
{
    ReleaseSRWLockExclusive(lock_of(mutex));
}

void rf_condition_init(struct rf_condition *condition)
{
    InitializeConditionVariable(variable_of(condition));
}

void rf_condition_destroy(struct rf_condition *condition)
{
}

void rf_condition_wait(struct rf_condition *condition, struct rf_mutex *mutex)
{
    SleepConditionVariableSRW(variable_of(condition), lock_of(mutex), INFINITE, 0);
}

void rf_condition_wake(struct rf_condition *condition)
{
    WakeConditionVariable(variable_of(condition));
}

void rf_condition_wake_all(struct rf_condition *condition)
{
    WakeAllConditionVariable(variable_of(condition));
}

/* GCC's code expects the stack of Win32's callbacks to be aligned for SSE only. */
static unsigned __stdcall run_thread(void *thread)
{
    struct rf_thread *t = thread;
    t->run(t->data);
    return 0;
}

bool rf_thread_start(struct rf_thread *thread, void (*run)(void *data), void *data)
{
    *thread = (struct rf_thread){.run = run, .data = data};
    thread->room = (uint64_t)_beginthreadex(NULL, STACK_BYTES, run_thread, thread,
                                            STACK_SIZE_PARAM_IS_A_RESERVATION, NULL);
    return thread->room != 0;
}

void rf_thread_join(struct rf_thread *thread)
{
    HANDLE handle = (HANDLE)(uintptr_t)thread->room;
    WaitForSingleObject(handle, INFINITE);
    CloseHandle(handle);
}

uint64_t rf_thread_self(void)
{
    return GetCurrentThreadId();
}

int rf_system_processors(void)
{
    DWORD_PTR ours = 0, all;
    int n = 0;
    if (!GetProcessAffinityMask(GetCurrentProcess(), &ours, &all))
        return 1;
    for (; ours; ours &= ours - 1)
        n++;
    return n ? n : 1;
}

int64_t rf_system_process(void)
{
    return 1; /* nothing forks */
}

#else

#include <pthread.h>
#include <signal.h>
#include <unistd.h>
#ifdef __linux__
#include <sched.h>
#endif

_Static_assert(sizeof(pthread_mutex_t) <= sizeof(struct rf_mutex), "a mutex has room");
_Static_assert(sizeof(pthread_cond_t) <= sizeof(struct rf_condition),
               "a condition has room");
_Static_assert(sizeof(pthread_t) <= sizeof(uint64_t), "a thread has room");

/* Some systems give 128 or 512 KiB; the deepest loop takes less than 200 KiB. */
enum { STACK_BYTES = 2 << 20 };

static pthread_mutex_t *mutex_of(struct rf_mutex *mutex)
{
    return (pthread_mutex_t *)(void *)mutex->room;
}

static pthread_cond_t *condition_of(struct rf_condition *condition)
{
    return (pthread_cond_t *)(void *)condition->room;
}

void rf_mutex_init(struct rf_mutex *mutex)
{
    pthread_mutex_init(mutex_of(mutex), NULL);
}

void rf_mutex_destroy(struct rf_mutex *mutex)
{
    pthread_mutex_destroy(mutex_of(mutex));
}

void rf_mutex_lock(struct rf_mutex *mutex)
{
    pthread_mutex_lock(mutex_of(mutex));
}

void rf_mutex_unlock(struct rf_mutex *mutex)
{
    pthread_mutex_unlock(mutex_of(mutex));
}

void rf_condition_init(struct rf_condition *condition)
{
    pthread_cond_init(condition_of(condition), NULL);
}

void rf_condition_destroy(struct rf_condition *condition)
{
    pthread_cond_destroy(condition_of(condition));
}

void rf_condition_wait(struct rf_condition *condition, struct rf_mutex *mutex)
{
    pthread_cond_wait(condition_of(condition), mutex_of(mutex));
}

void rf_condition_wake(struct rf_condition *condition)
{
    pthread_cond_signal(condition_of(condition));
}

void rf_condition_wake_all(struct rf_condition *condition)
{
    pthread_cond_broadcast(condition_of(condition));
}

static void *run_thread(void *thread)
{
    struct rf_thread *t = thread;
    t->run(t->data);
    return NULL;
}

/* A host's handlers of signals run on its own threads; faults stay where they are. */
static void block_signals(sigset_t *before)
{
    const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT, SIGSYS};
    sigset_t all;
    sigfillset(&all);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++)
        sigdelset(&all, faults[i]);
    pthread_sigmask(SIG_SETMASK, &all, before);
}

bool rf_thread_start(struct rf_thread *thread, void (*run)(void *data), void *data)
{
    pthread_attr_t attributes;
    pthread_t made;
    sigset_t before;
    *thread = (struct rf_thread){.run = run, .data = data};
    if (pthread_attr_init(&attributes) != 0)
        return false;
    pthread_attr_setstacksize(&attributes, STACK_BYTES);
    block_signals(&before);
    bool is_made = pthread_create(&made, &attributes, run_thread, thread) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&attributes);
    if (is_made)
        thread->room = (uint64_t)made;
    return is_made;
}

void rf_thread_join(struct rf_thread *thread)
{
    pthread_join((pthread_t)thread->room, NULL);
}

uint64_t rf_thread_self(void)
{
    return (uint64_t)pthread_self();
}

int rf_system_processors(void)
{
#ifdef __linux__
    cpu_set_t ours;
    if (sched_getaffinity(0, sizeof ours, &ours) == 0 && CPU_COUNT(&ours) > 0)
        return CPU_COUNT(&ours);
#endif
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n > 0 ? (int)n : 1;
}

int64_t rf_system_process(void)
{
    return getpid();
}

#endif
