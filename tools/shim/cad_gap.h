/* cad_gap.h - how far faces end from the edges that they share.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAD_GAP_H
#define EPATCH_CAD_GAP_H

#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include <array>
#include <vector>

namespace cad
{

/* The faces of each edge. */
using face_map = TopTools_IndexedDataMapOfShapeListOfShape;

/* How far a face has to go on, in space, if the outside is on the right of its side or on the left. */
using edge_gap = std::array<double, 2>;

/* Of the face's side that the edge from `first` to `last` is, at places that are even in the parameter. */
std::vector<edge_gap> measure_gaps(const TopoDS_Edge &edge, const TopoDS_Face &face, double first, double last,
                                   const face_map &faces);

/* ... and where the side is one point, a pole. */
edge_gap measure_pole(const TopoDS_Edge &edge, const TopoDS_Face &face, double first, double last);

} // namespace cad
#endif
