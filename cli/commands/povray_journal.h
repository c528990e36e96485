/* SPDX-License-Identifier: Apache-2.0 */
/* The frames of an animation of POV-Ray: which are finished. */
#ifndef CLI_POVRAY_JOURNAL_H
#define CLI_POVRAY_JOURNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "commands/povray_command.h"
#include "povray.h"
#include "sequence/frames_check.h"
#include "sequence/journal.h"
#include "sources/settings.h"

struct povray_journal {
    struct journal journal;
    const struct povray_tool *tool;
    uint64_t hash;     /* of all that a frame depends on but its number */
    bool has_computed; /* and on files that nobody knows (povray_list_inputs) */
    bool has_said;     /* which the user has been told */
};

/* Opens the journal of what `pattern` names. An exit code; messages have been printed.
 */
int povray_journal_open(struct povray_journal *journal, const char *pattern,
                        const struct povray_tool *tool, const struct settings *settings,
                        const struct povray_plan *plan,
                        const struct povray_frames *frames);
void povray_journal_close(struct povray_journal *journal);

/* Is the frame there, made as it would be now? `files`: all that it writes. */
bool povray_journal_finds(struct povray_journal *journal, int32_t number,
                          const struct frame_files *files);
/* The same, and says so. */
bool povray_journal_has(struct povray_journal *journal, int32_t number,
                        const struct frame_files *files);

/* The frame has been made. */
void povray_journal_add(struct povray_journal *journal, int32_t number,
                        const struct frame_files *files, double seconds);

/* Fills the verdict on the frame. An exit code. */
int povray_journal_check(struct povray_journal *journal, struct frame_check *check,
                         const struct frame_files *files);

#endif
