/* SPDX-License-Identifier: Apache-2.0 */
#include "console/json.h"

#include <math.h>
#include <stdio.h>

static void print_string(const char *text)
{
    putchar('"');
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            printf("\\%c", c);
        else if (c < 0x20)
            printf("\\u%04x", c);
        else
            putchar(c);
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

void json_number(struct json *json, const char *name, double number)
{
    begin_item(json, name);
    if (isnan(number))
        printf("null");
    else if (isinf(number))
        printf("%s1e999", number < 0 ? "-" : "");
    else
        printf("%.9g", number);
}

void json_bool(struct json *json, const char *name, bool value)
{
    begin_item(json, name);
    printf(value ? "true" : "false");
}
