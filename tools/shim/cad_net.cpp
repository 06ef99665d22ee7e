/* cad_net.cpp - see cad_net.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/shim/cad_net.h"

#include <algorithm>
#include <cmath>

namespace cad
{

namespace
{

/* Points along `direction` are `stride` apart; the others are rows of them. */
size_t stride_of(const net &n, int direction)
{
    return direction ? n.count[0] : 1;
}

/* The same net with other points along one direction: `to(i, row)` computes the i-th from a row of old ones. */
template <class F> void replace(net &n, int direction, size_t count, F &&to)
{
    net out = n;
    out.count[direction] = count;
    out.points.resize(out.count[0] * out.count[1]);
    const size_t rows = n.count[1 - direction];
    for (size_t row = 0; row < rows; ++row) {
        const point *from = &n.points[row * stride_of(n, 1 - direction)];
        point *into = &out.points[row * stride_of(out, 1 - direction)];
        for (size_t i = 0; i < count; ++i) into[i * stride_of(out, direction)] = to(i, from);
    }
    n = std::move(out);
}

point mix(const point &a, const point &b, double t)
{
    point p;
    for (int c = 0; c < 4; ++c) p[c] = (1 - t) * a[c] + t * b[c];
    return p;
}

/* One more knot. */
void insert(net &n, int direction, double x)
{
    std::vector<double> &knots = n.knots[direction];
    const size_t p = (size_t)n.degree[direction], stride = stride_of(n, direction);
    const size_t after = (size_t)(std::upper_bound(knots.begin(), knots.end(), x) - knots.begin());
    const size_t k = std::clamp(after, p + 1, n.count[direction]) - 1;
    replace(n, direction, n.count[direction] + 1, [&](size_t i, const point *from) {
        if (i + p <= k) return from[i * stride];
        if (i > k) return from[(i - 1) * stride];
        return mix(from[(i - 1) * stride], from[i * stride], (x - knots[i]) / (knots[i + p] - knots[i]));
    });
    knots.insert(knots.begin() + (std::ptrdiff_t)after, x);
}

/* A knot that is as good as x, or x. */
double near_knot(const std::vector<double> &knots, double x, double tolerance)
{
    const auto at = std::min_element(knots.begin(), knots.end(),
                                     [x](double a, double b) { return std::fabs(a - x) < std::fabs(b - x); });
    return std::fabs(*at - x) <= tolerance ? *at : x;
}

constexpr double near = 1e-9; /* of the interval */

} // namespace

net take_spans(const net &n, int direction, const periodic &p, range r)
{
    const std::vector<double> &knots = n.knots[direction];
    const std::ptrdiff_t degree = n.degree[direction], count = (std::ptrdiff_t)n.count[direction];
    const auto turn = [&](std::ptrdiff_t i) { return p.length > 0 ? (i % count + count) % count : i; };
    const auto knot = [&](std::ptrdiff_t i) {
        if (!(p.length > 0)) return knots[(size_t)i];
        const std::ptrdiff_t at = i - degree + (std::ptrdiff_t)p.first;
        return knots[(size_t)turn(at)] + p.length * (double)((at - turn(at)) / count);
    };
    std::ptrdiff_t first = degree, last;
    if (p.length > 0) first += count * (std::ptrdiff_t)std::floor((r.low - knot(degree)) / p.length) - 1;
    const std::ptrdiff_t end = p.length > 0 ? PTRDIFF_MAX : count;
    while (first + 1 < end && knot(first + 1) <= r.low) ++first;
    for (last = first; last + 1 < end && knot(last + 1) < r.high;) ++last;

    net out = n;
    replace(out, direction, (size_t)(last - first + degree + 1), [&](size_t i, const point *from) {
        return from[(size_t)turn(first - degree + (std::ptrdiff_t)i) * stride_of(n, direction)];
    });
    out.knots[direction].clear();
    for (std::ptrdiff_t i = first - degree; i <= last + degree + 1; ++i) out.knots[direction].push_back(knot(i));
    return out;
}

void cut(net &n, int direction, range &r)
{
    const size_t p = (size_t)n.degree[direction], stride = stride_of(n, direction);
    std::vector<double> &knots = n.knots[direction];
    const double tolerance = near * r.size();
    r = {near_knot(knots, r.low, tolerance), near_knot(knots, r.high, tolerance)};
    if (!(r.low < r.high)) throw unusable("it has no area in its parameters");
    for (double x : {r.low, r.high})
        while ((size_t)std::count(knots.begin(), knots.end(), x) < p) insert(n, direction, x);

    /* the last `p` copies of the lower end and the first `p` of the upper one, and one more of each */
    const size_t low = (size_t)(std::upper_bound(knots.begin(), knots.end(), r.low) - knots.begin()) - p;
    const size_t high = (size_t)(std::lower_bound(knots.begin(), knots.end(), r.high) - knots.begin());
    replace(n, direction, high - low + 1, [&](size_t i, const point *from) { return from[(low - 1 + i) * stride]; });
    std::vector<double> kept{r.low};
    kept.insert(kept.end(), knots.begin() + (std::ptrdiff_t)low, knots.begin() + (std::ptrdiff_t)(high + p));
    kept.push_back(r.high);
    knots = std::move(kept);
}

/* A control point is the blossom of its p knots. At an end, the first ones have been cut to a and are to be b:
 *
 *     f(b^j, a^(p-i-j), t_1 ... t_i) = mix(f(b^(j-1), a^(p-i-j+1), t_1 ...  t_i), f(b^(j-1), a^(p-i-j), t_1 ...
 * t_(i+1)))
 *
 * by how far b is on the way from a to t_(i+1). */
void extend(net &n, int direction, range wanted, range &r)
{
    const size_t p = (size_t)n.degree[direction], count = n.count[direction], stride = stride_of(n, direction);
    constexpr double most = 0x1p-6; /* of a span: beyond, polynomials go astray */
    for (const bool high : {false, true}) {
        net out = n;
        std::vector<double> &knots = out.knots[direction];
        const auto knot = [&](size_t i) -> double & { return knots[high ? knots.size() - 1 - i : i]; };
        const double a = knot(p), span = knot(p + 1) - a, by = (high ? wanted.high : wanted.low) - a;
        if (!(by / span < -near * r.size() / std::fabs(span)) || by / span < -most) continue;
        bool is_positive = true;
        for (size_t row = 0; row < n.count[1 - direction]; ++row) {
            const auto at = [&](size_t i) -> point & {
                return out.points[row * stride_of(n, 1 - direction) + (high ? count - 1 - i : i) * stride];
            };
            for (size_t j = 1; j <= p; ++j)
                for (size_t i = 0; i + j <= p; ++i) at(i) = mix(at(i), at(i + 1), by / (knot(p + 1 + i) - a));
            for (size_t i = 0; i < p; ++i) is_positive = is_positive && at(i)[3] > 0;
        }
        if (!is_positive) continue;
        for (size_t i = 0; i <= p; ++i) knot(i) = a + by;
        (high ? r.high : r.low) = a + by;
        n = std::move(out);
    }
}

arcs::arcs(range r) : whole(r)
{
    constexpr double right = 1.5707963267948966;
    if (r.size() > 8.001 * right) throw unusable("it goes round more than twice");
    count = std::max(1, (int)std::ceil(r.size() / right - near));
    step = r.size() / count;
    for (int i = 0; i <= 2 * count; ++i) {
        const double angle = i == 2 * count && std::fabs(r.size() - 4 * right) < near ? r.low : r.low + i * step / 2;
        circle.push_back({std::cos(angle), std::sin(angle), i % 2 ? std::cos(step / 2) : 1});
    }
}

double arcs::parameter(double angle) const
{
    const double at = std::clamp(std::floor((angle - whole.low) / step), 0.0, count - 1.0);
    const double middle = whole.low + (at + 0.5) * step;
    return middle + step / 2 * std::tan((angle - middle) / 2) / std::tan(step / 4);
}

double arcs::first_end(double from, double to) const
{
    const double a = (from - whole.low) / step, b = (to - whole.low) / step;
    const double end = a < b ? std::floor(a + near) + 1 : std::ceil(a - near) - 1;
    return std::fabs(b - a) > near && (end - a) * (end - b) < 0 ? whole.low + end * step : to;
}

std::vector<double> arcs::knots() const
{
    std::vector<double> all{whole.low};
    for (int i = 0; i <= count; ++i) all.insert(all.end(), 2, i < count ? whole.low + i * step : whole.high);
    all.push_back(whole.high);
    return all;
}

net revolve(const net &curve, const arcs &angles)
{
    net n;
    n.degree[0] = 2;
    n.degree[1] = curve.degree[0];
    n.knots[0] = angles.knots();
    n.knots[1] = curve.knots[0];
    n.count[0] = angles.points().size();
    n.count[1] = curve.count[0];
    for (const point &p : curve.points)
        for (const auto &[c, s, w] : angles.points())
            n.points.push_back({p[0] * c - p[1] * s, p[1] * c + p[0] * s, p[2] * w, p[3] * w});
    return n;
}

net extrude(const net &curve, const double direction[3], range r)
{
    net n = curve;
    n.degree[1] = 1;
    n.count[1] = 2;
    n.knots[1] = {r.low, r.low, r.high, r.high};
    n.points.clear();
    for (double x : {r.low, r.high})
        for (point p : curve.points) {
            for (int c = 0; c < 3; ++c) p[c] += p[3] * x * direction[c];
            n.points.push_back(p);
        }
    return n;
}

net ellipse(const arcs &angles, const double origin[3], const double x[3], const double y[3])
{
    net n;
    n.degree[0] = 2;
    n.knots[0] = angles.knots();
    n.count[0] = angles.points().size();
    for (const auto &[c, s, w] : angles.points()) {
        point p{0, 0, 0, w};
        for (int k = 0; k < 3; ++k) p[k] = w * origin[k] + c * x[k] + s * y[k];
        n.points.push_back(p);
    }
    return n;
}

net line(const double origin[3], const double direction[3], range r)
{
    net n;
    n.degree[0] = 1;
    n.knots[0] = {r.low, r.low, r.high, r.high};
    n.count[0] = 2;
    for (double x : {r.low, r.high})
        n.points.push_back(
            {origin[0] + x * direction[0], origin[1] + x * direction[1], origin[2] + x * direction[2], 1});
    return n;
}

void transform(net &n, const double m[12])
{
    for (point &p : n.points) {
        const point q = p;
        for (int c = 0; c < 3; ++c) p[c] = m[c] * q[0] + m[3 + c] * q[1] + m[6 + c] * q[2] + m[9 + c] * q[3];
    }
}

} // namespace cad
