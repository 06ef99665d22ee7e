/* cad_trim.cpp - see cad_trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Loops are even-odd: which way a curve runs does not matter, only that all of them are there and that neighbours
 * follow one another. They are put in order by where they end, since that is what a file is least wrong about. On a
 * surface that closes on itself curves may be whole turns apart; where that is so, they are moved. */
#include "tools/shim/cad_trim.h"

#include <BRep_Tool.hxx>
#include <Geom2dConvert.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <ShapeFix_Edge.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Wire.hxx>

#include <algorithm>
#include <cfloat>
#include <cmath>

namespace cad
{

namespace
{

/* The parameter plane: what a turn is in either direction (0: there are none), and how large the face is. */
struct plane {
    double turn[2], size[2];

    double distance(const gp_Pnt2d &a, const gp_Pnt2d &b) const
    {
        return std::hypot((a.X() - b.X()) / size[0], (a.Y() - b.Y()) / size[1]);
    }
    /* What moves `p` next to `to` in whole turns. */
    gp_Vec2d turns(const gp_Pnt2d &p, const gp_Pnt2d &to) const
    {
        gp_Vec2d by(0, 0);
        if (turn[0] > 0) by.SetX(turn[0] * std::round((to.X() - p.X()) / turn[0]));
        if (turn[1] > 0) by.SetY(turn[1] * std::round((to.Y() - p.Y()) / turn[1]));
        return by;
    }
};

side take_edge(const TopoDS_Edge &edge, const TopoDS_Face &face, const face_map &faces)
{
    double first, last;
    Handle(Geom2d_Curve) c = BRep_Tool::CurveOnSurface(edge, face, first, last);
    if (c.IsNull()) {
        ShapeFix_Edge().FixAddPCurve(edge, face, false);
        c = BRep_Tool::CurveOnSurface(edge, face, first, last);
    }
    if (c.IsNull()) throw unusable("an edge of it has no curve in its parameters");
    if (!c->IsPeriodic()) {
        first = std::max(first, c->FirstParameter());
        last = std::min(last, c->LastParameter());
    }
    if (!(first < last)) throw unusable("an edge of it has no length");
    const curve b = Geom2dConvert::CurveToBSplineCurve(new Geom2d_TrimmedCurve(c, first, last));
    if (b->IsPeriodic()) b->SetNotPeriodic();
    if (BRep_Tool::Degenerated(edge)) return {b, {measure_pole(edge, face, first, last)}};
    if (BRep_Tool::IsClosed(edge, face)) return {b, {{0, 0}}};
    return {b, measure_gaps(edge, face, first, last, faces)};
}

loop take_wire(const TopoDS_Shape &wire, const TopoDS_Face &face, const face_map &faces)
{
    loop all;
    for (TopExp_Explorer e(wire, TopAbs_EDGE); e.More(); e.Next()) {
        const TopAbs_Orientation side = e.Current().Orientation();
        if (side != TopAbs_FORWARD && side != TopAbs_REVERSED) continue; /* bounds nothing */
        all.push_back(take_edge(TopoDS::Edge(e.Current()), face, faces));
        if (side == TopAbs_REVERSED) all.back().reverse();
    }
    return all;
}

/* Takes what goes on best at `end`; none when nothing does better than to close the loop, `gap` away. */
std::optional<side> take_next(loop &rest, const gp_Pnt2d &end, double gap, const plane &p)
{
    struct choice {
        size_t index;
        bool reversed;
        gp_Vec2d by;
    } best{rest.size(), false, gp_Vec2d()};
    constexpr double to_reverse = 1e-4, to_turn = 1e-2; /* reluctance: gaps that are not worth it */
    constexpr double enough = 1e-9;                     /* for the first one, mostly, to do */
    for (size_t i = 0; i < rest.size() && (gap > enough || best.index == rest.size()); ++i)
        for (int k = 0; k < 4; ++k) {
            const bool reversed = k & 1, turned = k & 2;
            const gp_Pnt2d start = reversed ? rest[i].along->EndPoint() : rest[i].along->StartPoint();
            const gp_Vec2d by = turned ? p.turns(start, end) : gp_Vec2d(0, 0);
            const double d = p.distance(start.Translated(by), end) + to_reverse * reversed + to_turn * turned;
            if (d < gap) gap = d, best = {i, reversed, by};
        }
    if (best.index == rest.size()) return {};
    side c = rest[best.index];
    rest.erase(rest.begin() + (std::ptrdiff_t)best.index);
    if (best.reversed) c.reverse();
    c.along->Translate(best.by);
    return c;
}

/* Is it one point of the surface that two points of the parameter plane mean, and all between them? */
bool is_one_point(const Handle(Geom_Surface) & s, const gp_Pnt2d &a, const gp_Pnt2d &b, double tolerance)
{
    const gp_Pnt p = s->Value(a.X(), a.Y());
    for (int i = 1; i <= 4; ++i) {
        const gp_XY at = a.XY() + (b.XY() - a.XY()) * (0.25 * i);
        if (s->Value(at.X(), at.Y()).Distance(p) > tolerance) return false;
    }
    return true;
}

std::vector<loop> chain(loop rest, const plane &p, const Handle(Geom_Surface) & s, double tolerance)
{
    constexpr double far = 0.2; /* of the face: what cannot be bridged by a straight line */
    const auto bridge = [&](const gp_Pnt2d &from, const gp_Pnt2d &to) {
        if (p.distance(from, to) > far && !is_one_point(s, from, to, tolerance))
            throw unusable("its boundary does not close");
    };
    std::vector<loop> all;
    while (!rest.empty()) {
        loop l{rest.front()};
        rest.erase(rest.begin());
        const gp_Pnt2d start = l.front().along->StartPoint();
        for (;;) {
            const gp_Pnt2d end = l.back().along->EndPoint();
            const double gap = p.distance(end, start);
            const std::optional<side> next = take_next(rest, end, gap > 0.1 * far ? HUGE_VAL : gap, p);
            bridge(end, next ? next->along->StartPoint() : start);
            if (!next) break;
            l.push_back(*next);
        }
        all.push_back(l);
    }
    return all;
}

/* Loops that are whole turns away from the largest one are moved to it. */
void gather(std::vector<loop> &loops, const plane &p)
{
    range most[2] = {{0, 0}, {0, 0}};
    double area = -1;
    for (const loop &l : loops) {
        range box[2];
        bound({l}, box);
        if (box[0].size() * box[1].size() > area)
            area = box[0].size() * box[1].size(), most[0] = box[0], most[1] = box[1];
    }
    for (loop &l : loops) {
        range box[2];
        bound({l}, box);
        double by[2];
        for (int d = 0; d < 2; ++d) {
            const double middle = 0.5 * (box[d].low + box[d].high);
            by[d] = p.turn[d] > 0 ? p.turn[d] * std::ceil((most[d].low - middle) / p.turn[d]) : 0;
        }
        for (const side &c : l) c.along->Translate(gp_Vec2d(by[0], by[1]));
    }
}

void extend(range box[2], double x, double y)
{
    const double at[2] = {x, y};
    for (int d = 0; d < 2; ++d) box[d] = {std::min(box[d].low, at[d]), std::max(box[d].high, at[d])};
}

} // namespace

std::vector<loop> take_loops(const TopoDS_Face &of, const Handle(Geom_Surface) & s, const face_map &faces)
{
    const TopoDS_Face face = TopoDS::Face(of.Oriented(TopAbs_FORWARD));
    std::vector<loop> wires, loops;
    for (TopExp_Explorer e(face, TopAbs_WIRE); e.More(); e.Next()) wires.push_back(take_wire(e.Current(), face, faces));
    wires.erase(std::remove_if(wires.begin(), wires.end(), [](const auto &w) { return w.empty(); }), wires.end());
    if (wires.empty()) return loops;

    range box[2];
    bound(wires, box);
    const plane p = {{s->IsUPeriodic() ? s->UPeriod() : 0, s->IsVPeriodic() ? s->VPeriod() : 0},
                     {std::max(box[0].size(), DBL_MIN), std::max(box[1].size(), DBL_MIN)}};
    for (loop &w : wires)
        for (loop &l : chain(std::move(w), p, s, 10 * BRep_Tool::Tolerance(face))) loops.push_back(std::move(l));
    if (loops.size() > 1) gather(loops, p);
    return loops;
}

void bound(const std::vector<loop> &loops, range box[2])
{
    box[0] = box[1] = {HUGE_VAL, -HUGE_VAL};
    for (const loop &l : loops)
        for (const side &c : l)
            for (int i = 1; i <= c.along->NbPoles(); ++i) extend(box, c.along->Pole(i).X(), c.along->Pole(i).Y());
}

} // namespace cad
