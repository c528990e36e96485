/* SPDX-License-Identifier: Apache-2.0 */
#include "pages/methods_details.h"

#include <math.h>
#include <stdlib.h>

#include "console/cli.h"
#include "measure/measure.h"

enum { STEP = 8 }; /* px between the places that are asked */

struct search {
    double *sums; /* of all above and left: (width + 1) x (height + 1) */
    int32_t width, height;
};

static double *sum_at(const struct search *s, int32_t x, int32_t y)
{
    return s->sums + (size_t)y * (size_t)(s->width + 1) + (size_t)x;
}

static double sum_of(const struct search *s, struct canvas_box box)
{
    const int32_t x = box.x + box.width, y = box.y + box.height;
    return *sum_at(s, x, y) - *sum_at(s, box.x, y) - *sum_at(s, x, box.y) +
           *sum_at(s, box.x, box.y);
}

static bool overlap(struct canvas_box a, struct canvas_box b)
{
    return abs(a.x - b.x) < a.width && abs(a.y - b.y) < a.height;
}

/* The box of the largest sum that is not over `taken`; where there is none, the first
 * corner. */
static struct canvas_box find_box(const struct search *s, struct canvas_box box,
                                  const struct canvas_box *taken)
{
    struct canvas_box best = box;
    double most = -1;
    for (box.y = 0; box.y + box.height <= s->height; box.y += STEP)
        for (box.x = 0; box.x + box.width <= s->width; box.x += STEP)
            if (sum_of(s, box) > most && !(taken && overlap(box, *taken))) {
                most = sum_of(s, box);
                best = box;
            }
    return best;
}

/* How much the lens changes pixel i, tone mapped. */
static double change_of(const struct canvas_picture *a, const struct canvas_picture *b,
                        size_t i)
{
    double sum = 0;
    for (size_t c = 0; c < 3; c++)
        sum += fabs(measure_tone(a->rgb[3 * i + c]) - measure_tone(b->rgb[3 * i + c]));
    return sum;
}

bool methods_find_details(const unsigned char *is_exposed,
                          const struct canvas_picture *pinhole,
                          const struct canvas_picture *reference, int32_t box_width,
                          int32_t box_height, struct canvas_box details[N_DETAILS])
{
    struct search s = {.width = pinhole->width, .height = pinhole->height};
    const struct canvas_box box = {.width = box_width < s.width ? box_width : s.width,
                                   .height =
                                       box_height < s.height ? box_height : s.height};
    s.sums = app_memory((size_t)(s.width + 1) * (size_t)(s.height + 1), sizeof *s.sums,
                        NULL);
    for (int k = 0; s.sums && k < N_DETAILS; k++) {
        for (int32_t y = 0; y < s.height; y++)
            for (int32_t x = 0; x < s.width; x++) {
                const size_t i = (size_t)y * (size_t)s.width + (size_t)x;
                const double value =
                    k == 0 ? is_exposed[i] : change_of(pinhole, reference, i);
                *sum_at(&s, x + 1, y + 1) = value + *sum_at(&s, x, y + 1) +
                                            *sum_at(&s, x + 1, y) - *sum_at(&s, x, y);
            }
        details[k] = find_box(&s, box, k > 0 ? &details[0] : NULL);
    }
    free(s.sums);
    return s.sums != NULL;
}
