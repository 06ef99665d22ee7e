/* triangles.c - see triangles.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/triangles.h"

#include <math.h>

bool normalise(double n[3])
{
    const double most = fmax(fabs(n[0]), fmax(fabs(n[1]), fabs(n[2])));
    if (most == 0) return false;
    for (int c = 0; c < 3; ++c) n[c] /= most; /* squares neither overflow nor all vanish now */
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int c = 0; c < 3; ++c) n[c] /= length;
    return true;
}

static void set_point(double to[4], const double p[3])
{
    for (int c = 0; c < 3; ++c) to[c] = p[c];
    to[3] = 1;
}

/* S. Ogaki, "Ray tracing of quadratic parametric surface", MI lecture note series 50 (2013):
 *     Q = A u² + B v² + C w² + D uv + E uw + F vw with A = P1, B = P2, C = P3, D = 4 P6 - (P1 + P2), ...
 * is P6 at u = v = 1/2, w = 0. The Bernstein polynomial of uv is 2 uv: its control point is D/2. */
static void through_middle(const double a[4], const double middle[4], const double b[4], double to[4])
{
    double p[3];
    for (int c = 0; c < 3; ++c) p[c] = 2 * middle[c] - (a[c] + b[c]) / 2;
    set_point(to, p);
}

void quadratic_triangle(const double on[6][4], double to[6][4])
{
    set_point(to[0], on[2]);
    through_middle(on[0], on[4], on[2], to[1]);
    set_point(to[2], on[0]);
    through_middle(on[1], on[3], on[2], to[3]);
    through_middle(on[0], on[5], on[1], to[4]);
    set_point(to[5], on[1]);
}

/* How far b is above the tangent plane of a. */
static double height(const mesh_vertex *a, const mesh_vertex *b)
{
    return (b->p[0] - a->p[0]) * a->n[0] + (b->p[1] - a->p[1]) * a->n[1] + (b->p[2] - a->p[2]) * a->n[2];
}

/* T. Boubekeur, M. Alexa, "Phong tessellation" (2008): with weights b of the vertices, p = sum b_j p_j and the
 * projection pi_i(q) = q - ((q - p_i) . n_i) n_i, p* = (1 - alpha) p + alpha sum b_i pi_i(p). pi_i is affine and the
 * weights sum to 1, so that pi_i(p) = sum b_j pi_i(p_j), and p* = sum over i, j of b_i b_j q_ij,  q_ij = (1 - alpha)
 * p_j + alpha pi_i(p_j) = p_j - alpha h_ij n_i with h_ij = (p_j - p_i) . n_i. b_i b_j comes twice, as q_ij and q_ji,
 * and its Bernstein polynomial is 2 b_i b_j: its control point is (q_ij + q_ji) / 2; those of the vertices are q_ii =
 * p_i. */
static void phong_middle(const mesh_vertex *a, const mesh_vertex *b, double alpha, double to[4])
{
    const double above_a = height(a, b), above_b = height(b, a);
    double p[3];
    for (int c = 0; c < 3; ++c) p[c] = (a->p[c] + b->p[c] - alpha * (above_a * a->n[c] + above_b * b->n[c])) / 2;
    set_point(to, p);
}

void phong_triangle(const mesh_vertex *const at[3], double alpha, double to[6][4])
{
    set_point(to[0], at[0]->p);
    phong_middle(at[0], at[1], alpha, to[1]);
    set_point(to[2], at[1]->p);
    phong_middle(at[0], at[2], alpha, to[3]);
    phong_middle(at[1], at[2], alpha, to[4]);
    set_point(to[5], at[2]->p);
}

/* A. Vlachos, J. Peters, C. Boyd, J. L. Mitchell, "Curved PN triangles" (2001): the point at a third of the way from a
 * to b, put onto the tangent plane of a. */
static void pn_third(const mesh_vertex *a, const mesh_vertex *b, double to[4])
{
    const double above = height(a, b);
    double p[3];
    for (int c = 0; c < 3; ++c) p[c] = (2 * a->p[c] + b->p[c] - above * a->n[c]) / 3;
    set_point(to, p);
}

void pn_triangle(const mesh_vertex *const at[3], double to[10][4])
{
    static const int corners[] = {0, 3, 9}, thirds[3][3] = {{0, 1, 4}, {2, 0, 6}, {7, 8, 0}}; /* [near][far] */
    for (int i = 0; i < 3; ++i) {
        set_point(to[corners[i]], at[i]->p);
        for (int j = 0; j < 3; ++j)
            if (i != j) pn_third(at[i], at[j], to[thirds[i][j]]);
    }
    /* the middle: E + (E - V) / 2, the means of the six points of the edges and of the vertices */
    double p[3];
    for (int c = 0; c < 3; ++c) {
        const double e = (to[1][c] + to[2][c] + to[4][c] + to[6][c] + to[7][c] + to[8][c]) / 6;
        p[c] = 1.5 * e - (to[0][c] + to[3][c] + to[9][c]) / 6;
    }
    set_point(to[5], p);
}
