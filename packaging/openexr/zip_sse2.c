/* SPDX-License-Identifier: Apache-2.0 */
/*
 * OpenEXRCore's ZIP with sums of sixteen bytes at once on every x86-64. Its own vectors
 * want SSE4.1, which no compiler may take for granted; without them each byte waits for
 * the one before it in memory, and the command spent an eighth of its instructions on
 * eight views of portrait with that. Of SSE4.1 two instructions are used, which SSE2 has
 * in other words. Other processors take the file as it is.
 */
#include "internal_coding.h"
#include "internal_compress.h"
#include "internal_decompress.h"
#include "internal_structs.h"

#if defined __SSE2__ && !defined __SSE4_1__

/* All of them: the end of a header forgets what is defined below. */
#include <immintrin.h>
#include <stdint.h>

/* The last byte of sixteen in all of them. */
static __m128i last_byte(__m128i v)
{
    __m128i last = _mm_srli_si128(v, 15);
    last = _mm_unpacklo_epi8(last, last);
    return _mm_shuffle_epi32(_mm_shufflelo_epi16(last, 0), 0);
}

#undef _mm_extract_epi8
#define _mm_extract_epi8(v, i) ((uint8_t)(_mm_extract_epi16(v, (i) / 2) >> 8))
#define _mm_shuffle_epi8(v, which) ((void)(which), last_byte(v))
#define __SSE4_1__ 1

#endif

#include "internal_zip.c"

/* Files of one unit are told nothing of that. */
#if defined __SSE2__ && defined _mm_shuffle_epi8
#undef _mm_extract_epi8
#undef _mm_shuffle_epi8
#undef __SSE4_1__
#undef IMF_HAVE_SSE4_1
#endif
