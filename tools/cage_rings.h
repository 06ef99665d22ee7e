/* cage_rings.h - the limit surface of Catmull and Clark's scheme around an extraordinary point, ring by ring.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAGE_RINGS_H
#define EPATCH_CAGE_RINGS_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The vertices around a smooth vertex inside a mesh of quadrilaterals, all others of which are regular, and those of
 * its subdivisions, one level after the other. Sector i is the quadrilateral between edges i and i + 1,
 * counter-clockwise; point[i][a - 1][b] is a steps along edge i and b along edge i + 1 away. Two steps are what the
 * surface depends on. */
typedef struct cage_rings {
    size_t n; /* edges, at least 2 */
    int levels;
    double (*centre)[3];      /* of each level                                                                       */
    double (*point)[3][4][3]; /* of each sector of each level: a = 1..2, b = 0..2, and from the second on one more   */
    double limit[3];          /* where the centre goes                                                               */
    double tangent[2][3];     /* the last level's: along edge i, cos(2 pi i / n) of the one, sin of it of the other  */
} cage_rings;

/* A bicubic patch over the square of that size at x, y of a sector, which is the unit square with the extraordinary
 * point at the origin. */
typedef struct cage_ring_patch {
    double x, y, size, points[16][3]; /* x runs fastest */
} cage_ring_patch;

/* Room for a mesh, which is the caller's to fill in. False without memory. */
bool cage_rings_begin(cage_rings *r, size_t n);
void cage_rings_free(cage_rings *r);

/* Subdivides the mesh that often. False without memory. */
bool cage_rings_subdivide(cage_rings *r, int levels);
/* Subdivides it until what is left is within `flat` of its tangent plane, or within `tiny` of its point, in all
 * sectors. */
bool cage_rings_flatten(cage_rings *r, double flat, double tiny);

/* The patches of one sector: three a level, from the outside in, and one for what is left. The same number of levels in
 * all sectors leaves no gap. Ends early when `take` returns false. */
void cage_rings_cut(const cage_rings *r, size_t sector, bool (*take)(void *user, const cage_ring_patch *p), void *user);

#ifdef __cplusplus
}
#endif
#endif
