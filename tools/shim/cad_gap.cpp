/* cad_gap.cpp - see cad_gap.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A file has an edge, and for each of its faces a curve on the surface that is to be the same. They are not: curves are
 * approximated, and surfaces meet where they were computed to. What is stated is a tolerance, but that is mostly more
 * than what there is, and sometimes less, so it is measured.
 *
 * A face has to reach the edge, which may be farther out than its side; past the other face, if that is off the edge,
 * for where they meet at an angle; and where they meet smoothly and one is above the other, so far that few rays slip
 * through between. What reaches farther is in the way of other rays.
 *
 * A pole has an edge, too, which is a point. Where the surface ends before, in a circle that is tiny, it goes on across
 * that. */
#include "tools/shim/cad_gap.h"

#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <TopTools_ListIteratorOfListOfShape.hxx>
#include <TopoDS.hxx>

#include <algorithm>
#include <cmath>

namespace cad
{

namespace
{

constexpr int last_sample = 16;
constexpr double between = 1.25; /* what may be missed between two samples */
constexpr double past_own = 2, past_other = 0.5;
constexpr double rounding = 0x1p-44;  /* of coordinates: no gap */
constexpr double most_of_a_pole = 10; /* of its tolerance: else it is none */
constexpr size_t most = 8;            /* other faces: in a book of thousands that is enough */

/* Where the edge is nearest to p, from t on by Newton's method. */
gp_Pnt nearest(const Handle(Geom_Curve) & c, double from, double to, double t, const gp_Pnt &p)
{
    gp_Pnt at = c->Value(t);
    constexpr int steps = 4;
    for (int i = 0; i < steps; ++i) {
        gp_Vec along;
        c->D1(t, at, along);
        if (!(along.SquareMagnitude() > 0)) break;
        t = std::clamp(t + gp_Vec(at, p) * along / along.SquareMagnitude(), from, to);
    }
    const gp_Pnt next = c->Value(t);
    return next.SquareDistance(p) < at.SquareDistance(p) ? next : at;
}

/* From where a face's side for an edge is to the edge, there and on the right of the side. */
struct gap {
    gp_Vec right, across, to;
    gp_XYZ from;
};

class edge_side
{
  public:
    edge_side(const TopoDS_Edge &edge, const TopoDS_Face &face)
        : of(BRep_Tool::CurveOnSurface(edge, face, first, last)), s(BRep_Tool::Surface(face)),
          c(BRep_Tool::Curve(edge, from, to))
    {
    }
    bool known() const { return !of.IsNull() && !c.IsNull(); }

    gap at(double t) const
    {
        gp_Pnt2d at;
        gp_Vec2d along;
        gp_Pnt p;
        gp_Vec u, v;
        of->D1(t, at, along);
        s->D1(at.X(), at.Y(), p, u, v);
        gap g{{}, u.Crossed(v), gp_Vec(p, nearest(c, from, to, t, p)), p.XYZ()};
        g.right = (u * along.X() + v * along.Y()).Crossed(g.across);
        return g;
    }

  private:
    double first, last, from, to;
    Handle(Geom2d_Curve) of;
    Handle(Geom_Surface) s;
    Handle(Geom_Curve) c;
};

} // namespace

std::vector<edge_gap> measure_gaps(const TopoDS_Edge &edge, const TopoDS_Face &face, double first, double last,
                                   const face_map &faces)
{
    const double said = BRep_Tool::Tolerance(edge);
    const edge_side own(edge, face);
    if (!own.known() || !BRep_Tool::SameRange(edge)) return {{said, said}};
    std::vector<edge_side> others;
    if (faces.Contains(edge))
        for (TopTools_ListIteratorOfListOfShape f(faces.FindFromKey(edge)); f.More() && others.size() < most; f.Next())
            if (!f.Value().IsSame(face)) others.emplace_back(edge, TopoDS::Face(f.Value()));
    std::vector<edge_gap> all(last_sample + 1, {0, 0});
    for (int i = 0; i <= last_sample; ++i) {
        const double t = first + (last - first) * i / last_sample;
        const gap g = own.at(t);
        if (!(g.right.Magnitude() > 0)) continue;
        const double out = g.to * g.right / g.right.Magnitude(),
                     off = std::fabs(g.to * g.across) / g.across.Magnitude();
        double other = 0;
        for (const edge_side &o : others)
            if (o.known()) other = std::max(other, o.at(t).to.Magnitude());
        const double own_gap = g.to.Magnitude();
        if (own_gap + other <= rounding * g.from.Modulus()) continue;
        for (int k = 0; k < 2; ++k)
            all[i][k] = std::min(between * (std::max(k ? -out : out, 0.0) + past_own * off + past_other * other),
                                 std::max({said, own_gap, other}));
    }
    return all;
}

edge_gap measure_pole(const TopoDS_Edge &edge, const TopoDS_Face &face, double first, double last)
{
    double from, to, around = 0;
    const Handle(Geom2d_Curve) side = BRep_Tool::CurveOnSurface(edge, face, from, to);
    const Handle(Geom_Surface) s = BRep_Tool::Surface(face);
    const auto point = [&](double t) {
        const gp_Pnt2d at = side->Value(t);
        return s->Value(at.X(), at.Y());
    };
    const gp_Pnt begin = point(first);
    for (int i = 1; i < last_sample; ++i)
        around = std::max(around, point(first + (last - first) * i / last_sample).Distance(begin));
    const bool is_point = around <= most_of_a_pole * BRep_Tool::Tolerance(edge);
    const double gap = is_point && around > rounding * begin.XYZ().Modulus() ? between * around : 0;
    return {gap, gap};
}

} // namespace cad
