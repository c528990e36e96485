/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Undoes DWAA and DWAB, the lossy compression by DreamWorks Animation, which
 * OpenEXRCore 3.1 lists but does not contain. Source for the format: the description in
 * ImfDwaCompressor.cpp of the OpenEXR library (the format has no other document).
 *
 * A chunk holds 11 sizes, rules that tell the channels' kinds by their suffix and type,
 * and four streams:
 *   UNKNOWN  channels without a rule, planar, deflated
 *   AC, DC   LOSSY channels: blocks of 8 x 8 samples, transformed by a DCT, halfs. DC
 *            are the first coefficients, predicted and deflated; AC the others, zig-zag,
 *            0xff00 ends a block and 0xffnn stands for nn zeros; Huffman or deflate. R G
 *            B of one layer are Y Cb Cr (Rec. 709). Values are perceptual, and come back
 *            to linear by x^2.2 up to 1 and exp(2.2 (x - 1)) above
 *   RLE      channels like alpha: planes of bytes, run-length coded, deflated
 */
#include "exr_private.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <zlib.h>

#include "clock.h"

enum {
    VERSION,
    UNKNOWN_RAW_BYTES,
    UNKNOWN_BYTES,
    AC_BYTES,
    DC_BYTES,
    RLE_BYTES,
    RLE_INFLATED_BYTES,
    RLE_RAW_BYTES,
    N_AC,
    N_DC,
    AC_METHOD,
    N_SIZES
};
enum { AC_HUFFMAN, AC_DEFLATE };
enum kind { KIND_UNKNOWN, KIND_LOSSY, KIND_RLE };

struct lane { /* a channel */
    enum kind kind;
    int colour; /* 0 1 2: R G B, -1 */
    bool is_done;
    size_t prefix_length; /* of the name, up to the last dot */
    size_t width, height, n_bytes_per_sample;
    size_t *row; /* offset of each line in the output */
};

struct dwa {
    const exr_coding_channel_info_t *channels;
    struct lane *lanes;
    size_t *rows;
    int n;
    uint64_t sizes[N_SIZES];
    const uint8_t *stream[4]; /* UNKNOWN, AC, DC, RLE */
    uint16_t *ac, *dc;
    size_t ac_at, dc_at;
    uint8_t *unknown, *rle;
    uint8_t *out;
};

static uint16_t linear_table[65536];

static uint16_t to_linear(uint16_t half)
{
    if ((half & 0x7c00) == 0x7c00)
        return 0;
    double x = (double)image_half_to_float(half & 0x7fff);
    double linear = x <= 1 ? pow(x, 2.2) : exp(2.2 * (x - 1));
    float value = (float)linear;
    uint16_t sign = half & 0x8000;
    return value >= 65520.0f ? (uint16_t)(sign | 0x7c00)
                             : (uint16_t)(sign | image_float_to_half(value));
}

/* Whoever comes while another makes it waits some 5 ms. */
static void make_linear_table(void)
{
    static bool is_taken, is_made;
    while (__atomic_test_and_set(&is_taken, __ATOMIC_ACQUIRE))
        os_sleep_s(1e-4);
    for (int i = 0; i < 65536 && !is_made; i++)
        linear_table[i] = to_linear((uint16_t)i);
    is_made = true;
    __atomic_clear(&is_taken, __ATOMIC_RELEASE);
}

/* Rules */

struct rule {
    char suffix[64];
    enum kind kind;
    int colour;
    int type;
    bool ignores_case;
};

static void apply_rule(struct dwa *d, const struct rule *rule)
{
    for (int i = 0; i < d->n; i++) {
        const char *suffix = d->channels[i].channel_name + d->lanes[i].prefix_length;
        suffix += *suffix == '.';
        int difference = rule->ignores_case ? strcasecmp(suffix, rule->suffix)
                                            : strcmp(suffix, rule->suffix);
        if (difference != 0 || d->channels[i].data_type != rule->type)
            continue;
        d->lanes[i].kind = rule->kind;
        if (rule->colour >= 0)
            d->lanes[i].colour = rule->colour;
    }
}

/* Before version 2 the rules were fixed. */
static void apply_old_rules(struct dwa *d)
{
    static const struct rule rules[] = {
        {"r", KIND_LOSSY, 0, 0, true},     {"red", KIND_LOSSY, 0, 0, true},
        {"g", KIND_LOSSY, 1, 0, true},     {"grn", KIND_LOSSY, 1, 0, true},
        {"green", KIND_LOSSY, 1, 0, true}, {"b", KIND_LOSSY, 2, 0, true},
        {"blu", KIND_LOSSY, 2, 0, true},   {"blue", KIND_LOSSY, 2, 0, true},
        {"y", KIND_LOSSY, -1, 0, true},    {"by", KIND_LOSSY, -1, 0, true},
        {"ry", KIND_LOSSY, -1, 0, true},   {"a", KIND_RLE, -1, 0, true}};
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        for (int type = EXR_PIXEL_UINT; type <= EXR_PIXEL_FLOAT; type++) {
            struct rule rule = rules[i];
            rule.type = type;
            if (type != EXR_PIXEL_UINT || rule.kind == KIND_RLE)
                apply_rule(d, &rule);
        }
    }
}

/* Text, 0, a byte of colour + 1, kind and case, a byte of type. */
static bool read_rules(struct dwa *d, const uint8_t *at, const uint8_t *end)
{
    while (at < end) {
        struct rule rule = {.suffix = ""};
        const uint8_t *zero = memchr(at, 0, (size_t)(end - at));
        if (!zero || end - zero < 3 || (size_t)(zero - at) >= sizeof rule.suffix)
            return false;
        memcpy(rule.suffix, at, (size_t)(zero - at));
        rule.colour = (zero[1] >> 4) - 1;
        int kind = zero[1] >> 2 & 3;
        rule.ignores_case = zero[1] & 1;
        rule.type = zero[2];
        if (rule.colour > 2 || kind > KIND_RLE)
            return false;
        rule.kind = (enum kind)kind;
        apply_rule(d, &rule);
        at = zero + 3;
    }
    return true;
}

/* Layout */

static void lay_out_rows(struct dwa *d, const exr_chunk_info_t *chunk)
{
    size_t offset = 0, *next = d->rows;
    for (int i = 0; i < d->n; i++) {
        d->lanes[i].row = next;
        next += chunk->height;
    }
    for (int32_t line = 0; line < chunk->height; line++) {
        for (int i = 0; i < d->n; i++) {
            struct lane *lane = &d->lanes[i];
            int32_t step = d->channels[i].y_samples > 1 ? d->channels[i].y_samples : 1;
            /* Tiles are never sub-sampled, so start_y is a line whenever step > 1. */
            if (step > 1 && (chunk->start_y + line) % step != 0)
                continue;
            lane->row[lane->height++] = offset;
            offset += lane->width * lane->n_bytes_per_sample;
        }
    }
}

static bool set_up_lanes(struct dwa *d, const exr_decode_pipeline_t *pipeline)
{
    uint64_t n_bytes = 0;
    d->n = pipeline->channel_count;
    d->channels = pipeline->channels;
    d->lanes = calloc((size_t)d->n, sizeof *d->lanes);
    d->rows = calloc((size_t)d->n * (size_t)pipeline->chunk.height, sizeof *d->rows);
    if (!d->lanes || !d->rows)
        return false;
    for (int i = 0; i < d->n; i++) {
        const exr_coding_channel_info_t *channel = &d->channels[i];
        const char *dot = strrchr(channel->channel_name, '.');
        d->lanes[i] = (struct lane){
            .colour = -1,
            .prefix_length = dot ? (size_t)(dot - channel->channel_name) : 0,
            .width = (size_t)channel->width,
            .n_bytes_per_sample = (size_t)channel->bytes_per_element,
        };
    }
    lay_out_rows(d, &pipeline->chunk);
    for (int i = 0; i < d->n; i++)
        n_bytes +=
            d->lanes[i].width * d->lanes[i].height * d->lanes[i].n_bytes_per_sample;
    return n_bytes <= pipeline->chunk.unpacked_size;
}

static size_t kind_bytes(const struct dwa *d, enum kind kind)
{
    size_t n = 0;
    for (int i = 0; i < d->n; i++)
        if (d->lanes[i].kind == kind)
            n +=
                d->lanes[i].width * d->lanes[i].height * d->lanes[i].n_bytes_per_sample;
    return n;
}

static size_t n_blocks(const struct lane *lane)
{
    return (lane->width + 7) / 8 * ((lane->height + 7) / 8);
}

static bool read_layout(struct dwa *d, const exr_decode_pipeline_t *pipeline)
{
    const uint8_t *at = pipeline->packed_buffer;
    const uint8_t *end = at + pipeline->chunk.packed_size;
    if (pipeline->chunk.packed_size < sizeof d->sizes)
        return false;
    memcpy(d->sizes, at, sizeof d->sizes);
    at += sizeof d->sizes;
    if (d->sizes[VERSION] > 2)
        return false;
    if (d->sizes[VERSION] < 2) {
        apply_old_rules(d);
    } else {
        uint16_t n_rule_bytes;
        if (end - at < 2)
            return false;
        memcpy(&n_rule_bytes, at, 2);
        if (n_rule_bytes < 2 || n_rule_bytes > end - at ||
            !read_rules(d, at + 2, at + n_rule_bytes))
            return false;
        at += n_rule_bytes;
    }
    static const int stream_size[4] = {UNKNOWN_BYTES, AC_BYTES, DC_BYTES, RLE_BYTES};
    for (int i = 0; i < 4; i++) {
        if (d->sizes[stream_size[i]] > (uint64_t)(end - at))
            return false;
        d->stream[i] = at;
        at += d->sizes[stream_size[i]];
    }
    return true;
}

/* Streams */

static bool inflate_to(uint8_t *out, size_t n_out, const uint8_t *in, uint64_t n_in)
{
    uLongf n = n_out;
    return uncompress(out, &n, in, (uLong)n_in) == Z_OK && n == n_out;
}

static bool load_unknown(struct dwa *d)
{
    size_t n = kind_bytes(d, KIND_UNKNOWN);
    if (d->sizes[UNKNOWN_RAW_BYTES] > n)
        return false;
    d->unknown = calloc(n + 1, 1);
    return d->unknown && (d->sizes[UNKNOWN_BYTES] == 0 ||
                          inflate_to(d->unknown, d->sizes[UNKNOWN_RAW_BYTES],
                                     d->stream[0], d->sizes[UNKNOWN_BYTES]));
}

static bool load_ac(struct dwa *d, size_t n_all_blocks)
{
    size_t n = d->sizes[N_AC];
    if (n > n_all_blocks * 64)
        return false;
    d->ac = calloc(n + 1, sizeof *d->ac);
    if (!d->ac || d->sizes[AC_BYTES] == 0)
        return d->ac && n == 0;
    if (d->sizes[AC_METHOD] == AC_HUFFMAN)
        return image_undo_huffman(d->stream[1], d->sizes[AC_BYTES], d->ac, n);
    return d->sizes[AC_METHOD] == AC_DEFLATE &&
           inflate_to((uint8_t *)d->ac, n * sizeof *d->ac, d->stream[1],
                      d->sizes[AC_BYTES]);
}

/* As EXR's zip: differences of bytes, first halves and second halves apart. */
static bool load_dc(struct dwa *d, size_t n_all_blocks)
{
    size_t n = n_all_blocks * sizeof *d->dc;
    if (d->sizes[N_DC] != n_all_blocks)
        return false;
    uint8_t *bytes = calloc(n + 1, 1);
    d->dc = calloc(n_all_blocks + 1, sizeof *d->dc);
    bool is_good = bytes && d->dc &&
                   (n == 0 || inflate_to(bytes, n, d->stream[2], d->sizes[DC_BYTES]));
    for (size_t i = 1; is_good && i < n; i++)
        bytes[i] = (uint8_t)(bytes[i - 1] + bytes[i] - 128);
    for (size_t i = 0; is_good && i < n; i++)
        ((uint8_t *)d->dc)[i] = bytes[i / 2 + (i % 2 ? (n + 1) / 2 : 0)];
    free(bytes);
    return is_good;
}

static bool undo_runs(const uint8_t *in, size_t n_in, uint8_t *out, size_t n_out)
{
    const uint8_t *end = in + n_in, *out_end = out + n_out;
    while (in < end) {
        int count = (int8_t)*in++;
        size_t n = count < 0 ? (size_t)-count : (size_t)count + 1;
        if (n > (size_t)(out_end - out) || in == end ||
            (count < 0 && n > (size_t)(end - in)))
            return false;
        if (count < 0)
            memcpy(out, in, n);
        else
            memset(out, *in, n);
        in += count < 0 ? n : 1;
        out += n;
    }
    return out == out_end;
}

static bool load_rle(struct dwa *d)
{
    size_t n = kind_bytes(d, KIND_RLE), n_inflated = d->sizes[RLE_INFLATED_BYTES];
    d->rle = calloc(n + 1, 1);
    if (!d->rle || d->sizes[RLE_RAW_BYTES] == 0)
        return d->rle;
    /* Literal runs cost one byte in 128. */
    if (d->sizes[RLE_RAW_BYTES] != n || n_inflated > 2 * n + 128)
        return false;
    uint8_t *runs = calloc(n_inflated + 1, 1);
    bool is_good = runs &&
                   inflate_to(runs, n_inflated, d->stream[3], d->sizes[RLE_BYTES]) &&
                   undo_runs(runs, n_inflated, d->rle, n);
    free(runs);
    return is_good;
}

/* Lossy channels */

static void inverse_dct(float block[64])
{
    enum { N = 8 };
    const float a = 0.35355339f, b = 0.49039264f, c = 0.46193977f, d = 0.41573481f,
                e = 0.27778512f, f = 0.19134172f, g = 0.09754516f;
    /* Row k is half a cosine of frequency k. */
    const float basis[N][N] = {
        {a, a, a, a, a, a, a, a},     {b, d, e, g, -g, -e, -d, -b},
        {c, f, -f, -c, -c, -f, f, c}, {d, -g, -b, -e, e, b, g, -d},
        {a, -a, -a, a, a, -a, -a, a}, {e, -b, g, d, -d, -g, b, -e},
        {f, -c, c, -f, -f, c, -c, f}, {g, -e, d, -b, b, -d, e, -g}};
    float rows[N][N] = {{0}};
    for (int y = 0; y < N; y++)
        for (int k = 0; k < N; k++)
            for (int x = 0; x < N; x++)
                rows[y][x] += block[y * N + k] * basis[k][x];
    memset(block, 0, N * N * sizeof *block);
    for (int k = 0; k < N; k++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < N; x++)
                block[y * N + x] += basis[k][y] * rows[k][x];
}

/* The AC of one block from the stream, un-zig-zagged, as floats. */
static bool read_block(struct dwa *d, uint16_t dc, float block[64])
{
    static const uint8_t zigzag[64] = {
        0,  1,  8,  16, 9,  2,  3,  10, 17, 24, 32, 25, 18, 11, 4,  5,
        12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6,  7,  14, 21, 28,
        35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51,
        58, 59, 52, 45, 38, 31, 39, 46, 53, 60, 61, 54, 47, 55, 62, 63};
    memset(block, 0, 64 * sizeof *block);
    block[0] = image_half_to_float(dc);
    for (int i = 1; i < 64;) {
        if (d->ac_at >= d->sizes[N_AC])
            return false;
        uint16_t value = d->ac[d->ac_at++];
        if (value == 0xff00)
            break;
        if (value >> 8 == 0xff)
            i += value & 0xff;
        else
            block[zigzag[i++]] = image_half_to_float(value);
    }
    inverse_dct(block);
    return true;
}

static void to_rgb(float y[64], float cb[64], float cr[64])
{
    for (int i = 0; i < 64; i++) {
        float r = y[i] + 1.5747f * cr[i];
        float g = y[i] - 0.1873f * cb[i] - 0.4682f * cr[i];
        float b = y[i] + 1.8556f * cb[i];
        y[i] = r;
        cb[i] = g;
        cr[i] = b;
    }
}

static void store_block(struct dwa *d, int channel, const float block[64], size_t x0,
                        size_t y0, bool is_perceptual)
{
    const struct lane *lane = &d->lanes[channel];
    for (size_t i = 0; i < 64; i++) {
        size_t x = x0 + i % 8, y = y0 + i / 8;
        if (x >= lane->width || y >= lane->height)
            continue;
        uint16_t half = image_float_to_half(block[i]);
        if (is_perceptual)
            half = linear_table[half];
        uint8_t *out = d->out + lane->row[y] + x * lane->n_bytes_per_sample;
        if (lane->n_bytes_per_sample == 2) {
            memcpy(out, &half, 2);
        } else {
            float value = image_half_to_float(half);
            memcpy(out, &value, 4);
        }
    }
}

/* One channel, or R G B together; the DC of each channel follow each other. */
static bool undo_lossy(struct dwa *d, const int *channels, int n)
{
    const struct lane *lane = &d->lanes[channels[0]];
    size_t n_dc = n_blocks(lane), n_x = (lane->width + 7) / 8;
    for (size_t i = 0; i < n_dc; i++) {
        float block[3][64];
        for (int c = 0; c < n; c++)
            if (!read_block(d, d->dc[d->dc_at + (size_t)c * n_dc + i], block[c]))
                return false;
        if (n == 3)
            to_rgb(block[0], block[1], block[2]);
        for (int c = 0; c < n; c++)
            store_block(d, channels[c], block[c], i % n_x * 8, i / n_x * 8,
                        n == 3 || !d->channels[channels[c]].p_linear);
    }
    d->dc_at += n_dc * (size_t)n;
    for (int c = 0; c < n; c++)
        d->lanes[channels[c]].is_done = true;
    return true;
}

static bool has_prefix_of(const struct dwa *d, int a, int b)
{
    size_t n = d->lanes[a].prefix_length;
    return d->lanes[b].prefix_length == n &&
           strncmp(d->channels[a].channel_name, d->channels[b].channel_name, n) == 0;
}

/* The last R, G and B of the layer of `channel`; -1 where it has none. */
static void find_set(const struct dwa *d, int channel, int set[3])
{
    set[0] = set[1] = set[2] = -1;
    for (int i = 0; i < d->n; i++)
        if (d->lanes[i].colour >= 0 && has_prefix_of(d, channel, i))
            set[d->lanes[i].colour] = i;
}

static bool is_set(const struct dwa *d, const int set[3])
{
    for (int c = 0; c < 3; c++) {
        if (set[c] < 0 || d->lanes[set[c]].kind != KIND_LOSSY ||
            d->lanes[set[c]].width != d->lanes[set[0]].width ||
            d->lanes[set[c]].height != d->lanes[set[0]].height)
            return false;
    }
    return true;
}

/* Sorts before in the order of the layers' names, which is that of the streams. */
static bool comes_before(const struct dwa *d, int a, int b)
{
    char name_a[256], name_b[256];
    snprintf(name_a, sizeof name_a, "%.*s", (int)d->lanes[a].prefix_length,
             d->channels[a].channel_name);
    snprintf(name_b, sizeof name_b, "%.*s", (int)d->lanes[b].prefix_length,
             d->channels[b].channel_name);
    return strcmp(name_a, name_b) < 0;
}

static bool undo_colours(struct dwa *d)
{
    for (;;) {
        int first = -1, set[3];
        for (int i = 0; i < d->n; i++) {
            if (d->lanes[i].is_done || d->lanes[i].colour < 0)
                continue;
            find_set(d, i, set);
            if (is_set(d, set) && set[d->lanes[i].colour] == i &&
                (first < 0 || comes_before(d, i, first)))
                first = i;
        }
        if (first < 0)
            return true;
        find_set(d, first, set);
        if (!undo_lossy(d, set, 3))
            return false;
    }
}

/* The others */

static void place_planes(struct dwa *d, int channel, const uint8_t *bytes)
{
    const struct lane *lane = &d->lanes[channel];
    size_t n_samples = lane->width * lane->height;
    for (size_t y = 0; y < lane->height; y++)
        for (size_t x = 0; x < lane->width; x++)
            for (size_t b = 0; b < lane->n_bytes_per_sample; b++)
                d->out[lane->row[y] + x * lane->n_bytes_per_sample + b] =
                    bytes[b * n_samples + y * lane->width + x];
}

static void place_rows(struct dwa *d, int channel, const uint8_t *bytes)
{
    const struct lane *lane = &d->lanes[channel];
    size_t n = lane->width * lane->n_bytes_per_sample;
    for (size_t y = 0; y < lane->height; y++)
        memcpy(d->out + lane->row[y], bytes + y * n, n);
}

static bool undo_rest(struct dwa *d)
{
    size_t unknown_at = 0, rle_at = 0;
    for (int i = 0; i < d->n; i++) {
        const struct lane *lane = &d->lanes[i];
        size_t n = lane->width * lane->height * lane->n_bytes_per_sample;
        if (lane->kind == KIND_UNKNOWN) {
            place_rows(d, i, d->unknown + unknown_at);
            unknown_at += n;
        } else if (lane->kind == KIND_RLE) {
            place_planes(d, i, d->rle + rle_at);
            rle_at += n;
        } else if (!lane->is_done && !undo_lossy(d, &i, 1)) {
            return false;
        }
    }
    return true;
}

static bool undo(struct dwa *d, exr_decode_pipeline_t *pipeline)
{
    size_t n_all_blocks = 0;
    if (!set_up_lanes(d, pipeline) || !read_layout(d, pipeline))
        return false;
    for (int i = 0; i < d->n; i++) {
        if (d->lanes[i].kind != KIND_LOSSY)
            continue;
        if (d->channels[i].data_type == EXR_PIXEL_UINT)
            return false;
        n_all_blocks += n_blocks(&d->lanes[i]);
    }
    return load_unknown(d) && load_ac(d, n_all_blocks) && load_dc(d, n_all_blocks) &&
           load_rle(d) && undo_colours(d) && undo_rest(d);
}

exr_result_t image_undo_dwa(exr_decode_pipeline_t *pipeline)
{
    struct dwa d = {.out = pipeline->unpacked_buffer};
    make_linear_table();
    bool is_good = undo(&d, pipeline);
    free(d.lanes);
    free(d.rows);
    free(d.ac);
    free(d.dc);
    free(d.unknown);
    free(d.rle);
    if (is_good)
        return EXR_ERR_SUCCESS;
    image_core_on_error(pipeline->context, EXR_ERR_CORRUPT_CHUNK,
                        "invalid DWA data, or out of memory");
    return EXR_ERR_CORRUPT_CHUNK;
}
