/* trim_reference.h - a slow answer to "is this point inside the region?", by other means than trim/.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A region is a tree of shapes. Squares and circles are tested in their own coordinates. A polygon is even-odd: the
 * crossings of a vertical ray are counted by halving each curve until the hull of its control points lies beside the
 * point. Where that would take hulls much smaller than `band`, the point is near the border and there is no answer. */
#ifndef ORACLE_TRIM_REFERENCE_H
#define ORACLE_TRIM_REFERENCE_H

#include "test/oracle/rng.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum segment_kind { SEGMENT_LINE, SEGMENT_BEZIER, SEGMENT_NURBS } segment_kind;

typedef struct trim_segment {
    segment_kind kind;
    unsigned degree; /* of NURBS */
    size_t count;
    double (*points)[3]; /* x, y, weight           */
    double *knots;       /* count+degree+1 of NURBS */
} trim_segment;

typedef enum shape_kind {
    SHAPE_UNION,
    SHAPE_INTERSECTION,
    SHAPE_DIFFERENCE,
    SHAPE_LOOPS,
    SHAPE_POLYGON,
    SHAPE_SQUARE,
    SHAPE_CIRCLE
} shape_kind;

/* A Bézier curve in the domain's coordinates. Curves that meet have equal ends, bit for bit: those of the points round.
 */
typedef struct shape_curve {
    double end[2][2];
    size_t first; /* of its degree+1 homogeneous points */
    unsigned degree;
} shape_curve;

typedef struct trim_shape {
    shape_kind kind;
    bool transformed;
    double transform[6];
    size_t count; /* of children or segments */
    struct trim_shape **child;
    trim_segment **segment;
    /* what shape_prepare() adds: of a contour, its border */
    shape_curve *curves;
    double (*points)[3];
    size_t curve_count, point_count;
    double place[6];
} trim_shape;

/* NULL when there is no memory; the others return false. */
trim_shape *shape_new(shape_kind kind);
void shape_free(trim_shape *s);
/* `count` points of weight 1 at the origin, and knots of 0. */
trim_segment *segment_new(segment_kind kind, unsigned degree, size_t count);
void segment_free(trim_segment *g);
/* Takes the child or the segment over, whatever it returns; NULL is no memory, too. */
bool shape_add(trim_shape *s, trim_shape *child);
bool shape_add_segment(trim_shape *s, trim_segment *g);
/* The same of a segment with these points, `each` doubles a point (without a third one, of weight 1), and of NURBS with
 * these knots. */
bool shape_add_points(trim_shape *s, segment_kind kind, unsigned degree, const double *knots, size_t count,
                      const double *points, size_t each);

/* Once the tree is complete. */
bool shape_prepare(trim_shape *root);

typedef enum shape_side { SHAPE_OUT, SHAPE_IN, SHAPE_NEAR } shape_side;

/* SHAPE_NEAR when the point is closer than about `band` to the border of any contour, also of one that does not show;
 * never when it is farther than 1.6 times that. */
shape_side shape_at(const trim_shape *s, double x, double y, double band);

/* A point of some contour's border; false when there is none. */
bool shape_border(const trim_shape *s, rng *r, double *x, double *y);

#endif
