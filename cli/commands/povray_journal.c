/* SPDX-License-Identifier: Apache-2.0 */
#include "commands/povray_journal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "console/cli.h"
#include "rackfocus/rackfocus.h"

static void hash_input(void *user, const char *text, bool is_file)
{
    if (is_file)
        frame_hash_file(user, text);
    else
        frame_hash_text(user, text);
}

/* What was typed, but what the pictures do not depend on: frames, threads, words. */
static void hash_tool(uint64_t *hash, const struct povray_tool *tool)
{
    const double numbers[] = {tool->aperture, tool->shutter, tool->stop.f_stop,
                              tool->stop.radius[0], tool->stop.radius[1]};
    const int32_t integers[] = {
        tool->n_views,      tool->n_reference, tool->n_samples,
        tool->overscan_px,  tool->move,        tool->is_linear,
        tool->has_subpixel, tool->is_average,  tool->is_through_glass};
    frame_hash_text(hash, tool->program);
    frame_hash_text(hash, tool->output);
    frame_hash_text(hash, tool->keep);
    frame_hash_text(hash, tool->reference);
    frame_hash_text(hash, tool->focal_point);
    frame_hash_file(hash, tool->distribution_image);
    frame_hash_bytes(hash, numbers, sizeof(numbers));
    frame_hash_bytes(hash, integers, sizeof(integers));
}

int povray_journal_open(struct povray_journal *journal, const char *pattern,
                        const struct povray_tool *tool, const struct settings *settings,
                        const struct povray_plan *plan,
                        const struct povray_frames *frames)
{
    struct image_error error;
    const int32_t range[] = {frames->animation_first, frames->animation_last};
    *journal = (struct povray_journal){.tool = tool, .hash = FRAME_HASH_START};
    frame_hash_text(&journal->hash, rf_version());
    frame_hash_settings(&journal->hash, settings);
    hash_tool(&journal->hash, tool);
    frame_hash_bytes(&journal->hash, range, sizeof(range));
    /* A scene that cannot be read is told of when it is rendered. */
    povray_list_inputs(plan, hash_input, &journal->hash, &journal->has_computed);
    if (journal_open(&journal->journal, pattern, &error))
        return EXIT_DONE;
    message("%s", error.message);
    return EXIT_FAILED;
}

void povray_journal_close(struct povray_journal *journal)
{
    journal_close(&journal->journal);
}

static uint64_t hash_of(const struct povray_journal *journal, int32_t number)
{
    uint64_t hash = journal->hash;
    frame_hash_bytes(&hash, &number, sizeof(number));
    return hash;
}

bool povray_journal_finds(struct povray_journal *journal, int32_t number,
                          const struct frame_files *files)
{
    return frame_is_finished(&journal->journal, number, hash_of(journal, number),
                             files);
}

bool povray_journal_has(struct povray_journal *journal, int32_t number,
                        const struct frame_files *files)
{
    const struct povray_tool *tool = journal->tool;
    if (!povray_journal_finds(journal, number, files))
        return false;
    if (journal->has_computed && !journal->has_said)
        warning(tool->is_quiet, "the scene puts names together (concat): whether files "
                                "so named have changed is not looked at; --anew makes "
                                "all frames again");
    journal->has_said = true;
    if (!tool->is_quiet)
        printf("frame %d: %s is there\n", (int)number, files->paths[0]);
    return true;
}

void povray_journal_add(struct povray_journal *journal, int32_t number,
                        const struct frame_files *files, double seconds)
{
    char sums[FRAME_SUMS];
    if (!frame_sum_files(files, sums))
        return;
    const int reason = journal_add_finished(&journal->journal, number,
                                            hash_of(journal, number), sums, seconds);
    if (reason != 0)
        warning(journal->tool->is_quiet, "%s: %s; frame %d will not be skipped",
                journal->journal.path, strerror(reason), (int)number);
}

int povray_journal_check(struct povray_journal *journal, struct frame_check *check,
                         const struct frame_files *files)
{
    struct image_error error;
    const uint64_t hash = hash_of(journal, check->number);
    const size_t n = strlen(files->paths[0]) + 1;
    check->path = app_memory(n, 1, &error);
    if (!check->path)
        return exit_without_memory();
    memcpy(check->path, files->paths[0], n);
    return frame_check_files(check, &journal->journal, &hash, files, &error)
               ? EXIT_DONE
               : exit_without_memory();
}
