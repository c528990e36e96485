/* SPDX-License-Identifier: Apache-2.0 */
#include "common/frame_list.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/report.h"
#include "file.h"
#include "folder.h"
#include "path.h"
#include "rackfocus/rackfocus.h"

enum { MAX_FRAMES = 1000000, LAST_FRAME = 100 * MAX_FRAMES };
#define FRAME_RANGE "-1000000 to 100000000"

/* ---- lists ---------------------------------------------------------------------- */

static int compare_numbers(const void *a, const void *b)
{
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

static void sort_once(struct frame_list *list)
{
    int n = 0;
    qsort(list->numbers, (size_t)list->n, sizeof(*list->numbers), compare_numbers);
    for (int i = 0; i < list->n; i++)
        if (i == 0 || list->numbers[i] != list->numbers[n - 1])
            list->numbers[n++] = list->numbers[i];
    list->n = n;
}

static bool add(struct frame_list *list, int32_t number, struct image_error *error)
{
    if ((list->n & (list->n - 1)) == 0) {
        const size_t room = list->n ? 2 * (size_t)list->n : 1;
        int32_t *grown = app_memory(room, sizeof(*grown), error);
        if (!grown)
            return false;
        if (list->n)
            memcpy(grown, list->numbers, (size_t)list->n * sizeof(*grown));
        free(list->numbers);
        list->numbers = grown;
    }
    list->numbers[list->n++] = number;
    return true;
}

enum number { NO_NUMBER, OUT_OF_RANGE, NUMBER };

/* A whole number at *text, which moves behind it. */
static enum number take_number(const char **text, int32_t *number)
{
    char *end;
    errno = 0;
    const long v = strtol(*text, &end, 10);
    if (end == *text || isspace((unsigned char)**text))
        return NO_NUMBER;
    *text = end;
    if (errno || v < -MAX_FRAMES || v > LAST_FRAME)
        return OUT_OF_RANGE;
    *number = (int32_t)v;
    return NUMBER;
}

bool frame_number_parse(const char *text, int32_t *number)
{
    return take_number(&text, number) == NUMBER && *text == '\0';
}

static const char *const why_no_list =
    "is no list of frames; write 1-240, 1-240x2 for every second one, or 1-10,20,30-40";

/* What is wrong with a number of a list; NULL: nothing. */
static const char *take_listed(const char **text, int32_t *number)
{
    switch (take_number(text, number)) {
    case NUMBER:
        return NULL;
    case OUT_OF_RANGE:
        return "has a number that no frame can have; they lie in " FRAME_RANGE;
    default:
        return why_no_list;
    }
}

/* What is wrong with a range; NULL: nothing. */
static const char *take_range(const char **text, int32_t *first, int32_t *last,
                              int32_t *step)
{
    *first = 0;
    *step = 1;
    const char *why = take_listed(text, first);
    *last = *first;
    if (!why && **text == '-') {
        (*text)++;
        why = take_listed(text, last);
        if (!why && *last < *first)
            why = "has a range that ends before it begins; write the smaller number "
                  "first, as in 1-240";
    }
    if (!why && **text == 'x') {
        (*text)++;
        why = take_listed(text, step);
        if (!why && *step < 1)
            why = why_no_list;
    }
    return why || **text == ',' || **text == '\0' ? why : why_no_list;
}

bool frame_list_parse(struct frame_list *list, const char *text,
                      struct image_error *error)
{
    *list = (struct frame_list){0};
    for (const char *at = text;; at++) {
        int32_t first, last, step;
        const char *why = take_range(&at, &first, &last, &step);
        if (!why && (last - first) / step + 1 > MAX_FRAMES - list->n)
            why = "has more than 1000000 frames; give a part of them at a time";
        if (why) {
            frame_list_free(list);
            return set_error(error, "'%s' %s", text, why);
        }
        for (int64_t k = first; k <= last; k += step)
            if (!add(list, (int32_t)k, error)) {
                frame_list_free(list);
                return false;
            }
        if (*at == '\0')
            break;
    }
    sort_once(list);
    return true;
}

/* The step that all differences are multiples of. */
static int32_t common_step(const struct frame_list *list)
{
    int32_t step = 0;
    for (int i = 1; i < list->n; i++) {
        int32_t a = list->numbers[i] - list->numbers[i - 1];
        while (a != 0) {
            const int32_t rest = step % a;
            step = a;
            a = rest;
        }
    }
    return step;
}

bool frame_list_missing(struct frame_list *missing, const struct frame_list *list,
                        struct image_error *error)
{
    const int32_t step = common_step(list);
    *missing = (struct frame_list){0};
    for (int i = 1; i < list->n; i++)
        for (int32_t k = list->numbers[i - 1] + step; k < list->numbers[i]; k += step)
            if (!add(missing, k, error)) {
                frame_list_free(missing);
                return false;
            }
    return true;
}

char *frame_list_text(const int32_t *numbers, int n, struct image_error *error)
{
    const size_t n_bytes = 14 * (size_t)n + 1;
    char *text = app_memory(n_bytes, 1, error);
    size_t used = 0;
    for (int i = 0, last; i < n && text; i = last + 1) {
        last = i;
        while (last + 1 < n && numbers[last + 1] == numbers[last] + 1)
            last++;
        const char *comma = i > 0 ? "," : "";
        used +=
            (size_t)(last == i ? snprintf(text + used, n_bytes - used, "%s%d", comma,
                                          (int)numbers[i])
                               : snprintf(text + used, n_bytes - used, "%s%d-%d", comma,
                                          (int)numbers[i], (int)numbers[last]));
    }
    return text;
}

bool frame_list_holes(const struct frame_list *list, char text[FRAME_LIST_HOLES],
                      struct image_error *error)
{
    struct frame_list missing;
    text[0] = '\0';
    if (!frame_list_missing(&missing, list, error))
        return false;
    bool is_good = true;
    if (missing.n > 0 && missing.n < list->n) {
        char *numbers = frame_list_text(missing.numbers, missing.n, error);
        is_good = numbers != NULL;
        if (is_good)
            snprintf(text, FRAME_LIST_HOLES, "of frames %d to %d there is no %.200s",
                     (int)list->numbers[0], (int)list->numbers[list->n - 1], numbers);
        free(numbers);
    }
    frame_list_free(&missing);
    return is_good;
}

void frame_list_free(struct frame_list *list)
{
    free(list->numbers);
    *list = (struct frame_list){0};
}

/* ---- names ---------------------------------------------------------------------- */

/* Where the number of the frame stands in a name. */
struct place {
    const char *begin, *end;
    int n_digits; /* at least so many, padded with zeros */
};

/* "%d", "%4d" or "%04d", as Nuke and many others write; the padding is by zeros. */
static bool is_percent(const char *at, struct place *place)
{
    const char *digits = at + 1;
    const size_t n = strspn(digits, "0123456789");
    if (*at != '%' || n > 2 || digits[n] != 'd')
        return false;
    const int wanted = atoi(digits);
    *place = (struct place){at, digits + n + 1, wanted > 0 ? wanted : 1};
    return true;
}

/* "$F" or "$F4", as Houdini writes. */
static bool is_dollar(const char *at, struct place *place)
{
    if (at[0] != '$' || at[1] != 'F')
        return false;
    const bool has_digit = at[2] >= '1' && at[2] <= '9';
    *place = (struct place){at, at + 2 + has_digit, has_digit ? at[2] - '0' : 1};
    return true;
}

static bool is_run(const char *at, struct place *place)
{
    const size_t n = strspn(at, "#");
    *place = (struct place){at, at + n, (int)n};
    return n > 0;
}

/* A place for a number that begins here; false where none does. */
static bool is_place(const char *at, struct place *place)
{
    return is_run(at, place) || is_percent(at, place) || is_dollar(at, place);
}

/* The last place for a number in the last part of a path; false where there is none. */
static bool find_place(const char *pattern, struct place *place)
{
    bool is_found = false;
    for (const char *at = os_path_name(pattern); *at;) {
        struct place next;
        const bool is_next = is_place(at, &next);
        if (is_next)
            *place = next;
        is_found |= is_next;
        at = is_next ? next.end : at + 1;
    }
    return is_found;
}

bool frame_is_pattern(const char *name)
{
    struct place place;
    return find_place(name, &place);
}

/* A word of a shell that is written into `to`, which holds the final zero. */
struct word {
    char to[1200];
    size_t n;
};

static void add_mark(struct word *word, char mark)
{
    if (word->n + 1 < sizeof(word->to))
        word->to[word->n++] = mark;
}

/* Adds what lies before `end`, each character for what it is. */
static void add_plain(struct word *word, const char *at, const char *end)
{
    for (; at < end; at++) {
        const bool is_special = (unsigned char)*at < 128 &&
                                !isalnum((unsigned char)*at) &&
                                !strchr("/._-+,:@", *at);
        if (is_special)
            add_mark(word, '\\');
        add_mark(word, *at);
    }
}

/* Adds the name with a star for each number. */
static void add_glob(struct word *word, const char *name)
{
    while (*name) {
        struct place place;
        const bool is_number = is_place(name, &place);
        if (is_number)
            add_mark(word, '*');
        else
            add_plain(word, name, name + 1);
        name = is_number ? place.end : name + 1;
    }
}

bool frame_is_in_folder(const char *name, char *links, size_t n_bytes)
{
    const char *const last = os_path_name(name), *const dot = strrchr(last, '.');
    const char *at = name;
    struct place place;
    char folder[1024];
    while (at < last && !is_place(at, &place))
        at++;
    snprintf(folder, sizeof(folder), "%.*s", (int)(last - name), name);
    if (at >= last || os_file_facts(folder).kind != OS_FILE_NONE)
        return false;
    struct word glob = {.n = 0}, before = {.n = 0}, after = {.n = 0};
    add_glob(&glob, name);
    add_plain(&before, name, at);
    add_plain(&after, place.end, place.end + strcspn(place.end, "/"));
    snprintf(links, n_bytes,
             "for f in %s; do n=${f#%s}; ln -s \"%s$f\" \"frame.${n%%%%%s/*}%s\"; done",
             glob.to, before.to, name[0] == '/' ? "" : "$PWD/", after.to,
             dot ? dot : "");
    return true;
}

/* Length of "@@@@" at the beginning; one alone may be part of a name. */
static size_t at_signs(const char *at)
{
    const size_t n = strspn(at, "@");
    return n > 1 ? n : 0;
}

/* Length of what a bracket holds, with both, where it may be a frame's number. */
static size_t bracketed(const char *at)
{
    const char *close = *at == '<' ? ">" : *at == '{' ? "}" : *at == '[' ? "]" : NULL;
    const size_t n = close ? strcspn(at, close) : 0;
    if (n < 2 || !at[n])
        return 0;
    char word[32];
    snprintf(word, sizeof(word), "%.*s", (int)(n - 1), at + 1);
    const size_t n_digits = strspn(word, "#0123456789-,:");
    const bool is_numbers = *at == '[' && n_digits == strlen(word);
    const bool is_frame = strncasecmp(word, "frame", 5) == 0;
    const bool is_short = tolower((unsigned char)word[0]) == 'f' &&
                          strspn(word + 1, "0123456789") == strlen(word + 1);
    return is_numbers || (*at != '[' && (is_frame || is_short)) ? n + 1 : 0;
}

static size_t foreign_mark(const char *at)
{
    const size_t n = at_signs(at);
    if (n > 0)
        return n;
    return strncmp(at, "$frame", 6) == 0 ? 6 : bracketed(at);
}

/* Length of the name before " 1-240"; 0 where that is not at its end. */
static size_t before_range(const char *name)
{
    const char *space = strrchr(name, ' ');
    int32_t first, last, step;
    if (!space || space == name)
        return 0;
    const char *at = space + 1;
    return !take_range(&at, &first, &last, &step) && last > first && *at == '\0'
               ? (size_t)(space - name)
               : 0;
}

/* Where digits begin that end at `end`. */
static const char *digits_before(const char *begin, const char *end)
{
    while (end > begin && isdigit((unsigned char)end[-1]))
        end--;
    return end;
}

/* Where "0001-0003" or "1-240x2" begins that ends at `end`; `end` where there is none. A
 * date, 2026-11-30, is none. */
static const char *range_before(const char *begin, const char *end)
{
    const char *last = digits_before(begin, end);
    int32_t from, to, step;
    if (last > begin && last < end && last[-1] == 'x')
        last = digits_before(begin, last - 1);
    if (last == begin || last[-1] != '-')
        return end;
    const char *const at = digits_before(begin, last - 1);
    const bool is_date = at - begin > 1 && at[-1] == '-' && isdigit((uint8_t)at[-2]);
    char word[32];
    const char *rest = word;
    snprintf(word, sizeof(word), "%.*s", (int)(end - at), at);
    return !is_date && !take_range(&rest, &from, &to, &step) && *rest == '\0' &&
                   to > from
               ? at
               : end;
}

bool frame_guess_foreign(const char *name, char *pattern, size_t n_bytes)
{
    const char *const last = os_path_name(name), *dot = strrchr(last, '.');
    const size_t n_name = before_range(name);
    if (n_name > 0)
        return snprintf(pattern, n_bytes, "%.*s", (int)n_name, name) < (int)n_bytes;
    const char *at = last, *end = dot ? dot : last + strlen(last);
    while (*at && foreign_mark(at) == 0)
        at++;
    if (*at)
        end = at + foreign_mark(at);
    else if (frame_is_pattern(name))
        return false;
    at = range_before(last, *at ? at : end);
    return at < end && snprintf(pattern, n_bytes, "%.*s####%s", (int)(at - name), name,
                                end) < (int)n_bytes;
}

bool frame_guess_pattern(const char *name, char *pattern, size_t n_bytes)
{
    const char *last = os_path_name(name), *end = strrchr(last, '.');
    if (!end)
        end = last + strlen(last);
    const char *begin = end;
    while (begin > last && isdigit((unsigned char)begin[-1]))
        begin--;
    const size_t n = (size_t)(end - begin);
    if (n == 0 || n > 16 || strlen(name) >= n_bytes)
        return false;
    snprintf(pattern, n_bytes, "%s", name);
    memset(pattern + (begin - name), '#', n);
    return true;
}

bool frame_guess_sequence(char *const *names, int n, char *pattern, size_t n_bytes)
{
    char other[4096];
    bool is_one = n >= 2 && frame_guess_pattern(names[0], pattern, n_bytes);
    for (int i = 1; i < n && is_one; i++)
        is_one = frame_guess_pattern(names[i], other, sizeof(other)) &&
                 strcmp(pattern, other) == 0;
    return is_one;
}

char *frame_name(const char *pattern, int32_t number, struct image_error *error)
{
    struct place place;
    const size_t size = strlen(pattern) + 112;
    char *name = app_memory(size, 1, error);
    if (name && find_place(pattern, &place))
        snprintf(name, size, "%.*s%0*d%s", (int)(place.begin - pattern), pattern,
                 place.n_digits, (int)number, place.end);
    else if (name)
        snprintf(name, size, "%s", pattern);
    return name;
}

char *frame_pattern(const char *pattern, struct image_error *error)
{
    struct place place;
    const size_t size = strlen(pattern) + 112;
    char *spelled = app_memory(size, 1, error);
    if (!spelled)
        return NULL;
    snprintf(spelled, size, "%s", pattern);
    if (find_place(pattern, &place)) {
        const size_t n_before = (size_t)(place.begin - pattern);
        memset(spelled + n_before, '#', (size_t)place.n_digits);
        snprintf(spelled + n_before + place.n_digits, strlen(place.end) + 1, "%s",
                 place.end);
    }
    return spelled;
}

/* The frames that a folder has. */
struct search {
    struct frame_list *list;
    const char *name; /* the pattern without its folder */
    size_t n_before;  /* characters before the number */
    struct image_error *error;
    bool lacks_memory;
};

static bool visit_file(void *user, const char *file)
{
    struct search *search = user;
    int32_t number;
    if (strncmp(file, search->name, search->n_before) != 0)
        return true;
    const char *at = file + search->n_before;
    if (take_number(&at, &number) != NUMBER)
        return true;
    char *again = frame_name(search->name, number, search->error);
    search->lacks_memory = !again || (strcmp(again, file) == 0 &&
                                      !add(search->list, number, search->error));
    free(again);
    return !search->lacks_memory;
}

bool frame_list_find(struct frame_list *list, const char *pattern,
                     struct image_error *error)
{
    const char *name = os_path_name(pattern);
    struct place place = {name, name, 0};
    *list = (struct frame_list){0};
    find_place(pattern, &place);
    char *folder = app_memory((size_t)(name - pattern) + 2, 1, error);
    if (!folder)
        return false;
    memcpy(folder, name == pattern ? "." : pattern,
           name == pattern ? 1 : (size_t)(name - pattern));
    struct search search = {list, name, (size_t)(place.begin - name), error, false};
    const int reason = os_folder_list(folder, visit_file, &search);
    if (reason != 0)
        set_error(error, "%s: %s", folder, strerror(reason));
    else if (!search.lacks_memory && list->n == 0)
        set_error(error,
                  "%s: no such frames; is the number of digits right? #### stands for "
                  "0001, # for 1",
                  pattern);
    free(folder);
    if (reason != 0 || search.lacks_memory || list->n == 0) {
        frame_list_free(list);
        return false;
    }
    sort_once(list);
    return true;
}
