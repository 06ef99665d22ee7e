/* cad_flat.cpp - the curves of cad_trim.h in the parameters of the NURBS surface.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Where angles have become parameters of arcs, lines along a parameter stay lines. Other curves become something that
 * is no NURBS curve, and are interpolated. */
#include "tools/shim/cad_trim.h"

#include <algorithm>
#include <cmath>

namespace cad
{

namespace
{

flat_curve keep(const curve &c)
{
    flat_curve to{c->Degree(), {}, {}};
    for (int i = 1; i <= c->NbKnots(); ++i) to.knots.insert(to.knots.end(), (size_t)c->Multiplicity(i), c->Knot(i));
    for (int i = 1; i <= c->NbPoles(); ++i) to.points.push_back({c->Pole(i).X(), c->Pole(i).Y(), c->Weight(i)});
    return to;
}

/* Interpolates a curve that is given point by point, by pieces of one degree. */
class fit
{
  public:
    fit(const curve &c, const surface &s) : c(c), s(s)
    {
        for (int d = 0; d < 2; ++d)
            tolerance[d] =
                1e-10 * s.box[d].size() + 1e-14 * std::max(std::fabs(s.box[d].low), std::fabs(s.box[d].high));
        out.degree = degree;
        out.knots.assign(degree + 1, c->FirstParameter());
        out.points.push_back({at(c->FirstParameter())[0], at(c->FirstParameter())[1], 1});
        for (int i = 1; i < c->NbKnots(); ++i) add(c->Knot(i), c->Knot(i + 1), 0);
        out.knots.push_back(c->LastParameter());
    }
    flat_curve out;

  private:
    static constexpr int degree = 7;
    using pair = std::array<double, 2>;

    pair at(double t) const
    {
        const gp_Pnt2d p = c->Value(t);
        return {s.parameter(0, p.X()), s.parameter(1, p.Y())};
    }

    /* Where on the way from a to b an arc of the surface ends; b: nowhere. Only there is the curve not smooth. */
    double next_end(double a, double b) const
    {
        double next = b;
        for (int d = 0; d < 2; ++d) {
            if (!s.angles[d]) continue;
            const auto angle = [&](double t) { return d ? c->Value(t).Y() : c->Value(t).X(); };
            const double from = angle(a), to = angle(next), end = s.angles[d]->first_end(from, to);
            if (end == to) continue;
            double before = a, after = next;
            for (int i = 0; i < 60; ++i) {
                const double middle = 0.5 * (before + after);
                ((angle(middle) - end) * (to - end) < 0 ? before : after) = middle;
            }
            next = after;
        }
        return next;
    }

    static double node(int i) { return 0.5 - 0.5 * std::cos(i * 3.141592653589793 / degree); }

    static double bernstein(int i, double t)
    {
        static const double choose[degree + 1] = {1, 7, 21, 35, 35, 21, 7, 1};
        return choose[i] * std::pow(t, i) * std::pow(1 - t, degree - i);
    }

    /* From values at the nodes to Bézier points. */
    static const std::array<std::array<double, degree + 1>, degree + 1> &weights()
    {
        static const auto inverse = [] {
            std::array<std::array<double, degree + 1>, degree + 1> a{}, b{};
            for (int i = 0; i <= degree; ++i) {
                for (int j = 0; j <= degree; ++j) a[i][j] = bernstein(j, node(i));
                b[i][i] = 1;
            }
            for (int k = 0; k <= degree; ++k) /* totally positive: needs no pivots */
                for (int i = 0; i <= degree; ++i) {
                    if (i == k) continue;
                    const double f = a[i][k] / a[k][k];
                    for (int j = 0; j <= degree; ++j) a[i][j] -= f * a[k][j], b[i][j] -= f * b[k][j];
                }
            for (int k = 0; k <= degree; ++k)
                for (int j = 0; j <= degree; ++j) b[k][j] /= a[k][k];
            return b;
        }();
        return inverse;
    }

    bool is_near(const pair *points, double a, double b) const
    {
        for (int i = 0; i < degree; ++i) {
            const double t = 0.5 * (node(i) + node(i + 1));
            const pair p = at(a + t * (b - a));
            for (int d = 0; d < 2; ++d) {
                double x = 0;
                for (int k = 0; k <= degree; ++k) x += bernstein(k, t) * points[k][d];
                if (!(std::fabs(x - p[d]) <= tolerance[d])) return false;
            }
        }
        return true;
    }

    void add(double a, double b, int depth)
    {
        const double end = next_end(a, b);
        if (end < b && end > a && depth < most) {
            add(a, end, depth + 1);
            return add(end, b, depth + 1);
        }
        if (out.points.size() > most_points) throw unusable("a curve of its boundary cannot be approximated");
        pair values[degree + 1], points[degree + 1];
        for (int i = 0; i <= degree; ++i) values[i] = at(a + node(i) * (b - a));
        for (int i = 0; i <= degree; ++i)
            for (int d = 0; d < 2; ++d) {
                points[i][d] = 0;
                for (int k = 0; k <= degree; ++k) points[i][d] += weights()[i][k] * values[k][d];
            }
        points[degree] = values[degree];
        if (depth < most && !is_near(points, a, b)) {
            add(a, 0.5 * (a + b), depth + 1);
            return add(0.5 * (a + b), b, depth + 1);
        }
        for (int i = 1; i <= degree; ++i) out.points.push_back({points[i][0], points[i][1], 1});
        out.knots.insert(out.knots.end(), degree, b);
    }

    static constexpr int most = 30; /* pieces within pieces */
    static constexpr size_t most_points = 100000;
    const curve &c;
    const surface &s;
    double tolerance[2];
};

/* Does the curve stay at one value of a parameter? */
bool is_constant(const curve &c, int direction, double tolerance)
{
    for (int i = 2; i <= c->NbPoles(); ++i)
        if (std::fabs(c->Pole(i).Coord(1 + direction) - c->Pole(1).Coord(1 + direction)) > tolerance) return false;
    return true;
}

} // namespace

flat_curve convert(const curve &c, const surface &s)
{
    if (!s.angles[0] && !s.angles[1]) return keep(c);
    const auto constant = [&](int d) { return is_constant(c, d, 1e-12 * s.box[d].size()); };
    if (!is_straight(c) || !(constant(0) || constant(1))) return fit(c, s).out;
    flat_curve l = keep(c);
    for (auto &p : l.points)
        for (int d = 0; d < 2; ++d) p[d] = s.parameter(d, p[d]);
    return l;
}

bool is_border(const std::vector<flat_curve> &l, const surface &s)
{
    double around = 0;
    for (const flat_curve &c : l) {
        bool on_side = false;
        for (int d = 0; d < 2; ++d) {
            const double size = s.box[d].size();
            for (double side : {s.box[d].low, s.box[d].high})
                on_side = on_side || std::all_of(c.points.begin(), c.points.end(),
                                                 [&](const auto &p) { return std::fabs(p[d] - side) <= 1e-9 * size; });
            around += std::fabs(c.points.back()[d] - c.points.front()[d]) / size;
        }
        if (!on_side) return false;
    }
    return std::fabs(around - 4) < 1e-6;
}

void join(std::vector<flat_curve> &l, const surface &s)
{
    for (size_t i = 0; i < l.size(); ++i) {
        const auto &end = l[i].points.back();
        auto &start = l[(i + 1) % l.size()].points.front();
        bool near = true;
        for (int d = 0; d < 2; ++d) near = near && std::fabs(start[d] - end[d]) <= 1e-9 * s.box[d].size();
        if (near) start[0] = end[0], start[1] = end[1];
    }
}

} // namespace cad
