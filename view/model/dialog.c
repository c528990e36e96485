/* SPDX-License-Identifier: Apache-2.0 */
#include "model/dialog.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "folder.h"

enum { LEFT = 1, MOST_PATH = 4096 }; /* exit code of both where nothing was chosen */

static void name_log(const struct dialog *dialog, char *path, size_t n_bytes)
{
    snprintf(path, n_bytes, "%s/answer", dialog->folder);
}

static bool start(struct dialog *dialog, char *const *arguments)
{
    char log[MOST_PATH];
    name_log(dialog, log, sizeof(log));
    const struct os_process_request request = {.arguments = arguments, .log = log};
    return os_process_start(&dialog->process, &request) == 0;
}

/* The desktop's own is tried first. */
bool dialog_open(struct dialog *dialog, const char *folder)
{
    char from[MOST_PATH + 16];
    const char *desktop = getenv("XDG_CURRENT_DESKTOP");
    if (dialog->is_open || os_folder_make_temporary("rackfocus-view-", dialog->folder,
                                                    sizeof(dialog->folder)) != 0)
        return false;
    /* A slash at its end says that it is a folder. */
    snprintf(from, sizeof(from), "--filename=%s/", folder);
    char *const zenity[] = {"zenity", "--file-selection", "--title=Rack Focus",
                            *folder ? from : NULL, NULL};
    char *const kdialog[] = {"kdialog",
                             "--title",
                             "Rack Focus",
                             "--getopenfilename",
                             *folder ? (char *)folder : ".",
                             NULL};
    const bool is_kde = desktop && strstr(desktop, "KDE");
    dialog->is_open = start(dialog, is_kde ? kdialog : zenity) ||
                      start(dialog, is_kde ? zenity : kdialog);
    if (!dialog->is_open)
        os_folder_remove(dialog->folder);
    return dialog->is_open;
}

/* The last line that names a file: libraries print warnings of their own. */
static bool read_answer(const struct dialog *dialog, char *path, size_t n_bytes)
{
    char log[MOST_PATH], line[MOST_PATH];
    bool has_found = false;
    name_log(dialog, log, sizeof(log));
    FILE *file = fopen(log, "r");
    while (file && fgets(line, sizeof(line), file)) {
        line[strcspn(line, "\r\n")] = 0;
        if (os_file_facts(line).kind == OS_FILE_NONE)
            continue;
        has_found = strlen(line) < n_bytes;
        snprintf(path, n_bytes, "%s", line);
    }
    if (file)
        fclose(file);
    return has_found;
}

enum dialog_answer dialog_take(struct dialog *dialog, char *path, size_t n_bytes)
{
    if (!dialog->is_open || !os_process_has_ended(&dialog->process))
        return DIALOG_NONE;
    const int code = dialog->process.exit_code;
    const bool has_answer = code == 0 && read_answer(dialog, path, n_bytes);
    dialog_close(dialog);
    return has_answer ? DIALOG_CHOSEN : code == LEFT ? DIALOG_LEFT : DIALOG_FAILED;
}

void dialog_close(struct dialog *dialog)
{
    if (!dialog->is_open)
        return;
    os_process_end(&dialog->process);
    os_folder_remove(dialog->folder);
    *dialog = (struct dialog){0};
}
