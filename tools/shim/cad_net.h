/* cad_net.h - B-spline curves and surfaces as nets of homogeneous control points, and how surfaces become such nets.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAD_NET_H
#define EPATCH_CAD_NET_H

#include <array>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace cad
{

/* Why a face cannot be traced. */
struct unusable : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/* An interval of a parameter. */
struct range {
    double low, high;
    double size() const { return high - low; }
};

using point = std::array<double, 4>; /* w x, w y, w z, w */

/* A surface; or, with degree 0 and one point in the other direction, a curve. */
struct net {
    int degree[2] = {0, 0};
    std::vector<double> knots[2];
    size_t count[2] = {1, 1};
    std::vector<point> points; /* the first direction runs fastest */
};

/* The spline over the spans that `r` touches in one direction. A period joins its end to its beginning as often as is
 * wanted; `first` is the index of the first span's first knot. */
struct periodic {
    double length = 0; /* 0: there is no period */
    size_t first = 0;
};
net take_spans(const net &n, int direction, const periodic &p, range r);

/* Cuts the spline at the ends of `r`, which move to knots that are very near. */
void cut(net &n, int direction, range &r);

/* The outermost polynomials of a spline over `r`, which has been cut there, go on to the ends of `wanted`, where these
 * are a little farther out. */
void extend(net &n, int direction, range wanted, range &r);

/* Where an angle has become the parameter of rational quadratic arcs, each of at most 90 degrees: equal at the ends of
 * arcs, and in between half the angle's tangent is what goes on evenly. */
class arcs
{
  public:
    explicit arcs(range r);
    double parameter(double angle) const;
    /* (cosine, sine, 1), homogeneous */
    const std::vector<std::array<double, 3>> &points() const { return circle; }
    std::vector<double> knots() const;
    /* The first end of an arc on the way from an angle to another one, or that one. */
    double first_end(double from, double to) const;

  private:
    range whole;
    int count;
    double step;
    std::vector<std::array<double, 3>> circle;
};

/* A curve in the x, z plane, or anywhere, turned about the z axis; the angle is the first parameter. */
net revolve(const net &curve, const arcs &angles);
/* A curve, and the same moved by multiples of a vector; the curve's parameter is the first. */
net extrude(const net &curve, const double direction[3], range r);
/* origin + cos x + sin y */
net ellipse(const arcs &angles, const double origin[3], const double x[3], const double y[3]);
net line(const double origin[3], const double direction[3], range r);
/* m: the images of the axes, then that of the origin. */
void transform(net &n, const double m[12]);

} // namespace cad
#endif
