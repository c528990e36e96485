/* SPDX-License-Identifier: Apache-2.0 */
/* The four graphs of Yu against his formula, and their axes. */
#include <math.h>

#include "pixels/graphs.h"
#include "testing.h"

enum { WIDTH = 960, HEIGHT = 540 };

/* Millimetres: the demo's lens. */
#define FOCAL 85.0
#define SENSOR 36.0
#define F_STOP 1.4
#define FOCUS 3000.0
#define THING 6000.0

static struct rf_params make_params(void)
{
    struct rf_params params;
    rf_params_init(&params);
    params.focal_length = FOCAL;
    params.sensor_width = SENSOR;
    params.sensor_fit = RF_SENSOR_FIT_HORIZONTAL;
    params.f_stop = F_STOP;
    params.focus_distance = FOCUS / 1000;
    params.optics = RF_OPTICS_YU;
    return params;
}

/* c = |a (s (1/f - 1/d) - 1)| as the paper has it, a in px of the sensor. */
static double formula(double aperture, double s, double f, double d)
{
    return fabs(aperture * WIDTH / SENSOR * (s * (1 / f - 1 / d) - 1));
}

static double at(const struct graph *graph, int i)
{
    return graph->from + (graph->to - graph->from) * i / (GRAPH_STEPS - 1);
}

static struct graph make(enum graph_axis axis, double distance)
{
    struct graph graph = {0};
    char text[256] = "";
    const struct rf_params params = make_params();
    CHECK(
        graph_make(axis, &params, WIDTH, HEIGHT, distance, &graph, text, sizeof(text)));
    return graph;
}

static void they_are_the_formula(void)
{
    const double a = FOCAL / F_STOP, s = FOCAL * FOCUS / (FOCUS - FOCAL);
    for (int axis = 0; axis < N_GRAPHS; axis++) {
        const struct graph graph = make((enum graph_axis)axis, THING / 1000);
        for (int i = 0; i < GRAPH_STEPS; i++) {
            const double x = at(&graph, i);
            const double want =
                formula(axis == GRAPH_APERTURE ? x : a, axis == GRAPH_SCREEN ? x : s,
                        axis == GRAPH_FOCAL ? x : FOCAL,
                        axis == GRAPH_DISTANCE ? 1000 * x : THING);
            CHECK_NEAR(graph.px[i], want, 1e-6 * (1 + want));
        }
        CHECK_NEAR(graph.now_px, formula(a, s, FOCAL, THING), 1e-6);
        CHECK(graph.from <= graph.now && graph.now <= graph.to);
    }
}

static void what_is_sharp_is_marked(void)
{
    CHECK(isnan(make(GRAPH_APERTURE, 6).sharp));
    CHECK_NEAR(make(GRAPH_SCREEN, 6).sharp, FOCAL * THING / (THING - FOCAL), 1e-6);
    const double s = FOCAL * FOCUS / (FOCUS - FOCAL);
    CHECK_NEAR(make(GRAPH_FOCAL, 6).sharp, 1 / (1 / s + 1 / THING), 1e-6);
    CHECK_NEAR(make(GRAPH_DISTANCE, 6).sharp, FOCUS / 1000, 1e-6);
}

/* The thing in focus, at infinity nearly, and a focus at infinity: axes all the same. */
static void there_is_always_an_axis(void)
{
    const double distances[] = {0.3, 3, 1e6};
    char text[256];
    for (int i = 0; i < 6; i++) {
        struct rf_params params = make_params();
        params.focus_distance = i < 3 ? 3 : 1e9;
        for (int axis = 0; axis < N_GRAPHS; axis++) {
            struct graph graph;
            REQUIRE(graph_make((enum graph_axis)axis, &params, WIDTH, HEIGHT,
                               distances[i % 3], &graph, text, sizeof(text)));
            CHECK(graph.from < graph.to && graph.n_ticks >= 2);
            CHECK(graph.n_ticks_px >= 2 && graph.top_px > 0);
            for (int k = 0; k < GRAPH_STEPS; k++)
                CHECK(isfinite(graph.px[k]));
        }
    }
}

static void ticks_are_round(void)
{
    double ticks[GRAPH_MOST_TICKS];
    REQUIRE(graph_ticks(0, 121, ticks) == 3);
    CHECK(ticks[0] == 0 && ticks[1] == 50 && ticks[2] == 100);
    REQUIRE(graph_ticks(85.1, 89.9, ticks) == 4);
    CHECK_NEAR(ticks[0], 86, 1e-9);
    CHECK_NEAR(ticks[3], 89, 1e-9);
    REQUIRE(graph_ticks(0, 10, ticks) == 6);
    CHECK_NEAR(ticks[5], 10, 1e-9);
}

static void no_lens_is_said(void)
{
    struct graph graph;
    char text[256] = "";
    struct rf_params params = make_params();
    params.projection = RF_PROJECTION_ORTHOGRAPHIC;
    CHECK(!graph_make(GRAPH_SCREEN, &params, WIDTH, HEIGHT, 6, &graph, text,
                      sizeof(text)));
    CHECK(strstr(text, "perspective") != NULL);
    params = make_params();
    params.focus_distance = 0.05;
    CHECK(!graph_make(GRAPH_SCREEN, &params, WIDTH, HEIGHT, 6, &graph, text,
                      sizeof(text)));
    CHECK(strstr(text, "focus distance") != NULL);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(they_are_the_formula);
    TEST(what_is_sharp_is_marked);
    TEST(there_is_always_an_axis);
    TEST(ticks_are_round);
    TEST(no_lens_is_said);
    return testing_end();
}
