/* SPDX-License-Identifier: Apache-2.0 */
/* Messages: ours, and those that OpenEXRCore reports through its callback. */
#include "exr_private.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Length of the UTF-8 sequence at `text`; 0 for what is none or controls terminals. */
static size_t printable_length(const char *text)
{
    const unsigned char *c = (const unsigned char *)text;
    if (*c < 0x80)
        return *c >= 0x20 && *c != 0x7f;
    size_t n = *c >= 0xf0 ? 4 : *c >= 0xe0 ? 3 : 2;
    if (*c < 0xc2 || *c > 0xf4)
        return 0;
    for (size_t i = 1; i < n; i++)
        if ((c[i] & 0xc0) != 0x80)
            return 0;
    return n;
}

/* Names in a damaged file may be anything; messages are text. */
static void make_printable(char *text)
{
    while (*text) {
        size_t n = printable_length(text);
        if (n == 0)
            *text = '?';
        text += n ? n : 1;
    }
}

bool image_fail(struct image_error *error, const char *path, const char *format, ...)
{
    if (!error)
        return false;
    error->code = IMAGE_FAILED;
    int n = snprintf(error->message, sizeof error->message, "%s: ", path);
    if (n < 0 || (size_t)n >= sizeof error->message)
        return false;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message + n, sizeof error->message - (size_t)n, format, arguments);
    va_end(arguments);
    make_printable(error->message + n);
    return false;
}

bool image_lacks_memory(struct image_error *error, const char *path)
{
    image_fail(error, path, "out of memory");
    if (error)
        error->code = IMAGE_NO_MEMORY;
    return false;
}

static _Thread_local char core_message[400];
static _Thread_local bool core_lacked_memory;
static _Thread_local int core_compression = -1;

void image_core_clear(void)
{
    core_message[0] = '\0';
    core_lacked_memory = false;
    core_compression = -1;
}

bool image_core_lacked_memory(void)
{
    return core_lacked_memory;
}

int image_core_unknown_compression(void)
{
    return core_compression;
}

/* "Attribute 'compression' (type 'compression'): Invalid value 12 (max allowed 10)". */
static void note_compression(const char *message)
{
    static const char phrase[] = "Invalid value ";
    const char *value = strstr(message, phrase);
    if (value && strstr(message, "'compression'"))
        core_compression = (int)strtol(value + sizeof phrase - 1, NULL, 10);
}

void image_core_on_error(exr_const_context_t context, exr_result_t code,
                         const char *message)
{
    core_lacked_memory |= code == EXR_ERR_OUT_OF_MEMORY;
    if (message)
        note_compression(message);
    if (core_message[0] == '\0' && message)
        snprintf(core_message, sizeof core_message, "%s", message);
}

const char *image_core_message(exr_result_t fallback)
{
    if (core_message[0])
        return core_message;
    /* read_at reports other failures; a short read is none in a header. */
    if (fallback == EXR_ERR_READ_IO)
        return "the file ends too early";
    return exr_get_default_error_message(fallback);
}
