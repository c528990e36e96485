/* SPDX-License-Identifier: Apache-2.0 */
#include "clock.h"

#include "wide.h"

double os_clock_s(void)
{
    LARGE_INTEGER now, per_s;
    QueryPerformanceCounter(&now);
    QueryPerformanceFrequency(&per_s);
    return (double)now.QuadPart / (double)per_s.QuadPart;
}

void os_sleep_s(double seconds)
{
    Sleep((DWORD)(1000 * seconds + 0.999));
}
