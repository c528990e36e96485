/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers of frames: from the command line and from the files that there are. */
#ifndef APP_FRAME_LIST_H
#define APP_FRAME_LIST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "image.h"

struct frame_list {
    int32_t *numbers; /* rising, each once */
    int n;
};

/* The number of a frame and nothing else. */
bool frame_number_parse(const char *text, int32_t *number);

/* "1-240x2,300": from 1 to 240 in steps of 2, and 300. */
bool frame_list_parse(struct frame_list *list, const char *text,
                      struct image_error *error);
/* The files that a pattern names. */
bool frame_list_find(struct frame_list *list, const char *pattern,
                     struct image_error *error);
/* The frames between the first and the last that a list lacks, where it goes in equal
 * steps otherwise. False without memory. */
bool frame_list_missing(struct frame_list *missing, const struct frame_list *list,
                        struct image_error *error);
/* Says which those are, "of frames 1 to 8 there is no 4,6-7", of a shot, that is where
 * more frames are there than not: a few stills have no holes. Else the text is "". False
 * without memory. */
enum { FRAME_LIST_HOLES = 256 };
bool frame_list_holes(const struct frame_list *list, char text[FRAME_LIST_HOLES],
                      struct image_error *error);
/* n rising numbers as frame_list_parse() reads them: "1-240,300". The caller frees; NULL
 * without memory. */
char *frame_list_text(const int32_t *numbers, int n, struct image_error *error);
void frame_list_free(struct frame_list *list);

/* Has the last part of a path a place for the number of a frame: ####, or as other
 * programs write it, %04d (Nuke) or $F4 (Houdini)? */
bool frame_is_pattern(const char *name);

/* Has a folder of a path, which there is not, such a place? Then also the command of a
 * shell that links the files side by side, as frame.####. */
bool frame_is_in_folder(const char *name, char *links, size_t n_bytes);

/*
 * The name with #### where its last part has the number of a frame as programs write it
 * that are not followed: @@@@, <frame04> and <f4>, {frame}, [1-240] and [####], $frame,
 * 0001-0240 before the ending.
 * "shot.%04d.exr 1-240", as Nuke copies it, becomes the name alone. False where there
 * is nothing of the kind.
 */
bool frame_guess_foreign(const char *name, char *pattern, size_t n_bytes);

/* The pattern of a file that may be a frame: "shot.0001.exr" gives "shot.####.exr".
 * False where the last part has no digits before its ending. */
bool frame_guess_pattern(const char *name, char *pattern, size_t n_bytes);

/* Do the files, two or more, look like frames of one sequence: alike but for digits?
 * The pattern that names them. */
bool frame_guess_sequence(char *const *names, int n, char *pattern, size_t n_bytes);

/* The name of a frame: the last such place becomes its number, padded with zeros. The
 * caller frees; NULL without memory. */
char *frame_name(const char *pattern, int32_t number, struct image_error *error);

/* The pattern with # for each digit of the number, however it is spelled: those of the
 * same files are one. The caller frees; NULL without memory. */
char *frame_pattern(const char *pattern, struct image_error *error);

#endif
