/* cad_trim.h - the boundary of a face as loops in its surface's parameters.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAD_TRIM_H
#define EPATCH_CAD_TRIM_H

#include "tools/shim/cad_gap.h"
#include "tools/shim/cad_surface.h"

#include <Geom2d_BSplineCurve.hxx>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace cad
{

using curve = Handle(Geom2d_BSplineCurve);

inline bool is_straight(const curve &c)
{
    return c->Degree() == 1 && c->NbPoles() == 2 && !c->IsRational();
}

/* A side of a loop. */
struct side {
    curve along;
    std::vector<edge_gap> short_of; /* at one or more places along it; 0 along a seam and at a pole */

    void reverse()
    {
        along->Reverse();
        std::reverse(short_of.begin(), short_of.end());
        for (edge_gap &g : short_of) std::swap(g[0], g[1]);
    }
};
using loop = std::vector<side>;

/* The loops, each in one piece, in the surface's own parameters; none: the face is all of its surface. */
std::vector<loop> take_loops(const TopoDS_Face &face, const Handle(Geom_Surface) & s, const face_map &faces);

/* A box that the loops do not leave. */
void bound(const std::vector<loop> &loops, range box[2]);

/* A NURBS curve, its points being x, y and weight. */
struct flat_curve {
    int degree;
    std::vector<double> knots;
    std::vector<std::array<double, 3>> points;
};

/* A curve in the parameters of the NURBS surface: the same, or, where a parameter was an angle and neither stays as it
 * is, a spline that is off by 1e-10 of the box. */
flat_curve convert(const curve &c, const surface &s);

/* Is a loop the border of the surface, which needs no trim? */
bool is_border(const std::vector<flat_curve> &l, const surface &s);

/* Where a curve begins within rounding of where the one before it has ended, it begins there. */
void join(std::vector<flat_curve> &l, const surface &s);

} // namespace cad
#endif
