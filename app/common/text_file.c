/* SPDX-License-Identifier: Apache-2.0 */
#include "common/text_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "file.h"
#include "replace.h"

/* Closes the stream, too. 0 or errno. */
static int print_all(FILE *stream, text_print_fn print, const void *data)
{
    if (!stream)
        return errno;
    errno = 0;
    print(stream, data);
    const bool is_good = fflush(stream) == 0 && !ferror(stream);
    const int reason = is_good ? 0 : errno ? errno : EIO;
    return fclose(stream) == 0 || reason != 0 ? reason : errno;
}

bool text_file_write(const char *path, text_print_fn print, const void *data,
                     struct image_error *error)
{
    struct os_replace file;
    int reason = os_replace_open(&file, path);
    if (reason == 0) {
        reason = print_all(os_replace_stream(&file), print, data);
        if (reason == 0)
            reason = os_replace_commit(&file);
        else
            os_replace_abort(&file);
    }
    if (reason == 0)
        return true;
    return set_error(
        error, "%s: cannot be written: %s; choose another name or free some space",
        path,
        reason == OS_REPLACE_NOT_REGULAR ? "is no regular file"
        : reason == OS_REPLACE_IN_USE    ? "another program has it open"
                                         : strerror(reason));
}

/* ---- reading --------------------------------------------------------------------- */

/* Of parameters and tables; far more than a person types, far less than a picture. */
enum { MOST_BYTES = 16 << 20 };

static char *lacks_memory(struct image_error *error)
{
    app_fail(error, APP_NO_MEMORY, "out of memory");
    return NULL;
}

/* Up to the end or MOST_BYTES + 1, with a 0 behind them. */
static char *read_bytes(FILE *file, size_t *n_bytes, struct image_error *error)
{
    size_t n = 0, n_most = 4096;
    char *text = malloc(n_most + 1);
    while (text) {
        n += fread(text + n, 1, n_most - n, file);
        if (n < n_most || n > MOST_BYTES)
            break;
        n_most *= 2;
        char *grown = realloc(text, n_most + 1);
        if (!grown)
            free(text);
        text = grown;
    }
    if (!text)
        return lacks_memory(error);
    text[n] = '\0';
    *n_bytes = n;
    return text;
}

/* Begins it as UTF-16 does in either order of bytes? */
static bool is_utf16(const char *text, size_t n_bytes)
{
    return n_bytes >= 2 &&
           (memcmp(text, "\xff\xfe", 2) == 0 || memcmp(text, "\xfe\xff", 2) == 0);
}

static bool check_text(const char *path, const char *text, size_t n_bytes,
                       struct image_error *error)
{
    if (is_utf16(text, n_bytes))
        return set_error(error, "%s: its text is UTF-16; save it as UTF-8", path);
    if (n_bytes > MOST_BYTES || memchr(text, '\0', n_bytes))
        return set_error(error,
                         "%s: is no text file; give one with a parameter or a row in "
                         "each line",
                         path);
    return true;
}

char *text_file_read(const char *path, struct image_error *error)
{
    static const char mark[] = "\xef\xbb\xbf"; /* as Excel and Notepad write it */
    const size_t n_mark = sizeof(mark) - 1;
    size_t n = 0;
    if (os_file_facts(path).kind == OS_FILE_FOLDER) {
        set_error(error, "%s: is a folder; give the name of a file", path);
        return NULL;
    }
    FILE *file = fopen(path, "rb");
    if (!file) {
        set_error(error, "%s: cannot be read: %s", path, strerror(errno));
        return NULL;
    }
    errno = 0;
    char *text = read_bytes(file, &n, error);
    if (text && ferror(file)) {
        set_error(error, "%s: cannot be read: %s", path, strerror(errno ? errno : EIO));
        free(text);
        text = NULL;
    }
    fclose(file);
    if (text && !check_text(path, text, n, error)) {
        free(text);
        text = NULL;
    }
    if (text && strncmp(text, mark, n_mark) == 0)
        memmove(text, text + n_mark, n - n_mark + 1);
    return text;
}

char *text_next_line(char **rest)
{
    char *line = *rest;
    if (*line == '\0')
        return NULL;
    const size_t n = strcspn(line, "\r\n");
    const bool is_pair = line[n] == '\r' && line[n + 1] == '\n';
    *rest = line + n + (is_pair ? 2 : line[n] != '\0');
    line[n] = '\0';
    return line;
}
