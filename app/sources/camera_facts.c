/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The camera in headers of other programs.
 *
 *   f, S, N   focal length and width of the sensor in mm, f-number
 *   a         angle of view across the picture
 *   C, D      worldToCamera and worldToNDC, points are rows
 *   P         C^-1 D, what makes NDC of a point in the camera's space
 *
 * V-Ray: S is that of the film, of which the picture may show more or less, so that
 * S = 2 f tan(a / 2); where there is no f (another camera than V-Ray's), f of the film.
 * Unreal (Movie Render Queue): texts, a set for each pass; its units are centimetres.
 * NDC: x = (P00 X + P20 Z) / (P23 Z) goes from -1 to 1 (Arnold, Houdini) or from 0 to 1
 * (RenderMan), which the place of the axis tells; S / f is that span over |P00 / P23|.
 * Redshift: a is in degrees in its files, whose page says radians; its film is in inches,
 * in mm or 1 wide, by the host, and FStop is that of the exposure: neither is read.
 */
#include "sources/camera_facts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char camera_facts_target[] = "cameraTargetDistance";
const char camera_facts_redshift[] = "rs/camera/DOFFocusDistance";

/* Of a picture's shape: pixels are whole, the camera's film is not. */
static const double MOST_OFF = 0.02;

struct list {
    struct camera_fact *facts;
    int n;
};

static void add(struct list *list, const char *key, double value, const char *text,
                const char *attribute)
{
    struct camera_fact *fact = &list->facts[list->n++];
    *fact = (struct camera_fact){.key = key, .value = value, .text = text};
    snprintf(fact->attribute, sizeof(fact->attribute), "%s", attribute);
}

/* ---- V-Ray ----------------------------------------------------------------------- */

/* From here on V-Ray means that there is no target. */
static const double NO_TARGET = 1e17;

static void read_vray(const struct image_input *input, struct list *list)
{
    double film, degrees, focal, number, projection = 0;
    if (!image_attribute_number(input, "cameraAperture", &film) ||
        !image_attribute_number(input, "cameraFov", &degrees) ||
        (image_attribute_number(input, "cameraProjection", &projection) &&
         projection != 0) ||
        !(degrees > 0 && degrees < 180 && film > 0))
        return;
    const double width = 2 * tan(degrees * M_PI / 360);
    if (image_attribute_number(input, "cameraFocalLength", &focal) && focal > 0) {
        add(list, "focal-length", focal, NULL, "cameraFocalLength");
        add(list, "sensor-width", width * focal, NULL, "cameraFov");
    } else {
        add(list, "focal-length", film / width, NULL, "cameraFov");
        add(list, "sensor-width", film, NULL, "cameraAperture");
    }
    if (!image_attribute_number(input, "cameraFNumber", &number))
        return;
    add(list, "f-stop", number, NULL, "cameraFNumber");
    if (image_attribute_number(input, camera_facts_target, &number) &&
        number < NO_TARGET)
        add(list, "focus-distance", number, NULL, camera_facts_target);
}

/* ---- Unreal ---------------------------------------------------------------------- */

static const char unreal_last[] = "/focalLength";

/* The name in front of an attribute of the first pass: unreal/camera/FinalImage/. */
static bool find_unreal(const struct image_input *input, char *prefix, size_t n_bytes)
{
    int n_parts;
    const size_t n_last = sizeof(unreal_last) - 1;
    image_parts(input, &n_parts);
    for (int part = 0; part < n_parts; part++) {
        const char *name;
        for (int i = 0; (name = image_attribute_name(input, part, i)); i++) {
            const size_t n = strlen(name);
            if (strncmp(name, "unreal/", 7) == 0 && n > n_last && n < n_bytes &&
                strcmp(name + n - n_last, unreal_last) == 0) {
                snprintf(prefix, n_bytes, "%.*s", (int)(n - n_last + 1), name);
                return true;
            }
        }
    }
    return false;
}

static void read_unreal(const struct image_input *input, struct list *list)
{
    static const struct {
        const char *last, *key;
    } texts[] = {{"focalLength", "focal-length"},
                 {"sensorWidth", "sensor-width"},
                 {"fstop", "f-stop"},
                 {"focalDistance", "focus-distance"}};
    enum { UNITS_PER_METRE = 100 };
    char prefix[64], name[96];
    if (!find_unreal(input, prefix, sizeof(prefix)))
        return;
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); i++) {
        const char *text;
        snprintf(name, sizeof(name), "%s%s", prefix, texts[i].last);
        if (image_attribute_string(input, name, &text))
            add(list, texts[i].key, 0, text, name);
    }
    snprintf(name, sizeof(name), "%s*", prefix);
    add(list, "unit-scale", UNITS_PER_METRE, NULL, name);
}

/* ---- Redshift -------------------------------------------------------------------- */

static const char redshift_angle[] = "rs/camera/fov";

static void read_redshift(const struct image_input *input, struct list *list)
{
    double distance;
    if (image_attribute_number(input, camera_facts_redshift, &distance) && distance > 0)
        add(list, "focus-distance", distance, NULL, camera_facts_redshift);
}

/* Pictures less than so many degrees wide are taken for radians. */
static const double LEAST_DEGREES = M_PI;

static bool redshift_width(const struct image_input *input, double aspect,
                           double *width)
{
    double angle, own_aspect;
    if (!image_attribute_number(input, redshift_angle, &angle) ||
        !(angle > 0 && angle < 180) ||
        (image_attribute_number(input, "rs/camera/aspect", &own_aspect) &&
         !(fabs(own_aspect - aspect) < MOST_OFF * aspect)))
        return false;
    *width = 2 * tan((angle < LEAST_DEGREES ? angle : angle * M_PI / 180) / 2);
    return true;
}

int camera_facts_read(const struct image_input *input,
                      struct camera_fact facts[CAMERA_MOST_FACTS])
{
    struct list list = {.facts = facts};
    read_vray(input, &list);
    if (list.n == 0)
        read_unreal(input, &list);
    if (list.n == 0)
        read_redshift(input, &list);
    return list.n;
}

/* ---- worldToNDC ------------------------------------------------------------------ */

static const char ndc[] = "worldToNDC";

/* Solves C P = D for P, all of 4 x 4 by rows; C and D are spent. False where C has no
 * inverse. */
static bool solve(double c[16], double d[16])
{
    for (int column = 0; column < 4; column++) {
        int pivot = column;
        for (int row = column + 1; row < 4; row++)
            if (fabs(c[row * 4 + column]) > fabs(c[pivot * 4 + column]))
                pivot = row;
        if (!(fabs(c[pivot * 4 + column]) > 1e-12))
            return false;
        for (int i = 0; i < 4; i++) {
            const double a = c[pivot * 4 + i], b = d[pivot * 4 + i];
            c[pivot * 4 + i] = c[column * 4 + i];
            d[pivot * 4 + i] = d[column * 4 + i];
            c[column * 4 + i] = a;
            d[column * 4 + i] = b;
        }
        for (int row = 0; row < 4; row++) {
            const double by = c[row * 4 + column] / c[column * 4 + column];
            for (int i = 0; i < 4 && row != column; i++) {
                c[row * 4 + i] -= by * c[column * 4 + i];
                d[row * 4 + i] -= by * d[column * 4 + i];
            }
        }
    }
    for (int row = 0; row < 4; row++)
        for (int i = 0; i < 4; i++)
            d[row * 4 + i] /= c[row * 4 + row];
    return true;
}

/* The span of NDC by where the axis lies in it, which a lens shift moves a little; 0 if
 * it is neither. */
static double span_of(double axis)
{
    enum { FROM_0_TO_1 = 1, FROM_1_TO_1 = 2 };
    return fabs(axis) < 0.25 ? FROM_1_TO_1 : fabs(axis - 0.5) < 0.25 ? FROM_0_TO_1 : 0;
}

/* What is seen along an axis of P, at a distance of 1; 0 if P is no perspective. */
static double extent_of(const double p[16], int axis)
{
    const double depth = p[2 * 4 + 3];
    const double span = span_of(p[2 * 4 + axis] / depth);
    const double extent = span * fabs(depth / p[axis * 4 + axis]);
    return isfinite(extent) ? extent : 0;
}

static bool ndc_width(const struct image_input *input, double aspect, double *width)
{
    double c[16], p[16];
    if (!image_attribute_matrix(input, "worldToCamera", c) ||
        !image_attribute_matrix(input, ndc, p) || !solve(c, p))
        return false;
    *width = extent_of(p, 0);
    const double height = extent_of(p, 1);
    return *width > 0 && height > 0 &&
           fabs(*width / height - aspect) < MOST_OFF * aspect;
}

const char *camera_facts_width(const struct image_input *input,
                               const struct image_part_info *part, double *width)
{
    const struct image_box *box = &part->display_window;
    const double aspect = ((double)box->max_x - box->min_x + 1) * part->pixel_aspect /
                          ((double)box->max_y - box->min_y + 1);
    if (ndc_width(input, aspect, width))
        return ndc;
    return redshift_width(input, aspect, width) ? redshift_angle : NULL;
}
