/* SPDX-License-Identifier: Apache-2.0 */
/* Other layers of the picture (light groups, normals) through the same lens. */
#ifndef APP_AOV_H
#define APP_AOV_H

#include "rackfocus/rackfocus.h"
#include "sources/source.h"

struct aovs {
    int n;          /* channels */
    int *channels;  /* of source->colour */
    float *samples; /* n per pixel, interleaved */
};

/*
 * Finds the channels of the layers in `names` ("diffuse,ViewLayer.Normal"): those whose
 * dotted name has the layer's words in front of its last one, or that is their name.
 * They must be in the part of the colour and full-size. False with a message: nothing
 * of that name, identifiers, which no mean can be taken of.
 */
bool aovs_find(struct aovs *aovs, const struct source *source, const char *names,
               struct image_error *error);

/*
 * Reads and filters them, three channels at a time, with weights that follow from depth
 * and lens alone: linear, so that what was added up before the lens adds up behind it.
 * What belongs to the colours of one picture is left out: split edges, highlights
 * apart or changed, a blend gamma. The layers of the picture itself may so differ from it at such
 * places.
 */
bool aovs_filter(struct aovs *aovs, const struct source *source,
                 const struct rf_context *context, const struct rf_params *params,
                 const float *depth, int n_threads, struct image_error *error);

void aovs_free(struct aovs *aovs);

#endif
