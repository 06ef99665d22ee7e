/* leaf.h - the leaf of the hierarchy: a piece of a patch in a tripiped, with what certifies its hits.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A leaf covers a part D of a patch's domain; x = (s, t) are coordinates in which D is [-1/2, 1/2]² or the unit
 * triangle about its centroid. Its frame is an affine map of space, M, to leaf coordinates (s, t, h): on the piece, M
 * S(x) = (x, 0) + r(x) with a remainder r that vanishes as the piece gets small. So the plane h = 0 is the plane
 * approximation from which iteration starts, and |h| <= height, |r_s|, |r_t| <= side make the prism: Stürzlinger's
 * tripiped, five planes (six around a rectangle), two parallel to the leaf and the others parallel to its sides.
 *
 * The kernels compute with r itself, a polynomial in powers of s and t (a quotient of two, if rational). Leaf
 * coordinates are small, so its coefficients fall off like the powers of the piece's size; a Horner scheme costs half
 * of what de Casteljau's would, and errs by units in the last place of the leaf, not of the patch.
 *
 * A ray o + k d meets the plane at x0 = (s, t)(o) - p h(o), p = (s, t)(d) / h(d) being how far it moves along the
 * leaf per unit of height. Projected along the ray, the hit is the zero of
 *
 *     F(x) = x - x0 + r_st(x) - p r_h(x),     so it is in Q: in D, and within side + |p| height of x0.
 *
 * With DF = I + R - p g^T, two of its values over D differ in R by at most bend_st times the distance, and in g by
 * bend_h times it, in the maximum norm. Take y in D with J = DF(y), its Newton point c = y - J^-1 F(y), and a root x*
 * in D with |x* - y| <= e. The mean A of DF along the segment from y to x* has F(y) = -A (x* - y), so
 *
 *     x* - c = J^-1 (J - A) (x* - y),   |x* - c| <= G e² / 2,   G = |J^-1| bend_st + |q| bend_h
 *
 * with q = J^-1 p, which stays of the order of 1/|g| however long p gets, because A deviates from J by half of what DF
 * does over the segment. Three conclusions, none of which counts steps:
 *
 *   (1) All roots in Q are within b = G e²/2 of c (or b' of c', below), with e the radius of Q about y. If c is farther
 *       than that outside D there is none. Otherwise b is the radius of a new, smaller Q about c.
 *   (2) With w = |c - y| and a = G w <= 3/8, |x* - y| <= w + G |x* - y|²/2 holds up to the equation's lesser root, at
 *       most w (1 + 8/9 a), and again from the greater on, at least (2 - 4/3 a) / G. If e is no more than that,
 *       |x* - y| <= w (1 + 8/9 a), usually much less than e; and as G times that is at most 1/2, DF = J (I + E) with
 *       |E| < 1 there: F is injective, the root is unique.
 *   (3) When b falls below the rounding error of F, c is the root.
 *
 * The first y need not be x0. Seen from its plane the leaf is a graph, its height over its feet x + r_st(x), and a ray
 * meets a graph that is nearly quadratic where a quadratic equation has its roots (w_start in isa/start_tmpl.h): that
 * leaves a small Q, or none, however the leaf is parametrised. One evaluation of the surface then usually ends in (3).
 * What that equation is to be solved to is little: b' is below rounding once |c - y| is a fiftieth of the leaf.
 *
 * Terms of the second order take out most of what Newton leaves: with H the second derivatives of r at y and v = H
 * (c-y)²/2, x* is at c' = c - J^-1 (v_st - p v_h) up to terms of the third order, and what (c-y)² differs from (x*-y)²:
 *
 *     |x* - c'| <= b' = T e³ / 2 + (G e)² (1 + G e / 4) e / 2,    T like G with `twist`, a third of the Lipschitz
 *                                                                 constants of second derivatives,
 *
 * for (x*-y)² and (c-y)² differ by at most |x*-c| (2 |x*-y| + |x*-c|). When rounding displaces c by n, |x*-c| grows by
 * n, and c' is displaced by n (1 + G e + ((G e)² + G n) / 2); e being no less than n, by n (1 + 3/2 G e + (G e)² / 2)
 * at most.
 *
 * Where the quadratic equation has two roots in the leaf, or may have a double one, and where b is not smaller than e,
 * the ray is nearly tangent to the leaf; cells along its way (isa/cells_tmpl.h) and then subdivision (solve.c) take
 * over. Both tests use the tangents where the ray is, not their range over the leaf, as a cone of normals would. */
#ifndef EP_LEAF_H
#define EP_LEAF_H

#include "embree_patch/patch.h"

#include <stdalign.h>

/* Three cache lines, read once per visit; written by build.c, constant afterwards. Lengths are in leaf coordinates
 * unless said otherwise, and every bound includes the rounding of the frame itself to float. */
typedef struct ep_leaf {
    alignas(64) float frame[3][3];     /* M without its offset: columns for x, y, z; rows s, t, h                */
    float centre[3], centre_low[3];    /* M's zero is centre + centre_low, exactly, in the geometry's space      */
    float rim;                         /* how far the prism reaches from the middle along s and t, ...           */
    float height;                      /* ... and along h                                                        */
    float graph, foot;                 /* how far the model may be off: heights over feet, and the way from feet */
    float reach;                       /* by rays: what these four, and noise, grow by per |t| |d|               */
    float middle;                      /* the graph's height over the middle of D, in the model                  */
    float half[3][3];                  /* the model: u_s², 2 u_s u_t, u_t² in u - x, for s and t, and in heights */
    float sigma;                       /* bound on the norm of the cofactors of I + Dr_st                        */
    float bend_st, noise_st, twist_st; /* of (r_s, r_t): Lipschitz constants of its derivatives, its rounding, ... */
    float bend_h, noise_h, twist_h;    /* ... a third of those of second derivatives; of r_h                     */
    float domain[6];                   /* u0, v0, uu, vv, uv, vu of ep_domain                                    */
    float volume;                      /* S_u x S_v = volume * frame^T (S_s x S_t in leaf coordinates)           */
    uint32_t patch;                    /* index of the patch                                                     */
    uint32_t net;                      /* where its coefficients begin, in floats                                */
    uint32_t trim;                     /* 1 + where what decides about (u, v) within it begins; 0: all is kept   */
    uint8_t shape, degree_s, degree_t; /* of the coefficients; see ep_shape                                      */
    uint8_t rational : 1, stretch : 7; /* |Dr_st| <= stretch / EP_STRETCH over D, or is not below one            */
} ep_leaf;
enum { EP_STRETCH = 127 };
_Static_assert(sizeof(ep_leaf) == 192, "a leaf is three cache lines");

/* The coefficient of s^i t^j stands at the index that the kind gives to (i, j), (r_s, r_t, r_h) or, if rational,
 * (w (s + r_s), w (t + r_t), w r_h, w). */
static inline unsigned ep_leaf_stride(const ep_leaf *leaf)
{
    return leaf->rational ? 4 : 3;
}

/* A leaf's constants are made for rays that are no closer to parallel to its plane than |p| < EP_STEEP, come from no
 * farther than where reach |t| |d| < EP_ASTRAY, and meet the graph over a foot that is known to EP_ABOUT; others are
 * left to isa/tangent_tmpl.h.
 *
 * A piece that has no frame, a pole or a line, has an infinite height, on which the kernels leave every ray undecided.
 * Its points are within `foot`, which is in space there, of the line through the centre along the frame's row s. */
#define EP_STEEP 0x1p5f
#define EP_ASTRAY 0x1p-2f
#define EP_ABOUT 0x1p-3f

/* A root that may be farther than this on either side of the leaf's border, in leaf coordinates, is found again in
 * double. If it then is farther outside it is the neighbour's alone: what is found must not depend on which leaves were
 * met. Others are in the boxes of both. */
#define EP_SHARP 0x1p-18f

/* Rounding (noise_st) that has every root of a leaf found again in double, with its normal. */
#define EP_VAGUE 0x1p-14f

/* How far the prism reaches beyond the domain. */
static inline float ep_leaf_side(const ep_leaf *leaf, int triangle)
{
    return leaf->rim - (triangle ? 1.0f / 3 : 0.5f);
}

/* How far from the middle along s and t the prism reaches at most. */
static inline float ep_leaf_room(const ep_leaf *leaf, int triangle)
{
    return (triangle ? 2 * (1.0f / 3) : 0.5f) + ep_leaf_side(leaf, triangle);
}

/* |Dr_st|, and what rounding adds to it. */
static inline float ep_leaf_stretch(const ep_leaf *leaf)
{
    return (float)leaf->stretch / EP_STRETCH + leaf->noise_st;
}

/* How much farther than a foot u the model's point over it may be off, beside `foot`: 1 + k, k = |H_st| |u|, for a foot
 * that is in D give or take EP_ABOUT. A triangle's corner is where both coordinates of a foot are farthest out. */
static inline float ep_leaf_from_foot(const ep_leaf *leaf, int triangle)
{
    const float u = triangle ? fmaf(4, leaf->rim, 4 * EP_ABOUT - 2.0f / 3) : leaf->rim + EP_ABOUT;
    return fmaf(leaf->bend_st, u, 1);
}

/* How far the patch's parameters move when a leaf coordinate moves by one. */
static inline float ep_leaf_extent(const ep_leaf *leaf)
{
    const float *d = leaf->domain;
    return fmaxf(fabsf(d[2]) + fabsf(d[4]), fabsf(d[3]) + fabsf(d[5]));
}

/* Degrees 1 to 4, the same both ways, have kernels of their own; shape 0 of each block takes any. */
enum { EP_SPECIAL_DEGREES = 4, EP_SHAPES = 4 * (EP_SPECIAL_DEGREES + 1) };

/* The box of a leaf in the geometry's space, rounded outwards and padded: what Embree sees. */
typedef struct ep_box {
    float lower[3], upper[3];
} ep_box;

/* A leaf being fitted, and what the build wants to know beyond it. */
typedef struct ep_fit {
    ep_leaf leaf;
    bool regular;      /* false: a pole or a cusp has no frame; the leaf is left to subdivision                     */
    bool line;         /* ... for the piece is no more than a line, or a point                                      */
    double thickness;  /* 2 height, in units of the piece's width                                                  */
    double distortion; /* bound on |Dr_st|: how far the parametrisation is from affine                             */
    double side;       /* bound on |r_s| and |r_t|                                                                 */
    double turn[2];    /* how much halving the first or the second side would flatten the piece                  */
    double loss;       /* how far rounding puts its series off, in units of the patch's radius                      */
    double error;      /* the leaf's noise in scene units                                                          */
    size_t net_floats; /* what ep_leaf_pack will write                                                             */
    double area;       /* of the part of the domain, in parameters; negative where it stands on its head            */
    double weight_low; /* no weight is below it, the middle's being one */
    ep_vec3 row[3], column[3];      /* M as rounded, and its inverse                 */
    ep_point series[EP_NET_POINTS]; /* M S w and w in powers of s and t */
    ep_point rest[EP_NET_POINTS];   /* r w and w                        */
    /* Of the patch, from ep_leaf_begin. */
    const ep_patch *patch;
    const ep_kind *kind;
    unsigned m, n;                   /* its degrees                                                           */
    unsigned raised;                 /* those of `rest` are higher by this                                    */
    ep_point local[EP_NET_POINTS];   /* ep_patch_local                                                        */
    size_t terms;                    /* of `rest`                                                             */
    size_t low[6];                   /* where those of 1, s, t, s², st, t² are, SIZE_MAX for none             */
    double monomial[EP_NET_POINTS];  /* how much a term may be, its coefficient being one                     */
    double high[EP_NET_POINTS];      /* ... those that are not in `low`                                       */
    double spread[EP_NET_POINTS][5]; /* how much its derivatives by s, t, ss, st, tt may be, but in the middle */
    double third[EP_NET_POINTS];     /* ... and |sss| + 3 |sst| + 3 |stt| + |ttt|                             */
} ep_fit;

/* Degree of the series of r W. */
static inline unsigned ep_rest_m(const ep_fit *f)
{
    return f->m + f->raised;
}
static inline unsigned ep_rest_n(const ep_fit *f)
{
    return f->n + f->raised;
}

static inline double ep_monomial(const ep_fit *f, unsigned i, unsigned j)
{
    return f->monomial[f->kind->index(ep_rest_m(f), ep_rest_n(f), i, j)];
}

/* Prepares for the pieces of a patch, which has to stay. */
void ep_leaf_begin(const ep_patch *p, ep_fit *fit);

/* Fits frame and prism to the part `d` of the patch: all that says whether the piece is to be a leaf. */
void ep_leaf_fit(const ep_domain *d, ep_fit *fit);

/* The rest of the certificate, for a piece that is kept; all but leaf.patch, leaf.net and leaf.trim is there then. */
void ep_leaf_certify(const ep_domain *d, ep_fit *fit);

/* M's zero: *at, relative to the patch's centre, which becomes what of it leaf.centre and leaf.centre_low hold. */
void ep_leaf_put_centre(ep_fit *fit, ep_vec3 *at);

/* The box of a fitted piece in the geometry's space. */
void ep_leaf_box(const ep_fit *fit, const ep_domain *d, double lower[3], double upper[3]);

/* Writes the coefficients of a fitted leaf. */
void ep_leaf_pack(const ep_fit *fit, float *net);

#endif
