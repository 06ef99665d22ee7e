/* region.c - the public regions: trim/'s builder with references, made ready as soon as it is complete.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/region.h"

#include <string.h>

_Static_assert((int)EP_UNION == (int)EP_REGION_UNION && (int)EP_INTERSECTION == (int)EP_REGION_INTERSECTION &&
                   (int)EP_DIFFERENCE == (int)EP_REGION_DIFFERENCE && (int)EP_LOOPS == (int)EP_REGION_LOOPS &&
                   (int)EP_POLYGON == (int)EP_REGION_POLYGON,
               "the public kinds are trim/'s");

EPRegion epNewRegion(void)
{
    EPRegion r = ep_alloc(1, sizeof *r);
    if (!r) return NULL;
    memset(r, 0, sizeof *r);
    atomic_init(&r->references, 1);
    r->region = ep_region_new();
    if (r->region) return r;
    ep_free(r);
    return NULL;
}

void epRetainRegion(EPRegion r)
{
    if (r) atomic_fetch_add(&r->references, 1);
}

void epReleaseRegion(EPRegion r)
{
    if (!r || atomic_fetch_sub(&r->references, 1) != 1) return;
    ep_trim_free(r->trim);
    ep_region_free(r->region);
    ep_free(r);
}

const char *epGetRegionMessage(EPRegion r)
{
    return r->message.text;
}

/* After a call that may have ended the outermost node. */
static EPStatus complete(EPRegion r, EPStatus status)
{
    ep_region_view view;
    ep_message open;
    if (status != EP_OK || ep_region_look(r->region, &view, &open) != EP_OK) return status;
    return ep_trim_new(r->region, &r->trim, &r->message);
}

size_t ep_region_object_bytes(EPRegion r)
{
    return sizeof *r + ep_region_bytes(r->region) + ep_trim_bytes(r->trim);
}

EPStatus epBeginRegion(EPRegion r, EPRegionKind kind, const double transform[6])
{
    if ((unsigned)kind > EP_POLYGON) return ep_fail(&r->message, EP_INVALID, "%d is no kind of region", (int)kind);
    return ep_region_begin(r->region, (ep_region_kind)kind, transform, &r->message);
}

EPStatus epEndRegion(EPRegion r)
{
    return complete(r, ep_region_end(r->region, &r->message));
}

EPStatus epAddRegionSquare(EPRegion r, const double transform[6])
{
    return complete(r, ep_region_square(r->region, transform, &r->message));
}

EPStatus epAddRegionCircle(EPRegion r, const double transform[6])
{
    return complete(r, ep_region_circle(r->region, transform, &r->message));
}

int epIsInRegion(EPRegion r, double u, double v)
{
    return r->trim && ep_trim_has_point(r->trim, u, v);
}

EPStatus epAddRegionLine(EPRegion r, size_t count, const double *points)
{
    return ep_region_line(r->region, count, (const ep_point2 *)points, &r->message);
}

EPStatus epAddRegionBezier(EPRegion r, size_t count, const double *points)
{
    return ep_region_bezier(r->region, count, (const ep_point2w *)points, &r->message);
}

EPStatus epAddRegionNURBS(EPRegion r, unsigned degree, size_t knotCount, const double *knots, size_t count,
                          const double *points)
{
    return ep_region_nurbs(r->region, degree, knotCount, knots, count, (const ep_point2w *)points, &r->message);
}
