/* loops.h - the trim of a face as CAD writes it: loops of curves in the face's parameters, even-odd.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Written down twice at once: for the library, and as it is given, for the reference that `epatch verify` holds the
 * library against. Functions return NULL, or what is wrong in words that live until the next call. */
#ifndef EPATCH_LOOPS_H
#define EPATCH_LOOPS_H

#include "tools/scene.h"

typedef struct loops {
    EPRegion region;
    struct trim_shape *shape, *polygon; /* the polygon is the shape's */
} loops;

const char *loops_begin(loops *l);
const char *loops_begin_loop(loops *l);
/* The loop goes on with a NURBS curve of `count` points (x, y, weight) and count + degree + 1 knots; or with straight
 * lines between `count` points. */
const char *loops_add_curve(loops *l, unsigned degree, size_t knot_count, const double *knots, size_t count,
                            const double (*points)[3]);
const char *loops_add_lines(loops *l, size_t count, const double (*points)[2]);
const char *loops_end_loop(loops *l);
/* The complete region, which the caller releases; the shape is the geometry's from now on. */
const char *loops_end(loops *l, scene_geometry *g, EPRegion *region, struct trim_shape **shape);

/* Whatever has been begun; also after loops_end. */
void loops_free(loops *l);

#endif
