/* SPDX-License-Identifier: Apache-2.0 */
#include "interrupt.h"

#include <errno.h>

#include "clean_up.h"
#include "clock.h"
#include "wide.h"

/* As signals are numbered elsewhere. */
enum { INTERRUPT = 2, TERMINATE = 15 };

static volatile LONG caught_signal;

/* Windows calls it on a thread of its own, which serves as the watching one: what
 * main() has not ended by then, it will not end soon. */
static BOOL WINAPI catch_event(DWORD event)
{
    const bool is_key = event == CTRL_C_EVENT || event == CTRL_BREAK_EVENT;
    InterlockedExchange(&caught_signal, is_key ? INTERRUPT : TERMINATE);
    os_sleep_s(OS_INTERRUPT_PATIENCE_S);
    os_clean_up();
    ExitProcess((UINT)os_interrupt_code());
}

void os_interrupt_catch(void)
{
    SetConsoleCtrlHandler(catch_event, TRUE);
}

void os_interrupt_not_by_writing(void)
{
    /* Here such a write fails and no more. */
}

/* Microsoft's C library says EINVAL for a pipe that is being closed. */
bool os_interrupt_is_reader_gone(int number)
{
    return number == EPIPE || number == EINVAL;
}

bool os_is_interrupted(void)
{
    return caught_signal != 0;
}

int os_interrupt_code(void)
{
    return 128 + (int)caught_signal;
}
