/* SPDX-License-Identifier: Apache-2.0 */
/* Loops on threads. */
#ifndef RF_BASE_PARALLEL_H
#define RF_BASE_PARALLEL_H

/* Index of the calling thread in its parallel region. */
int rf_thread_num(void);

#endif
