/* leaf.h - the leaf of the hierarchy: a piece of a patch in a tripiped, with what certifies its hits.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A leaf covers a part D of a patch's domain; x = (s, t) are coordinates in which D is [0,1]² or the unit triangle.
 * Its frame is an affine map of space, M, to leaf coordinates (s, t, h): on the piece, M S(x) = (x, 0) + r(x) with a
 * remainder r that vanishes as the piece gets small. So the plane h = 0 is the plane approximation from which
 * iteration starts, and |h| <= height, |r_s| <= side_s, |r_t| <= side_t make the prism: Stürzlinger's tripiped, five
 * planes (six around a rectangle), two parallel to the leaf and the others parallel to its sides.
 *
 * A ray o + k d meets the plane at x0 = (s, t)(o) - p h(o), p = (s, t)(d) / h(d) being how far it moves along the
 * leaf per unit of height. Projected along the ray, the hit is the zero of
 *
 *     F(x) = x - x0 + r_st(x) - p r_h(x),     so it is in Q: in D, and within side + |p| height of x0.
 *
 * With DF = I + R - p g^T, two of its values over D differ in R by at most (bend_s, bend_t) times the distance, row by
 * row, and in g by bend_h times it, in the maximum norm. Take y in D with J = DF(y), its Newton point
 * c = y - J^-1 F(y), and a root x* in D with |x* - y| <= e. The mean A of DF along the segment from y to x* has
 * F(y) = -A (x* - y), so
 *
 *     x* - c = J^-1 (J - A) (x* - y),   |x* - c| <= G e² / 2,   G = max over rows of |J^-1| (bend_s, bend_t)^T + |q| bend_h
 *
 * with q = J^-1 p, which stays of the order of 1/|g| however long p gets,
 * because A deviates from J by half of what DF does over the segment. Three conclusions, none of which counts steps:
 *
 *   (1) All roots in Q are within b = G e²/2 of c (or b' of c', below), with e the radius of Q about y. If c is farther than that outside
 *       D there is none. Otherwise b is the radius of a new, smaller Q about c.
 *   (2) If G e <= 1, DF = J (I + E) with |E| < 1 throughout Q: F is injective there, the root is unique, and
 *       |x* - y| <= |c - y| + G e |x* - y| / 2 gives |x* - y| <= 2 |c - y|, which is usually much less than e.
 *   (3) When b falls below the rounding error of F, c is the root.
 *
 * The first y need not be x0: the quadratic `model` of r makes F's zero a step of a few dozen operations away, and the
 * same three conclusions hold for that step with the model's error in place of rounding. One evaluation of the surface
 * then usually ends in (3).
 *
 * The model's second derivatives also take out most of what Newton leaves: with v = H (c-y)²/2, x* is at
 * c' = c - J^-1 (v_st - p v_h) up to what H differs from the truth, and (c-y)² from (x*-y)²:
 *
 *     |x* - c'| <= b' = W e² / 2 + (G e)² e / 2,    W like G with `warp`, the Lipschitz constants of D(r - model).
 *
 * Where b is not smaller than e the ray is nearly tangent to the leaf and solve.c subdivides. The test uses the
 * tangents where the ray is, not their range over the leaf, and the part of the leaf that the ray can touch: with a
 * height H = k/16 of an arc of curvature k it holds up to |p| k = 4, while a cone of normals must give up at 2. */
#ifndef EP_LEAF_H
#define EP_LEAF_H

#include "embree_patch/patch.h"

#include <stdalign.h>

/* Three cache lines, read once per visit; written by build.c, constant afterwards. Lengths are in leaf coordinates
 * unless said otherwise, and every bound includes the rounding of the frame itself to float. */
typedef struct ep_leaf {
    alignas(64) float frame[4][3]; /* columns for x, y, z (relative to the patch's centre) and 1; rows s, t, h     */
    float height;              /* half the prism's thickness                                                      */
    float side_s, side_t;      /* how far the prism reaches beyond the domain                                     */
    float reach_st, reach_h;   /* rounding error of M(o) per unit of |o|, |.| the sum norm: 8 eps |row of M|       */
    float model[4][3];         /* r at the middle of D, and r_ss, r_st, r_tt there; each for s, t, h               */
    float model_st, model_h;   /* how far r may be from that quadratic                                            */
    float bend[3];             /* Lipschitz constants of the derivatives of r_s, r_t, r_h                         */
    float warp[3];             /* the same for r minus the model                                                  */
    float noise_st, noise_h;   /* rounding errors of F: of its rows, and of the height that p multiplies          */
    float stretch;             /* |r_st(x) - r_st(y)| <= stretch |x - y|                                           */
    float domain[6];           /* u0, v0, uu, vv, uv, vu of ep_domain                                             */
    float volume;              /* S_u x S_v = volume * frame^T (S_s x S_t in leaf coordinates)                    */
    uint32_t patch;            /* index of the patch                                                              */
} ep_leaf;
_Static_assert(sizeof(ep_leaf) == 192, "a leaf is three cache lines");

/* The box of a leaf in the geometry's space, rounded outwards and padded: what Embree sees. */
typedef struct ep_box {
    float lower[3], upper[3];
} ep_box;

/* What the build wants to know beyond the leaf itself. */
typedef struct ep_fit_info {
    bool regular;      /* false: a pole or a cusp has no frame; the leaf is left to subdivision                     */
    double thickness;  /* 2 height, in units of the piece's width                                                  */
    double distortion; /* bound on |Dr_st|: how far the parametrisation is from affine                             */
    double turn[2];    /* how much halving the first or the second side would flatten the piece                  */
    double lower[3], upper[3]; /* box of the piece relative to the patch's centre                                  */
} ep_fit_info;

/* Fits frame, prism and certificate to the part `d` of a patch. `local` is the patch's net relative to its centre
 * (ep_patch_local). Fills everything but leaf->patch. With `tighten`, heights and boxes come from the
 * halves of the piece instead of from its own net, whose hull is looser. */
void ep_leaf_fit(const ep_patch *p, const ep_point *local, const ep_domain *d, bool tighten, ep_leaf *leaf,
                 ep_fit_info *info);

#endif
