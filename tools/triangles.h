/* triangles.h - curved triangles as Bézier triangles: quadratic ones through six points, and those that Phong
 * tessellation and PN triangles make of a mesh with normals.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Control points are x, y, z, w with w = 1, in the order of PATCH_TRIANGLE: for j in 0..n: for i in 0..n-j, the
 * exponents of v and u. Those along an edge depend on its two ends alone and not on which comes first: neighbours have
 * the same, bit for bit. They may be no points that can be traced, see point_problem. */
#ifndef EPATCH_TRIANGLES_H
#define EPATCH_TRIANGLES_H

#include <stdbool.h>

typedef struct mesh_vertex {
    double p[3], n[3]; /* n: a unit vector */
} mesh_vertex;

/* Makes n a unit vector, whatever its length. False when it is zero. */
bool normalise(double n[3]);

/* From P1 to P6, which are on the surface: at u = 1, v = 1, w = 1, and in the middle of the edges P2 P3, P1 P3, P1 P2.
 */
void quadratic_triangle(const double on[6][4], double to[6][4]);

/* Vertex 0 is at u = v = 0, vertex 1 at u = 1 and vertex 2 at v = 1. */
void phong_triangle(const mesh_vertex *const at[3], double alpha, double to[6][4]);
void pn_triangle(const mesh_vertex *const at[3], double to[10][4]);

#endif
