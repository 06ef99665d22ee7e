/* region.c - see region.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/region.h"

#include <string.h>

static void add_segment(EPRegion region, const trim_segment *g)
{
    EPStatus status;
    double line[RANDOM_POINTS][2];
    for (size_t i = 0; i < g->count; ++i) memcpy(line[i], g->points[i], sizeof line[i]);
    if (g->kind == SEGMENT_LINE) status = epAddRegionLine(region, g->count, line[0]);
    else if (g->kind == SEGMENT_BEZIER) status = epAddRegionBezier(region, g->count, g->points[0]);
    else status = epAddRegionNURBS(region, g->degree, g->count + g->degree + 1, g->knots, g->count, g->points[0]);
    CHECK(status == EP_OK, "%s", epGetRegionMessage(region));
}

static void add_shape(EPRegion region, const trim_shape *s)
{
    static const EPRegionKind kinds[] = {EP_UNION, EP_INTERSECTION, EP_DIFFERENCE, EP_LOOPS, EP_POLYGON};
    const double *t = s->transformed ? s->transform : NULL;
    EPStatus status;
    if (s->kind == SHAPE_SQUARE) {
        status = epAddRegionSquare(region, t);
    } else if (s->kind == SHAPE_CIRCLE) {
        status = epAddRegionCircle(region, t);
    } else {
        status = epBeginRegion(region, kinds[s->kind], t);
        for (size_t i = 0; i < s->count && !status; ++i)
            if (s->kind == SHAPE_POLYGON) add_segment(region, s->segment[i]);
            else add_shape(region, s->child[i]);
        if (!status) status = epEndRegion(region);
    }
    CHECK(status == EP_OK, "%s", epGetRegionMessage(region));
}

EPRegion new_region(const trim_shape *s)
{
    EPRegion region = epNewRegion();
    assert_non_null(region);
    add_shape(region, s);
    return region;
}
