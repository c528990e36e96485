/* SPDX-License-Identifier: Apache-2.0 */
/* Time. */
#ifndef OS_CLOCK_H
#define OS_CLOCK_H

/* Seconds of a clock that only goes forward; from when is not said. */
double os_clock_s(void);

/* Seconds since 1970, UTC, by the clock on the wall, which somebody may set. */
double os_clock_date_s(void);

/* Waits. */
void os_sleep_s(double seconds);

#endif
