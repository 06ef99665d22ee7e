/* cad_surface.cpp - see cad_surface.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Splines, planes and what is swept from splines keep their parameters, and so do lines. A circle becomes arcs of
 * rational curves, which are that circle, but whose parameter is no angle. What is left has no exact NURBS: offsets and
 * curves such as hyperbolas, which are approximated. */
#include "tools/shim/cad_surface.h"

#include <GeomConvert_ApproxCurve.hxx>
#include <GeomConvert_ApproxSurface.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_Line.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>

#include <algorithm>
#include <cmath>

namespace cad
{

namespace
{

/* How far what cannot be exact may be off. */
double tolerance(const gp_Pnt &a, const gp_Pnt &b)
{
    return 1e-8 * (a.XYZ().Modulus() + b.XYZ().Modulus());
}

struct vector {
    double x[3];
    vector(const gp_XYZ &v) : x{v.X(), v.Y(), v.Z()} {}
    operator const double *() const { return x; }
};

point homogeneous(const gp_Pnt &p, double w)
{
    return {w * p.X(), w * p.Y(), w * p.Z(), w};
}

/* All knots of a spline that is not periodic; of one that is, those of one period, and where its first span begins. */
std::vector<double> list_knots(const TColStd_Array1OfReal &knots, const TColStd_Array1OfInteger &times,
                               bool is_periodic, periodic &p)
{
    std::vector<double> all;
    for (int i = knots.Lower(); i <= knots.Upper() - (is_periodic ? 1 : 0); ++i)
        all.insert(all.end(), (size_t)times.Value(i), knots.Value(i));
    if (is_periodic) p = {knots.Last() - knots.First(), (size_t)times.First() - 1};
    return all;
}

/* What there is of `r` between two ends. */
range within(range r, double low, double high)
{
    const range left{std::max(r.low, low), std::min(r.high, high)};
    if (!(left.size() > 0)) throw unusable("it has no area in its parameters");
    return left;
}

/* The spline over `r`, which becomes smaller where there is much less of it. */
void restrict_to(net &n, int direction, const periodic &p, range &r)
{
    const range wanted = r;
    if (!(p.length > 0)) {
        const std::vector<double> &knots = n.knots[direction];
        r = within(r, knots[(size_t)n.degree[direction]], knots[n.count[direction]]);
    } else if (r.size() > 2.001 * p.length) {
        throw unusable("it goes round more than twice");
    }
    n = take_spans(n, direction, p, r);
    cut(n, direction, r);
    extend(n, direction, wanted, r);
}

net spline_curve(const Handle(Geom_BSplineCurve) & c, range &r)
{
    net n;
    periodic p;
    n.degree[0] = c->Degree();
    n.count[0] = (size_t)c->NbPoles();
    n.knots[0] = list_knots(c->Knots(), c->Multiplicities(), c->IsPeriodic(), p);
    for (int i = 1; i <= c->NbPoles(); ++i) n.points.push_back(homogeneous(c->Pole(i), c->Weight(i)));
    restrict_to(n, 0, p, r);
    return n;
}

net conic(const gp_Ax2 &at, double major, double minor, range r, std::optional<arcs> &angles)
{
    angles.emplace(r);
    return ellipse(*angles, vector(at.Location().XYZ()), vector(at.XDirection().XYZ() * major),
                   vector(at.YDirection().XYZ() * minor));
}

net convert_curve(const Handle(Geom_Curve) & c, range &r, std::optional<arcs> &angles)
{
    if (const auto trimmed = Handle(Geom_TrimmedCurve)::DownCast(c))
        return convert_curve(trimmed->BasisCurve(), r, angles);
    if (const auto l = Handle(Geom_Line)::DownCast(c))
        return line(vector(l->Lin().Location().XYZ()), vector(l->Lin().Direction().XYZ()), r);
    if (const auto o = Handle(Geom_Circle)::DownCast(c))
        return conic(o->Position(), o->Radius(), o->Radius(), r, angles);
    if (const auto o = Handle(Geom_Ellipse)::DownCast(c))
        return conic(o->Position(), o->MajorRadius(), o->MinorRadius(), r, angles);
    if (const auto b = Handle(Geom_BSplineCurve)::DownCast(c)) return spline_curve(b, r);
    if (const auto b = Handle(Geom_BezierCurve)::DownCast(c))
        return spline_curve(GeomConvert::CurveToBSplineCurve(b), r);
    if (!c->IsPeriodic()) r = within(r, c->FirstParameter(), c->LastParameter());
    const Handle(Geom_TrimmedCurve) part = new Geom_TrimmedCurve(c, r.low, r.high);
    GeomConvert_ApproxCurve a(part, tolerance(part->StartPoint(), part->EndPoint()), GeomAbs_C2, 100, 9);
    if (!a.HasResult()) throw unusable("its curve cannot be approximated");
    return spline_curve(a.Curve(), r);
}

/* A curve by its radii and heights about the axis of a frame. */
surface turn(const gp_Ax3 &at, const net &curve, const range box[2])
{
    surface s;
    s.box[0] = box[0];
    s.box[1] = box[1];
    s.angles[0].emplace(box[0]);
    s.patches = revolve(curve, *s.angles[0]);
    double m[12];
    const gp_XYZ columns[4] = {at.XDirection().XYZ(), at.YDirection().XYZ(), at.Direction().XYZ(), at.Location().XYZ()};
    for (int i = 0; i < 12; ++i) m[i] = columns[i / 3].Coord(i % 3 + 1);
    transform(s.patches, m);
    return s;
}

/* A cylinder or a cone. */
surface turn_line(const gp_Ax3 &at, double radius, double angle, const range box[2])
{
    const double origin[3] = {radius, 0, 0}, direction[3] = {std::sin(angle), 0, std::cos(angle)};
    return turn(at, line(origin, direction, box[1]), box);
}

/* A sphere or a torus. */
surface turn_circle(const gp_Ax3 &at, double major, double minor, const range box[2])
{
    const double origin[3] = {major, 0, 0}, x[3] = {minor, 0, 0}, y[3] = {0, 0, minor};
    const arcs angles(box[1]);
    surface s = turn(at, ellipse(angles, origin, x, y), box);
    s.angles[1] = angles;
    return s;
}

surface turn_curve(const Handle(Geom_SurfaceOfRevolution) & of, const range box[2])
{
    const gp_Ax3 at(of->Axis().Location(), of->Axis().Direction());
    gp_Trsf to_axis;
    to_axis.SetTransformation(at);
    range along = box[1];
    std::optional<arcs> angles;
    const net curve =
        convert_curve(Handle(Geom_Curve)::DownCast(of->BasisCurve()->Transformed(to_axis)), along, angles);
    const range part[2] = {box[0], along};
    surface s = turn(at, curve, part);
    s.angles[1] = angles;
    return s;
}

surface sweep(const Handle(Geom_SurfaceOfLinearExtrusion) & of, const range box[2])
{
    surface s;
    s.box[0] = box[0];
    s.box[1] = box[1];
    const net curve = convert_curve(of->BasisCurve(), s.box[0], s.angles[0]);
    s.patches = extrude(curve, vector(of->Direction().XYZ()), box[1]);
    return s;
}

surface plane(const gp_Ax3 &at, const range box[2])
{
    surface s;
    s.box[0] = box[0];
    s.box[1] = box[1];
    const net side = line(vector(at.Location().XYZ()), vector(at.XDirection().XYZ()), box[0]);
    s.patches = extrude(side, vector(at.YDirection().XYZ()), box[1]);
    return s;
}

surface spline(const Handle(Geom_BSplineSurface) & b, const range box[2])
{
    surface s;
    net &n = s.patches;
    periodic p[2];
    n.degree[0] = b->UDegree();
    n.degree[1] = b->VDegree();
    n.count[0] = (size_t)b->NbUPoles();
    n.count[1] = (size_t)b->NbVPoles();
    n.knots[0] = list_knots(b->UKnots(), b->UMultiplicities(), b->IsUPeriodic(), p[0]);
    n.knots[1] = list_knots(b->VKnots(), b->VMultiplicities(), b->IsVPeriodic(), p[1]);
    for (int j = 1; j <= b->NbVPoles(); ++j)
        for (int i = 1; i <= b->NbUPoles(); ++i) n.points.push_back(homogeneous(b->Pole(i, j), b->Weight(i, j)));
    for (int d = 0; d < 2; ++d) {
        s.box[d] = box[d];
        restrict_to(n, d, p[d], s.box[d]);
    }
    return s;
}

/* Is b the same surface, with the same parameters, as well as its coordinates tell? */
bool is_same(const Handle(Geom_Surface) & a, const Handle(Geom_Surface) & b, const range box[2])
{
    double apart = 0, size = 0;
    for (int i = 0; i < 9; ++i) {
        const double u = box[0].low + (i % 3 + 0.5) / 3 * box[0].size(),
                     v = box[1].low + (i / 3 + 0.5) / 3 * box[1].size();
        const gp_Pnt p = a->Value(u, v);
        apart = std::max(apart, p.Distance(b->Value(u, v)));
        size = std::max(size, p.XYZ().Modulus());
    }
    return apart <= 1e-12 * size;
}

surface offset(const Handle(Geom_OffsetSurface) & o, const range box[2])
{
    const Handle(Geom_Surface) exact = o->Surface();
    if (!exact.IsNull() && is_same(o, exact, box)) return convert(exact, box);
    range whole[2], r[2];
    o->Bounds(whole[0].low, whole[0].high, whole[1].low, whole[1].high);
    for (int d = 0; d < 2; ++d)
        r[d] = (d ? o->IsVPeriodic() : o->IsUPeriodic()) ? box[d] : within(box[d], whole[d].low, whole[d].high);
    const Handle(Geom_Surface) part = new Geom_RectangularTrimmedSurface(o, r[0].low, r[0].high, r[1].low, r[1].high);
    const gp_Pnt begin = part->Value(r[0].low, r[1].low), end = part->Value(r[0].high, r[1].high);
    GeomConvert_ApproxSurface a(part, tolerance(begin, end), GeomAbs_C1, GeomAbs_C1, 9, 9, 100, 1);
    if (!a.HasResult()) throw unusable("its surface, an offset, cannot be approximated");
    return spline(a.Surface(), r);
}

} // namespace

Handle(Geom_Surface) untrimmed(const Handle(Geom_Surface) & s)
{
    const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(s);
    return trimmed.IsNull() ? s : untrimmed(trimmed->BasisSurface());
}

surface convert(const Handle(Geom_Surface) & of, const range box[2])
{
    const Handle(Geom_Surface) s = untrimmed(of);
    for (int d = 0; d < 2; ++d)
        if (!(box[d].size() > 0)) throw unusable("it has no area in its parameters");
    if (const auto p = Handle(Geom_Plane)::DownCast(s)) return plane(p->Position(), box);
    if (const auto b = Handle(Geom_BSplineSurface)::DownCast(s)) return spline(b, box);
    if (const auto b = Handle(Geom_BezierSurface)::DownCast(s))
        return spline(GeomConvert::SurfaceToBSplineSurface(b), box);
    if (const auto c = Handle(Geom_CylindricalSurface)::DownCast(s))
        return turn_line(c->Position(), c->Radius(), 0, box);
    if (const auto c = Handle(Geom_ConicalSurface)::DownCast(s))
        return turn_line(c->Position(), c->RefRadius(), c->SemiAngle(), box);
    if (const auto o = Handle(Geom_SphericalSurface)::DownCast(s))
        return turn_circle(o->Position(), 0, o->Radius(), box);
    if (const auto t = Handle(Geom_ToroidalSurface)::DownCast(s))
        return turn_circle(t->Position(), t->MajorRadius(), t->MinorRadius(), box);
    if (const auto e = Handle(Geom_SurfaceOfLinearExtrusion)::DownCast(s)) return sweep(e, box);
    if (const auto r = Handle(Geom_SurfaceOfRevolution)::DownCast(s)) return turn_curve(r, box);
    if (const auto o = Handle(Geom_OffsetSurface)::DownCast(s)) return offset(o, box);
    throw unusable("its surface is of no kind that is known here");
}

} // namespace cad
