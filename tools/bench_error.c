/* bench_error.c - how far hits are from the exact surface, in double precision.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The point org + t dir, with the float numbers of ray and hit taken as exact, is compared with the nearest point of
 * the patch that was hit, and the normal with the one there. So only errors across the surface count: not where along
 * the surface a tessellation thinks it was hit. A hit may lie a little beyond the border of its patch, next to another
 * one; when the border is what is nearest, all patches are asked. */
#include "tools/bench.h"
#include "tools/nearest.h"
#include "tools/report.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>

/* The worst of so many hits of each kind is close to the worst of all. */
#define SAMPLES 65536
/* Relative to the diagonal, float tells no smaller errors apart, so that none is reported: flat triangles are as exact
 * as flat patches, whoever rounds t more luckily. */
#define RESOLUTION 0x1p-23
#define PI 3.14159265358979323846

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double r[3])
{
    r[0] = a[1] * b[2] - a[2] * b[1];
    r[1] = a[2] * b[0] - a[0] * b[2];
    r[2] = a[0] * b[1] - a[1] * b[0];
}

/* The angle in degrees; 180 for something that is no normal. At a pole the exact normal is the limit from inside. */
static double normal_error(const placed_chart *p, const double point[3], foot f, const float Ng[3])
{
    const double h[3] = {(double)Ng[0], (double)Ng[1], (double)Ng[2]};
    double n[3], sine[3];
    cross(f.du, f.dv, n);
    if (!(dot(n, n) > 1e-20 * dot(f.du, f.du) * dot(f.dv, f.dv))) {
        const double inside = 1e-6, middle = p->chart.kind == PATCH_TRIANGLE ? 1.0 / 3 : 0.5;
        f = foot_at(p, point, f.u + inside * (middle - f.u), f.v + inside * (middle - f.v));
        cross(f.du, f.dv, n);
    }
    if (!(dot(h, h) > 0 && dot(h, h) < (double)INFINITY)) return 180;
    cross(n, h, sine);
    return atan2(sqrt(dot(sine, sine)), dot(n, h)) * 180 / PI;
}

typedef struct errors {
    double position, normal;
} errors;

/* Raises the largest errors so far to those of one hit. */
static void judge(const world *w, const trace_ray *ray, const world_hit *hit, errors *worst)
{
    const scene_geometry *g = &w->scene->geometries[w->scene->objects[hit->geomID].geometry];
    const placed_chart p = place_chart(w, hit->geomID, chart_of(g, hit->primID, (double)hit->u, (double)hit->v));
    double point[3];
    for (int x = 0; x < 3; ++x) point[x] = (double)ray->org[x] + (double)hit->t * (double)ray->dir[x];
    const foot f =
        foot_near(&p, point, ((double)hit->u - p.chart.u0) / p.chart.du, ((double)hit->v - p.chart.v0) / p.chart.dv);
    double distance = sqrt(f.r2);
    if (f.border && distance > worst->position) distance = nearest_distance(w, point, distance);
    worst->position = fmax(worst->position, distance);
    worst->normal = fmax(worst->normal, normal_error(&p, point, f, hit->Ng));
}

/* Some of the rays, evenly chosen. */
static bool measure(const world *w, const trace_ray *rays, size_t count, errors *worst)
{
    const trace_options options = {.width = 16};
    const size_t stride = 1 + (count - 1) / SAMPLES, n = (count + stride - 1) / stride;
    trace_result result;
    trace_ray *few = malloc(n * sizeof *few);
    world_hit *hits = malloc(n * sizeof *hits);
    bool done = few && hits;
    if (!done) report_no_memory(w->scene->path);
    for (size_t i = 0; done && i < n; ++i) few[i] = rays[i * stride];
    done = done && trace_rays(w, few, n, &options, hits, &result);
    if (done) {
#pragma omp parallel
        {
            errors mine = {0, 0};
#pragma omp for schedule(dynamic, 256) nowait
            for (size_t i = 0; i < n; ++i)
                if (hits[i].geomID != ~0u) judge(w, &few[i], &hits[i], &mine);
#pragma omp critical
            {
                worst->position = fmax(worst->position, mine.position);
                worst->normal = fmax(worst->normal, mine.normal);
            }
        }
    }
    free(few);
    free(hits);
    return done;
}

bool bench_errors(const world *w, const bench_rays *r, double diagonal, bench_subject *to)
{
    errors worst = {0, 0};
    bool done = measure(w, r->of[BENCH_PRIMARY], r->count[BENCH_PRIMARY], &worst) &&
                measure(w, r->of[BENCH_RANDOM], r->count[BENCH_RANDOM], &worst);
    to->position_error = fmax(worst.position / diagonal, RESOLUTION);
    to->normal_error = worst.normal;
    return done;
}
