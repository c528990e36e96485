/* SPDX-License-Identifier: Apache-2.0 */
/* The lens, cut into cells for which views stand. */
#ifndef RF_METHODS_VIEWS_VIEWS_LENS_H
#define RF_METHODS_VIEWS_VIEWS_LENS_H

#include "input/views_in.h"
#include "methods/views/merge.h"
#include "rackfocus/rackfocus.h"

/* What a window of several views needs around it. */
struct rf_margin {
    int px;     /* how far a pixel of the result looks */
    int border; /* px that the whole picture is continued by */
    int level;  /* the coarsest */
};

/* `surface_px` is what splitting and highlights need, `hidden_px` what hidden.c does.
 */
rf_result rf_views_margin(struct rf_work *work, int surface_px, int hidden_px,
                          struct rf_margin *margin, struct rf_error *error);

/* The view from the place nearest to the lens' centre. */
int rf_views_middle(const struct rf_work *work);

/*
 * Cuts the lens into cells, as many as views at the most, and their areas; returns how
 * many there are. Many views share them: a pixel of a cell has the samples of its own
 * views alone, and few of them are grain.
 */
int rf_views_make_cells(struct rf_views *v, struct rf_view_cell *cells, double *area);

/*
 * How far beyond the picture lies what the cells can show of it, px: what their views
 * see, moved to the cell's place, and its footprint.
 */
float rf_views_border(const struct rf_work *work, const struct rf_view_cell *cells,
                      int n);

#endif
