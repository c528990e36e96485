/* SPDX-License-Identifier: Apache-2.0 */
#include "console/progress.h"

#include <stdio.h>
#include <string.h>

#include "clock.h"
#include "interrupt.h"
#include "terminal.h"

#define REDRAW_S 0.1 /* between two pictures of the bar */
#define SETTLE_S 0.5 /* before the time left is worth showing */
#define MAX_CELLS 40

void progress_start(struct progress *bar, const char *label, bool is_quiet)
{
    *bar = (struct progress){.label = label,
                             .is_shown = !is_quiet && os_terminal_is_live(stderr),
                             .started_s = os_clock_s()};
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

/* At once, over what was drawn last: Windows' console takes a stream without a buffer
 * letter by letter, and not every one knows the escape that wipes a line. */
static void write_line(struct progress *bar, const char *line)
{
    char text[256];
    const int n = (int)strlen(line), n_blank = bar->n_drawn > n ? bar->n_drawn - n : 0;
    snprintf(text, sizeof(text), "\r%s%*s%s", line, n_blank, "", n > 0 ? "" : "\r");
    fputs(text, stderr);
    fflush(stderr);
    bar->n_drawn = n;
}

static void draw(struct progress *bar, double fraction, double now_s)
{
    char left[48], cells[MAX_CELLS + 1], line[200];
    format_left(left, sizeof(left), now_s - bar->started_s, fraction);
    int n = os_terminal_columns(stderr) - (int)strlen(bar->label) - 32;
    n = n > MAX_CELLS ? MAX_CELLS : n < 0 ? 0 : n;
    memset(cells, '.', sizeof(cells));
    memset(cells, '#', (size_t)(fraction * n));
    cells[n] = 0;
    snprintf(line, sizeof(line), "%s [%s] %3.0f %% %s", bar->label, cells,
             100 * fraction, left);
    write_line(bar, line);
}

bool progress_report(void *user, double fraction)
{
    struct progress *bar = user;
    const double now_s = os_clock_s();
    if (bar->is_shown && (fraction >= 1 || now_s - bar->drawn_s >= REDRAW_S)) {
        bar->drawn_s = now_s;
        draw(bar, fraction, now_s);
    }
    return !os_is_interrupted();
}

void progress_end(struct progress *bar)
{
    if (bar->is_shown && bar->drawn_s > 0)
        write_line(bar, "");
    bar->is_shown = false;
}
