/* nearest.c - Levenberg and Marquardt's method on |S(u,v) - P|², kept in the domain.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The steps of Gauss and Newton leave out the second derivatives. They converge well all the same: what matters is
 * the distance relative to the radii of curvature, and points are asked for that are next to the surface. */
#include "tools/nearest.h"
#include "tools/model.h"

#include <math.h>

#define STEPS 60
#define GRID 9 /* starts along each side of a domain, when nothing better is known */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void turn(const double m[12], double a[3])
{
    const double b[3] = {a[0], a[1], a[2]};
    for (int x = 0; x < 3; ++x) a[x] = m[x] * b[0] + m[3 + x] * b[1] + m[6 + x] * b[2];
}

placed_chart place_chart(const world *w, size_t object, size_t index)
{
    const scene_object *o = &w->scene->objects[object];
    placed_chart p = {.geometry = w->geometries[o->geometry],
                      .chart = chart_at(&w->scene->geometries[o->geometry], index)};
    for (int i = 0; i < 12; ++i) p.m[i] = o->identity ? o->transform[i] : (double)(float)o->transform[i];
    return p;
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

foot foot_at(const placed_chart *p, const double point[3], double u, double v)
{
    const double most_v = p->chart.kind == PATCH_TRIANGLE ? 1 - u : 1;
    foot f = {.u = u, .v = v, .border = u <= 0 || v <= 0 || u >= 1 || v >= most_v};
    double at_u, at_v;
    chart_place(&p->chart, u, v, &at_u, &at_v);
    epEvaluate(p->geometry, p->chart.face, at_u, at_v, f.r, f.du, f.dv, NULL);
    for (int x = 0; x < 3; ++x) f.du[x] *= p->chart.du, f.dv[x] *= p->chart.dv;
    turn(p->m, f.r), turn(p->m, f.du), turn(p->m, f.dv);
    for (int x = 0; x < 3; ++x) f.r[x] += p->m[9 + x] - point[x];
    f.r2 = dot(f.r, f.r);
    return f;
}

foot foot_near(const placed_chart *p, const double point[3], double u, double v)
{
    keep_in_domain(p->chart.kind, &u, &v);
    foot f = foot_at(p, point, u, v);
    double damping = 1e-9;
    for (int step = 0; step < STEPS && f.r2 > 0; ++step) {
        const double a = dot(f.du, f.du), b = dot(f.du, f.dv), c = dot(f.dv, f.dv);
        const double gu = dot(f.r, f.du), gv = dot(f.r, f.dv), more = damping * (a + c);
        const double det = (a + more) * (c + more) - b * b;
        if (!(det > 0)) break; /* no tangents at all */
        double to_u = f.u - ((c + more) * gu - b * gv) / det, to_v = f.v - ((a + more) * gv - b * gu) / det;
        keep_in_domain(p->chart.kind, &to_u, &to_v);
        if (to_u == f.u && to_v == f.v) break;
        const foot next = foot_at(p, point, to_u, to_v);
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

/* Whether the hull of a chart's control points comes that close. */
static bool may_be_near(const scene_geometry *g, const placed_chart *p, const double point[3], double within)
{
    const patch *first = &g->patches[p->chart.first], *last = first + p->chart.count - 1;
    const size_t end = last->first + patch_point_count(last->kind, last->degree_u, last->degree_v);
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = first->first; i < end; ++i) {
        double at[3] = {g->points[4 * i], g->points[4 * i + 1], g->points[4 * i + 2]};
        turn(p->m, at);
        for (int x = 0; x < 3; ++x) {
            lower[x] = fmin(lower[x], at[x] + p->m[9 + x]);
            upper[x] = fmax(upper[x], at[x] + p->m[9 + x]);
        }
    }
    for (int x = 0; x < 3; ++x)
        if (point[x] < lower[x] - within || point[x] > upper[x] + within) return false;
    return true;
}

static double distance_to(const placed_chart *p, const double point[3])
{
    foot best = {.r2 = INFINITY};
    for (int i = 0; i < GRID * GRID; ++i) {
        const double u = (i % GRID) / (GRID - 1.0), v = (i / GRID) / (GRID - 1.0);
        const foot f = foot_at(p, point, u, p->chart.kind == PATCH_TRIANGLE ? v * (1 - u) : v);
        if (f.r2 < best.r2) best = f;
    }
    return sqrt(foot_near(p, point, best.u, best.v).r2);
}

double nearest_distance(const world *w, const double point[3], double within)
{
    const scene *s = w->scene;
    for (size_t i = 0; i < s->object_count; ++i) {
        const scene_geometry *g = &s->geometries[s->objects[i].geometry];
        for (size_t k = 0; k < chart_count(g); ++k) {
            const placed_chart p = place_chart(w, i, k);
            if (may_be_near(g, &p, point, within)) within = fmin(within, distance_to(&p, point));
        }
    }
    return within;
}
