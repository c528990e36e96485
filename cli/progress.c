/* SPDX-License-Identifier: Apache-2.0 */
#include "progress.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

/* The one piece of global state: a signal handler has nothing else to write to. */
static volatile sig_atomic_t caught_signal;

static void catch_signal(int number)
{
    caught_signal = number;
}

void interrupt_catch(void)
{
    struct sigaction action = {.sa_handler = catch_signal, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

bool is_interrupted(void)
{
    return caught_signal != 0;
}

int interrupt_exit_code(void)
{
    return 128 + caught_signal;
}

double clock_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#define REDRAW_S 0.1 /* between two pictures of the bar */
#define SETTLE_S 0.5 /* before the time left is worth showing */
#define MAX_CELLS 40

void progress_start(struct progress *bar, const char *label, bool is_quiet)
{
    *bar = (struct progress){.label = label,
                             .is_shown = !is_quiet && isatty(STDERR_FILENO),
                             .started_s = clock_seconds()};
}

static int terminal_columns(void)
{
    struct winsize size;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
        return size.ws_col;
    return 80;
}

static void format_left(char *text, size_t n_bytes, double elapsed_s, double fraction)
{
    *text = 0;
    if (fraction <= 0 || fraction >= 1 || elapsed_s < SETTLE_S)
        return;
    const double left_s = elapsed_s * (1 - fraction) / fraction;
    if (left_s < 60)
        snprintf(text, n_bytes, "%.0f s left", left_s);
    else
        snprintf(text, n_bytes, "%d min %02d s left", (int)left_s / 60,
                 (int)left_s % 60);
}

static void draw(const struct progress *bar, double fraction, double now_s)
{
    char left[48], cells[MAX_CELLS + 1];
    format_left(left, sizeof(left), now_s - bar->started_s, fraction);
    int n = terminal_columns() - (int)strlen(bar->label) - 32;
    n = n > MAX_CELLS ? MAX_CELLS : n < 0 ? 0 : n;
    memset(cells, '.', sizeof(cells));
    memset(cells, '#', (size_t)(fraction * n));
    cells[n] = 0;
    fprintf(stderr, "\r%s [%s] %3.0f %% %s\033[K", bar->label, cells, 100 * fraction,
            left);
    fflush(stderr);
}

bool progress_report(void *user, double fraction)
{
    struct progress *bar = user;
    const double now_s = clock_seconds();
    if (bar->is_shown && (fraction >= 1 || now_s - bar->drawn_s >= REDRAW_S)) {
        bar->drawn_s = now_s;
        draw(bar, fraction, now_s);
    }
    return !is_interrupted();
}

void progress_end(struct progress *bar)
{
    if (bar->is_shown && bar->drawn_s > 0)
        fputs("\r\033[K", stderr);
    bar->is_shown = false;
}
