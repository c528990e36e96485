/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The Huffman code of OpenEXR (PIZ, and the AC coefficients of DWA): 16 bit symbols,
 * one more symbol that repeats the last value, canonical codes of up to 58 bits, most
 * significant bit first. Among codes, the longer have the smaller values, so that a
 * prefix of n bits is a code exactly when it is not below the first code of length n.
 */
#include "exr_private.h"

#include <stdlib.h>
#include <string.h>

enum {
    N_SYMBOLS = 65537,
    MAX_LENGTH = 58,
    SHORT_RUN = 59, /* 59..62: 2 to 5 symbols without a code */
    LONG_RUN = 63,  /* 8 more bits: 6 to 261 of them */
    TABLE_BITS = 12,
    HEADER_BYTES = 20
};

struct bits {
    const uint8_t *data;
    size_t n_bits, at; /* in bits */
};

struct code {
    uint8_t *length;  /* of each symbol, 0: none */
    uint32_t *symbol; /* ordered by length, then by symbol */
    uint64_t first[MAX_LENGTH + 1];
    uint32_t count[MAX_LENGTH + 1], offset[MAX_LENGTH + 1];
    struct {
        uint32_t symbol;
        uint8_t length; /* 0: longer than the table */
    } table[1 << TABLE_BITS];
};

/* The next n bits, zeros beyond the end. */
static uint32_t peek(const struct bits *bits, unsigned n)
{
    uint64_t window = 0;
    for (size_t i = 0; i < 5; i++) {
        size_t byte = bits->at / 8 + i;
        window = window << 8 | (byte * 8 < bits->n_bits ? bits->data[byte] : 0u);
    }
    return (uint32_t)(window >> (40 - bits->at % 8 - n) & ((1ull << n) - 1));
}

static bool take(struct bits *bits, unsigned n, uint32_t *value)
{
    if (bits->n_bits - bits->at < n)
        return false;
    *value = peek(bits, n);
    bits->at += n;
    return true;
}

/* Lengths of the codes of symbols first..last, 6 bits each, gaps as runs. */
static bool read_lengths(struct bits *bits, uint32_t first, uint32_t last,
                         uint8_t *length)
{
    for (uint32_t i = first; i <= last;) {
        uint32_t l, run = 1;
        if (!take(bits, 6, &l))
            return false;
        if (l == LONG_RUN) {
            if (!take(bits, 8, &run))
                return false;
            run += 6;
        } else if (l >= SHORT_RUN) {
            run = l - SHORT_RUN + 2;
        } else {
            length[i] = (uint8_t)l;
        }
        if (run > last + 1 - i)
            return false;
        i += run;
    }
    return true;
}

static void order_symbols(struct code *code)
{
    uint64_t next = 0;
    uint32_t offset = 0, filled[MAX_LENGTH + 1] = {0};
    for (uint32_t i = 0; i < N_SYMBOLS; i++)
        code->count[code->length[i]]++;
    code->count[0] = 0;
    for (int l = MAX_LENGTH; l > 0; l--) {
        uint64_t above = (next + code->count[l]) >> 1;
        code->first[l] = next;
        next = above;
    }
    for (int l = 1; l <= MAX_LENGTH; l++) {
        code->offset[l] = offset;
        offset += code->count[l];
    }
    for (uint32_t i = 0; i < N_SYMBOLS; i++) {
        unsigned l = code->length[i];
        if (l > 0)
            code->symbol[code->offset[l] + filled[l]++] = i;
    }
}

static void fill_table(struct code *code)
{
    for (unsigned l = 1; l <= TABLE_BITS; l++) {
        for (uint32_t i = 0; i < code->count[l]; i++) {
            uint64_t begin = (code->first[l] + i) << (TABLE_BITS - l);
            uint64_t end = (code->first[l] + i + 1) << (TABLE_BITS - l);
            for (uint64_t k = begin; k < end && k < 1 << TABLE_BITS; k++) {
                code->table[k].symbol = code->symbol[code->offset[l] + i];
                code->table[k].length = (uint8_t)l;
            }
        }
    }
}

static bool next_symbol(const struct code *code, struct bits *bits, uint32_t *symbol)
{
    uint32_t prefix = peek(bits, TABLE_BITS);
    unsigned l = code->table[prefix].length;
    if (l > 0) {
        *symbol = code->table[prefix].symbol;
        bits->at += l;
        return bits->at <= bits->n_bits;
    }
    uint64_t value = 0;
    for (l = 1; l <= MAX_LENGTH; l++) {
        uint32_t bit;
        if (!take(bits, 1, &bit))
            return false;
        value = value << 1 | bit;
        if (value >= code->first[l] && value - code->first[l] < code->count[l]) {
            *symbol = code->symbol[code->offset[l] + (value - code->first[l])];
            return true;
        }
    }
    return false;
}

static bool decode(const struct code *code, struct bits *bits, uint32_t repeat,
                   uint16_t *out, size_t n_out)
{
    size_t n = 0;
    while (n < n_out) {
        uint32_t symbol, times = 1;
        if (!next_symbol(code, bits, &symbol))
            return false;
        uint16_t value = (uint16_t)symbol;
        if (symbol == repeat) {
            if (n == 0 || !take(bits, 8, &times) || times > n_out - n)
                return false;
            value = out[n - 1];
        }
        while (times-- > 0)
            out[n++] = value;
    }
    return true;
}

static uint32_t load32(const uint8_t *bytes)
{
    uint32_t value;
    memcpy(&value, bytes, sizeof value);
    return value;
}

bool image_undo_huffman(const uint8_t *in, size_t n_in, uint16_t *out, size_t n_out)
{
    if (n_in < HEADER_BYTES)
        return n_out == 0;
    uint32_t first = load32(in), last = load32(in + 4), n_bits = load32(in + 12);
    if (first >= N_SYMBOLS || last >= N_SYMBOLS || first > last)
        return false;
    struct code *code = calloc(1, sizeof *code);
    uint8_t *length = calloc(N_SYMBOLS, sizeof *length);
    uint32_t *symbol = calloc(N_SYMBOLS, sizeof *symbol);
    bool is_good = code && length && symbol;
    struct bits bits = {in + HEADER_BYTES, 8 * (n_in - HEADER_BYTES), 0};
    if (is_good) {
        code->length = length;
        code->symbol = symbol;
        is_good = read_lengths(&bits, first, last, length);
    }
    if (is_good) {
        order_symbols(code);
        fill_table(code);
        /* The codes start at the next whole byte. */
        bits.at = (bits.at + 7) / 8 * 8;
        is_good = bits.n_bits - bits.at >= n_bits;
        bits.n_bits = bits.at + n_bits;
        is_good = is_good && decode(code, &bits, last, out, n_out);
    }
    free(code);
    free(length);
    free(symbol);
    return is_good;
}
