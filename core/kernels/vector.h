/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Vectors of eight floats for the inner loops: the compiler's vector extension, so that
 * one source serves every instruction set. Comparisons give all bits or none.
 */
#ifndef RF_VECTOR_H
#define RF_VECTOR_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#ifdef __AVX__
#include <immintrin.h>
#endif
#ifdef RF_USE_NEON
#include <arm_neon.h>
#endif

typedef float vf __attribute__((vector_size(32)));
typedef float vf_loose __attribute__((vector_size(32), aligned(4)));
typedef int32_t vi __attribute__((vector_size(32)));

#define LANES 8
#define LOAD(p) (*(const vf_loose *)(p))
#define STORE(p, v) (*(vf_loose *)(p) = (v))

static inline vf splat(float x)
{
    return (vf){x, x, x, x, x, x, x, x};
}
#define SPLAT(x) splat((float)(x))

/* Four doubles, from and to floats. */
typedef double vd __attribute__((vector_size(32)));
typedef int64_t vl __attribute__((vector_size(32)));
typedef float vf_half __attribute__((vector_size(16), aligned(4)));

#define LANES_D 4
#define LOAD_D(p) __builtin_convertvector(*(const vf_half *)(p), vd)
#define STORE_D(p, v) (*(vf_half *)(p) = __builtin_convertvector(v, vf_half))
#define SPLAT_D(x) ((vd){(x), (x), (x), (x)})

/* Four whole numbers. */
typedef uint64_t vu __attribute__((vector_size(32)));
typedef uint64_t vu_loose __attribute__((vector_size(32), aligned(8)));

static inline vd choose_d(vl mask, vd a, vd b)
{
    return (vd)(((vl)a & mask) | ((vl)b & ~mask));
}

#ifdef RF_USE_NEON
/* NEON's vectors have four lanes: half of ours. */
union halves {
    vf v;
    vi i;
    vu w;
    float32x4_t f[2];
    uint32x4_t u[2];
};

/* True where a < b of each half; GCC 12 takes comparisons of eight lanes apart. */
static inline union halves is_less(union halves a, union halves b)
{
    return (union halves){.u = {vcltq_f32(a.f[0], b.f[0]), vcltq_f32(a.f[1], b.f[1])}};
}
#endif

/* The compiler does not see by itself that these are one instruction each. */
static inline vf choose(vi mask, vf a, vf b)
{
#ifdef __AVX__
    return (vf)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)mask);
#elif defined RF_USE_NEON
    const union halves m = {.i = mask}, p = {.v = a}, q = {.v = b};
    const union halves chosen = {
        .f = {vbslq_f32(m.u[0], p.f[0], q.f[0]), vbslq_f32(m.u[1], p.f[1], q.f[1])}};
    return chosen.v;
#else
    return (vf)(((vi)a & mask) | ((vi)b & ~mask));
#endif
}

#define LOAD_U(p) (*(const vu_loose *)(p))

static inline bool is_same(vu a, vu b)
{
    vu d = a ^ b;
#ifdef __AVX__
    return _mm256_testz_si256((__m256i)d, (__m256i)d);
#elif defined RF_USE_NEON
    const union halves h = {.w = d};
    return vmaxvq_u32(vorrq_u32(h.u[0], h.u[1])) == 0;
#else
    return !(d[0] | d[1] | d[2] | d[3]);
#endif
}

/* Without its sign. */
static inline vf vabs(vf v)
{
    return (vf)((vi)v & ~(vi)SPLAT(-0.0f));
}

/* a < b ? a : b */
static inline vf vmin(vf a, vf b)
{
#ifdef __AVX__
    return (vf)_mm256_min_ps((__m256)a, (__m256)b);
#elif defined RF_USE_NEON
    return choose(is_less((union halves){a}, (union halves){b}).i, a, b);
#else
    return choose(a < b, a, b);
#endif
}

/* a > b ? a : b */
static inline vf vmax(vf a, vf b)
{
#ifdef __AVX__
    return (vf)_mm256_max_ps((__m256)a, (__m256)b);
#elif defined RF_USE_NEON
    return choose(is_less((union halves){b}, (union halves){a}).i, a, b);
#else
    return choose(a > b, a, b);
#endif
}

/* One bit per lane of a mask. */
static inline unsigned lane_bits(vi mask)
{
#ifdef __AVX__
    return (unsigned)_mm256_movemask_ps((__m256)mask);
#elif defined RF_USE_NEON
    static const uint32_t BITS[4] = {1, 2, 4, 8};
    const union halves m = {.i = mask};
    const uint32x4_t bits = vld1q_u32(BITS);
    return vaddvq_u32(vandq_u32(m.u[0], bits)) | vaddvq_u32(vandq_u32(m.u[1], bits))
                                                     << 4;
#else
    unsigned bits = 0;
    for (int l = 0; l < LANES; l++)
        bits |= (unsigned)(mask[l] & 1) << l;
    return bits;
#endif
}

/* The lanes of a, 0 to 7, and b, 8 to 15, in any order. */
#if defined __clang__
#define SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (vi){__VA_ARGS__})
#endif

/* a[i], b[i], a[i + 1], b[i + 1], .. from i = 0 or 4 on. */
#define INTERLEAVE(a, b, i)                                                            \
    SHUFFLE(a, b, (i), (i) + 8, (i) + 1, (i) + 9, (i) + 2, (i) + 10, (i) + 3, (i) + 11)

/*
 * Takes 32 floats as one row and interleaves its halves: the bits of each place turn
 * left by one, so three turns take r g b a r g b a .. to eight of r, g, b and a.
 */
static inline void turn(vf v[4])
{
    vf a = INTERLEAVE(v[0], v[2], 0), b = INTERLEAVE(v[0], v[2], 4);
    vf c = INTERLEAVE(v[1], v[3], 0), d = INTERLEAVE(v[1], v[3], 4);
    v[0] = a;
    v[1] = b;
    v[2] = c;
    v[3] = d;
}

/* Four floats from a and four from b, without a way through memory. */
static inline vf load_halves(const float *a, const float *b)
{
#ifdef __AVX__
    __m256 low = _mm256_castps128_ps256(_mm_loadu_ps(a));
    return (vf)_mm256_insertf128_ps(low, _mm_loadu_ps(b), 1);
#else
    vf v;
    memcpy(&v, a, 4 * sizeof *a);
    memcpy((float *)&v + 4, b, 4 * sizeof *b);
    return v;
#endif
}

/* The way back; past the caches, which is for what is not read soon, where both places
 * are multiples of 16 bytes. */
static inline void store_halves(float *a, float *b, vf v, bool is_past_caches)
{
#ifdef __AVX__
    __m128 low = _mm256_castps256_ps128((__m256)v);
    __m128 high = _mm256_extractf128_ps((__m256)v, 1);
    if (is_past_caches) {
        _mm_stream_ps(a, low);
        _mm_stream_ps(b, high);
        return;
    }
    _mm_storeu_ps(a, low);
    _mm_storeu_ps(b, high);
#else
    (void)is_past_caches;
    memcpy(a, &v, 4 * sizeof *a);
    memcpy(b, (const float *)&v + 4, 4 * sizeof *b);
#endif
}

/* 0, 1, .. 7 */
static inline vi lane_numbers(void)
{
    return (vi){0, 1, 2, 3, 4, 5, 6, 7};
}

static inline vf to_float(vi v)
{
    return __builtin_convertvector(v, vf);
}

static inline vi to_int(vf v)
{
    return __builtin_convertvector(v, vi);
}

static inline vf vsqrt(vf v)
{
#ifdef __AVX__
    return (vf)_mm256_sqrt_ps((__m256)v);
#elif defined RF_USE_NEON
    const union halves h = {.v = v};
    return (union halves){.f = {vsqrtq_f32(h.f[0]), vsqrtq_f32(h.f[1])}}.v;
#else
    for (int l = 0; l < LANES; l++)
        v[l] = __builtin_sqrtf(v[l]);
    return v;
#endif
}

/*
 * Quadruples 0 and 4, 1 and 5, 2 and 6, 3 and 7 become the first floats of all eight,
 * the second ones, .., and back. No lane changes halves, which costs the least.
 */
static inline void turn_halves(vf v[4])
{
    vf a = SHUFFLE(v[0], v[1], 0, 8, 1, 9, 4, 12, 5, 13);
    vf b = SHUFFLE(v[2], v[3], 0, 8, 1, 9, 4, 12, 5, 13);
    vf c = SHUFFLE(v[0], v[1], 2, 10, 3, 11, 6, 14, 7, 15);
    vf d = SHUFFLE(v[2], v[3], 2, 10, 3, 11, 6, 14, 7, 15);
    v[0] = SHUFFLE(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
    v[1] = SHUFFLE(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
    v[2] = SHUFFLE(c, d, 0, 1, 8, 9, 4, 5, 12, 13);
    v[3] = SHUFFLE(c, d, 2, 3, 10, 11, 6, 7, 14, 15);
}

/*
 * Stores the lanes whose bits are set, in turn; writes all eight, and those that are
 * left may be anything.
 */
static inline void store_lanes(int32_t *to, vi v, unsigned bits)
{
#ifdef __AVX2__
    /* Which of four lanes they are: a byte for each. */
    static const uint32_t FOUR[16] = {
        0,    0x00,   0x01,   0x0100,   0x02,   0x0200,   0x0201,   0x020100,
        0x03, 0x0300, 0x0301, 0x030100, 0x0302, 0x030200, 0x030201, 0x03020100};
    uint64_t high = (uint64_t)(FOUR[bits >> 4] | 0x04040404);
    uint64_t lanes = FOUR[bits & 15] | high << 8 * __builtin_popcount(bits & 15);
    __m256i order = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)lanes));
    _mm256_storeu_si256((__m256i *)to, _mm256_permutevar8x32_epi32((__m256i)v, order));
#else
    for (; bits; bits &= bits - 1)
        *to++ = v[__builtin_ctz(bits)];
#endif
}

/* Sum of the lanes in a fixed order. */
static inline float lane_sum(vf v)
{
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

/* rf_expf() for v <= 0: relative error 4e-7 down to -80. */
static inline vf vexp(vf v)
{
    v = vmax(v, SPLAT(-80));
    vi n = to_int(v * SPLAT(1.44269504f) - SPLAT(0.5f)); /* rounds towards zero */
    vf k = to_float(n);
    vf f = v - k * SPLAT(0.693145752f);
    f -= k * SPLAT(1.42860677e-6f);
    vf p = SPLAT(1.0f / 5040);
    p = p * f + SPLAT(1.0f / 720);
    p = p * f + SPLAT(1.0f / 120);
    p = p * f + SPLAT(1.0f / 24);
    p = p * f + SPLAT(1.0f / 6);
    p = p * f + SPLAT(0.5f);
    p = p * f + SPLAT(1);
    p = p * f + SPLAT(1);
    return p * (vf)((n + 127) << 23);
}

/*
 * log for normal v > 0, absolute error 3e-7: log(v) = e ln 2 + log(m), m in
 * [sqrt(1/2), sqrt(2)), by log(m) = 2 atanh(t) with t = (m - 1) / (m + 1),
 * |t| <= 0.172, to t^9.
 */
static inline vf vlog(vf v)
{
    vi bits = (vi)v;
    vi e = (bits >> 23) - 127;
    vf m = (vf)((bits & 0x7fffff) | 0x3f800000);
    vi is_high = m > SPLAT(1.41421356f);
    m = choose(is_high, m * SPLAT(0.5f), m);
    e -= is_high; /* all bits are -1 */
    vf t = (m - SPLAT(1)) / (m + SPLAT(1)), t2 = t * t;
    vf p = SPLAT(1.0f / 9);
    p = p * t2 + SPLAT(1.0f / 7);
    p = p * t2 + SPLAT(0.2f);
    p = p * t2 + SPLAT(1.0f / 3);
    p = p * t2 + SPLAT(1);
    return SPLAT(2) * t * p + to_float(e) * SPLAT(0.69314718f);
}

/* rf_luminance() of planes of colour. */
static inline vf luminance_of(const vf c[3])
{
    return SPLAT(0.2126f) * c[0] + SPLAT(0.7152f) * c[1] + SPLAT(0.0722f) * c[2];
}

#endif
