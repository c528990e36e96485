/* SPDX-License-Identifier: Apache-2.0 */
#include "model/browser.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/report.h"
#include "file.h"
#include "folder.h"
#include "path.h"

static bool add(struct browser *b, enum browser_kind kind, const char *name)
{
    struct browser_item *items = realloc(b->items, ((size_t)b->n + 1) * sizeof(*items));
    char *copy = app_memory(strlen(name) + 1, 1, NULL);
    b->items = items ? items : b->items;
    if (!items || !copy) {
        free(copy);
        snprintf(b->problem, sizeof(b->problem), "out of memory");
        return false;
    }
    strcpy(copy, name);
    b->items[b->n++] = (struct browser_item){kind, copy};
    return true;
}

bool browser_is_for_us(const char *name)
{
    static const char *const endings[] = {".exr", ".png", ".pov", ".params"};
    const size_t n = strlen(name);
    for (size_t i = 0; i < sizeof(endings) / sizeof(endings[0]); i++) {
        const size_t length = strlen(endings[i]);
        if (n > length && strcasecmp(name + n - length, endings[i]) == 0)
            return true;
    }
    return false;
}

static void join(const struct browser *b, const char *name, char *path, size_t n_bytes)
{
    const size_t n = strlen(b->folder);
    const bool has_slash = n > 0 && b->folder[n - 1] == '/';
    snprintf(path, n_bytes, "%s%s%s", b->folder, has_slash ? "" : "/", name);
}

static bool add_entry(void *user, const char *name)
{
    struct browser *b = user;
    char path[2 * REMEMBERED_PATH];
    if (name[0] == '.')
        return true;
    join(b, name, path, sizeof(path));
    const enum os_file_kind kind = os_file_facts(path).kind;
    if (kind == OS_FILE_FOLDER)
        return add(b, BROWSER_FOLDER, name);
    return kind != OS_FILE_REGULAR || !browser_is_for_us(name) ||
           add(b, BROWSER_FILE, name);
}

static int compare(const void *a, const void *b)
{
    const struct browser_item *x = a, *y = b;
    return x->kind != y->kind ? (int)x->kind - (int)y->kind : strcmp(x->name, y->name);
}

static void forget_items(struct browser *b)
{
    for (int i = 0; i < b->n; i++)
        free(b->items[i].name);
    free(b->items);
    b->items = NULL;
    b->n = b->at = 0;
    b->problem[0] = b->typed[0] = 0;
    b->is_unknown = false;
}

void browser_free(struct browser *b)
{
    forget_items(b);
    *b = (struct browser){0};
}

void browser_open(struct browser *b, const char *folder,
                  const struct remembered *recent)
{
    char *full = os_file_full_path(*folder ? folder : ".");
    forget_items(b);
    snprintf(b->folder, sizeof(b->folder), "%s", full ? full : folder);
    free(full);
    for (int i = 0; recent && i < recent->n_files; i++)
        if (os_file_facts(recent->files[i]).kind != OS_FILE_NONE)
            add(b, BROWSER_RECENT, recent->files[i]);
    const int n_recent = b->n;
    const int reason = os_folder_list(b->folder, add_entry, b);
    if (reason != 0)
        snprintf(b->problem, sizeof(b->problem), "cannot be read: %s",
                 strerror(reason));
    if (b->n > n_recent)
        qsort(b->items + n_recent, (size_t)(b->n - n_recent), sizeof(*b->items),
              compare);
}

void browser_type(struct browser *b, const char *text, bool is_anew)
{
    const size_t n_before = is_anew ? 0 : strlen(b->typed);
    snprintf(b->typed + n_before, sizeof(b->typed) - n_before, "%s", text);
    b->is_unknown = true;
    for (int i = 0; i < b->n && b->is_unknown; i++) {
        const char *name = os_path_name(b->items[i].name);
        if (strncasecmp(name, b->typed, strlen(b->typed)) != 0)
            continue;
        b->at = i;
        b->is_unknown = false;
    }
}

void browser_move(struct browser *b, int by)
{
    b->typed[0] = 0;
    b->is_unknown = false;
    b->at += by;
    b->at = b->at >= b->n ? b->n - 1 : b->at;
    b->at = b->at < 0 ? 0 : b->at;
}

bool browser_choose(struct browser *b, char *path, size_t n_bytes)
{
    if (b->n == 0)
        return false;
    const struct browser_item *item = &b->items[b->at];
    if (item->kind == BROWSER_RECENT)
        snprintf(path, n_bytes, "%s", item->name);
    else
        join(b, item->name, path, n_bytes);
    if (item->kind != BROWSER_FOLDER)
        return true;
    browser_open(b, path, NULL);
    return false;
}

void browser_up(struct browser *b)
{
    char above[REMEMBERED_PATH];
    snprintf(above, sizeof(above), "%s", b->folder);
    char *slash = strrchr(above, '/');
    if (slash)
        slash[slash == above] = 0; /* the root keeps its slash */
    browser_open(b, slash ? above : "/", NULL);
}
