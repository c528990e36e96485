/* SPDX-License-Identifier: Apache-2.0 */
#include "sequence/journal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "common/frame_list.h"
#include "common/report.h"
#include "file.h"
#include "folder.h"
#include "path.h"
#include "process.h"
#include "replace.h"

/* Of notes, by enum journal_kind. */
static const char *const kind_words[JOURNAL_N_KINDS] = {"", "made", "warning",
                                                        "failed"};

bool journal_open(struct journal *journal, const char *pattern,
                  struct image_error *error)
{
    *journal = (struct journal){0};
    os_machine_name(journal->host, sizeof(journal->host));
    if (!journal->host[0])
        snprintf(journal->host, sizeof(journal->host), "unnamed");
    char *spelled = frame_pattern(pattern, error);
    if (!spelled)
        return false;
    const size_t n = strlen(spelled) + sizeof(".frames");
    const size_t n_own = n + sizeof(journal->host) + 48;
    journal->path = app_memory(n, 1, error);
    journal->own_path = app_memory(n_own, 1, error);
    if (!journal->path || !journal->own_path) {
        free(journal->path);
        free(journal->own_path);
        free(spelled);
        return false;
    }
    snprintf(journal->path, n, "%s.frames", spelled);
    free(spelled);
    /* The time, because two machines may have one name (containers) and numbers of
     * processes come again. */
    snprintf(journal->own_path, n_own, "%s.%s-%" PRId64 "-%" PRIx64, journal->path,
             journal->host, os_process_number(), (uint64_t)(1e6 * os_clock_date_s()));
    os_lock_init(&journal->lock);
    return true;
}

/* ---- the files ------------------------------------------------------------------ */

/* The files of processes. */
struct paths {
    char **items;
    int n;
    const char *folder;
    size_t n_folder;
    const char *start; /* of their names: "NAME.frames" */
    struct image_error *error;
    bool lacks_memory;
};

/* ".partXXXXXX": being written beside its place (replace.h). */
static bool is_unfinished(const char *ending)
{
    return strncmp(ending, ".part", 5) == 0 && strlen(ending) == 11;
}

static bool add_path(void *user, const char *name)
{
    struct paths *paths = user;
    const size_t n_start = strlen(paths->start);
    if (strncmp(name, paths->start, n_start) != 0 || name[n_start] != '.' ||
        is_unfinished(name + n_start))
        return true;
    char **grown = app_memory((size_t)paths->n + 1, sizeof(*grown), paths->error);
    char *path = app_memory(paths->n_folder + strlen(name) + 1, 1, paths->error);
    paths->lacks_memory = !grown || !path;
    if (paths->lacks_memory) {
        free(grown);
        free(path);
        return false;
    }
    memcpy(path, paths->folder, paths->n_folder);
    strcpy(path + paths->n_folder, name);
    if (paths->n)
        memcpy(grown, paths->items, (size_t)paths->n * sizeof(*grown));
    grown[paths->n++] = path;
    free(paths->items);
    paths->items = grown;
    return true;
}

static void paths_free(struct paths *paths)
{
    for (int i = 0; i < paths->n; i++)
        free(paths->items[i]);
    free(paths->items);
    paths->items = NULL;
    paths->n = 0;
}

/* False without memory. */
static bool paths_find(struct paths *paths, const char *journal_path,
                       struct image_error *error)
{
    const char *name = os_path_name(journal_path);
    const size_t n = (size_t)(name - journal_path);
    *paths = (struct paths){
        .folder = journal_path, .n_folder = n, .start = name, .error = error};
    char *folder = app_memory(n + 2, 1, error);
    if (!folder)
        return false;
    memcpy(folder, n ? journal_path : ".", n ? n : 1);
    os_folder_list(folder, add_path, paths);
    free(folder);
    if (paths->lacks_memory)
        paths_free(paths);
    return !paths->lacks_memory;
}

/* What a file holds, ended by 0; an empty text where it cannot be read, NULL without
 * memory. */
static char *read_file(const char *path, size_t *n_bytes, struct image_error *error)
{
    const struct os_file_facts facts = os_file_facts(path);
    const size_t room = facts.kind == OS_FILE_REGULAR ? (size_t)facts.n_bytes : 0;
    char *text = app_memory(room + 1, 1, error);
    FILE *file = text && room ? fopen(path, "rb") : NULL;
    *n_bytes = file ? fread(text, 1, room, file) : 0;
    if (file)
        fclose(file);
    if (text)
        text[*n_bytes] = '\0';
    return text;
}

/* ---- lines ---------------------------------------------------------------------- */

/* "@ HOST PROCESS DATE REST" at `at`, which it cuts; leaves what is missing. */
static void parse_origin(struct journal_line *line, char *at)
{
    char *rest = at, *host = strsep(&rest, " ");
    const char *process = rest ? strsep(&rest, " ") : NULL;
    const char *date = rest ? strsep(&rest, " ") : NULL;
    if (!date || !rest)
        return;
    line->host = host;
    line->process = strtoll(process, NULL, 10);
    line->date_s = strtod(date, NULL);
    if (line->kind == JOURNAL_FINISHED)
        line->seconds = strtod(rest, NULL);
    else
        line->text = rest;
}

/* The line at `text`, without its end, which it cuts; false where it is none. */
static bool parse_line(struct journal_line *line, char *text)
{
    *line = (struct journal_line){.host = "", .text = ""};
    const bool is_note = text[0] == '#' && text[1] == ' ';
    char *end, *begin = text + (is_note ? 2 : 0);
    const long number = strtol(begin, &end, 10);
    if (end == begin || *end != ' ')
        return false;
    line->number = (int32_t)number;
    begin = end + 1;
    char *origin = strstr(begin, " @ ");
    if (origin) {
        *origin = '\0';
        origin += 3;
    }
    if (is_note) {
        for (int i = JOURNAL_MADE; i < JOURNAL_N_KINDS; i++)
            if (strcmp(begin, kind_words[i]) == 0)
                line->kind = (enum journal_kind)i;
        if (line->kind == JOURNAL_FINISHED)
            return false;
    } else {
        line->hash = strtoull(begin, &end, 16);
        if (end != begin + 16 || *end != ' ')
            return false;
        line->text = end + 1;
    }
    if (origin)
        parse_origin(line, origin);
    return !is_note || origin;
}

static int count_ends(const char *text)
{
    int n = 0;
    while ((text = strchr(text, '\n')) != NULL) {
        text++;
        n++;
    }
    return n;
}

/* Only lines that have their end count. */
static void parse_buffer(struct journal *journal, char *text)
{
    for (char *end; (end = strchr(text, '\n')) != NULL; text = end + 1) {
        *end = '\0';
        struct journal_line *line = &journal->lines[journal->n_lines];
        if (!parse_line(line, text))
            continue;
        line->order = journal->n_lines++;
    }
}

static int compare_lines(const void *a, const void *b)
{
    const struct journal_line *x = a, *y = b;
    if (x->number != y->number)
        return x->number > y->number ? 1 : -1;
    return (x->order > y->order) - (x->order < y->order);
}

static bool load_files(struct journal *journal, const struct paths *paths,
                       struct image_error *error)
{
    size_t n_bytes, n_lines = 0;
    journal->buffers = app_memory((size_t)paths->n + 1, sizeof(char *), error);
    if (!journal->buffers)
        return false;
    journal->n_buffers = paths->n + 1;
    /* Processes first, and then where they are folded into: what one of them loses to
     * it in between is there. The order of lines is the other way round. */
    for (int i = paths->n; i >= 0; i--) {
        const char *path = i > 0 ? paths->items[i - 1] : journal->path;
        journal->buffers[i] = read_file(path, &n_bytes, error);
        if (!journal->buffers[i])
            return false;
        n_lines += (size_t)count_ends(journal->buffers[i]);
    }
    journal->lines = app_memory(n_lines, sizeof(*journal->lines), error);
    if (!journal->lines)
        return false;
    for (int i = 0; i < journal->n_buffers; i++)
        parse_buffer(journal, journal->buffers[i]);
    qsort(journal->lines, (size_t)journal->n_lines, sizeof(*journal->lines),
          compare_lines);
    return true;
}

static void unload(struct journal *journal)
{
    for (int i = 0; i < journal->n_buffers; i++)
        free(journal->buffers[i]);
    free(journal->buffers);
    free(journal->lines);
    journal->buffers = NULL;
    journal->lines = NULL;
    journal->n_buffers = journal->n_lines = 0;
    journal->is_loaded = false;
}

bool journal_load(struct journal *journal, struct image_error *error)
{
    struct paths paths = {0};
    os_lock_take(&journal->lock);
    bool is_good = journal->is_loaded;
    if (!is_good && paths_find(&paths, journal->path, error)) {
        is_good = load_files(journal, &paths, error);
        if (!is_good)
            unload(journal);
        journal->is_loaded = is_good;
        paths_free(&paths);
    }
    os_lock_release(&journal->lock);
    return is_good;
}

const struct journal_line *journal_lines(const struct journal *journal, int32_t number,
                                         int *n)
{
    int low = 0, high = journal->n_lines;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (journal->lines[middle].number < number)
            low = middle + 1;
        else
            high = middle;
    }
    *n = 0;
    while (low + *n < journal->n_lines && journal->lines[low + *n].number == number)
        (*n)++;
    return journal->lines + low;
}

/* ---- writing -------------------------------------------------------------------- */

static int add_line(struct journal *journal, const char *line)
{
    os_lock_take(&journal->lock);
    const int reason = os_file_append(journal->own_path, line, strlen(line));
    os_lock_release(&journal->lock);
    return reason;
}

int journal_add_finished(struct journal *journal, int32_t number, uint64_t hash,
                         const char *files, double seconds)
{
    char line[320];
    snprintf(line, sizeof(line), "\n%d %016" PRIx64 " %s @ %s %" PRId64 " %.0f %.3f\n",
             (int)number, hash, files, journal->host, os_process_number(),
             os_clock_date_s(), seconds);
    return add_line(journal, line);
}

int journal_add_note(struct journal *journal, int32_t number, enum journal_kind kind,
                     const char *text)
{
    char line[1280];
    const int n = snprintf(line, sizeof(line) - 1, "\n# %d %s @ %s %" PRId64 " %.0f %s",
                           (int)number, kind_words[kind], journal->host,
                           os_process_number(), os_clock_date_s(), text);
    for (char *at = line + 1; *at; at++)
        if (*at == '\n' || *at == '\r')
            *at = ' ';
    strcpy(line + (n < (int)sizeof(line) - 2 ? n : (int)sizeof(line) - 2), "\n");
    return add_line(journal, line);
}

/* ---- folding -------------------------------------------------------------------- */

static bool write_all(FILE *stream, char *const *texts, const size_t *sizes, int n)
{
    bool is_good = stream != NULL;
    for (int i = 0; i < n && is_good; i++)
        is_good = fwrite(texts[i], 1, sizes[i], stream) == sizes[i];
    return stream && fclose(stream) == 0 && is_good;
}

/* Writes what the files hold into `path`. 0 or what os_replace_open() returns. */
static int write_folded(const char *path, char *const *texts, const size_t *sizes,
                        int n)
{
    struct os_replace file;
    int reason = os_replace_open(&file, path);
    if (reason != 0)
        return reason;
    errno = 0;
    if (write_all(os_replace_stream(&file), texts, sizes, n))
        return os_replace_commit(&file);
    reason = errno ? errno : EIO;
    os_replace_abort(&file);
    return reason;
}

/* A file that has grown since it was read stays, to be folded the next time. */
static void remove_folded(const struct paths *paths, const size_t *sizes)
{
    for (int i = 0; i < paths->n; i++)
        if (os_file_facts(paths->items[i]).n_bytes == (int64_t)sizes[i])
            remove(paths->items[i]);
}

static bool fold_paths(const char *path, const struct paths *paths,
                       struct image_error *error)
{
    const size_t n = (size_t)paths->n + 1;
    char **texts = app_memory(n, sizeof(*texts), error);
    size_t *sizes = app_memory(n, sizeof(*sizes), error);
    bool is_good = texts && sizes;
    /* As in load_files(): where they are folded into comes last. */
    for (int i = paths->n; i >= 0 && is_good; i--) {
        const char *from = i > 0 ? paths->items[i - 1] : path;
        texts[i] = read_file(from, &sizes[i], error);
        is_good = texts[i] != NULL;
    }
    if (is_good && os_file_facts(path).n_bytes > (int64_t)sizes[0])
        is_good = set_error(error, "%s: cannot be read; it stays as it is", path);
    if (is_good) {
        const int reason = write_folded(path, texts, sizes, (int)n);
        if (reason == 0)
            remove_folded(paths, sizes + 1);
        else
            is_good = set_error(error, "%s: %s; nothing in it is lost", path,
                                reason > 0 ? strerror(reason) : "cannot be replaced");
    }
    for (size_t i = 0; i < n && texts; i++)
        free(texts[i]);
    free(texts);
    free(sizes);
    return is_good;
}

bool journal_fold(struct journal *journal, struct image_error *error)
{
    struct paths paths;
    if (!paths_find(&paths, journal->path, error))
        return false;
    const bool is_good = paths.n == 0 || fold_paths(journal->path, &paths, error);
    paths_free(&paths);
    return is_good;
}

/* Of this process, or of one of this machine that is no more? The name says it. */
static bool is_over(const struct journal *journal, const char *path)
{
    const size_t n = strlen(journal->path), n_host = strlen(journal->host);
    const char *host = path + n + 1;
    if (strcmp(path, journal->own_path) == 0)
        return true;
    if (strncmp(host, journal->host, n_host) != 0 || host[n_host] != '-')
        return false;
    return !os_process_exists(strtoll(host + n_host + 1, NULL, 10));
}

/* Folds where nobody else is at work. Two that end at once leave both files: each sees
 * the other's. */
static void fold_at_end(const struct journal *journal)
{
    struct paths paths;
    struct image_error ignored; /* then the files stay, and are read as well */
    if (!paths_find(&paths, journal->path, &ignored))
        return;
    bool is_alone = paths.n > 0;
    for (int i = 0; i < paths.n && is_alone; i++)
        is_alone = is_over(journal, paths.items[i]);
    if (is_alone)
        fold_paths(journal->path, &paths, &ignored);
    paths_free(&paths);
}

void journal_close(struct journal *journal)
{
    fold_at_end(journal);
    unload(journal);
    os_lock_destroy(&journal->lock);
    free(journal->path);
    free(journal->own_path);
}
