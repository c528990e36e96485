/* SPDX-License-Identifier: Apache-2.0 */
#include "console/json.h"

#include <math.h>
#include <stdio.h>

/* Bytes of the letter of UTF-8 at `text`, as RFC 3629 has them; 0: there is none. */
static int letter_bytes(const char *text)
{
    const unsigned char *c = (const unsigned char *)text;
    const int n = c[0] < 0x80                    ? 1
                  : c[0] >= 0xc2 && c[0] <= 0xdf ? 2
                  : (c[0] & 0xf0) == 0xe0        ? 3
                  : c[0] >= 0xf0 && c[0] <= 0xf4 ? 4
                                                 : 0;
    for (int i = 1; i < n; i++)
        if ((c[i] & 0xc0) != 0x80)
            return 0;
    /* Longer than need be, halves of UTF-16, beyond the last code. */
    const bool is_none = (c[0] == 0xe0 && c[1] < 0xa0) ||
                         (c[0] == 0xed && c[1] > 0x9f) ||
                         (c[0] == 0xf0 && c[1] < 0x90) || (c[0] == 0xf4 && c[1] > 0x8f);
    return is_none ? 0 : n;
}

/* JSON is UTF-8; names of files, channels and layers may be anything, and one byte that
 * is not would make all of it unreadable: it becomes U+FFFD. */
static void print_string(const char *text)
{
    putchar('"');
    while (*text) {
        const unsigned char c = (unsigned char)*text;
        const int n = letter_bytes(text);
        if (c == '"' || c == '\\')
            printf("\\%c", c);
        else if (c < 0x20)
            printf("\\u%04x", c);
        else if (n == 0)
            printf("\\ufffd");
        else
            printf("%.*s", n, text);
        text += n ? n : 1;
    }
    putchar('"');
}

static void begin_item(struct json *json, const char *name)
{
    if (json->has_items)
        putchar(',');
    if (json->depth > 0)
        printf("\n%*s", 2 * json->depth, "");
    json->has_items = true;
    if (name) {
        print_string(name);
        printf(": ");
    }
}

void json_open(struct json *json, const char *name, char bracket)
{
    begin_item(json, name);
    putchar(bracket);
    json->depth++;
    json->has_items = false;
}

void json_close(struct json *json, char bracket)
{
    json->depth--;
    if (json->has_items)
        printf("\n%*s", 2 * json->depth, "");
    putchar(bracket);
    json->has_items = true;
    if (json->depth == 0)
        putchar('\n');
}

void json_text(struct json *json, const char *name, const char *text)
{
    begin_item(json, name);
    print_string(text);
}

/* Below it every whole number is a double. */
static const double WHOLE = 9007199254740992.0;

void json_number(struct json *json, const char *name, double number)
{
    begin_item(json, name);
    if (isnan(number))
        printf("null");
    else if (isinf(number))
        printf("%s1e999", number < 0 ? "-" : "");
    else if (number == floor(number) && fabs(number) < WHOLE)
        printf("%.0f", number); /* counts and seeds have ten digits */
    else
        printf("%.9g", number);
}

void json_bool(struct json *json, const char *name, bool value)
{
    begin_item(json, name);
    printf(value ? "true" : "false");
}
