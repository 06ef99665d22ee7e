/* patch.h - one patch as the library keeps it, and the two kinds of patch.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A patch is its homogeneous control points in double, as given: what the build cuts into leaves and what the slow path
 * computes with. The kernels never see it; each leaf holds the piece of surface that it covers (leaf.h). */
#ifndef EP_PATCH_H
#define EP_PATCH_H

#include "embree_patch/base.h"
#include "embree_patch/bezier.h"
#include "embree_patch/range.h"
#include "embree_patch/vec.h"

typedef enum ep_kind_id { EP_KIND_TENSOR, EP_KIND_TRIANGLE } ep_kind_id;

/* A part of a patch's domain: the affine image of [0,1]² or of the unit triangle,
 * (u, v) = (u0 + s uu + t uv, v0 + s vu + t vv). Parts of tensor patches are rectangles, uv = vu = 0. */
typedef struct ep_domain {
    double u0, v0, uu, uv, vu, vv;
} ep_domain;

typedef struct ep_patch {
    double centre[3]; /* middle of the control points' box: what the slow path's coordinates are relative to */
    double radius;    /* max |coordinate| of a control point from there, scene units                         */
    double weight_min, weight_max; /* the smallest and the largest weight                                     */
    double error; /* how far a hit may be from the surface by the kernels' rounding, scene units; from the build */
    uint8_t kind, degree_u, degree_v, rational;
    const ep_point *points; /* homogeneous (wx, wy, wz, w) in the geometry's space                            */
} ep_patch;

/* What a kind of patch has to know. Nothing else in the build switches on the kind. */
typedef struct ep_kind {
    const char *name;
    size_t (*point_count)(unsigned m, unsigned n);
    void (*eval)(const ep_point *net, unsigned m, unsigned n, double u, double v, ep_jet *jet);
    void (*restrict_to)(const ep_point *net, unsigned m, unsigned n, const ep_domain *d, ep_point *out);
    /* The surface over d as a polynomial in the leaf's coordinates: (s, t) of d minus `middle`. In double, or in
     * twofold.h's arithmetic. */
    void (*series)(const ep_point *net, unsigned m, unsigned n, const ep_domain *d, bool twofold, ep_point *out);
    /* How many times a rounding of points counts in the series, at most anywhere over d. */
    double (*growth)(unsigned m, unsigned n, const ep_domain *d);
    /* The parts that a domain is halved into: along its first side, its second, or (triangles) into four by the
     * midpoints of its sides whatever `along` is. Returns their number. */
    unsigned (*split)(const ep_domain *d, unsigned along, ep_domain part[4]);
    /* Where point (i, j), or the coefficient of s^i t^j, stands; SIZE_MAX: there is none. */
    size_t (*index)(unsigned m, unsigned n, unsigned i, unsigned j);
    /* Range of c[0] + c[1] s + c[2] t + c[3] s² + c[4] st + c[5] t² over the leaf's domain; not much too wide. */
    ep_range (*quadratic)(const double c[6]);
    /* max |s|^i |t|^j over the leaf's domain */
    double (*monomial)(unsigned i, unsigned j);
    unsigned halvings; /* that a split is: 1, or 2 where it makes four parts                        */
    double middle;     /* what the leaf's coordinates call zero, in both coordinates of the unit domain */
    double extent;     /* max |s|, |t|                                                                  */
    /* The linear function closest to s³ over the leaf's domain is level[0] s + c, to s²t level[1] s + level[2] t + c.
     */
    double level[3];
} ep_kind;

extern const ep_kind ep_kinds[2]; /* by ep_kind_id */

/* The Euclidean point and derivatives of a homogeneous jet. */
typedef struct ep_frame {
    ep_vec3 p, pu, pv, puu, puv, pvv;
} ep_frame;
ep_frame ep_project(const ep_jet *jet);

/* The ranges of the coordinates of points, Euclidean ones. */
void ep_hull(const ep_point *points, size_t count, ep_range box[3]);

/* Fills centre, radius and weights from the points. */
void ep_patch_measure(ep_patch *p);

/* The patch's points relative to its centre: (w(x-c), w). */
void ep_patch_local(const ep_patch *p, ep_point *out);

#endif
