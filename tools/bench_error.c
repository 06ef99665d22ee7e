/* bench_error.c - how far hits are from the exact surface, in double precision.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The point org + t dir, with the float numbers of ray and hit taken as exact, is compared with the nearest point of
 * the patch that was hit: the minimum of |S(u,v) - P|² by the method of Levenberg and Marquardt, started at the hit's
 * own u,v and kept in the domain. The steps of Gauss and Newton converge well here because the residual is small next
 * to the radii of curvature. The normal is compared with the one at that nearest point. So only the error across the
 * surface counts: where along the surface a tessellation thinks it was hit does not. */
#include "tools/bench.h"
#include "tools/report.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

/* The worst of so many hits of each kind is close to the worst of all. */
#define SAMPLES 65536
#define STEPS 60
#define PI 3.14159265358979323846

/* A patch in the world. The transform is the one that Embree got: rounded to float. */
typedef struct placed_patch {
    EPGeometry geometry;
    uint32_t index;
    patch_kind kind;
    double m[12];
} placed_patch;

typedef struct foot {
    double u, v, r[3], du[3], dv[3]; /* r = S(u,v) - P */
    double r2;
} foot;

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

static placed_patch place_patch(const world *w, const world_hit *h)
{
    const scene_object *o = &w->scene->objects[h->geomID];
    placed_patch p = {
        w->geometries[o->geometry], h->primID, w->scene->geometries[o->geometry].patches[h->primID].kind, {0}};
    for (int i = 0; i < 12; ++i) p.m[i] = o->identity ? o->transform[i] : (double)(float)o->transform[i];
    return p;
}

static void turn(const double m[12], double a[3])
{
    const double b[3] = {a[0], a[1], a[2]};
    for (int x = 0; x < 3; ++x) a[x] = m[x] * b[0] + m[3 + x] * b[1] + m[6 + x] * b[2];
}

static void keep_in_domain(patch_kind kind, double *u, double *v)
{
    *u = fmin(fmax(*u, 0), 1);
    *v = fmin(fmax(*v, 0), 1);
    const double beyond = kind == PATCH_TRIANGLE ? *u + *v - 1 : 0;
    if (beyond <= 0) return;
    *u = fmin(fmax(*u - 0.5 * beyond, 0), 1);
    *v = 1 - *u;
}

static foot stand(const placed_patch *p, const double at[3], double u, double v)
{
    foot f = {.u = u, .v = v};
    epEvaluate(p->geometry, p->index, u, v, f.r, f.du, f.dv, NULL);
    turn(p->m, f.r), turn(p->m, f.du), turn(p->m, f.dv);
    for (int x = 0; x < 3; ++x) f.r[x] += p->m[9 + x] - at[x];
    f.r2 = dot(f.r, f.r);
    return f;
}

static foot nearest(const placed_patch *p, const double at[3], double u, double v)
{
    keep_in_domain(p->kind, &u, &v);
    foot f = stand(p, at, u, v);
    double damping = 1e-9;
    for (int step = 0; step < STEPS && f.r2 > 0; ++step) {
        const double a = dot(f.du, f.du), b = dot(f.du, f.dv), c = dot(f.dv, f.dv);
        const double gu = dot(f.r, f.du), gv = dot(f.r, f.dv), more = damping * (a + c);
        const double det = (a + more) * (c + more) - b * b;
        if (!(det > 0)) break; /* no tangents at all */
        double to_u = f.u - ((c + more) * gu - b * gv) / det, to_v = f.v - ((a + more) * gv - b * gu) / det;
        keep_in_domain(p->kind, &to_u, &to_v);
        if (to_u == f.u && to_v == f.v) break;
        const foot next = stand(p, at, to_u, to_v);
        if (next.r2 < f.r2) {
            const bool settled = next.r2 > (1 - 1e-6) * f.r2;
            f = next;
            if (settled) break;
            damping *= 0.1;
        } else {
            damping = fmax(10 * damping, 1e-6);
        }
    }
    return f;
}

/* The angle in degrees; 180 for something that is no normal. At a pole the exact normal is the limit from inside. */
static double normal_error(const placed_patch *p, const double at[3], foot f, const float Ng[3])
{
    const double h[3] = {(double)Ng[0], (double)Ng[1], (double)Ng[2]};
    double n[3], sine[3];
    cross(f.du, f.dv, n);
    if (!(dot(n, n) > 1e-20 * dot(f.du, f.du) * dot(f.dv, f.dv))) {
        const double inside = 1e-6, middle = p->kind == PATCH_TRIANGLE ? 1.0 / 3 : 0.5;
        f = stand(p, at, f.u + inside * (middle - f.u), f.v + inside * (middle - f.v));
        cross(f.du, f.dv, n);
    }
    if (!(dot(h, h) > 0 && dot(h, h) < (double)INFINITY)) return 180;
    cross(n, h, sine);
    return atan2(sqrt(dot(sine, sine)), dot(n, h)) * 180 / PI;
}

/* Every stride-th of the rays. */
static bool measure(const world *w, const trace_ray *rays, size_t count, double *position, double *normal)
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

    double worst = 0, worst_angle = 0;
    if (done) {
#pragma omp parallel for schedule(dynamic, 256) reduction(max : worst, worst_angle)
        for (size_t i = 0; i < n; ++i) {
            if (hits[i].geomID == ~0u) continue;
            const placed_patch p = place_patch(w, &hits[i]);
            double at[3];
            for (int x = 0; x < 3; ++x) at[x] = (double)few[i].org[x] + (double)hits[i].t * (double)few[i].dir[x];
            const foot f = nearest(&p, at, (double)hits[i].u, (double)hits[i].v);
            worst = fmax(worst, sqrt(f.r2));
            worst_angle = fmax(worst_angle, normal_error(&p, at, f, hits[i].Ng));
        }
    }
    *position = fmax(*position, worst);
    *normal = fmax(*normal, worst_angle);
    free(few);
    free(hits);
    return done;
}

bool bench_errors(const world *w, const bench_rays *r, double diagonal, bench_subject *to)
{
    double position = 0, normal = 0;
    bool done = measure(w, r->of[BENCH_PRIMARY], r->count, &position, &normal) &&
                measure(w, r->of[BENCH_RANDOM], r->count, &position, &normal);
    to->position_error = position / diagonal;
    to->normal_error = normal;
    return done;
}
