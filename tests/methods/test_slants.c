/* SPDX-License-Identifier: Apache-2.0 */
/* What lies far behind a slanted surface does not shine through it. */
#include "physics/frames.h"
#include "testing.h"

enum { WIDTH = 160, HEIGHT = 128, SKY_END = 40 };

struct slope {
    double first, slope; /* radius beside the sky, px; px per px away from it */
    bool is_upright;     /* the sky is at the top, else at the left */
};

/* A bright sky of radius 100 px, and a dark wall that begins beside it. */
static void draw(struct frame *f, const struct slope *s)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int at = s->is_upright ? i / WIDTH : i % WIDTH, in = at - SKY_END;
        f->depth[i] = plain_depth(in < 0 ? 100 : s->first + s->slope * in);
        for (int c = 0; c < 3; c++)
            f->colour[3 * i + c] = in < 0 ? 1.5f : 0.01f;
    }
}

/* The most light where the wall hides the sky from all of the lens. */
static float brightest(const struct slope *s, int sub_apertures)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    struct rf_params params;
    float most = 0;
    draw(&f, s);
    plain_params(&params, RF_METHOD_LAYERED);
    params.sub_apertures = sub_apertures;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int y = 30; y < HEIGHT - 20; y++)
        for (int x = 30; x < WIDTH - 30; x++) {
            double in = (s->is_upright ? y : x) - SKY_END;
            if (in > 12 + 1.5 * fabs(s->first + s->slope * in))
                most = fmaxf(most, frame_at(&f, f.out, x, y)[1]);
        }
    frame_free(&f);
    return most;
}

static void check(const struct slope *slopes, int n, float limit)
{
    for (int i = 0; i < n; i++)
        for (int cells = 2; cells <= 4; cells += 2) {
            const struct slope *s = &slopes[i];
            float most = brightest(s, cells);
            printf(
                "# from %.1f px by %.2f px per px %s, %d cells: %.4f of a sky of 1.5\n",
                s->first, s->slope, s->is_upright ? "down" : "right", cells,
                (double)most);
            CHECK(most > 0 && most < limit);
        }
}

static void a_far_sky_shines_through_no_slanted_surface(void)
{
    static const struct slope slopes[] = {
        {-6, 0.16, false}, {4, 0.16, false}, {20, -0.16, false}, {3, 0.3, false},
        {-6, 0.16, true},  {4, 0.16, true},  {-14, 0.16, true},  {6, 0.08, true},
    };
    check(slopes, 8, 0.025f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_far_sky_shines_through_no_slanted_surface);
    return testing_end();
}
