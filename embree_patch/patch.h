/* patch.h - one patch as the library keeps it, and the two kinds of patch.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A patch is stored twice: its homogeneous control points in double, as given, for building and for the cases that
 * float cannot decide; and a float net relative to a centre, laid out for the kernels.
 *
 * The kernel net stops de Casteljau's algorithm one level before the end [de Casteljau 1959; Farin, Curves and
 * Surfaces for CAGD, 5th ed., 4.2 and 17.2]. In a tensor patch of degree (m, n) that level has four points,
 *
 *     H_ab(u,v) = sum_ij B^(m-1)_i(u) B^(n-1)_j(v) P_(i+a)(j+b),   a, b in {0, 1},
 *
 * and the surface is their bilinear mix, S_u = m times the mix of H_1b - H_0b along v, and so on: one set of weights
 * gives point and tangents, every sum is a convex combination, and no derivative comes from large terms cancelling.
 * A block of 16 floats holds what one pair of weights multiplies: P_ij, P_i(j+1), P_(i+1)j, P_(i+1)(j+1), each
 * (wx, wy, wz, w). A triangle of degree n has three such points, and its blocks are P_ij, P_i(j+1), P_(i+1)j, 0. */
#ifndef EP_PATCH_H
#define EP_PATCH_H

#include "embree_patch/base.h"
#include "embree_patch/bezier.h"
#include "embree_patch/vec.h"

typedef enum ep_kind_id { EP_KIND_TENSOR, EP_KIND_TRIANGLE } ep_kind_id;

/* A part of a patch's domain: the affine image of [0,1]² or of the unit triangle,
 * (u, v) = (u0 + s uu + t uv, v0 + s vu + t vv). Parts of tensor patches are rectangles, uv = vu = 0. */
typedef struct ep_domain {
    double u0, v0, uu, uv, vu, vv;
} ep_domain;

typedef struct ep_patch {
    const float *net;    /* blocks of 16, see above; 64-byte aligned                                 */
    float centre[3];     /* the net's origin in the geometry's space is centre + centre_low, exactly */
    float centre_low[3]; /* ... the part of it that centre's rounding left over                      */
    float radius;        /* max |coordinate| of the net's Euclidean points, scene units              */
    float weight_max;    /* largest weight; 1 for polynomial patches                                 */
    uint8_t kind, degree_u, degree_v, rational;
    uint8_t shape;       /* which kernel; see kernels.h                                              */
    const ep_point *points; /* homogeneous (wx, wy, wz, w) in the geometry's space                   */
} ep_patch;

/* What a kind of patch has to know. Nothing else in the build switches on the kind. */
typedef struct ep_kind {
    const char *name;
    size_t (*point_count)(unsigned m, unsigned n);
    size_t (*block_count)(unsigned m, unsigned n); /* of the kernel net */
    void (*eval)(const ep_point *net, unsigned m, unsigned n, double u, double v, ep_jet *jet);
    void (*restrict_to)(const ep_point *net, unsigned m, unsigned n, const ep_domain *d, ep_point *out);
    /* Fills the kernel net from points given relative to the centre. */
    void (*pack)(const ep_point *net, unsigned m, unsigned n, float *blocks);
    /* The parts that a domain is halved into: along its first side, its second, or (triangles) into four by the
     * midpoints of its sides whatever `along` is. Returns their number. */
    unsigned (*split)(const ep_domain *d, unsigned along, ep_domain part[4]);
    /* Where point (i, j) stands in a net; SIZE_MAX: there is none. */
    size_t (*index)(unsigned m, unsigned n, unsigned i, unsigned j);
    /* The net with both degrees raised by one, and the coefficients of s w and t w in that degree, (s, t) being the
     * domain's coordinates and w the net's fourth. */
    void (*raise)(const ep_point *net, unsigned m, unsigned n, ep_point *out, double *sw, double *tw);
    double mixed;     /* d²/dsdt of a net is its mixed difference times this times m n ... */
    double mixed_one; /* ... plus this times m                                             */
    double centre[2]; /* of the unit domain                                                */
    double square, product; /* largest (s - centre)², |(s - centre) (t - centre)| over it     */
} ep_kind;

extern const ep_kind ep_kinds[2]; /* by ep_kind_id */

/* The Euclidean point and derivatives of a homogeneous jet. */
typedef struct ep_frame {
    ep_vec3 p, pu, pv, puu, puv, pvv;
} ep_frame;
ep_frame ep_project(const ep_jet *jet);

/* Chooses the centre and fills the kernel net from p->points; p->net points to block_count * 16 floats. */
void ep_patch_pack(ep_patch *p, float *net);

/* The patch's points relative to its centre: (w(x-c), w). */
void ep_patch_local(const ep_patch *p, ep_point *out);

#endif
