/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes JSON to stdout: objects and arrays open and close, commas come by themselves.
 * Names are NULL inside arrays. Bytes that are no UTF-8 become U+FFFD. Infinity is
 * written as 1e999, which is valid JSON and which readers turn into infinity; NaN as
 * null.
 */
#ifndef CLI_JSON_H
#define CLI_JSON_H

#include <stdbool.h>

struct json {
    int depth;
    bool has_items; /* at this depth */
};

void json_open(struct json *json, const char *name, char bracket); /* '{' or '[' */
void json_close(struct json *json, char bracket);                  /* '}' or ']' */
void json_text(struct json *json, const char *name, const char *text);
void json_number(struct json *json, const char *name, double number);
void json_bool(struct json *json, const char *name, bool value);

#endif
