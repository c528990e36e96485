/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Threads as the systems have them: pthreads, Win32, or none (WebAssembly without
 * threads, and wherever RF_ONE_THREAD is defined). base/threads.h makes loops of them.
 */
#ifndef RF_BASE_SYSTEM_THREADS_H
#define RF_BASE_SYSTEM_THREADS_H

#include <stdbool.h>
#include <stdint.h>

/* Room for what a system has of each kind; system_threads.c checks that it suffices. */
struct rf_mutex {
    uint64_t room[8];
};
struct rf_condition {
    uint64_t room[8];
};
struct rf_thread {
    void (*run)(void *data);
    void *data;
    uint64_t room;
};

/* One thread at a time. None of these takes memory, and so none can fail. */
void rf_mutex_init(struct rf_mutex *mutex);
void rf_mutex_destroy(struct rf_mutex *mutex);
void rf_mutex_lock(struct rf_mutex *mutex);
void rf_mutex_unlock(struct rf_mutex *mutex);

/* Sleep until woken, or for no reason: the caller looks again at what it waits for. */
void rf_condition_init(struct rf_condition *condition);
void rf_condition_destroy(struct rf_condition *condition);
void rf_condition_wait(struct rf_condition *condition, struct rf_mutex *mutex);
void rf_condition_wake(struct rf_condition *condition); /* at least one */
void rf_condition_wake_all(struct rf_condition *condition);

/*
 * Starts run(data) on a thread that takes no signals of the process; `thread` stays
 * where it is until rf_thread_join(). False: the system gives no more threads.
 */
bool rf_thread_start(struct rf_thread *thread, void (*run)(void *data), void *data);
void rf_thread_join(struct rf_thread *thread);

/* A number that no other running thread of the process has. */
uint64_t rf_thread_self(void);

/* Processors that the process may run on, at least 1. */
int rf_system_processors(void);

/* The process; a forked child has another number. Positive. */
int64_t rf_system_process(void);

/* Tells the processor that a loop only waits. */
static inline void rf_system_pause(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("isb");
#endif
}

/*
 * A lock for a few instructions, of which a bool that is false is the free one; for
 * more, a mutex.
 */
static inline void rf_spin_lock(bool *lock)
{
    while (__atomic_test_and_set(lock, __ATOMIC_ACQUIRE))
        rf_system_pause();
}

static inline void rf_spin_unlock(bool *lock)
{
    __atomic_clear(lock, __ATOMIC_RELEASE);
}

#endif
