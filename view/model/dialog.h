/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The desktop's own dialog for files, which is a program of its own: zenity of GNOME or
 * kdialog of KDE, where one is installed. Where none is, the window has its list.
 */
#ifndef VIEW_DIALOG_H
#define VIEW_DIALOG_H

#include <stdbool.h>
#include <stddef.h>

#include "process.h"

struct dialog {
    bool is_open;
    struct os_process process;
    char folder[1024]; /* temporary, for what the program prints */
};

/* Shows the dialog with this folder; "" for where it likes. False where there is none,
 * or it is open already. */
bool dialog_open(struct dialog *dialog, const char *folder);

enum dialog_answer {
    DIALOG_NONE,   /* none yet, or it is not open */
    DIALOG_CHOSEN, /* `path` */
    DIALOG_LEFT,   /* the user chose nothing */
    DIALOG_FAILED, /* it could not show itself */
};

/* Does not wait. Any answer but DIALOG_NONE has closed it. */
enum dialog_answer dialog_take(struct dialog *dialog, char *path, size_t n_bytes);

void dialog_close(struct dialog *dialog); /* ends it */

#endif
