/* cad_widen.cpp - see cad_widen.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The faces on either side of an edge end somewhere within its tolerance of it, so between them is a gap. When each
 * reaches that much farther, both reach the edge.
 *
 * A side with the direction t has the normal n = ±(t_v, -t_u), a covector: moving the side by x in the parameter plane
 * moves it by n x. With the surface's first fundamental form I, the way x = I^-1 n / |n|, |n|² = n I^-1 n, is of length
 * one on the surface and at a right angle to the side. Straight sides stay straight, and parallel to what they were:
 * lines along a parameter are what leaves are cut along, and what makes a loop the whole border of a surface. In a
 * corner x is where both sides are as far out as they have to be. Of a curved side the control points move, each as
 * that point of the curve does which it has the most to do with. */
#include "tools/shim/cad_widen.h"

#include <TColStd_Array1OfReal.hxx>

#include <algorithm>
#include <cmath>

namespace cad
{

namespace
{

/* Of the largest tangent: shorter ones, towards a pole, count as that. */
constexpr double shortest = 0x1p-3;
/* Of the loop's box, that a side moves at most. */
constexpr double farthest = 0x1p-2;
/* A curve's control points move by this much more than its gap, and it by no less than `enough` of that. */
constexpr double more = 1.1, enough = 0.8;

/* Points along a loop. */
struct polygon {
    std::vector<gp_XY> points;
    range box[2] = {{HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, -HUGE_VAL}};

    void add(const gp_Pnt2d &p)
    {
        points.push_back(p.XY());
        for (int d = 0; d < 2; ++d) {
            box[d].low = std::min(box[d].low, p.Coord(1 + d));
            box[d].high = std::max(box[d].high, p.Coord(1 + d));
        }
    }
};

polygon sample(const loop &l)
{
    polygon p;
    for (const side &c : l) {
        const int parts = is_straight(c.along) ? 1 : 8;
        for (int i = 1; i < c.along->NbKnots(); ++i)
            for (int k = 0; k < parts; ++k) {
                const double from = c.along->Knot(i), to = c.along->Knot(i + 1);
                p.add(c.along->Value(from + (to - from) * k / parts));
            }
        p.add(c.along->EndPoint());
    }
    return p;
}

double twice_area(const polygon &of)
{
    const std::vector<gp_XY> &p = of.points;
    double area = 0;
    for (size_t i = 0; i < p.size(); ++i) area += (p[i] - p[0]) ^ (p[(i + 1) % p.size()] - p[0]);
    return area;
}

bool is_inside(const polygon &of, const gp_XY &x)
{
    const std::vector<gp_XY> &p = of.points;
    if (x.X() < of.box[0].low || x.X() > of.box[0].high || x.Y() < of.box[1].low || x.Y() > of.box[1].high)
        return false;
    bool inside = false;
    for (size_t i = 0; i < p.size(); ++i) {
        const gp_XY &a = p[i], &b = p[(i + 1) % p.size()];
        if ((a.Y() <= x.Y()) == (b.Y() <= x.Y())) continue;
        inside ^= (((b - a) ^ (x - a)) > 0) == (b.Y() > a.Y());
    }
    return inside;
}

/* Is most of one loop inside of the other? */
bool is_within(const polygon &p, const polygon &other)
{
    for (int d = 0; d < 2; ++d)
        if (p.box[d].low < other.box[d].low || p.box[d].high > other.box[d].high) return false;
    constexpr size_t asked = 9;
    size_t inside = 0;
    for (size_t i = 0; i < asked; ++i) inside += is_inside(other, p.points[i * p.points.size() / asked]);
    return 2 * inside > asked;
}

bool has_gap(const loop &l)
{
    return std::any_of(l.begin(), l.end(), [](const side &c) {
        return std::any_of(c.short_of.begin(), c.short_of.end(),
                           [](const edge_gap &g) { return g[0] > 0 || g[1] > 0; });
    });
}

class widening
{
  public:
    /* Of loop `index`, among the outlines of all of the face's. `outside`: 1 where that is on the right of the sides,
     * else -1. */
    widening(const loop &of, double outside, const std::vector<polygon> &all, size_t index,
             const Handle(Geom_Surface) & s)
        : l(of), outside(outside), s(s)
    {
        const polygon &about = all[index];
        double longest[2] = {0, 0};
        for (const gp_XY &p : about.points) {
            gp_Pnt at;
            gp_Vec u, v;
            s->D1(p.X(), p.Y(), at, u, v);
            longest[0] = std::max(longest[0], u.SquareMagnitude());
            longest[1] = std::max(longest[1], v.SquareMagnitude());
        }
        for (int d = 0; d < 2; ++d) {
            least[d] = shortest * shortest * longest[d];
            limit[d] = farthest * about.box[d].size();
            if (!(least[d] > 0 && std::isfinite(least[d]))) return; /* there is no telling how far to go */
        }
        usable = true;
        for (side &c : l) {
            stays.push_back(comes_back(c, all));
            if (stays.back()) c.short_of = {{0, 0}};
        }
        for (const side &c : l) out.push_back(out_of(c));
        for (size_t turn = 0; turn < 2 * l.size(); ++turn) align(turn % l.size());
    }

    loop run() const
    {
        loop wide;
        if (!usable) return l;
        for (size_t i = 0; i < l.size(); ++i) {
            const gp_XY start = corner(before(i), i), end = corner(i, (i + 1) % l.size());
            wide.push_back(
                {is_straight(l[i].along) ? move_line(l[i].along, start, end) : move_curve(i, start, end), {}});
        }
        return wide;
    }

  private:
    /* At a point of a side. */
    struct normal {
        gp_XY n, way; /* the covector, and I^-1 n */
        double square() const { return n * way; }
    };

    /* How far a side has to move, in space, around the parameter t. */
    double distance(const side &c, double t) const
    {
        const double places = (double)c.short_of.size() - 1, low = c.along->FirstParameter();
        const double at = places * (t - low) / (c.along->LastParameter() - low);
        double most = 0;
        for (double i = std::floor(at) - 1; i <= std::ceil(at) + 1; ++i)
            most = std::max(most, c.short_of[(size_t)std::clamp(i, 0.0, places)][outside < 0]);
        return most;
    }

    /* Does twice the way out of a side lead to the face again? Then what is there, a slit, a slot, or the rest of a
     * loop that touches this one, is narrower than the gap; if both of its sides moved, they would change places. Asked
     * at corners of the outline, or between those of a straight side. */
    bool comes_back(const side &c, const std::vector<polygon> &all) const
    {
        size_t asked = 0, back = 0;
        const int parts = is_straight(c.along) ? 8 : 2;
        for (int i = 1; i < c.along->NbKnots(); ++i)
            for (int k = 1; k < parts; ++k) {
                const double t = c.along->Knot(i) + (c.along->Knot(i + 1) - c.along->Knot(i)) * k / parts;
                const normal m = normal_at(c.along, t);
                if (!(m.square() > 0 && distance(c, t) > 0)) continue;
                const gp_XY way = limited(m.way * (distance(c, t) / std::sqrt(m.square())));
                const gp_XY at = c.along->Value(t).XY() + way * 2;
                bool on_face = false;
                for (const polygon &p : all) on_face ^= is_inside(p, at);
                ++asked;
                back += on_face;
            }
        return 3 * back > asked;
    }

    size_t before(size_t i) const { return (i + l.size() - 1) % l.size(); }

    normal normal_at(const curve &c, double t) const
    {
        gp_Pnt2d p;
        gp_Vec2d along;
        c->D1(t, p, along);
        gp_Pnt at;
        gp_Vec u, v;
        s->D1(p.X(), p.Y(), at, u, v);
        const double e = std::max(u.SquareMagnitude(), least[0]), g = std::max(v.SquareMagnitude(), least[1]);
        const double f = u * v, det = e * g - f * f;
        normal m;
        m.n = gp_XY(along.Y(), -along.X()) * outside;
        /* where the tangents are as good as parallel there is no telling */
        if (det > 0x1p-20 * e * g) m.way = gp_XY(g * m.n.X() - f * m.n.Y(), e * m.n.Y() - f * m.n.X()) / det;
        return m;
    }

    /* How far a straight side has to move, n x, but nowhere more than twice the largest gap; of a curve, 0. */
    double out_of(const side &c) const
    {
        if (!is_straight(c.along)) return 0;
        const double from = c.along->FirstParameter(), to = c.along->LastParameter();
        constexpr int samples = 16;
        double most = 0, widest = 0, least_size = HUGE_VAL;
        for (int i = 0; i <= samples; ++i) {
            const double t = from + (to - from) * i / samples, size = std::sqrt(normal_at(c.along, t).square());
            most = std::max(most, distance(c, t) * size);
            widest = std::max(widest, distance(c, t));
            least_size = std::min(least_size, size);
        }
        return std::min(most, 2 * widest * least_size);
    }

    /* Two straight sides that are one line move by the same, or both stay. */
    void align(size_t i)
    {
        const size_t k = (i + 1) % l.size();
        if (!is_straight(l[i].along) || !is_straight(l[k].along)) return;
        const gp_XY a = l[i].along->EndPoint().XY() - l[i].along->StartPoint().XY(),
                    b = l[k].along->EndPoint().XY() - l[k].along->StartPoint().XY();
        const double size_a = rate(l[i].along), size_b = rate(l[k].along);
        if (!(a * b > 0) || std::fabs(a ^ b) > 1e-9 * a.Modulus() * b.Modulus()) return;
        if (stays[i] || stays[k]) stays[i] = stays[k] = true;
        const double most = stays[i] ? 0 : std::max(out[i] / size_a, out[k] / size_b);
        out[i] = most * size_a, out[k] = most * size_b;
    }

    static double rate(const curve &c)
    {
        return (c->EndPoint().XY() - c->StartPoint().XY()).Modulus() / (c->LastParameter() - c->FirstParameter());
    }

    gp_XY limited(gp_XY x) const
    {
        const double over = std::max(std::fabs(x.X()) / limit[0], std::fabs(x.Y()) / limit[1]);
        return over > 1 ? x / over : x;
    }

    /* Where the end of side `i` and the start of side `k` go to. */
    gp_XY corner(size_t i, size_t k) const
    {
        const double end = l[i].along->LastParameter(), start = l[k].along->FirstParameter();
        const normal a = normal_at(l[i].along, end), b = normal_at(l[k].along, start);
        const double aa = a.square(), bb = b.square();
        if (!(aa > 0 && bb > 0)) return gp_XY(0, 0);
        const double to_a = is_straight(l[i].along) ? out[i] : distance(l[i], end) * std::sqrt(aa),
                     to_b = is_straight(l[k].along) ? out[k] : distance(l[k], start) * std::sqrt(bb);
        const double ab = a.n * b.way, sine2 = 1 - ab * ab / (aa * bb);
        if (sine2 < 0x1p-4) return limited((a.way * (to_a / aa) + b.way * (to_b / bb)) * 0.5);
        const double det = a.n ^ b.n;
        return limited(gp_XY(to_a * b.n.Y() - to_b * a.n.Y(), to_b * a.n.X() - to_a * b.n.X()) / det);
    }

    static curve move_line(const curve &c, const gp_XY &start, const gp_XY &end)
    {
        const curve to = Handle(Geom2d_BSplineCurve)::DownCast(c->Copy());
        to->SetPole(1, c->Pole(1).Translated(gp_Vec2d(start)));
        to->SetPole(2, c->Pole(2).Translated(gp_Vec2d(end)));
        return to;
    }

    curve move_curve(size_t i, const gp_XY &start, const gp_XY &end) const
    {
        constexpr int rounds = 3;
        const curve c = Handle(Geom2d_BSplineCurve)::DownCast(l[i].along->Copy());
        for (int round = 1;; ++round) {
            const curve to = move_poles(l[i], c, start, end);
            const std::vector<double> middles = short_spans(l[i], c, to);
            if (round == rounds || middles.empty()) return to;
            for (double t : middles) c->InsertKnot(t);
        }
    }

    /* `c`: the curve of `of`, perhaps with more knots. */
    curve move_poles(const side &of, const curve &c, const gp_XY &start, const gp_XY &end) const
    {
        const curve to = Handle(Geom2d_BSplineCurve)::DownCast(c->Copy());
        TColStd_Array1OfReal knots(1, c->NbPoles() + c->Degree() + 1);
        c->KnotSequence(knots);
        const int last = c->NbPoles();
        for (int k = 1; k <= last; ++k) {
            double mean = 0; /* Greville's abscissa */
            for (int j = 1; j <= c->Degree(); ++j) mean += knots(k + j) / c->Degree();
            const normal m = normal_at(c, mean);
            const double square = m.square();
            gp_XY x(0, 0);
            if (k == 1) x = start;
            else if (k == last) x = end;
            else if (square > 0) x = limited(m.way * (more * distance(of, mean) / std::sqrt(square)));
            to->SetPole(k, c->Pole(k).Translated(gp_Vec2d(x)));
        }
        return to;
    }

    /* The middles of the spans that are not moved far enough. */
    std::vector<double> short_spans(const side &of, const curve &c, const curve &to) const
    {
        constexpr int parts = 4;
        std::vector<double> middles;
        for (int i = 1; i < c->NbKnots(); ++i) {
            const double low = c->Knot(i), size = c->Knot(i + 1) - low;
            bool far_enough = true;
            for (int k = 0; k < parts && far_enough; ++k) {
                const double t = low + size * (k + 0.5) / parts;
                const normal m = normal_at(c, t);
                const gp_XY x = to->Value(t).XY() - c->Value(t).XY();
                far_enough = m.n * x >= enough * distance(of, t) * std::sqrt(m.square());
            }
            if (!far_enough) middles.push_back(low + 0.5 * size);
        }
        return middles;
    }

    loop l;
    const double outside;
    const Handle(Geom_Surface) & s;
    bool usable = false;
    double least[2], limit[2]; /* of squared tangents; of how far a side moves */
    std::vector<bool> stays;   /* for it comes back */
    std::vector<double> out;   /* of straight sides */
};

} // namespace

void widen(std::vector<loop> &loops, const Handle(Geom_Surface) & s)
{
    if (std::none_of(loops.begin(), loops.end(), has_gap)) return;
    std::vector<polygon> all;
    for (const loop &l : loops) all.push_back(sample(l));
    std::vector<loop> wide;
    for (size_t i = 0; i < loops.size(); ++i) {
        bool hole = false;
        for (size_t k = 0; k < loops.size(); ++k) hole ^= k != i && is_within(all[i], all[k]);
        const double outside = (twice_area(all[i]) > 0) != hole ? 1 : -1;
        wide.push_back(widening(loops[i], outside, all, i, s).run());
    }
    loops = std::move(wide);
}

} // namespace cad
