/* loops.c - see loops.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/loops.h"
#include "test/oracle/trim_reference.h"
#include "tools/model.h"

static const char out_of_memory[] = "out of memory";

static const char *check(loops *l, EPStatus status)
{
    return status == EP_OK ? NULL : status == EP_NO_MEMORY ? out_of_memory : epGetRegionMessage(l->region);
}

const char *loops_begin(loops *l)
{
    *l = (loops){epNewRegion(), shape_new(SHAPE_LOOPS), NULL};
    if (!l->region || !l->shape) return out_of_memory;
    return check(l, epBeginRegion(l->region, EP_LOOPS, NULL));
}

const char *loops_begin_loop(loops *l)
{
    l->polygon = shape_new(SHAPE_POLYGON);
    if (!shape_add(l->shape, l->polygon)) return out_of_memory;
    return check(l, epBeginRegion(l->region, EP_POLYGON, NULL));
}

const char *loops_add_curve(loops *l, unsigned degree, size_t knot_count, const double *knots, size_t count,
                            const double (*points)[3])
{
    const char *problem = check(l, epAddRegionNURBS(l->region, degree, knot_count, knots, count, points[0]));
    if (problem) return problem;
    return shape_add_points(l->polygon, SEGMENT_NURBS, degree, knots, count, points[0], 3) ? NULL : out_of_memory;
}

const char *loops_add_lines(loops *l, size_t count, const double (*points)[2])
{
    const char *problem = check(l, epAddRegionLine(l->region, count, points[0]));
    if (problem) return problem;
    return shape_add_points(l->polygon, SEGMENT_LINE, 1, NULL, count, points[0], 2) ? NULL : out_of_memory;
}

const char *loops_end_loop(loops *l)
{
    return check(l, epEndRegion(l->region));
}

const char *loops_end(loops *l, scene_geometry *g, EPRegion *region, struct trim_shape **shape)
{
    const char *problem = check(l, epEndRegion(l->region));
    if (problem) return problem;
    if (!geometry_add_shape(g, l->shape)) return out_of_memory;
    *region = l->region;
    *shape = l->shape;
    *l = (loops){NULL, NULL, NULL};
    return NULL;
}

void loops_free(loops *l)
{
    epReleaseRegion(l->region);
    shape_free(l->shape);
    *l = (loops){NULL, NULL, NULL};
}
