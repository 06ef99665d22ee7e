/* bench_degrees.c - what a degree costs: one patch fills the picture.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The setting of Table 1 in H.-F. Pabst, J. P. Springer, A. Schollmeyer, R. Lenhardt, C. Lessig, B. Froehlich, "Ray
 * casting of trimmed NURBS surfaces on the GPU" (2006): a single Bézier patch of each degree, seen so that it covers
 * every pixel. Theirs were the fragments of a GPU of that year. */
#include "tools/bench.h"
#include "tools/model.h"
#include "tools/progress.h"
#include "tools/report.h"
#include "tools/stats.h"
#include "tools/table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rational patches cost more for their quotients, and for what weights make of the surface: so one kind has weights
 * that only parametrise it anew (a Möbius transform of u and of v), the other weights from 1/2 to 3/2. */
typedef enum kind { POLYNOMIAL, RATIONAL_SAME, RATIONAL, KINDS } kind;

static const char *const kind_name[KINDS] = {"polynomial", "rational, the same surface",
                                             "rational, weights 0.5 to 1.5"};

enum { FIRST = 2, LAST = 6, DEGREES = LAST - FIRST + 1, SUBJECTS = KINDS * DEGREES };

static const double paper[DEGREES] = {87, 48, 23, 14, 9};

/* The view: an eye over the middle of the patch, which reaches a little beyond the picture. */
#define SIDE 512
#define TILE 4
#define PASSES 8
#define EYE_HEIGHT 2.0
#define EDGE 0.85 /* of the patch, in the picture's corner, where the height is 0 */

typedef struct degree {
    unsigned n;
    kind kind;
    scene *scene;
    world *world;
    bench_figure speed; /* millions of pixels a second */
    double coverage;    /* of the pixels               */
} degree;

static double weight(kind k, unsigned i, unsigned j)
{
    if (k == POLYNOMIAL) return 1;
    return k == RATIONAL_SAME ? pow(1.25, i) * pow(0.85, j) : 1 + 0.5 * sin(1.3 * i + 2.2 * j);
}

/* The graph of a function over [-1,1]²: hills and hollows, as many as the degree affords. */
static bool fill_patch(scene_geometry *g, unsigned n, kind k)
{
    double *p = geometry_add_patch(g, PATCH_TENSOR, n, n);
    if (!p) return false;
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= n; ++i, p += 4) {
            p[0] = 2.0 * i / n - 1;
            p[1] = 2.0 * j / n - 1;
            p[2] = 0.3 * sin(2.1 * i + 0.4) * cos(1.7 * j - 0.3);
            p[3] = weight(k, i, j);
        }
    g->patches[0].rational = k != POLYNOMIAL;
    return true;
}

static scene *new_scene(unsigned n, kind k)
{
    scene *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    s->path = strdup("a patch");
    s->geometries = calloc(1, sizeof *s->geometries);
    s->objects = calloc(1, sizeof *s->objects);
    s->geometry_count = s->geometries ? 1 : 0;
    s->object_count = s->objects ? 1 : 0;
    if (s->path && s->geometries && s->objects && fill_patch(s->geometries, n, k)) {
        *s->objects = (scene_object){0, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, true, NULL};
        return s;
    }
    scene_free(s);
    return NULL;
}

static bool build(degree *d, const bench_options *o)
{
    const world_options w = {.threads = o->threads[0], .ray_distance = 2 * EYE_HEIGHT, .build = o->build};
    d->scene = new_scene(d->n, d->kind);
    if (!d->scene) report_no_memory(NULL);
    d->world = d->scene ? world_new(d->scene, &w) : NULL;
    return d->world;
}

static void fill_rays(trace_ray *r)
{
    for (size_t y = 0; y < SIDE; y += TILE)
        for (size_t x = 0; x < SIDE; x += TILE)
            for (size_t k = 0; k < TILE * TILE; ++k) {
                const double px = EDGE * (2 * ((double)(x + k % TILE) + 0.5) / SIDE - 1);
                const double py = EDGE * (2 * ((double)(y + k / TILE) + 0.5) / SIDE - 1);
                const double length = sqrt(px * px + py * py + EYE_HEIGHT * EYE_HEIGHT);
                *r++ = (trace_ray){{0, 0, (float)EYE_HEIGHT},
                                   0,
                                   {(float)(px / length), (float)(py / length), (float)(-EYE_HEIGHT / length)},
                                   INFINITY};
            }
}

static bool measure(degree *d, const bench_rays *rays, const bench_options *o)
{
    static const bench_workload picture = {"picture", BENCH_PRIMARY, 16, true, false};
    const size_t blocks = bench_blocks(&picture, rays);
    progress p;
    bool done = true;
    progress_begin(&p, "degrees", (o->runs + 1) * SUBJECTS);
    for (unsigned run = 0; run <= o->runs && done; ++run)
        for (unsigned i = 0; i < SUBJECTS && done; ++i) {
            bench_timing t = {0};
            done = bench_trace(d[i].world->rtc, &picture, rays, 0, PASSES * blocks * o->threads[0], o->threads[0], &t);
            if (run) bench_add(&d[i].speed, bench_speed(&t)); /* the first one fills the caches */
            d[i].coverage = (double)t.hits / (double)t.rays;
            progress_add(&p, 1);
        }
    progress_end(&p);
    return done;
}

static void print(const degree *d, const bench_options *o, bool markdown)
{
    table t = {0};
    printf(
        "One Bézier patch of each degree fills %d x %d pixels; millions of pixels a second with %u thread%s, medians "
        "of %u runs.\n\n",
        SIDE, SIDE, o->threads[0], o->threads[0] == 1 ? "" : "s", o->runs);
    table_row(&t);
    table_cell(&t, "degree");
    for (unsigned i = 0; i < DEGREES; ++i) table_cell(&t, "%u×%u", FIRST + i, FIRST + i);
    for (unsigned k = 0; k < KINDS; ++k) {
        table_row(&t);
        table_cell(&t, "%s", kind_name[k]);
        for (unsigned i = 0; i < DEGREES; ++i) table_cell(&t, "%.1f", bench_median(&d[KINDS * i + k].speed));
    }
    table_row(&t);
    table_cell(&t, "a GPU of 2006 (Pabst et al.)");
    for (unsigned i = 0; i < DEGREES; ++i) table_cell(&t, "%.0f", paper[i]);
    table_print(&t, markdown);
}

static json_t *as_json(const degree *d, const bench_options *o)
{
    json_t *rows = json_array();
    for (unsigned i = 0; i < DEGREES; ++i) {
        const degree *of = &d[KINDS * i];
        double coverage = 1;
        for (unsigned k = 0; k < KINDS; ++k) coverage = fmin(coverage, of[k].coverage);
        json_t *row = json_pack("{s:[i, i], s:f, s:f, s:f, s:f, s:f}", "degree", (int)of->n, (int)of->n, "mpixels",
                                bench_median(&of[POLYNOMIAL].speed), "mpixels_rational_same",
                                bench_median(&of[RATIONAL_SAME].speed), "mpixels_rational",
                                bench_median(&of[RATIONAL].speed), "mpixels_2006", paper[i], "coverage", coverage);
        if (json_array_append_new(rows, row)) return json_decref(rows), NULL;
    }
    return json_pack("{s:o, s:i, s:i, s:[i, i], s:o}", "machine", bench_machine_json(o->build.isa), "threads",
                     (int)o->threads[0], "runs", (int)o->runs, "size", SIDE, SIDE, "degrees", rows);
}

bool bench_degrees(const bench_options *o, bench_form form)
{
    degree d[SUBJECTS] = {0};
    trace_ray *picture = malloc(SIDE * SIDE * sizeof *picture);
    const bench_rays rays = {{picture}, {SIDE * SIDE}, {true, true}};
    bool done = picture;
    if (picture) fill_rays(picture);
    else report_no_memory(NULL);
    for (unsigned i = 0; i < SUBJECTS && done; ++i) {
        d[i].n = FIRST + i / KINDS;
        d[i].kind = (kind)(i % KINDS);
        done = build(&d[i], o);
    }
    done = done && measure(d, &rays, o);
    if (done && form == BENCH_JSON) done = stats_write("-", as_json(d, o));
    else if (done) print(d, o, form == BENCH_MARKDOWN);
    for (unsigned i = 0; i < SUBJECTS; ++i) {
        world_free(d[i].world);
        if (d[i].scene) scene_free(d[i].scene);
    }
    free(picture);
    return done;
}
