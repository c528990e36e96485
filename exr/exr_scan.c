/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Counts what is in a header before OpenEXRCore reads it: its lists of attributes and
 * channels take time with the square of their length, minutes for what a few megabytes
 * can hold. Only the sizes are looked at; what is malformed is left for OpenEXRCore to
 * name.
 *
 * The layout (OpenEXR file layout, "Header Attributes"): after magic and version a list
 * of attributes, each name and type ended by 0, the size as int32 and the value, the
 * list ended by an empty name; of a multi-part file several such lists, ended by an
 * empty one. The value of `channels` is a list of names ended by 0 with 16 bytes each.
 */
#include "exr_private.h"

#include <string.h>

#include "file.h"

/* Renderers write tens of attributes and hundreds of channels; cryptomattes and light
 * groups at most some thousands. At the limits a header opens within a second. */
enum { MOST_ATTRIBUTES = 4096, MOST_CHANNELS = 8192, MOST_PARTS = 2048 };
enum { MULTI_PART = 1 << 12, NAME_BYTES = 256 };

struct scan {
    const struct image_input *input;
    uint64_t at; /* of the next byte */
    uint64_t begin;
    size_t n; /* bytes that are there, from `begin` on */
    uint8_t bytes[1 << 14];
    int n_attributes, n_channels, n_parts;
};

static bool take_byte(struct scan *scan, uint8_t *byte)
{
    if (scan->at < scan->begin || scan->at >= scan->begin + scan->n) {
        scan->begin = scan->at;
        scan->n =
            os_file_read_at(scan->input->fd, scan->bytes, sizeof scan->bytes, scan->at);
        if (scan->n == 0)
            return false;
    }
    *byte = scan->bytes[scan->at++ - scan->begin];
    return true;
}

/* A text ended by 0; false where it is longer than any name or the file ends. */
static bool take_name(struct scan *scan, char *name)
{
    for (int i = 0; i < NAME_BYTES; i++) {
        uint8_t byte;
        if (!take_byte(scan, &byte))
            return false;
        name[i] = (char)byte;
        if (byte == 0)
            return true;
    }
    return false;
}

static bool take_int(struct scan *scan, int64_t *value)
{
    uint32_t number = 0;
    for (int i = 0; i < 4; i++) {
        uint8_t byte;
        if (!take_byte(scan, &byte))
            return false;
        number |= (uint32_t)byte << 8 * i;
    }
    *value = (int32_t)number;
    return true;
}

/* The channels of a list of so many bytes. */
static bool count_channels(struct scan *scan, int64_t n_bytes)
{
    char name[NAME_BYTES];
    const uint64_t end = scan->at + (uint64_t)n_bytes;
    while (scan->at < end && scan->n_channels <= MOST_CHANNELS) {
        if (!take_name(scan, name))
            return false;
        if (!name[0])
            break;
        scan->at += 16;
        scan->n_channels++;
    }
    scan->at = end;
    return true;
}

/* The attributes of one part; false at the end of what can be read so. */
static bool count_part(struct scan *scan, bool *is_empty)
{
    char name[NAME_BYTES], type[NAME_BYTES];
    int64_t n_bytes;
    *is_empty = true;
    for (scan->n_attributes = 0; scan->n_attributes <= MOST_ATTRIBUTES;
         scan->n_attributes++) {
        if (!take_name(scan, name))
            return false;
        if (!name[0])
            return true;
        *is_empty = false;
        if (!take_name(scan, type) || !take_int(scan, &n_bytes) || n_bytes < 0)
            return false;
        if (strcmp(type, "chlist") == 0) {
            if (!count_channels(scan, n_bytes))
                return false;
        } else {
            scan->at += (uint64_t)n_bytes;
        }
    }
    return false;
}

bool image_scan_header(const struct image_input *input, struct image_error *error)
{
    struct scan scan = {.input = input, .at = 4};
    int64_t version;
    bool is_empty = false, is_good = take_int(&scan, &version);
    const bool is_multi_part = is_good && (version & MULTI_PART);
    while (is_good && !is_empty && scan.n_parts <= MOST_PARTS) {
        is_good = count_part(&scan, &is_empty);
        scan.n_parts += !is_empty;
        if (scan.n_channels > MOST_CHANNELS || !is_multi_part)
            break;
    }
    if (scan.n_attributes > MOST_ATTRIBUTES)
        return image_fail(error, input->path,
                          "has more than %d attributes in one part, more than this "
                          "program reads; drop those that nobody needs",
                          MOST_ATTRIBUTES);
    if (scan.n_channels > MOST_CHANNELS)
        return image_fail(error, input->path,
                          "has more than %d channels, more than this program reads; "
                          "split it into several files",
                          MOST_CHANNELS);
    if (scan.n_parts > MOST_PARTS)
        return image_fail(error, input->path,
                          "has more than %d parts, more than this program reads; split "
                          "it into several files",
                          MOST_PARTS);
    return true;
}
