/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The layered method's core in double precision, brute force, written from the formulas
 * (docs/algorithm.md, "Border", "Footprints", "Slanted surfaces", "The saturating sum"):
 *
 *   -  the picture is continued up and down, then to the sides, by its edge's radii; pixel
 *      k beyond it has the mean m of nine lines' colours, 2 k px apart, mirrored up to
 *      2 px before the radius steps by more than 1 px, plus 1 - change / variance of what
 *      the edge differs from m; or its own line's colour, mirrored, and no more
 *   -  a sample of radius r is deposited at (x + u r, y - v r) for a dense grid of lens
 *      points (u, v) inside the aperture, with 4 x 4 Catmull-Rom weights; lens points
 *      belong to the nearest of k Vogel points, of three to that around the middle
 *   -  with several cells, a surface of the slope g is multiplied by 1 + m . g, m a
 *      cell's middle and g rounded, but where that changes no cell by more than 0.02: i =
 *      t / 0.08 with t = g / (0.24 + |g|); g is the mean of two differences of radii in
 *      turn, about the pixel or on one side of it, that differ by less than half of the
 *      larger + 0.02 px, below 1 px
 *   -  bins floor(r / 2 px), with borders at +-0.5 px, too, near to far: w = T f(W / T), out += colour w / W, T -= w,
 *      f(x) = min(x, 1) with a ramp from 0.9 at 0.9 to 1 at 0.95 but next to the focus;
 *      at the end out / covered
 *
 * Splitting and hidden samples are off, and nothing is a highlight: they decide by
 * thresholds, and their worth is measured on real renders. The fast code differs by the
 * steps of its radii (1/32 px below 4 px, 1/16 below 8, 1/8 above), by floats, and from
 * 8 px on by its reduced resolution, so that the agreement asked for falls from 70 dB
 * to 50 dB.
 */
#include "physics/frames.h"
#include "testing.h"

enum { WIDTH = 64, HEIGHT = 48, GRID = 72, MAX_SITES = 16, MAX_REACH = 40 };

static const double PI = 3.14159265358979323846;

struct model {
    bool is_mirrored; /* beyond the border; no highlights are looked for */
    int blades, n_cells;
    double rotation, ratio; /* degrees */
    int border, width, height;
    double *radius, *colour; /* padded, three channels */
};

static bool is_inside(const struct model *m, double u, double v)
{
    double x = u * m->ratio;
    if (m->blades == 0)
        return x * x + v * v < 1;
    /* The middle of an edge at the rotation: the apothem is cos(pi / n). */
    double step = 2 * PI / m->blades;
    double angle = atan2(v, x) - m->rotation * PI / 180 + step / 2;
    double off_middle = angle - step * floor(angle / step) - step / 2;
    return hypot(x, v) * cos(off_middle) < cos(step / 2);
}

/* Three sites lie around the middle, the first on top. */
static int nearest_site(const struct model *m, double u, double v)
{
    int best = 0, n = m->n_cells;
    double best_d = INFINITY;
    for (int i = 0; i < n; i++) {
        double rho = sqrt((i + 0.5) / n), theta = 2.399963 * i;
        if (n == 3) {
            rho = 0.5;
            theta = 2 * PI * i / n + PI / 2;
        }
        double d = hypot(u - rho * cos(theta), v - rho * sin(theta));
        if (d < best_d) {
            best_d = d;
            best = i;
        }
    }
    return best;
}

static double catmull_rom(double t)
{
    t = fabs(t);
    return t < 1   ? 1.5 * t * t * t - 2.5 * t * t + 1
           : t < 2 ? -0.5 * t * t * t + 2.5 * t * t - 4 * t + 2
                   : 0;
}

enum { SIDE = 2 * MAX_REACH + 1 };

/* The middle of each cell of the lens. */
static void find_middles(const struct model *m, double middle[][2])
{
    double wide = fmax(1, 1 / m->ratio);
    int n[MAX_SITES] = {0};
    memset(middle, 0, sizeof *middle * MAX_SITES);
    for (int i = 0; i < 10 * GRID; i++)
        for (int k = 0; k < 10 * GRID; k++) {
            double u = ((i + 0.5) / (10 * GRID) * 2 - 1) * wide;
            double v = (k + 0.5) / (10 * GRID) * 2 - 1;
            if (!is_inside(m, u, v))
                continue;
            int cell = nearest_site(m, u, v);
            middle[cell][0] += u;
            middle[cell][1] += v;
            n[cell]++;
        }
    for (int i = 0; i < m->n_cells; i++) {
        middle[i][0] /= n[i];
        middle[i][1] /= n[i];
    }
}

static double limited(double v, double least, double most)
{
    return fmin(fmax(v, least), most);
}

/* The radius k px from place x of a line of n, `step` apart, of which `at` is the first. */
static double radius_beside(const double *at, int step, int n, int x, int k)
{
    return at[(int)limited(x + k, 0, n - 1) * step];
}

/* Do the differences before and after place x + k differ by little, and by how much? */
static bool is_slope(const double *at, int step, int n, int x, int k, double *slope,
                     double *apart)
{
    double before =
        radius_beside(at, step, n, x, k) - radius_beside(at, step, n, x, k - 1);
    double after =
        radius_beside(at, step, n, x, k + 1) - radius_beside(at, step, n, x, k);
    double larger = fmax(fabs(before), fabs(after));
    *slope = (before + after) / 2;
    *apart = fabs(before - after);
    return *apart < larger / 2 + 0.02 && larger < 1;
}

/* The slope at place x of a line. */
static double slope_at(const double *at, int step, int n, int x)
{
    double slope, beside[2], apart[2];
    double across;
    bool is_across = is_slope(at, step, n, x, 0, &slope, &across);
    bool is_before = is_slope(at, step, n, x, -1, &beside[0], &apart[0]);
    bool is_after = is_slope(at, step, n, x, 1, &beside[1], &apart[1]);
    if (!is_across)
        slope = is_after && (!is_before || apart[1] < apart[0]) ? beside[1]
                : is_before                                     ? beside[0]
                                                                : 0;
    return slope;
}

static double rounded(double slope)
{
    double t = rint(slope / (0.24 + fabs(slope)) / 0.08) * 0.08;
    return 0.24 * t / (1 - fabs(t));
}

/* What the surface of a pixel is multiplied by in each cell. */
static void find_factors(const struct model *m, double middle[][2], int x, int y,
                         double *factor)
{
    const double *r = m->radius;
    double along = slope_at(r + y * m->width, 1, m->width, x);
    double down = slope_at(r + x, m->width, m->height, y), most = 0;
    for (int c = 0; c < m->n_cells; c++)
        most = fmax(most, hypot(middle[c][0], middle[c][1]));
    bool is_flat = m->n_cells == 1 || fabs(r[y * m->width + x]) < 0.25 ||
                   fmax(fabs(along), fabs(down)) <= 0.02 / most;
    along = rounded(along);
    down = rounded(down);
    for (int c = 0; c < m->n_cells; c++)
        factor[c] =
            is_flat ? 1
                    : limited(1 + middle[c][0] * along - middle[c][1] * down, 0.3, 3);
}

/* weights[cell][dy][dx] of radius r, total 1; also each cell's share. */
static void footprint(const struct model *m, double r, double *weights, double *share)
{
    double wide = fmax(1, 1 / m->ratio);
    int n = 0;
    memset(weights, 0, sizeof *weights * MAX_SITES * SIDE * SIDE);
    memset(share, 0, sizeof *share * MAX_SITES);
    for (int i = 0; i < GRID; i++)
        for (int k = 0; k < GRID; k++) {
            double u = ((i + 0.5) / GRID * 2 - 1) * wide, v = (k + 0.5) / GRID * 2 - 1;
            if (!is_inside(m, u, v))
                continue;
            int cell = nearest_site(m, u, v);
            double px = u * r, py = -v * r;
            double *at = weights + cell * SIDE * SIDE;
            n++;
            share[cell]++;
            for (int y = (int)floor(py) - 1; y <= (int)floor(py) + 2; y++)
                for (int x = (int)floor(px) - 1; x <= (int)floor(px) + 2; x++)
                    at[(y + MAX_REACH) * SIDE + x + MAX_REACH] +=
                        catmull_rom(x - px) * catmull_rom(y - py);
        }
    for (int i = 0; i < MAX_SITES * SIDE * SIDE; i++)
        weights[i] /= n;
    for (int i = 0; i < m->n_cells; i++)
        share[i] /= n;
}

static double saturate(double x, bool has_ramp)
{
    return !has_ramp ? fmin(x, 1) : x < 0.9 ? x : x < 0.95 ? 0.9 + 2 * (x - 0.9) : 1;
}

struct sums {
    double *acc;                 /* [pixel][cell][4]: colour and coverage of the bin */
    double *left;                /* [pixel][cell]: T */
    double *out;                 /* [pixel][4]: colour and coverage */
    double *weights;             /* the footprint in use */
    double weights_of_r;         /* whose it is */
    double middle[MAX_SITES][2]; /* of each cell */
};

static void spread(const struct model *m, struct sums *s, int x, int y, double *share)
{
    int at = y * m->width + x;
    double r = m->radius[at];
    if (r != s->weights_of_r)
        footprint(m, r, s->weights, share);
    s->weights_of_r = r;
    double factor[MAX_SITES];
    find_factors(m, s->middle, x, y, factor);
    int reach = (int)ceil(fabs(r) * fmax(1, 1 / m->ratio)) + 2;
    for (int c = 0; c < m->n_cells; c++)
        for (int dy = -reach; dy <= reach; dy++)
            for (int dx = -reach; dx <= reach; dx++) {
                int qx = x + dx, qy = y + dy;
                if (qx < 0 || qy < 0 || qx >= m->width || qy >= m->height)
                    continue;
                double w =
                    factor[c] *
                    s->weights[(c * SIDE + dy + MAX_REACH) * SIDE + dx + MAX_REACH];
                double *acc =
                    s->acc + ((size_t)(qy * m->width + qx) * MAX_SITES + (size_t)c) * 4;
                for (int k = 0; k < 3; k++)
                    acc[k] += w * m->colour[3 * at + k];
                acc[3] += w;
            }
}

static int bin_of(double r)
{
    return (int)floor(r / 2) + (r >= 0.5) - (r < -0.5);
}

static void close_bin(const struct model *m, struct sums *s, bool has_ramp)
{
    for (int i = 0; i < m->width * m->height; i++)
        for (int c = 0; c < m->n_cells; c++) {
            double *acc = s->acc + ((size_t)i * MAX_SITES + (size_t)c) * 4;
            double *left = s->left + i * MAX_SITES + c;
            if (acc[3] > 1e-9 && *left > 1e-9) {
                double w = *left * saturate(acc[3] / *left, has_ramp);
                for (int k = 0; k < 3; k++)
                    s->out[4 * i + k] += acc[k] * w / acc[3];
                s->out[4 * i + 3] += w;
                *left -= w;
            }
            memset(acc, 0, 4 * sizeof *acc);
        }
}

static void model_run(const struct model *m, double *out)
{
    size_t n = (size_t)(m->width * m->height);
    struct sums s = {.acc = calloc(n * MAX_SITES * 4, sizeof(double)),
                     .left = calloc(n * MAX_SITES, sizeof(double)),
                     .out = calloc(n * 4, sizeof(double)),
                     .weights = calloc(MAX_SITES * SIDE * SIDE, sizeof(double)),
                     .weights_of_r = NAN};
    double share[MAX_SITES];
    footprint(m, 1, s.weights, share);
    find_middles(m, s.middle);
    for (size_t i = 0; i < n * MAX_SITES; i++)
        s.left[i] = share[i % MAX_SITES];
    for (int bin = -22; bin <= 22; bin++) {
        bool is_used = false;
        for (int y = 0; y < m->height; y++)
            for (int x = 0; x < m->width; x++)
                if (bin_of(m->radius[y * m->width + x]) == bin) {
                    spread(m, &s, x, y, share);
                    is_used = true;
                }
        if (is_used)
            close_bin(m, &s, bin < -1 || bin > 0);
    }
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const double *o = s.out + 4 * ((y + m->border) * m->width + x + m->border);
            for (int k = 0; k < 3; k++)
                out[(y * WIDTH + x) * 3 + k] = fmax(o[k] / o[3], 0);
        }
    free(s.acc);
    free(s.left);
    free(s.out);
    free(s.weights);
}

/* Radii of the scenes: flat, two steps, a slope, a checkerboard of depths. */
static double scene_radius(int kind, int x, int y, double r)
{
    switch (kind) {
    case 0:
        return r;
    case 1:
        return x > 20 && x < 33 ? -0.8 * r : 0.7 * r;
    case 2: /* not constant along rows or columns, in steps of 1/8 px */
        return floor(8 * (r * (2.0 * y / HEIGHT - 1) + 0.02 * x)) / 8 + 0.03125;
    default:
        return ((x / 16 + y / 12) % 3 - 1) * r + 0.25;
    }
}

/* Contrast below 4: brighter samples are spread without negative weights. */
static struct frame scene(int kind, double r)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    uint32_t seed = 11;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            for (int k = 0; k < 3; k++)
                frame_at(&f, f.colour, x, y)[k] =
                    (float)(0.3 + 0.15 * k * ((x / 5 + y / 5) % 2) +
                            0.2 * random_unit(&seed));
            f.depth[y * WIDTH + x] = plain_depth(scene_radius(kind, x, y, r));
        }
    return f;
}

/* How many pixels from i on, `step` apart, lie on one surface; n at the most. */
static int surface(const struct model *m, int i, int step, int n)
{
    int run = 1;
    while (run < n &&
           fabs(m->radius[i + run * step] - m->radius[i + (run - 1) * step]) <= 1)
        run++;
    return run;
}

static double luminance_at(const struct model *m, int i)
{
    const double *c = m->colour + 3 * i;
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

/* Half of the mean square by which eight pairs differ, or -1; they are a power of two of
 * pixels apart, at most k and run / 2. */
static double change(const struct model *m, int i, int inward, int run, int k)
{
    int apart = k < run / 2 ? k : run / 2;
    while (apart & (apart - 1))
        apart &= apart - 1;
    int n = run - apart, pairs = n < 8 ? n : 8;
    double sum = 0;
    for (int j = 0; j < pairs && apart > 0; j++) {
        int at = i + j * n / pairs * inward;
        sum += pow(luminance_at(m, at + apart * inward) - luminance_at(m, at), 2);
    }
    return apart > 0 ? sum / (2 * pairs) : -1;
}

/* The pixel, 0 the edge, that k beyond the border mirrors in a run. */
static int mirrored(int k, int run)
{
    int from = 0;
    for (int step = 1, way = 1; step < k; step++)
        if (from + way < 0 || from + way >= run)
            way = -way; /* the last one comes twice */
        else
            from += way;
    return from;
}

/* Of n lines from i on, `along` apart, pixel k beyond the border. */
static void continue_by(const struct model *m, int i, int along, int inward, int n,
                        int depth, int k)
{
    int *from = calloc((size_t)n, sizeof *from);
    double *changes = calloc((size_t)n, sizeof *changes);
    int most = 2 * m->border > 48 ? 2 * m->border : 48;
    int apart = 2 * k < m->border / 2 ? 2 * k : m->border > 1 ? m->border / 2 : 1;
    most = depth < most ? depth : most;
    for (int j = 0; j < n; j++) {
        int at = i + j * along, run = surface(m, at, inward, most);
        if (run < most)
            run = run > 3 ? run - 2 : 1;
        from[j] = at + inward * mirrored(k, run);
        changes[j] = change(m, at, inward, run, k);
    }
    for (int j = 0; j < n; j++) {
        int at = i + j * along, to = at - k * inward, count = 0, known = 0;
        int after = surface(m, at, along, n - j) - 1;
        int before = surface(m, at, -along, j + 1) - 1;
        double mean[3] = {0}, sum = 0, square = 0, changed = 0;
        for (int d = -4 * apart; d <= 4 * apart; d += apart)
            if (d >= -before && d <= after) {
                double l = luminance_at(m, from[j + d]);
                for (int c = 0; c < 3; c++)
                    mean[c] += m->colour[3 * from[j + d] + c];
                sum += l;
                square += l * l;
                changed += fmax(changes[j + d], 0);
                known += changes[j + d] >= 0;
                count++;
            }
        double variance = square / count - pow(sum / count, 2);
        double like = known > 0 ? 1 - changed / known / (fmax(variance, 0) + 1e-6) : 0;
        like = fmin(fmax(like, 0), 1);
        m->radius[to] = m->radius[at];
        for (int c = 0; c < 3; c++) {
            double guess =
                mean[c] / count + like * (m->colour[3 * at + c] - mean[c] / count);
            m->colour[3 * to + c] = m->is_mirrored ? m->colour[3 * from[j] + c] : guess;
        }
    }
    free(from);
    free(changes);
}

static void continue_picture(const struct model *m)
{
    int w = m->width, x0 = m->border, y0 = m->border;
    for (int k = 1; k <= m->border; k++) {
        continue_by(m, y0 * w + x0, 1, w, WIDTH, HEIGHT, k);
        continue_by(m, (y0 + HEIGHT - 1) * w + x0, 1, -w, WIDTH, HEIGHT, k);
    }
    for (int k = 1; k <= m->border; k++) {
        continue_by(m, x0, w, 1, m->height, WIDTH, k);
        continue_by(m, x0 + WIDTH - 1, w, -1, m->height, WIDTH, k);
    }
}

static void load(struct model *m, const struct frame *f, int kind, double r)
{
    double most = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        most = fmax(most, fabs(scene_radius(kind, i % WIDTH, i / WIDTH, r)));
    m->border = (int)ceil(most);
    m->width = WIDTH + 2 * m->border;
    m->height = HEIGHT + 2 * m->border;
    m->radius = calloc((size_t)(m->width * m->height), sizeof(double));
    m->colour = calloc((size_t)(m->width * m->height) * 3, sizeof(double));
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            int to = (y + m->border) * m->width + x + m->border;
            m->radius[to] = scene_radius(kind, x, y, r);
            for (int k = 0; k < 3; k++)
                m->colour[to * 3 + k] = frame_at(f, f->colour, x, y)[k];
        }
    continue_picture(m);
}

static void compare(struct model m, int kind, double r, double want_db)
{
    struct frame f = scene(kind, r);
    struct rf_params p;
    double *want = calloc(WIDTH * HEIGHT * 3, sizeof *want), sum = 0, worst = 0;
    plain_params(&p, RF_METHOD_LAYERED);
    p.split_edges = p.fill_hidden = 0;
    p.exact_highlights = !m.is_mirrored;
    p.blades = m.blades;
    p.blade_rotation = m.rotation;
    p.aperture_ratio = m.ratio;
    p.sub_apertures = m.n_cells;
    load(&m, &f, kind, r);
    model_run(&m, want);
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) {
        double d = fabs(f.out[i] - want[i]);
        sum += d * d;
        worst = fmax(worst, d);
    }
    double db = -10 * log10(sum / (WIDTH * HEIGHT * 3) + 1e-20);
    printf("# scene %d, radius %g, k %d, %d blades, ratio %g: %.1f dB, worst %.4f\n",
           kind, r, m.n_cells, m.blades, m.ratio, db, worst);
    CHECK(db >= want_db);
    free(m.radius);
    free(m.colour);
    free(want);
    frame_free(&f);
}

static void one_surface(void)
{
    compare((struct model){.n_cells = 1, .ratio = 1}, 0, 0.5, 70);
    compare((struct model){.n_cells = 1, .ratio = 1}, 0, 3.5, 70);
    compare((struct model){.n_cells = 4, .ratio = 1}, 0, -5.25, 70);
    compare((struct model){.n_cells = 4, .blades = 6, .rotation = 10, .ratio = 1}, 0,
            6.5, 70);
    compare((struct model){.n_cells = 1, .blades = 3, .rotation = 20, .ratio = 1.5}, 0,
            -4.75, 70);
}

static void two_surfaces(void)
{
    compare((struct model){.n_cells = 1, .ratio = 1}, 1, 5, 54);
    compare((struct model){.n_cells = 4, .ratio = 1}, 1, 5, 54);
    compare((struct model){.n_cells = 16, .blades = 5, .ratio = 1.5}, 1, 6.25, 54);
}

static void slopes_and_patches(void)
{
    compare((struct model){.n_cells = 1, .ratio = 1}, 2, 5, 64);
    compare((struct model){.n_cells = 3, .ratio = 1}, 2, 5, 64);
    compare((struct model){.n_cells = 4, .ratio = 1}, 2, 5, 64);
    compare((struct model){.n_cells = 4, .blades = 7, .ratio = 1}, 3, 4, 64);
}

static void large_radii_at_reduced_resolution(void)
{
    compare((struct model){.n_cells = 1, .ratio = 1}, 0, 14, 50);
    compare((struct model){.n_cells = 4, .ratio = 1}, 1, 14, 50);
    compare((struct model){.n_cells = 1, .ratio = 1}, 2, 18, 50);
}

static void light_that_adds_up(void)
{
    compare((struct model){.is_mirrored = true, .n_cells = 1, .ratio = 1}, 0, 6, 70);
    compare((struct model){.is_mirrored = true, .n_cells = 4, .ratio = 1}, 2, 5, 64);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(one_surface);
    TEST(two_surfaces);
    TEST(slopes_and_patches);
    TEST(large_radii_at_reduced_resolution);
    TEST(light_that_adds_up);
    return testing_end();
}
