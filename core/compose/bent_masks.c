/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Masks of lights whose discs are not drawn where their lens points are: with spherical
 * aberration the light of u lands at r0 u - a |p|^2 u, but what stands before it is hit
 * by other rays of the same lens points, and where the surface in focus is no plane, r0
 * is another at each pixel. A mask is drawn as for a = 0 and one radius, over the whole
 * disc, and each footprint pixel then asks it at r0 u.
 */
#include "compose/bent_masks.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/math.h"
#include "compose/scene.h"
#include "input/field.h"
#include "input/frame.h"
#include "kernels/data.h"

/* The height on the lens through which light of radius r lands `distance` px away. */
static double height_at(double r, double a, double distance)
{
    static const double MOST = 1.5; /* in the corner of a picture of the aperture */
    double size = fabs(r), bend = r > 0 ? a : -a, low = 0;
    double high = bend > 0 ? fmin(MOST, sqrt(size / (3 * bend))) : MOST;
    for (int i = 0; i < 24; i++) { /* halvings: what lands grows with the height */
        double at = (low + high) / 2;
        if (size * at - bend * at * at * at < distance)
            low = at;
        else
            high = at;
    }
    return low;
}

/* The heights for distances up to that of a mask's farthest pixel, which lie between
 * these: an eighth of a pixel apart, farther where there would be too many. */
enum { PER_PX = 8, MOST_HEIGHTS = 1024 };
struct heights {
    double per_px;
    double at[MOST_HEIGHTS + 2];
};

static void find_heights(struct heights *heights, double r, double a, double farthest)
{
    int n = (int)fmin(ceil(farthest * PER_PX) + 1, MOST_HEIGHTS);
    heights->per_px = n / fmax(farthest, 1);
    for (int i = 0; i <= n + 1; i++)
        heights->at[i] = height_at(r, a, i / heights->per_px);
}

static double known_height(const struct heights *heights, double distance)
{
    double at = distance * heights->per_px;
    int i = rf_min_int((int)at, MOST_HEIGHTS);
    return heights->at[i] + (at - i) * (heights->at[i + 1] - heights->at[i]);
}

/* Of a mask without aberration, the value at (x, y) px from its corner. */
static float mask_at(const struct rf_shadows *m, const float *mask, double x, double y)
{
    x = fmin(fmax(x, 0), m->width - 1);
    y = fmin(fmax(y, 0), m->height - 1);
    int i = rf_min_int((int)x, m->width - 2), j = rf_min_int((int)y, m->height - 2);
    const float *at = mask + (size_t)j * (size_t)m->width + i;
    float tx = (float)(x - i), ty = (float)(y - j);
    float above = at[0] + tx * (at[1] - at[0]);
    float below = at[m->width] + tx * (at[m->width + 1] - at[m->width]);
    return above + ty * (below - above);
}

/* Where light lands that passes the lens at one height, in parts of the distance
 * without aberration: one table for a mask. */
static double grown_by(const struct heights *heights, double disc_r, double far)
{
    return far > 0 ? fabs(disc_r) * known_height(heights, far) / far : 1;
}

/* The radius of the disc in parts of the one that its light has at the mask's (x, y),
 * where the surface in focus is no plane. */
static double grown_at(const struct rf_scene *scene, const struct rf_shadows *m, int x,
                       int y)
{
    static const double MOST = 2; /* so near the focus discs have no shape */
    const struct rf_field *apart = scene->frame->apart;
    if (!apart)
        return 1;
    float at_x = (float)(m->x + m->left + x - scene->x0) + 0.5f;
    float at_y = (float)(m->y + m->top + y - scene->y0) + 0.5f;
    double r = (double)rf_field_radius(apart, at_x, at_y, m->light_r);
    double part = r != 0 ? (double)m->disc_r / r : MOST;
    return fmin(fmax(part, 1 / MOST), MOST);
}

void rf_mask_bend(const struct rf_scene *scene, const struct rf_shadows *m,
                  float *plain)
{
    const struct rf_params *p = &scene->frame->params;
    size_t n = (size_t)m->width * (size_t)m->height;
    memcpy(plain, m->blocked, n * sizeof *plain);
    double middle[2] = {(double)m->light_x - m->left - 0.5,
                        (double)m->light_y - m->top - 0.5};
    double stretch[2] = {p->aperture_ratio, 1 / p->pixel_aspect};
    double farthest = rf_length(fmax(middle[0], m->width - middle[0]) * stretch[0],
                                fmax(middle[1], m->height - middle[1]) * stretch[1]);
    struct heights heights = {.per_px = 0};
    if (p->spherical != 0)
        find_heights(&heights, (double)m->disc_r, p->spherical, farthest);
    for (int y = 0; y < m->height; y++)
        for (int x = 0; x < m->width; x++) {
            double dx = x - middle[0], dy = y - middle[1];
            double far = rf_length(dx * stretch[0], dy * stretch[1]);
            double grown = grown_at(scene, m, x, y);
            if (p->spherical != 0)
                grown *= grown_by(&heights, (double)m->disc_r, far);
            m->blocked[(size_t)y * (size_t)m->width + (size_t)x] =
                mask_at(m, plain, middle[0] + dx * grown, middle[1] + dy * grown);
        }
}
