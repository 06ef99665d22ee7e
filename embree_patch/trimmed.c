/* trimmed.c - dividing crossed parts of a patch along the trim curves [Stürzlinger 1998, appendix]. See trimmed.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Rectangles are cut on a grid of floats, so that leaf.domain, which is float, is exact. Triangles are cut where the
 * strip meets their sides, in double: moved to a grid of floats a cut would leave its side, and a gap beside the
 * neighbour that is not cut there. */
#include "embree_patch/trimmed.h"
#include "trim/costs.h"
#include "trim/split.h"

#include <string.h>

_Static_assert((int)EP_TRIMMED_PARTS >= (int)EP_SPLIT_MOST, "room for every split");

/* Curves along a border, or along a straight cut, cross nothing; what a leaf loses there is not missed (EP_BORDER). */
static const double seam = 0x1p-38;

/* Of the rays that cross the geometry's box the share that has to come to a crossed leaf for it to be divided: others
 * gain less than another level costs. The time of the point test plays no part: a ray that passes through what was cut
 * away pays for finding the root, which takes many times as long, in every crossed leaf on its way. Models of hundreds
 * of faces have 0.4 times the memory of leaves down to 2^-14 of each face, packets are a tenth faster, single rays as
 * fast. */
static const double worth_it = 0x1p-13;

/* Where so many curves are so close together that leaves of the least size along them cover so much of the domain,
 * dividing wins less than it costs: rays meet several times as many leaves, and most of them still test. */
enum { CROWD = 16 };
static const double crowded = 0.2;
/* Even then down to such parts of it: beside the curves such leaves are nothing, and flatter ones leave fewer
 * rays undecided. */
static const double coarse = 0x1p-6;

/* For EP_TRIM_SPLIT_COST [section 3.2]: what a split adds to a ray, in the nanoseconds of ep_trim_usual_costs. It makes
 * about six parts, which is 2.6 halvings, of 1.4 ns in packets and 3.7 ns for single rays. */
static const double split_cost = 8;

/* The least height of a triangle over its longest side, and of a rectangle over its width. Where the parametrisation is
 * less even, triangles are not that slender: what bends along one is divided by its height, and rays that such a leaf
 * cannot decide are dear. */
static const double thinnest = 0.04;

/* Cuts of rectangles are multiples of it: floats, like their differences. */
static const double grid = 0x1p-24;

static void corners_of(const ep_domain *d, ep_point2 corner[3])
{
    corner[0][0] = d->u0, corner[0][1] = d->v0;
    corner[1][0] = d->u0 + d->uu, corner[1][1] = d->v0 + d->vu;
    corner[2][0] = d->u0 + d->uv, corner[2][1] = d->v0 + d->vv;
}

ep_trim_domain ep_trimmed_domain(ep_kind_id kind, const ep_domain *d)
{
    const double far = fmax(d->u0 + fmax(fmax(d->uu, d->uv), 0), d->v0 + fmax(fmax(d->vv, d->vu), 0));
    if (kind == EP_KIND_TENSOR) return ep_domain_rectangle(d->u0, d->u0 + d->uu, d->v0, d->v0 + d->vv, -seam * far);
    ep_point2 corner[3];
    corners_of(d, corner);
    return ep_domain_polygon(3, corner, -seam * far);
}

/* `share`: of the patch's domain, of which `least` is the smallest share of a leaf. */
static bool is_crowded(const ep_trim *trim, const ep_trim_part *part, const ep_domain *d, double share, double least)
{
    if (part->pieces < CROWD || share * trim->share > coarse) return false;
    const double across = hypot(fabs(d->uu) + fabs(d->uv), fabs(d->vv) + fabs(d->vu));
    return ep_trim_part_length(trim, part->words, across) * sqrt(least) > crowded * share;
}

bool ep_trimmed_wants_split(const ep_trim *trim, const ep_trim_part *part, ep_kind_id kind, const ep_domain *d,
                            EPTrimSplit way, double visits)
{
    if (way == EP_TRIM_SPLIT_NONE || !(visits >= worth_it)) return false;
    /* of the unit square or the unit triangle */
    const double share = fabs(d->uu * d->vv - d->uv * d->vu), least = share * worth_it / visits;
    const ep_trim_domain domain = ep_trimmed_domain(kind, d);
    /* curves that come from so far away that no part could be told to be clear of them */
    if (ep_domain_rounding(&domain, trim->scale) > 0x1p-6 * sqrt(share)) return false;
    if (way == EP_TRIM_SPLIT_REGULAR) return true;
    if (is_crowded(trim, part, d, share, least)) return false;
    if (way != EP_TRIM_SPLIT_COST) return true;
    return ep_trim_expect(trim, part, &domain, &ep_trim_usual_costs) > split_cost;
}

static unsigned split_triangle(const ep_trim *trim, const ep_trim_part *part, const ep_domain *d, EPTrimSplit way,
                               double distortion, ep_domain *parts)
{
    ep_point2 corner[3];
    ep_trim_triangles t;
    corners_of(d, corner);
    if (way == EP_TRIM_SPLIT_REGULAR) ep_trim_split_regular(corner, &t);
    else ep_trim_split_triangle(trim, part, corner, fmax(thinnest, distortion), &t);
    for (unsigned k = 0; k < t.count; ++k) {
        const ep_point2 *c = t.corner[k];
        parts[k] =
            (ep_domain){c[0][0], c[0][1], c[1][0] - c[0][0], c[2][0] - c[0][0], c[1][1] - c[0][1], c[2][1] - c[0][1]};
    }
    return t.count;
}

static unsigned split_rectangle(const ep_trim *trim, const ep_trim_part *part, const ep_domain *d, EPTrimSplit way,
                                ep_domain *parts)
{
    const ep_point2 lo = {d->u0, d->v0}, hi = {d->u0 + d->uu, d->v0 + d->vv};
    int axis = d->vv > d->uu;
    double at = 0.5 * (lo[axis] + hi[axis]);
    if (way != EP_TRIM_SPLIT_REGULAR) ep_trim_split_rectangle(trim, part, lo, hi, thinnest, &axis, &at);
    at = grid * rint(at / grid);
    if (!(lo[axis] < at && at < hi[axis])) at = lo[axis] + 0.5 * (hi[axis] - lo[axis]);
    parts[0] = parts[1] = *d;
    if (axis == 0) {
        parts[0].uu = at - lo[0];
        parts[1].u0 = at;
        parts[1].uu = hi[0] - at;
    } else {
        parts[0].vv = at - lo[1];
        parts[1].v0 = at;
        parts[1].vv = hi[1] - at;
    }
    return 2;
}

unsigned ep_trimmed_split(const ep_trim *trim, const ep_trim_part *part, ep_kind_id kind, const ep_domain *d,
                          EPTrimSplit way, double distortion, ep_domain parts[EP_TRIMMED_PARTS])
{
    return kind == EP_KIND_TRIANGLE ? split_triangle(trim, part, d, way, distortion, parts)
                                    : split_rectangle(trim, part, d, way, parts);
}
