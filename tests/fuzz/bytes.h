/* SPDX-License-Identifier: Apache-2.0 */
/* The fuzzer's bytes as a source of choices; when they end, zeros follow. */
#ifndef FUZZ_BYTES_H
#define FUZZ_BYTES_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

struct bytes {
    const uint8_t *at;
    size_t n;
};

static inline uint8_t bytes_take(struct bytes *b)
{
    if (b->n == 0)
        return 0;
    b->n--;
    return *b->at++;
}

/* 0 to below n. */
static inline int bytes_pick(struct bytes *b, int n)
{
    unsigned v = bytes_take(b);
    if (n > 256)
        v = v << 8 | bytes_take(b);
    return (int)(v % (unsigned)n);
}

/* What the target promises; a broken promise is a finding. */
#define PROMISE(condition)                                                             \
    do {                                                                               \
        if (!(condition)) {                                                            \
            fprintf(stderr, "%s:%d: broken: %s\n", __FILE__, __LINE__, #condition);    \
            abort();                                                                   \
        }                                                                              \
    } while (0)

#endif
