/* cad_trim.h - the boundary of a face as loops in its surface's parameters.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAD_TRIM_H
#define EPATCH_CAD_TRIM_H

#include "tools/shim/cad_surface.h"

#include <Geom2d_BSplineCurve.hxx>
#include <TopoDS_Face.hxx>

#include <array>
#include <vector>

namespace cad
{

using curve = Handle(Geom2d_BSplineCurve);
using loop = std::vector<curve>;

/* The loops, each in one piece, in the surface's own parameters; none: the face is all of its surface. */
std::vector<loop> take_loops(const TopoDS_Face &face, const Handle(Geom_Surface) & s);

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
