/* trim_reference.h - a slow answer to "is this point inside the region?", by other means than trim/.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A region is a tree of shapes. Squares and circles are tested in their own coordinates; the boundary of a polygon is
 * followed by a chain of short chords that are found by evaluating the definition of each curve, and crossings of
 * a vertical ray with it are counted. Right for points further than the chords' sagitta from every border, which is far
 * below 1e-6 of the unit square. */
#ifndef ORACLE_TRIM_REFERENCE_H
#define ORACLE_TRIM_REFERENCE_H

#include <stdbool.h>
#include <stddef.h>

enum { SHAPE_CHILDREN = 12, SHAPE_POINTS = 16, SHAPE_KNOTS = 2 * SHAPE_POINTS };

typedef enum segment_kind { SEGMENT_LINE, SEGMENT_BEZIER, SEGMENT_NURBS } segment_kind;

typedef struct trim_segment {
    segment_kind kind;
    unsigned degree; /* of NURBS */
    unsigned count;
    double points[SHAPE_POINTS][3]; /* x, y, weight */
    double knots[SHAPE_KNOTS];
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

typedef struct trim_shape {
    shape_kind kind;
    bool transformed;
    double transform[6];
    unsigned count; /* of children or segments */
    struct trim_shape *child[SHAPE_CHILDREN];
    trim_segment *segment[SHAPE_CHILDREN];
    /* what the reference adds: chords in the domain's coordinates, a closed chain for each polygon */
    double (*chord)[2];
    size_t chords, room;
    double place[6];
} trim_shape;

trim_shape *shape_new(shape_kind kind);
void shape_free(trim_shape *s);

/* Once the tree is complete. */
void shape_prepare(trim_shape *root);
bool shape_has(const trim_shape *s, double x, double y);
/* To the nearest border of any contour, also of one that does not show. */
double shape_distance(const trim_shape *s, double x, double y);

#endif
