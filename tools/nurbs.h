/* nurbs.h - NURBS surfaces of scenes and models: the patches of a face.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_NURBS_H
#define EPATCH_NURBS_H

#include "tools/scene.h"

typedef struct nurbs {
    unsigned degree[2]; /* in u and in v */
    size_t count[2];    /* of control points */
    size_t knot_count[2];
    const double *knots[2];
    const double (*points)[4]; /* count[0] * count[1], u running fastest; Euclidean, with a weight */
} nurbs;

/* Appends the surface's patches as face `face`, which is the last one or the next. `trim`, in its parameters, and
 * `shape`, the same for the reference, which is the geometry's already: NULL for none. NULL, or what is wrong, in a
 * buffer that the next call writes to. */
const char *geometry_add_nurbs(scene_geometry *g, uint32_t face, const nurbs *n, EPRegion trim,
                               struct trim_shape *shape);

#endif
