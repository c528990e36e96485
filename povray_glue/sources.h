/* SPDX-License-Identifier: Apache-2.0 */
/* The files of a scene: found as POV-Ray finds them, and their private copies. */
#ifndef POVRAY_SOURCES_H
#define POVRAY_SOURCES_H

#include <stdbool.h>
#include <stdint.h>

#include "rewrite.h"
#include "text.h"

struct source {
    char *path;                  /* as opened */
    char *copy[REWRITE_N_MODES]; /* private copy per rewrite_mode; NULL where the
                                    original serves */
    struct text content;
    struct tokens tokens;
    bool needs_copy;
    bool is_own; /* the scene's, not one of POV-Ray's */
};

struct sources {
    struct source *items; /* the scene first */
    int n;
    char **folders; /* where includes are looked for, in order; "" is the current one */
    int n_folders;
    int header;      /* of options (Include_Header), index of items; 0: none */
    char **computed; /* names that computed #includes came to, of files with copies */
    int n_computed;
    int32_t width, height;   /* 0: as POV-Ray has them */
    double now_days;         /* what `now` is in all copies: days since 2000, UTC */
    const char *temp_folder; /* with its slash */
    enum rewrite_mode mode;  /* of the copies being made */
    /* Words found anywhere in the scene's own files. */
    bool has_fog, has_radiosity, has_photons, has_media;
    bool holds_media; /* in a thing that bends no light (media.h) */
    char **holders;   /* names of interiors and materials that do */
    int n_holders;
    bool has_bumps;        /* normal { ... } of a texture */
    bool has_clear;        /* something may let light through */
    bool has_now;          /* the scene reads the time */
    bool keeps_light;      /* options want a file of radiosity's light written */
    bool writes_files;     /* each run needs a folder of its own to write to */
    bool writes_elsewhere; /* where no such folder helps: runs must not overlap */
    char **written;        /* names of files that #fopen writes or appends to */
    int n_written;
};

/*
 * Reads the scene and its includes. `args` are POV-Ray's options: their library paths
 * count. False with errno where the scene cannot be read.
 */
bool sources_load(struct sources *sources, const char *scene, char *const *args,
                  int n_args, const char *temp_folder);
void sources_free(struct sources *sources);

/* Where POV-Ray finds a file of this name; NULL where nowhere. The caller frees. */
char *sources_find(const struct sources *sources, const char *name);

/* A name that a computed #include came to; true where its file needs copies that the
 * ones written so far do not have: forget these, and write them anew. */
bool sources_add_computed(struct sources *sources, const char *name);
void sources_forget_copies(struct sources *sources);

/* Does the scene declare an image_width or image_height of its own? */
bool sources_declare_size(const struct sources *sources);

/* What image_width and image_height are to be in the copies to come, but those that
 * record: the passes may be larger than the picture. */
void sources_set_size(struct sources *sources, int32_t width, int32_t height);

/*
 * Writes the copies of a mode. The scene's own copy becomes NAME in the temporary
 * folder, with `head` at its beginning (behind a #version) and `tail` behind
 * it; both may be "". False with errno.
 */
bool sources_write(struct sources *sources, enum rewrite_mode mode, const char *name,
                   const char *head, const char *tail);

/* The copy of the options' header as it was written last; NULL where it has none. */
const char *sources_header(const struct sources *sources, enum rewrite_mode mode);

/* Gives private names in a message of POV-Ray back their own; the caller frees. */
char *sources_original_names(const struct sources *sources, const char *message);

#endif
