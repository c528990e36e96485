/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Private copies of scene files. No line break is ever added or removed, so that line
 * numbers in POV-Ray's messages stay those of the user's file.
 */
#ifndef POVRAY_REWRITE_H
#define POVRAY_REWRITE_H

#include "lexer.h"
#include "text.h"

enum rewrite_mode {
    REWRITE_RECORD,  /* every item of a camera is also written to the debug stream */
    REWRITE_PINHOLE, /* apertures are multiplied by zero */
    /* As pinhole, and things let atmosphere into them: planes that stand in the scene,
     * all that stands in it or that macros make, without what macros make, and with what
     * is declared. Parts of blobs and of patterns cannot be hollow, and nobody can tell
     * what a macro's thing, or a declared one, is for. */
    REWRITE_HOLLOW_PLANES,
    REWRITE_HOLLOW,
    REWRITE_HOLLOW_TOP,
    REWRITE_HOLLOW_DECLARED,
    /* As pinhole, and the camera does not see what holds media (media.h): the rays of
     * the picture end behind it, at the same places. */
    REWRITE_BARE,
    REWRITE_N_MODES
};

struct rewrite {
    enum rewrite_mode mode;
    const char *head; /* goes to the beginning, but behind a #version */
    /* Path to put in place of an #include's string, or NULL to leave it. */
    const char *(*include_path)(void *user, const char *name);
    /* Does a macro of this name make a transformation (rewrite_makes_transform)? May be
     * NULL. */
    bool (*makes_transform)(void *user, const char *macro);
    void *user;
    /* Names that computed #includes came to so far; include_path knows them. */
    char *const *computed;
    int n_computed;
    /* Names of interiors and materials that hold media. */
    char *const *holders;
    int n_holders;
};

/* Appends the copy of a file to `out`. */
void rewrite_file(struct text *out, const struct tokens *tokens, size_t n_bytes,
                  const struct rewrite *how);

/* Does the file hold anything that some mode but hollow would change, or include what
 * may? */
bool rewrite_has_camera(const struct tokens *tokens);

/* The string of an #include at token i as a new string, NULL where it is computed. */
char *rewrite_include_name(const struct tokens *tokens, int i);

/* Does the file define a macro of this name that makes a transformation, and no other
 * item of a camera? */
bool rewrite_makes_transform(const struct tokens *tokens, const char *macro);

#endif
