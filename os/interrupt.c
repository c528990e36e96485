/* SPDX-License-Identifier: Apache-2.0 */
#include "interrupt.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <unistd.h>

#include "clean_up.h"
#include "clock.h"

/* Global, because a signal handler has nothing else to write to. */
static volatile sig_atomic_t caught_signal;
static sem_t was_caught;

static void catch_signal(int number)
{
    const int kept = errno;
    caught_signal = number;
    sem_post(&was_caught);
    errno = kept;
}

/* What main() has not ended by then, it will not end soon. */
static void *watch(void *unused)
{
    while (sem_wait(&was_caught) != 0)
        ;
    os_sleep_s(OS_INTERRUPT_PATIENCE_S);
    os_clean_up();
    _exit(os_interrupt_code());
    return NULL;
}

/* A thread that takes no signals itself; without one the flag alone must do. */
static void start_watching(void)
{
    sigset_t all, before;
    pthread_t thread;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    if (pthread_create(&thread, NULL, watch, NULL) == 0)
        pthread_detach(thread);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

void os_interrupt_catch(void)
{
    struct sigaction action = {.sa_handler = catch_signal, .sa_flags = SA_RESTART};
    static bool is_watching;
    if (!is_watching && sem_init(&was_caught, 0, 0) == 0)
        start_watching();
    is_watching = true;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    struct sigaction before;
    if (sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler != SIG_IGN)
        sigaction(SIGHUP, &action, NULL); /* else it runs under nohup */
}

void os_interrupt_not_by_writing(void)
{
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}

bool os_is_interrupted(void)
{
    return caught_signal != 0;
}

int os_interrupt_code(void)
{
    return 128 + caught_signal;
}
