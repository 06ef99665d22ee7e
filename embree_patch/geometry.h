/* geometry.h - what is behind an EPGeometry.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_GEOMETRY_H
#define EP_GEOMETRY_H

#include "embree_patch/demand.h"
#include "embree_patch/face.h"
#include "embree_patch/kernels.h"
#include "embree_patch/region.h"

#include <stdatomic.h>

/* A patch as it was added; its points are at EPGeometryTy.points[first]. */
typedef struct ep_added {
    size_t first;
    uint8_t kind, degree_u, degree_v, rational;
    EPRegion region; /* NULL: untrimmed; holds a reference */
    ep_trim *trim;   /* the patch's own, where the region is in its face's parameters; else NULL */
} ep_added;

struct EPGeometryTy {
    atomic_int references;
    EPBuildSettings settings;
    const ep_kernels *kernels;
    ep_faces faces;
    ep_added *added;
    size_t added_count, added_capacity;
    ep_point *points; /* homogeneous */
    size_t point_count, point_capacity;
    ep_hierarchy hierarchy; /* of the last commit */
    size_t region_bytes;    /* that trim it, then */
    bool committed;         /* as the patches are, but for their points */
    bool moved;             /* points were set since */
    bool on_demand;         /* the last commit was: the hierarchy has a box a patch, and leaves are among the demands */
    ep_demand *demands;
    double build_seconds;
    ep_message message;
};

/* added.c */
const ep_trim *ep_added_trim(const ep_added *a); /* what trims it, NULL: nothing */
bool ep_added_shrink(EPGeometry g);              /* gives room for more patches back; false without memory */
void ep_added_free(EPGeometry g);

static inline size_t ep_face_count(EPGeometry g)
{
    return ep_faces_exist(&g->faces) ? g->faces.count : g->added_count;
}

#endif
