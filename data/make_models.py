#!/usr/bin/env python3
"""Writes the models and scenes of this directory from formulas, or checks the ones that are there.

SPDX-License-Identifier: Apache-2.0

    python3 data/make_models.py           writes *.json and scenes/*.json beside itself
    python3 data/make_models.py --check   reads them back: watertight? exact? smooth?

Control points are (x, y, z, w) in Euclidean coordinates, weights not premultiplied. Neighbours take their common
points from the same expression, so that they are equal bit for bit."""

import json
import math
import os
import sys
from math import comb, cos, factorial, pi, sin, sqrt

HERE = os.path.dirname(os.path.abspath(__file__))

# ---------------------------------------------------------------------------------------------- small algebra


def add(*vectors):
    return tuple(map(sum, zip(*vectors)))


def mul(s, a):
    return tuple(s * x for x in a)


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return mul(1 / sqrt(dot(a, a)), a)


def project(homogeneous):
    """(wx, wy, wz, w) -> (x, y, z, w)"""
    x, y, z, w = homogeneous
    return (x / w, y / w, z / w, w)


# ---------------------------------------------------------------------------------------------- the two spheres


def octants(first):
    """The eight mirror images of a patch in the first octant, turned so that u, v runs outwards in each of them.
    `first` maps (i, j, k), i + j + k constant, to a point; swapping i and j swaps orientation."""
    patches = []
    for sz in (1, -1):
        for sy in (1, -1):
            for sx in (1, -1):
                flip = sx * sy * sz < 0
                n = max(i for i, _, _ in first)
                patch = []
                for j in range(n + 1):
                    for i in range(n + 1 - j):
                        a, b = (j, i) if flip else (i, j)
                        x, y, z, w = first[a, b, n - i - j]
                        patch.append((sx * x, sy * y, sz * z, w))
                patches.append(patch)
    return patches


def sphere_triangles():
    """The octant of the unit sphere as one quartic rational Bezier triangle without a degenerate corner: G. Farin,
    B. Piper, A. J. Worsey, "The octant of a sphere as a non-degenerate triangular Bezier patch", CAGD 4 (1987)."""
    a = (sqrt(3) - 1) / sqrt(3)
    b = (sqrt(3) + 1) / (2 * sqrt(3))
    c = 1 - (5 - sqrt(2)) * (7 - sqrt(3)) / 46
    weights = {(4, 0, 0): 4 * sqrt(3) * (sqrt(3) - 1), (3, 1, 0): 3 * sqrt(2), (2, 2, 0): 4.0,
               (2, 1, 1): sqrt(2 / 3) * (3 + 2 * sqrt(2) - sqrt(3))}
    coordinates = {(4, 0, 0): {4: 1.0, 0: 0.0}, (3, 1, 0): {3: 1.0, 1: a, 0: 0.0}, (2, 2, 0): {2: b, 0: 0.0},
                   (2, 1, 1): {2: 1.0, 1: c}}
    first = {}
    for i in range(5):
        for j in range(5 - i):
            index = (i, j, 4 - i - j)
            kind = tuple(sorted(index, reverse=True))
            first[index] = tuple(coordinates[kind][e] for e in index) + (weights[kind],)
    return octants(first)


def sphere_tensor():
    """The unit sphere as six rational patches of degree 4 x 4, laid out like the faces of a cube: J. E. Cobb, "Tiling
    the sphere with rational Bezier patches", University of Utah UUCS-88-009 (1988). One eighth of the face at -z is
    written down; symmetry gives the rest."""
    s2, s3, s6 = sqrt(2), sqrt(3), sqrt(6)
    eighth = {
        (0, 0): (4 * (1 - s3), 4 * (1 - s3), 4 * (1 - s3), 4 * (3 - s3)),
        (1, 0): (-s2, s2 * (s3 - 4), s2 * (s3 - 4), s2 * (3 * s3 - 2)),
        (2, 0): (0.0, 4 * (1 - 2 * s3) / 3, 4 * (1 - 2 * s3) / 3, 4 * (5 - s3) / 3),
        (1, 1): ((2 - 3 * s3) / 2, (2 - 3 * s3) / 2, -(s3 + 6) / 2, (s3 + 6) / 2),
        (2, 1): (0.0, s2 * (2 * s3 - 7) / 3, -5 * s6 / 3, s2 * (s3 + 6) / 3),
        (2, 2): (0.0, 0.0, 4 * (s3 - 5) / 3, 4 * (5 * s3 - 1) / 9),
    }
    eighth = {index: project(p) for index, p in eighth.items()}
    # On the cube's edges and corners two or three coordinates are equal in magnitude; make them so to the last bit.
    for i, j in ((0, 0), (1, 0), (2, 0)):
        x, y, _, w = eighth[i, j]
        eighth[i, j] = (y if i == 0 else x, y, y, w)

    def face_point(i, j):  # of the face at -z
        a, b = min(i, 4 - i), min(j, 4 - j)
        x, y, z, w = eighth[max(a, b), min(a, b)]
        if a < b:
            x, y = y, x
        return (-x if i > 2 else x, -y if j > 2 else y, z, w)

    turns = (lambda x, y, z: (y, x, z), lambda x, y, z: (x, y, -z), lambda x, y, z: (x, z, y),
             lambda x, y, z: (y, -z, x), lambda x, y, z: (z, y, x), lambda x, y, z: (-z, x, y))
    return [[turn(*face_point(i, j)[:3]) + (face_point(i, j)[3],) for j in range(5) for i in range(5)]
            for turn in turns]


# ---------------------------------------------------------------------------------------------- surfaces of revolution

# The full circle as four quadratic arcs: the points of a square, corners with weight sqrt(1/2).
CIRCLE = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (-1.0, 1.0), (-1.0, 0.0), (-1.0, -1.0), (0.0, -1.0), (1.0, -1.0)]


def circle(k):
    return CIRCLE[k % 8] + (1.0 if k % 2 == 0 else sqrt(0.5),)


def torus(major=1.0, minor=0.4):
    """Exact: a rational quadratic circle swept along a rational quadratic circle, 4 x 4 patches."""
    patches = []
    for q in range(4):
        for p in range(4):
            patch = []
            for j in range(3):
                for i in range(3):
                    cx, cy, cw = circle(2 * p + i)
                    rx, rz, rw = circle(2 * q + j)
                    rho = major + minor * rx
                    patch.append((rho * cx, rho * cy, minor * rz, cw * rw))
            patches.append(patch)
    return patches


# ---------------------------------------------------------------------------------------------- single triangles


def domain_point(n, i, j):
    """Barycentric index -> plane, an equilateral triangle with side 2 about the origin."""
    u, v, w = i / n, j / n, (n - i - j) / n
    return (u - w, (2 * v - u - w) / sqrt(3), 0.0)


def one_triangle(n, height, weight):
    points = []
    for j in range(n + 1):
        for i in range(n + 1 - j):
            x, y, _ = domain_point(n, i, j)
            points.append((x, y, height(i, j), weight(i, j)))
    return [points]


def triangle_cubic():
    """A saddle that rises to one corner."""
    heights = {(0, 0): 0.1, (1, 0): 0.9, (2, 0): -0.5, (3, 0): 0.3, (0, 1): -0.4, (1, 1): 1.1, (2, 1): 0.2,
               (0, 2): 0.6, (1, 2): -0.3, (0, 3): 0.9}
    return one_triangle(3, lambda i, j: heights[i, j], lambda i, j: 1.0)


def triangle_rational_cubic():
    """A dome on a wavy rim: the heavy middle draws the surface up."""
    heights = {(1, 1): 0.75, (1, 0): 0.0, (0, 1): 0.45, (2, 0): 0.45, (2, 1): 0.0, (0, 2): 0.0, (1, 2): 0.45}
    weights = {(1, 1): 3.0, (0, 0): 1.0, (3, 0): 1.0, (0, 3): 1.0}
    return one_triangle(3, lambda i, j: heights.get((i, j), 0.0), lambda i, j: weights.get((i, j), 0.6))


def triangle_rational_9():
    """Ripples about the middle; weights between 1/4 and 4 sharpen the crests and flatten the troughs."""

    def wave(i, j):
        x, y, _ = domain_point(9, i, j)
        return cos(2 * pi * 0.95 * sqrt(x * x + y * y))

    return one_triangle(9, lambda i, j: 0.9 * wave(i, j), lambda i, j: 4.0 ** wave(i, j))


# ---------------------------------------------------------------------------------------------- a closed model

KNOT_LENGTH, KNOT_ROUND = 16, 3  # 16 x 3 quadrilaterals, 2 triangles each, 3 Bezier triangles each: 288


def knot_surface(a, b):
    """A tube about the trefoil (2 + cos 3s) (cos 2s, sin 2s), sin 3s, put up on two of its lobes; a and b count grid
    cells along and around."""
    s, t = 2 * pi * a / KNOT_LENGTH, 2 * pi * b / KNOT_ROUND
    rho = 2 + cos(3 * s)
    centre = (rho * cos(2 * s), rho * sin(2 * s), sin(3 * s))
    along = unit((-3 * sin(3 * s) * cos(2 * s) - 2 * rho * sin(2 * s),
                  -3 * sin(3 * s) * sin(2 * s) + 2 * rho * cos(2 * s), 3 * cos(3 * s)))
    out = (cos(3 * s) * cos(2 * s), cos(3 * s) * sin(2 * s), sin(3 * s))
    out = unit(sub(out, mul(dot(out, along), along)))
    side = cross(along, out)
    x, y, z = add(centre, mul(0.62 * cos(t), out), mul(0.62 * sin(t), side))
    return (-y, -z, x)


def gradient(f, a, b):
    """Fourth-order central differences. The result is data, not an approximation that must hold: any values give a
    smooth surface, these give one near f."""
    h = 1 / 1024

    def slope(g):
        return mul(1 / (12 * h), sub(mul(8, sub(g(h), g(-h))), sub(g(2 * h), g(-2 * h))))

    return slope(lambda e: f(a + e, b)), slope(lambda e: f(a, b + e))


def clough_tocher(f, columns, rows):
    """A C1 surface of cubic Bezier triangles near f, which is periodic over columns x rows grid cells: each half of a
    cell becomes three triangles about its centroid. R. W. Clough, J. L. Tocher, "Finite element stiffness matrices
    for analysis of plate bending" (1965); control net after G. Farin, "Triangular Bernstein-Bezier patches", CAGD 3
    (1986), applied to x, y and z over the one periodic parameter plane."""
    points, slopes = {}, {}
    for b in range(rows):
        for a in range(columns):
            points[a, b] = f(a, b)
            slopes[a, b] = gradient(f, a, b)

    def near(p, d):
        """The control point one third of the parameter step d away from grid point p."""
        p = (p[0] % columns, p[1] % rows)
        fu, fv = slopes[p]
        return add(points[p], mul(d[0] / 3, fu), mul(d[1] / 3, fv))

    def at(p):
        return points[p[0] % columns, p[1] % rows]

    def edge_centre(p, q, s, ps1, qs1):
        """The point b111 of triangle p, q, s: its derivative at the middle of p, q, across that edge, is f's."""
        e = sub(q, p)
        n = (-e[1], e[0])
        m = mul(0.5, add(p, q))
        d = sub(s, m)
        tau, nu = dot(d, e) / dot(e, e), dot(d, n) / dot(e, e)
        b300, b210, b120, b030 = at(p), near(p, e), near(q, mul(-1, e)), at(q)
        tangential = mul(0.75, sub(add(b030, b120), add(b210, b300)))
        fu, fv = gradient(f, *m)
        derivative = add(mul(tau, tangential), mul(nu * n[0], fu), mul(nu * n[1], fv))
        # derivative = 3 [ (r20 + 2 r11 + r02) / 4 ] with r = b(.., s) - (b(p) + b(q)) / 2 of each level; solve for b111
        r20 = sub(ps1, mul(0.5, add(b300, b210)))
        r02 = sub(qs1, mul(0.5, add(b120, b030)))
        r11 = mul(0.5, sub(mul(4 / 3, derivative), add(r20, r02)))
        return add(r11, mul(0.5, add(b210, b120)))

    patches = []
    for b in range(rows):
        for a in range(columns):
            for corners in (((a, b), (a + 1, b), (a + 1, b + 1)), ((a, b), (a + 1, b + 1), (a, b + 1))):
                s = mul(1 / 3, add(*corners))
                spoke = [near(p, sub(s, p)) for p in corners]
                middle = [edge_centre(corners[k], corners[k - 2], s, spoke[k], spoke[k - 2]) for k in range(3)]
                inner = [mul(1 / 3, add(spoke[k], middle[k], middle[k - 1])) for k in range(3)]
                centre = mul(1 / 3, add(*inner))
                for k in range(3):
                    p, q = corners[k], corners[k - 2]
                    e = sub(q, p)
                    patches.append([x + (1.0,) for x in (
                        centre, inner[k], spoke[k], at(p),  # w = 1 at the centroid, u = 1 at p, v = 1 at q
                        inner[k - 2], middle[k], near(p, e),
                        spoke[k - 2], near(q, mul(-1, e)),
                        at(q))])
    return patches


def knot():
    return clough_tocher(knot_surface, KNOT_LENGTH, KNOT_ROUND)


# ---------------------------------------------------------------------------------------------- furniture for scenes


def sweep(width=40.0, front=-30.0, back=16.0, radius=8.0, height=40.0):
    """A photographer's backdrop: floor, quarter cylinder, wall. Rational, so that the bend is a circle."""
    wall = back + radius
    profile = [((front, 0.0, 1.0), ((front + back) / 2, 0.0, 1.0), (back, 0.0, 1.0)),
               ((back, 0.0, 1.0), (wall, 0.0, sqrt(0.5)), (wall, radius, 1.0)),
               ((wall, radius, 1.0), (wall, (radius + height) / 2, 1.0), (wall, height, 1.0))]
    return [[(x, y, z, w) for y, z, w in part for x in (-width, width)] for part in profile]


# ---------------------------------------------------------------------------------------------- trims


def disc(x, y, r):
    return {"circle": {}, "transform": [r, 0, 0, r, x, y]}


def box(x, y, w, h, degrees=0.0):
    """A rectangle about (x, y), turned."""
    c, s = cos(math.radians(degrees)), sin(math.radians(degrees))
    a, b, d, e = w * c, w * s, -h * s, h * c
    return {"square": {}, "transform": [round(t, 9) for t in (a, b, d, e, x - (a + d) / 2, y - (b + e) / 2)]}


def minus(a, *others):
    return {"difference": [a, others[0] if len(others) == 1 else {"union": list(others)}]}


ALL = {"square": {}}


def straight_and_curved():
    """A contour of five straight edges and one curve, like that of Figure 11."""
    return {"polygon": {"segments": [
        {"line": [[0.42, 0.5], [0.1, 0.72], [0.08, 0.3], [0.28, 0.1], [0.62, 0.08], [0.8, 0.12]]},
        {"bezier": {"points": [[0.8, 0.12], [0.72, 0.34], [0.48, 0.26], [0.42, 0.5]]}}]}}


def machined():
    """Ten squares and eight circles under 17 operators, as many as in Figure 17(c)."""
    plate = {"union": [box(0.3, 0.3, 0.44, 0.44), {"union": [box(0.66, 0.16, 0.34, 0.2), box(0.16, 0.66, 0.2, 0.34)]}]}
    holes = [disc(0.2, 0.2, 0.05), disc(0.42, 0.2, 0.05), disc(0.2, 0.42, 0.05), disc(0.72, 0.16, 0.06),
             disc(0.16, 0.72, 0.06)]
    slots = [box(0.56, 0.16, 0.03, 0.12), box(0.16, 0.56, 0.12, 0.03), box(0.62, 0.16, 0.03, 0.08, 20),
             box(0.16, 0.62, 0.08, 0.03, -20)]
    ring = minus(disc(0.34, 0.34, 0.11), disc(0.34, 0.34, 0.05))
    bridge = {"intersection": [box(0.34, 0.34, 0.3, 0.03, 45), disc(0.34, 0.34, 0.12)]}
    cut = slots[0]
    for part in slots[1:] + holes:
        cut = {"union": [cut, part]}
    whole = minus(minus(plate, cut), ring)
    return {"union": [minus(whole, box(0.5, 0.5, 0.1, 0.1, 45)), minus(bridge, box(0.34, 0.34, 0.02, 0.02))]}


def leaf_contour():
    """Twelve quadratic NURBS arches around, and a closed cubic B-spline cut out, like Figure 17(d)."""
    centre, segments = (0.3, 0.3), []

    def at(k, radius):
        angle = 2 * pi * k / 24
        return [round(centre[0] + radius * cos(angle), 9), round(centre[1] + radius * sin(angle), 9)]

    for k in range(12):
        points = [at(2 * k, 0.2), at(2 * k + 0.5, 0.28) + [0.8], at(2 * k + 1.5, 0.28) + [0.8], at(2 * k + 2, 0.2)]
        segments.append({"nurbs": {"degree": 2, "knots": [0, 0, 0, 1, 2, 2, 2], "points": points}})
    inner = [at(4 * k, 0.15 if k % 2 else 0.07) for k in range(6)]
    hole = {"bspline": {"degree": 3, "knots": list(range(13)), "points": inner + inner[:3]}}
    return minus({"polygon": {"segments": segments}}, {"polygon": {"segments": [hole]}})


# ---------------------------------------------------------------------------------------------- cages


def star(sharpness, points=5, inner=0.45, height=0.7):
    """A star as a prism: a cage of quadrilaterals between two polygons, whose edges are sharp."""
    n = 2 * points
    ring = [(r * cos(pi * k / points), r * sin(pi * k / points)) for k in range(n) for r in [inner if k % 2 else 1.0]]
    vertices = [(x, y, 0.0) for x, y in ring] + [(x, y, height) for x, y in ring]
    sides = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    faces = sides + [[n - 1 - k for k in range(n)], [n + k for k in range(n)]]
    creases = [[low + k, low + (k + 1) % n, sharpness] for low in (0, n) for k in range(n)] if sharpness else []
    return vertices, faces, creases


# ---------------------------------------------------------------------------------------------- curved triangles


def tube_mesh(f, columns, rows):
    """A mesh of triangles over a periodic grid of f, with f's normals: vertices, normals, triangles."""
    vertices, normals, triangles = [], [], []
    for b in range(rows):
        for a in range(columns):
            vertices.append(f(a, b))
            normals.append(unit(cross(*gradient(f, a, b))))
            at = lambda i, j: (b + j) % rows * columns + (a + i) % columns
            triangles += [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]
    return vertices, normals, triangles


def knot_mesh(columns=18, rows=4):
    return tube_mesh(lambda a, b: knot_surface(a * KNOT_LENGTH / columns, b * KNOT_ROUND / rows), columns, rows)


def icosahedron():
    """Vertices on the unit sphere, and the faces, whose normals point outwards."""
    g = (1 + sqrt(5)) / 2
    vertices = [unit(p) for s in (1, -1) for t in (g, -g) for p in ((0, s, t), (s, t, 0), (t, 0, s))]
    near = lambda a, b: dot(a, b) > 0.4
    faces = [(a, b, c) for a in vertices for b in vertices for c in vertices
             if a < b and a < c and near(a, b) and near(b, c) and near(c, a) and dot(a, cross(b, c)) > 0]
    return vertices, faces


def sphere_quadratic():
    """Nearly a sphere: the faces of an icosahedron as quadratic triangles with points of the sphere at their corners
    and in the middle of their edges."""
    middle = lambda a, b: unit(add(a, b))
    return [[a, b, c, middle(b, c), middle(a, c), middle(a, b)] for a, b, c in icosahedron()[1]]


# ---------------------------------------------------------------------------------------------- NURBS


def clamped(degree, points):
    """Knots 0, 1, 2 ... for so many control points."""
    return [0] * degree + list(range(points - degree + 1)) + [points - degree] * degree


def revolved(profile, degree, knots=None):
    """A curve (r, z[, w]) about the z axis, exactly: a rational quadratic circle of four spans in u, the curve in v."""
    points = []
    for r, z, *w in profile:
        for k in range(9):
            x, y, weight = circle(k)
            points.append((r * x, r * y, z, weight * (w[0] if w else 1.0)))
    return (2, degree), ([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], knots or clamped(degree, len(profile))), points


def ball_surface():
    half = [(0.0, -1.0, 1.0), (1.0, -1.0, sqrt(0.5)), (1.0, 0.0, 1.0), (1.0, 1.0, sqrt(0.5)), (0.0, 1.0, 1.0)]
    return revolved(half, 2, [0, 0, 0, 1, 1, 2, 2, 2])


def shade():
    """A lampshade."""
    return revolved([(0.75, 0.0), (1.05, 0.5), (1.9, 1.0), (2.05, 2.0), (1.25, 2.6), (1.0, 3.3), (1.5, 4.1), (1.1, 4.6)], 3)


def pierced():
    """Rows of round holes; in every other row one is across the seam of u, half of it at either end."""
    rows = ((0.75, 14, 0.07), (1.35, 16, 0.091), (1.95, 16, 0.1015), (2.5, 16, 0.091), (3.1, 14, 0.07),
            (3.75, 14, 0.0595), (4.35, 14, 0.07))
    holes = []
    for row, (v, count, size) in enumerate(rows):
        for k in range(count + 1 - row % 2):
            u = round(4 * (k + (row % 2) / 2) / count, 9)
            holes.append({"circle": {}, "transform": [size, 0, 0, 2 * size, u, v]})
    return minus({"square": {}, "transform": [4, 0, 0, 5, 0, 0]}, *holes)


def cloth(n=14, size=5.2):
    """A bicubic B-spline sheet in folds that grow towards its border."""
    points = []
    for j in range(n):
        for i in range(n):
            x, y = size * (2 * i / (n - 1) - 1), size * (2 * j / (n - 1) - 1)
            r, a = sqrt(x * x + y * y), math.atan2(y, x)
            fold = 0.32 * max(0.0, r / size - 0.42) ** 2
            points.append(tuple(round(t, 6) for t in (x, y, 0.12 + fold * (1.2 + sin(9 * a)))))
    return (3, 3), (list(range(n + 4)), list(range(n + 4))), points


def scalloped(petals=12, centre=8.5, radius=4.6):
    """A closed cubic B-spline that swings round a circle."""
    count = 4 * petals
    points = []
    for k in range(count):
        a, r = 2 * math.pi * k / count, radius * (1 + (0.09, 0.0, -0.11, 0.0)[k % 4])
        points.append([round(centre + r * cos(a), 9), round(centre + r * sin(a), 9)])
    return {"polygon": {"segments": [{"bspline": {"degree": 3, "knots": list(range(count + 7)),
                                                  "points": points + points[:3]}}]}}


# ---------------------------------------------------------------------------------------------- writing


def number(x):
    x = float(x) + 0.0  # no negative zeros
    return str(int(x)) if x == int(x) and abs(x) < 1e15 else repr(x)


def point(p):
    rational = len(p) == 4 and p[3] != 1
    return "[" + ", ".join(number(x) for x in (p if rational else p[:3])) + "]"


def geometry(name, kind, degree, patches, trim=None):
    lines = ",\n        ".join("[" + ", ".join(map(point, patch)) + "]" for patch in patches)
    trims = '\n      "trim": %s,' % json.dumps(trim) if trim else ""
    degrees = ' "degree": %s,' % json.dumps(degree) if degree else ""
    return ('    { "name": "%s", "type": "%s",%s%s\n      "patches": [\n        %s ] }'
            % (name, kind, degrees, trims, lines))


def nurbs_geometry(name, surface, trim=None):
    degree, knots, points = surface
    trims = ',\n      "trim": %s' % json.dumps(trim) if trim else ""
    return ('    { "name": "%s", "type": "nurbs", "degree": %s,\n      "knots": %s,\n      "points": [%s]%s }'
            % (name, json.dumps(degree), json.dumps(knots), ", ".join(map(point, points)), trims))


def mesh_geometry(name, kind, mesh, more=""):
    vertices, normals, triangles = mesh
    listed = lambda points: ", ".join(map(point, points))
    return ('    { "name": "%s", "type": "%s",%s\n      "vertices": [%s],\n      "normals": [%s],\n'
            '      "triangles": %s }' % (name, kind, more, listed(vertices), listed(normals), json.dumps(triangles)))


def cage(name, vertices, faces, creases):
    sharp = ',\n      "creases": %s' % json.dumps(creases) if creases else ""
    return ('    { "name": "%s", "type": "subdivision",\n      "vertices": [%s],\n      "faces": %s%s }'
            % (name, ", ".join(map(point, vertices)), json.dumps(faces), sharp))


def file_geometry(name, path, more=""):
    return '    { "name": "%s", "type": "file", "path": "%s"%s }' % (name, path, more)


def turned(degrees, axis="z", scale=1.0, at=(0, 0, 0)):
    """Scaled (by one number or one an axis), then turned about an axis ("y up": the y axis raised, then turned about z),
    then moved. 12 numbers: the images of the axes,
    then the translation."""
    c, s = cos(math.radians(degrees)), sin(math.radians(degrees))
    images = {"z": ((c, s, 0), (-s, c, 0), (0, 0, 1)), "y": ((c, 0, -s), (0, 1, 0), (s, 0, c)),
              "y up": ((c, s, 0), (0, 0, 1), (s, -c, 0))}[axis]
    scales = scale if isinstance(scale, tuple) else (scale, scale, scale)
    return [round(x, 9) for k in range(3) for x in mul(scales[k], images[k])] + list(at)


def item(geometry_name, material=None, transform=None):
    parts = ['"geometry": "%s"' % geometry_name]
    if transform:
        parts.append('"transform": [' + ", ".join(map(number, transform)) + "]")
    if material:
        parts.append('"material": "%s"' % material)
    return "    { " + ", ".join(parts) + " }"


def scene(geometries, objects=None, camera=None):
    text = '{\n  "format": "embree_patch scene", "version": 1,\n'
    if camera:
        eye, target, fov = camera
        text += ('  "camera": { "eye": %s, "target": %s, "up": [0, 0, 1], "fov": %s },\n'
                 % (point(eye), point(target), number(fov)))
    text += '  "geometry": [\n' + ",\n".join(geometries) + "\n  ]"
    if objects:
        text += ',\n  "objects": [\n' + ",\n".join(objects) + "\n  ]"
    return text + "\n}\n"


def files():
    sphere = geometry("sphere", "bezier", [4, 4], sphere_tensor())
    ring = geometry("torus", "bezier", [2, 2], torus())
    backdrop = geometry("backdrop", "bezier", [1, 2], sweep())
    trefoil = geometry("knot", "bezier_triangles", 3, knot())
    dome = geometry("dome", "bezier_triangles", 3, triangle_rational_cubic())
    ripples = geometry("triangle", "bezier_triangles", 9, triangle_rational_9())
    teapot = file_geometry("teapot", "../teapot.bpt")

    models = {
        "sphere.json": scene([sphere]),
        "sphere_triangles.json": scene([geometry("sphere", "bezier_triangles", 4, sphere_triangles())]),
        "torus.json": scene([ring]),
        "triangle_cubic.json": scene([geometry("triangle", "bezier_triangles", 3, triangle_cubic())]),
        "triangle_rational_cubic.json": scene([dome]),
        "triangle_rational_9.json": scene([ripples]),
        "knot.json": scene([trefoil]),
    }

    models["scenes/tea.json"] = scene(
        [teapot, ring, sphere, backdrop],
        [item("teapot", "porcelain", turned(-12)),
         item("sphere", "chrome", turned(0, "z", 0.75, (3.9, -2.2, 0.75))),
         item("torus", "copper", turned(0, "z", 0.75, (-2.7, -2.9, 0.3))),
         item("sphere", "red plastic", turned(0, "z", 0.4, (-2.7, -2.9, 0.78))),
         item("backdrop", "slate")],
        ((0.6, -13.5, 5.6), (0.3, 0, 1.15), 27))

    models["scenes/chrome.json"] = scene(
        [sphere, ring, backdrop],
        [item("sphere", "chrome", turned(0, "z", 1.5, (0, 0, 1.5))),
         item("torus", "gold", turned(68, "y", 1.25, (-2.9, -0.6, 1.62))),
         item("torus", "chrome", turned(0, "z", 1.1, (2.9, -1.3, 0.44))),
         item("sphere", "red plastic", turned(0, "z", 0.62, (2.9, -1.3, 0.72))),
         item("sphere", "blue plastic", turned(0, "z", 0.5, (-0.9, -2.6, 0.5))),
         item("sphere", "porcelain", turned(0, "z", 0.34, (0.75, -2.9, 0.34))),
         item("backdrop", "stone")],
        ((0.4, -11.5, 4.2), (0.1, 0, 1.25), 29))

    colours = ["red", "orange", "yellow", "green", "teal", "blue", "violet"]
    foot = 2.95  # of the knot: it stands on two lobes so far below its origin
    objects = [item("knot", "gold", turned(0, "z", 1.0, (0, 0, foot)))]
    for row, (count, radius, scale) in enumerate(((9, 6.0, 0.36), (17, 9.0, 0.28), (27, 11.6, 0.2))):
        for k in range(count):
            angle = 360 * (k + 0.5 * row) / count
            place = (radius * cos(math.radians(angle)), radius * sin(math.radians(angle)), foot * scale)
            objects.append(item("knot", colours[(k + 2 * row) % 7] + " plastic", turned(angle + 90, "z", scale, place)))
    objects.append(item("backdrop", "paper"))
    models["scenes/knots.json"] = scene([trefoil, backdrop], objects, ((0, -21, 12), (0, -0.3, 1.6), 33))

    models["scenes/mirror.json"] = scene(
        [ripples, sphere, backdrop],
        [item("triangle", "mirror", turned(-30, "z", (3.6, 3.6, 1.1), (0, 0, 1.0))),
         item("sphere", "red plastic", turned(0, "z", 0.8, (-0.5, 0.6, 2.9))),
         item("sphere", "yellow plastic", turned(0, "z", 0.45, (1.5, -0.5, 2.3))),
         item("sphere", "blue plastic", turned(0, "z", 0.5, (-2.2, -0.9, 2.1))),
         item("backdrop", "slate")],
        ((0.3, -11.0, 6.2), (-0.1, 0.1, 1.55), 30))

    cubic = lambda name, trim: geometry(name, "bezier_triangles", 3, triangle_rational_cubic(), trim)
    stand = lambda x: turned(-45, "z", 4.2, (x, 0.2, 0.35))
    names = ("edges", "hole", "machined", "contour")
    trims = (straight_and_curved(), minus(ALL, disc(0.33, 0.33, 0.16)), machined(), leaf_contour())
    colour = ("teal plastic", "copper", "steel", "red plastic")
    models["scenes/trims.json"] = scene(
        [cubic(name, trim) for name, trim in zip(names, trims)] + [backdrop],
        [item(names[k], colour[k], stand(4.9 * k - 7.4)) for k in range(4)] + [item("backdrop", "paper")],
        ((0, -17, 13), (0, -0.4, 0.6), 33))

    window = {"loops": [{"polygon": {"segments": [{"bezier": {"points": points}} for points in loop]}} for loop in (
        [[[0.12, 0.12], [0.5, 0.02], [0.88, 0.12]], [[0.88, 0.12], [0.98, 0.5], [0.88, 0.88]],
         [[0.88, 0.88], [0.5, 0.98], [0.12, 0.88]], [[0.12, 0.88], [0.02, 0.5], [0.12, 0.12]]],
        [[[0.3, 0.5], [0.5, 0.42], [0.5, 0.22]], [[0.5, 0.22], [0.5, 0.42], [0.7, 0.5]],
         [[0.7, 0.5], [0.5, 0.58], [0.5, 0.78]], [[0.5, 0.78], [0.5, 0.58], [0.3, 0.5]]])]}
    models["scenes/lantern.json"] = scene(
        [geometry("lantern", "bezier", [4, 4], sphere_tensor(), minus(ALL, window)), sphere, backdrop],
        [item("lantern", "gold", turned(25, "z", 2, (0, 0, 2))),
         item("sphere", "red plastic", turned(0, "z", 0.8, (0, 0, 2))), item("backdrop", "slate")],
        ((0.4, -12.5, 6.2), (0, 0, 1.7), 26))
    sharpness = (0, 1, 2.5, 10)
    names = ["star %g" % x for x in sharpness]
    colour = ("yellow", "orange", "red", "violet")
    models["scenes/cages.json"] = scene(
        [file_geometry("spot", "../spot.obj", ', "as": "subdivision"')]
        + [cage(names[k], *star(sharpness[k])) for k in range(4)] + [backdrop],
        [item("spot", "porcelain", turned(150, "y up", 2.6, (0.1, 1.6, 1.9)))]
        + [item(names[k], colour[k] + " plastic", turned(20 * k, "z", 1.0, (2.35 * k - 3.5, -2.6, 0.0)))
           for k in range(4)]
        + [item("backdrop", "slate")],
        ((1.2, -14.5, 6.6), (0.1, -0.2, 1.3), 28))

    knots = [mesh_geometry("flat", "phong_triangles", knot_mesh(), ' "alpha": 0,'),
             mesh_geometry("phong", "phong_triangles", knot_mesh()), mesh_geometry("pn", "pn_triangles", knot_mesh())]
    ball = geometry("ball", "quadratic_triangles", None, sphere_quadratic())
    models["scenes/triangles.json"] = scene(
        knots + [ball, backdrop],
        [item(name, colour, turned(0, "z", 1.0, (7.3 * k - 7.3, 0, foot)))
         for k, (name, colour) in enumerate(zip(("flat", "phong", "pn"), ("ivory plastic", "copper", "gold")))]
        + [item("ball", colour + " plastic", turned(31 * k, "z", 0.9, (3.65 * k - 7.3, -4.2, 0.9)))
           for k, colour in enumerate(("red", "orange", "green", "teal", "violet"))]
        + [item("backdrop", "paper")],
        ((0, -24, 8), (0, -0.5, 2.55), 24.5))
    models["scenes/nurbs.json"] = scene(
        [nurbs_geometry("shade", shade(), pierced()), nurbs_geometry("ball", ball_surface()),
         nurbs_geometry("cloth", cloth(), scalloped()), backdrop],
        [item("cloth", "teal"), item("shade", "ivory plastic", turned(20, "z", 1.0, (0, 0, 0.14))),
         item("ball", "orange plastic", turned(0, "z", 0.82, (0, 0, 1.55))),
         item("ball", "gold", turned(0, "z", 0.55, (-2.45, -1.75, 0.69))),
         item("ball", "red plastic", turned(0, "z", 0.4, (2.35, -2.1, 0.54))), item("backdrop", "slate")],
        ((0.4, -14.5, 8.2), (0, -0.2, 1.75), 30))
    return models


# ---------------------------------------------------------------------------------------------- checking


def triangle_index(n, i, j):
    return j * (n + 1) - j * (j - 1) // 2 + i


class Patch:
    """One patch of a file that was read back, with homogeneous evaluation straight from the definition."""

    def __init__(self, kind, degree, points):
        self.kind, self.degree = kind, degree
        self.points = [tuple(map(float, p)) + (1.0,) * (4 - len(p)) for p in points]

    def edges(self):
        if self.kind == "bezier":
            m, n = self.degree
            index = lambda i, j: j * (m + 1) + i
            runs = [[index(i, 0) for i in range(m + 1)], [index(m, j) for j in range(n + 1)],
                    [index(m - i, n) for i in range(m + 1)], [index(0, n - j) for j in range(n + 1)]]
        else:
            n = self.degree
            runs = [[triangle_index(n, i, 0) for i in range(n + 1)],
                    [triangle_index(n, n - j, j) for j in range(n + 1)],
                    [triangle_index(n, 0, n - j) for j in range(n + 1)]]
        return [tuple(self.points[k] for k in run) for run in runs]

    def bernstein(self, u, v):
        """Values and derivatives by u and v of the basis, in the order of the points."""
        if self.kind == "bezier":
            def one(n, i, x):
                b = comb(n, i) * x**i * (1 - x)**(n - i)
                d = n * ((comb(n - 1, i - 1) * x**(i - 1) * (1 - x)**(n - i) if i > 0 else 0)
                         - (comb(n - 1, i) * x**i * (1 - x)**(n - 1 - i) if i < n else 0))
                return b, d
            m, n = self.degree
            for j in range(n + 1):
                bv, dv = one(n, j, v)
                for i in range(m + 1):
                    bu, du = one(m, i, u)
                    yield bu * bv, du * bv, bu * dv
        else:
            n, w = self.degree, 1 - u - v

            def basis(degree, i, j, k):
                if min(i, j, k) < 0:
                    return 0
                return factorial(degree) / (factorial(i) * factorial(j) * factorial(k)) * u**i * v**j * w**k
            for j in range(n + 1):
                for i in range(n + 1 - j):
                    k = n - i - j
                    down = basis(n - 1, i, j, k - 1)
                    yield (basis(n, i, j, k), n * (basis(n - 1, i - 1, j, k) - down),
                           n * (basis(n - 1, i, j - 1, k) - down))

    def evaluate(self, u, v):
        """Point and unnormalised normal."""
        h, hu, hv = [0.0] * 4, [0.0] * 4, [0.0] * 4
        for (x, y, z, w), (b, bu, bv) in zip(self.points, self.bernstein(u, v)):
            for k, c in enumerate((w * x, w * y, w * z, w)):
                h[k] += b * c
                hu[k] += bu * c
                hv[k] += bv * c
        p = mul(1 / h[3], h[:3])
        pu = mul(1 / h[3], sub(hu[:3], mul(hu[3], p)))
        pv = mul(1 / h[3], sub(hv[:3], mul(hv[3], p)))
        return p, cross(pu, pv)

    def samples(self, n=7):
        for b in range(n + 1):
            for a in range(n + 1):
                u, v = a / n, b / n
                yield (u, v) if self.kind == "bezier" else (u, v * (1 - u))


def read(path):
    with open(os.path.join(HERE, path), encoding="utf-8") as f:
        data = json.load(f)
    return [Patch(g["type"], g.get("degree"), points) for g in data["geometry"] for points in g.get("patches", [])]


def read_quadratic(path):
    """The quadratic triangles of a file, as Bezier triangles."""
    patches = []
    for p1, p2, p3, p4, p5, p6 in (p.points for p in read(path) if p.kind == "quadratic_triangles"):
        across = lambda a, b, m: add(mul(2, m), mul(-0.5, add(a, b)))
        net = [p3, across(p1, p3, p5), p1, across(p2, p3, p4), across(p1, p2, p6), p2]
        patches.append(Patch("bezier_triangles", 2, net))
    return patches


def check_closed(patches):
    """Every edge that is not a point belongs to exactly two patches, which run along it in opposite directions."""
    seen = {}
    for patch in patches:
        for edge in patch.edges():
            if len({p[:3] for p in edge}) > 1:
                seen.setdefault(edge, []).append(patch)
    for edge, owners in seen.items():
        if len(owners) != 1 or len(seen.get(edge[::-1], [])) != 1:
            raise AssertionError("the edge from %s to %s has no unique neighbour" % (edge[0], edge[-1]))


def check_meshes(path, count):
    """So many meshes with normals are closed: each edge belongs to two triangles, which run along it in opposite
    directions; and all triangles face to where their normals point."""
    with open(os.path.join(HERE, path), encoding="utf-8") as f:
        meshes = [g for g in json.load(f)["geometry"] if "triangles" in g]
    assert len(meshes) == count
    for g in meshes:
        edges = [(t[k - 1], t[k]) for t in g["triangles"] for k in range(3)]
        if len(set(edges)) != len(edges) or {(b, a) for a, b in edges} != set(edges):
            raise AssertionError("the mesh '%s' is not closed" % g["name"])
        for t in g["triangles"]:
            p, q, r = (g["vertices"][k] for k in t)
            if not dot(cross(sub(q, p), sub(r, p)), add(*(g["normals"][k] for k in t))) > 0:
                raise AssertionError("a triangle of '%s' faces against its normals" % g["name"])


def check_implicit(patches, f, tolerance):
    worst = max(abs(f(patch.evaluate(u, v)[0])) for patch in patches for u, v in patch.samples())
    if not worst <= tolerance:
        raise AssertionError("off the exact surface by %g" % worst)


def check_outward(patches, outward):
    for patch in patches:
        for u, v in patch.samples():
            p, n = patch.evaluate(u, v)
            if not dot(n, outward(p)) > 0:
                raise AssertionError("the normal at %s points inwards or vanishes" % (p,))


def check_smooth(patches, tolerance):
    """Normals of the two patches at an edge agree."""
    corner_uv = {"bezier_triangles": [(0, 0), (1, 0), (0, 1)]}
    halves = {}
    for patch in patches:
        corners = corner_uv[patch.kind]
        for k, edge in enumerate(patch.edges()):
            halves[edge] = (patch, corners[k], corners[(k + 1) % 3])
    worst = 0.0
    for edge, (patch, a, b) in halves.items():
        other, c, d = halves[edge[::-1]]
        for s in (0.0, 0.2, 0.5, 0.9):
            n0 = unit(patch.evaluate(*add(mul(1 - s, a), mul(s, b)))[1])
            n1 = unit(other.evaluate(*add(mul(1 - s, d), mul(s, c)))[1])
            worst = max(worst, sqrt(dot(sub(n0, n1), sub(n0, n1))))
    if not worst <= tolerance:
        raise AssertionError("normals differ across an edge by %g" % worst)


def check():
    tube = lambda p: sqrt((sqrt(p[0] * p[0] + p[1] * p[1]) - 1)**2 + p[2] * p[2]) - 0.4
    ring = lambda p: sub(p, unit((p[0], p[1], 0.0)))
    for name, count in (("sphere.json", 6), ("sphere_triangles.json", 8)):
        sphere = read(name)
        assert len(sphere) == count
        check_closed(sphere)
        check_implicit(sphere, lambda p: sqrt(dot(p, p)) - 1, 1e-15)
        check_outward(sphere, lambda p: p)
    torus_patches = read("torus.json")
    assert len(torus_patches) == 16
    check_closed(torus_patches)
    check_implicit(torus_patches, tube, 1e-15)
    check_outward(torus_patches, ring)
    knot_patches = read("knot.json")
    assert len(knot_patches) == 288
    check_closed(knot_patches)
    check_smooth(knot_patches, 1e-9)
    for name, degree in (("triangle_cubic", 3), ("triangle_rational_cubic", 3), ("triangle_rational_9", 9)):
        (patch,) = read(name + ".json")
        assert patch.degree == degree and all(p[3] > 0 for p in patch.points)
        assert ("rational" in name) == any(p[3] != 1 for p in patch.points)
    ball = read_quadratic("scenes/triangles.json")
    assert len(ball) == 20
    check_closed(ball)
    check_implicit(ball, lambda p: sqrt(dot(p, p)) - 1, 0.02)
    check_outward(ball, lambda p: p)
    check_meshes("scenes/triangles.json", 3)
    for name in files():
        read(name)
    print("ok   %d files: spheres and torus exact to 1e-15, eight closed models watertight, the knot smooth"
          % len(files()))


def main():
    if sys.argv[1:] == ["--check"]:
        try:
            check()
        except AssertionError as e:
            sys.exit("FAIL data: %s" % e)
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        for name, text in files().items():
            with open(os.path.join(HERE, name), "w", encoding="utf-8", newline="\n") as f:
                f.write(text)


if __name__ == "__main__":
    main()
