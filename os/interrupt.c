/* SPDX-License-Identifier: Apache-2.0 */
#include "interrupt.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include "clean_up.h"
#include "clock.h"

/* Global, because a signal handler has nothing else to write to. */
static volatile sig_atomic_t caught_signal;
static int ends[2]; /* of a pipe: macOS has no semaphore for a handler */

static void catch_signal(int number)
{
    const int kept = errno;
    caught_signal = number;
    const ssize_t n = write(ends[1], "", 1);
    (void)n; /* full: the other end has enough to read */
    errno = kept;
}

/* What main() has not ended by then, it will not end soon. */
static void *watch(void *unused)
{
    char byte;
    while (read(ends[0], &byte, 1) != 1)
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
    if (!is_watching && pipe(ends) == 0) {
        for (int i = 0; i < 2; i++)
            fcntl(ends[i], F_SETFD, FD_CLOEXEC);
        fcntl(ends[1], F_SETFL, O_NONBLOCK);
        start_watching();
    }
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

bool os_interrupt_is_reader_gone(int number)
{
    return number == EPIPE;
}

bool os_is_interrupted(void)
{
    return caught_signal != 0;
}

int os_interrupt_code(void)
{
    return 128 + caught_signal;
}
