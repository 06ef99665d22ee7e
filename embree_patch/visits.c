/* visits.c - see visits.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Of the rays that cross a convex body the share that meets a convex part of it is the share that its surface has of
 * the body's [Crofton; MacDonald and Booth, "Heuristics for ray tracing using space subdivision", 1990]. So a leaf that
 * fills little of its box, because it is long and lies askew, is visited by rays that miss it: two or four visits a
 * ray on a wing whose ribs run along it, where one in two would do. Half as long it has a quarter of the surface; along
 * an axis, where there is nothing to gain, half of it. */
#include "embree_patch/visits.h"

#include <math.h>

/* Halves have to have less than this between them of the surface of the whole. A visit that finds nothing takes some 15
 * ns, and a leaf more costs those that come to the whole one level more of Embree's hierarchy, 3 ns: four fifths would
 * pay for single rays. Packets share what they find on the way; they are slower with more than this. Pieces come to
 * five times their width by that. */
static const double halves = 0.625;

/* ... and as memory is not free, only where this share of the rays comes by: an airliner's leaves increase by a sixth,
 * and rays visit 1.9 of them in place of 8.9; with no limit six times as many leaves leave 1.3. */
static const double worth_it = 0x1p-12;

/* Of sixty million rays at the whole geometry one. Around a vertex where a cage has three or five edges, at creases
 * that run out and where faces come back to back, patches halve in size ten times over, and the last of them fold; the
 * pieces along a fold double at each halving. Half the leaves of a chess piece were smaller than this, and nine in ten
 * of two squares that share their borders. What merely bends is cut like any other piece, for a camera may see nothing
 * else: a teapot on a ground a thousand times its size, left whole, was traced at 1/25 of its speed. */
static const double seldom = 0x1p-26;

static double surface_of(const double side[3])
{
    return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
}

double ep_half_surface(const float bounds[6])
{
    double side[3];
    for (int c = 0; c < 3; ++c) side[c] = (double)bounds[3 + c] - bounds[c];
    return surface_of(side);
}

/* The sides of the box of a piece that has a frame. */
static void span(const ep_fit *f, double side[3])
{
    for (int c = 0; c < 3; ++c) {
        const double s = fabs((&f->column[0].x)[c]), t = fabs((&f->column[1].x)[c]);
        side[c] = s + t + 2 * (double)f->leaf.height * fabs((&f->column[2].x)[c]);
    }
}

double ep_visits(const ep_fit *f, const ep_domain *d, double half_surface)
{
    double side[3];
    if (f->regular) {
        span(f, side);
    } else {
        double lower[3], upper[3];
        ep_leaf_box(f, d, lower, upper);
        for (int c = 0; c < 3; ++c) side[c] = upper[c] - lower[c];
    }
    return surface_of(side) / half_surface;
}

bool ep_is_seldom_met(double visits)
{
    return visits < seldom;
}

bool ep_is_askew(const ep_fit *f, double visits, unsigned *along)
{
    if (!(visits > worth_it) || !f->regular || f->kind != &ep_kinds[EP_KIND_TENSOR]) return false;
    double whole[3], least = INFINITY;
    span(f, whole);
    for (unsigned k = 0; k < 2; ++k) {
        double half[3];
        for (int c = 0; c < 3; ++c) half[c] = whole[c] - 0.5 * fabs((&f->column[k].x)[c]);
        const double both = 2 * surface_of(half);
        if (both < least) least = both, *along = k;
    }
    return least < halves * surface_of(whole);
}
