/* SPDX-License-Identifier: Apache-2.0 */
#include "clock.h"

#include <stdint.h>

#include "wide.h"

double os_clock_s(void)
{
    LARGE_INTEGER now, per_s;
    QueryPerformanceCounter(&now);
    QueryPerformanceFrequency(&per_s);
    return (double)now.QuadPart / (double)per_s.QuadPart;
}

double os_clock_date_s(void)
{
    /* FILETIME counts 100 ns from 1601. */
    const double from_1601_to_1970_s = 11644473600.0;
    FILETIME now;
    GetSystemTimePreciseAsFileTime(&now);
    return 1e-7 * (double)((uint64_t)now.dwHighDateTime << 32 | now.dwLowDateTime) -
           from_1601_to_1970_s;
}

void os_sleep_s(double seconds)
{
    Sleep((DWORD)(1000 * seconds + 0.999));
}
