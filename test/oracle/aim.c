/* aim.c - see aim.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/oracle/aim.h"

const char *const aim_names[AIM_KINDS] = {"at", "inside", "grazing", "border", "axis"};

void aim_domain(const oracle *o, uint32_t patch, rng *r, double *u, double *v)
{
    *u = rng_unit(r);
    *v = rng_unit(r);
    if (oracle_is_triangle(o, patch) && *u + *v > 1) *u = 1 - *u, *v = 1 - *v;
}

void aim_border(const oracle *o, uint32_t patch, rng *r, double *u, double *v)
{
    const bool corner = rng_below(r, 4) == 0;
    const double along = corner ? rng_below(r, 2) : rng_unit(r);
    if (oracle_is_triangle(o, patch)) {
        const unsigned side = rng_below(r, 3);
        *u = side == 0 ? 0 : along;
        *v = side == 0 ? along : side == 1 ? 0 : 1 - along;
    } else {
        const unsigned side = rng_below(r, 4);
        *u = side < 2 ? side : along;
        *v = side < 2 ? along : side - 2;
    }
}

typedef struct box {
    double centre[3], half[3], radius;
} box;

static box box_of(const oracle *o)
{
    double lower[3], upper[3];
    box b = {.radius = 0};
    oracle_bounds(o, lower, upper);
    for (int c = 0; c < 3; ++c) {
        b.centre[c] = (lower[c] + upper[c]) / 2;
        b.half[c] = (upper[c] - lower[c]) / 2;
        b.radius += b.half[c] * b.half[c];
    }
    b.radius = sqrt(b.radius);
    return b;
}

static void outside(const box *b, rng *r, double p[3])
{
    double d[3];
    const double distance = b->radius * (rng_below(r, 8) ? rng_in(r, 1.2, 4) : rng_scale(r, 4, 50));
    rng_direction(r, d);
    for (int c = 0; c < 3; ++c) p[c] = b->centre[c] + distance * d[c];
}

static void within(const box *b, rng *r, double p[3])
{
    for (int c = 0; c < 3; ++c) p[c] = b->centre[c] + rng_in(r, -1, 1) * b->half[c];
}

/* From a, as floats see it, to b; now and then with a direction of another length. */
static void between(rng *r, const double a[3], const double b[3], float org[3], float dir[3])
{
    const double length = rng_below(r, 4) ? 1 : rng_scale(r, 1e-2, 1e2);
    for (int c = 0; c < 3; ++c) {
        org[c] = (float)a[c];
        dir[c] = (float)(length * (b[c] - org[c]));
    }
}

static void aim_grazing(const oracle *o, const box *b, uint32_t patch, rng *r, float org[3], float dir[3])
{
    double u, v, p[3], pu[3], pv[3], n[3], from[3], to[3];
    aim_domain(o, patch, r, &u, &v);
    oracle_evaluate(o, patch, u, v, p, pu, pv);
    const double angle = rng_in(r, 0, 6.283185307179586);
    double pu2 = 0, pv2 = 0, n2 = 0;
    for (int c = 0; c < 3; ++c) {
        n[c] = pu[(c + 1) % 3] * pv[(c + 2) % 3] - pu[(c + 2) % 3] * pv[(c + 1) % 3];
        pu2 += pu[c] * pu[c], pv2 += pv[c] * pv[c], n2 += n[c] * n[c];
    }
    if (!(pu2 > 0 && pv2 > 0 && n2 > 0)) {
        within(b, r, from);
        between(r, from, p, org, dir);
        return;
    }
    const double lift = rng_sign(r) * rng_scale(r, 1e-4, 0.5);
    const double past = rng_below(r, 2) ? 0 : rng_sign(r) * rng_scale(r, 1e-5, 1e-1) * oracle_radius(o, patch);
    const double distance = b->radius * rng_scale(r, 0.1, 10);
    for (int c = 0; c < 3; ++c) {
        const double unit = n[c] / sqrt(n2);
        const double d = cos(angle) * pu[c] / sqrt(pu2) + sin(angle) * pv[c] / sqrt(pv2) + lift * unit;
        to[c] = p[c] + past * unit;
        from[c] = to[c] - distance * d;
    }
    between(r, from, to, org, dir);
}

static void aim_axis(const box *b, const double p[3], rng *r, float org[3], float dir[3])
{
    const unsigned axis = rng_below(r, 3);
    const double sign = rng_sign(r), distance = rng_below(r, 4) ? 2.5 * b->radius : rng_in(r, 0, 1) * b->half[axis];
    double at[3];
    within(b, r, at);
    const bool through = rng_below(r, 2);
    for (unsigned c = 0; c < 3; ++c) {
        org[c] = (float)(through ? p[c] : at[c]);
        dir[c] = 0;
    }
    org[axis] = (float)(b->centre[axis] - sign * distance);
    dir[axis] = (float)sign;
}

void aim(const oracle *o, aim_kind kind, rng *r, float org[3], float dir[3])
{
    const box b = box_of(o);
    const uint32_t patch = rng_below(r, (unsigned)oracle_patch_count(o));
    double u, v, from[3], p[3];
    if (kind == AIM_GRAZING) {
        aim_grazing(o, &b, patch, r, org, dir);
        return;
    }
    if (kind == AIM_BORDER) aim_border(o, patch, r, &u, &v);
    else aim_domain(o, patch, r, &u, &v);
    oracle_evaluate(o, patch, u, v, p, NULL, NULL);
    switch (kind) {
    case AIM_AT:
        outside(&b, r, from);
        if (rng_below(r, 3) == 0)
            for (int c = 0; c < 3; ++c) p[c] += rng_in(r, -0.2, 0.2) * b.radius;
        break;
    case AIM_INSIDE:
        within(&b, r, from);
        rng_direction(r, p);
        for (int c = 0; c < 3; ++c) p[c] = from[c] + b.radius * p[c];
        break;
    case AIM_AXIS: aim_axis(&b, p, r, org, dir); return;
    default:
        if (rng_below(r, 2)) outside(&b, r, from);
        else within(&b, r, from);
    }
    between(r, from, p, org, dir);
}
