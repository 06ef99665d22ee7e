/* oracle.c - see oracle.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Patches are cut into pieces in advance, over a domain that reaches beyond their own by twice the band at borders; a
 * tree of boxes finds the pieces near a ray. Within a piece, points are seen along the ray: f1 and f2, their distances
 * from two planes through the ray, times w; and t, times w. Roots are zeros of the polynomials f1 and f2. */
#include "test/oracle/oracle.h"
#include "test/oracle/net.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    PIECE_CUTS = 6,      /* a patch is cut into 2^6 pieces                                           */
    SEARCH_PARTS = 5000, /* parts of a piece; a ray along a flat patch would go on for ever          */
    EDGE_ON_PARTS = 50   /* ... that one counts for which the ray sees as no more than a line        */
};
static const double extension = 2 * ORACLE_BORDER;
static const double smallest = 0x1p-16;  /* sides of a part, of the domain, that is no longer cut */
static const double rounding = 1e-13;    /* of the patch's radius; double errs by less           */
static const double newton_slack = 1e-9; /* a root on the border of two parts belongs to both    */
static const double edge_on = 1e-6;      /* sine between two sides that the ray sees as one line  */

typedef struct patch {
    net_shape shape;
    net_point *points; /* homogeneous, relative to the centre */
    double centre[3], radius;
} patch;

typedef struct piece {
    uint32_t patch;
    net_part part;
    double lower[3], upper[3];
    net_point *net;
} piece;

typedef struct node {
    double lower[3], upper[3];
    size_t first, count; /* pieces below; a leaf has few */
    size_t right;        /* the left child follows its parent */
} node;

enum { LEAF_PIECES = 2 };

struct oracle {
    patch *patches;
    size_t patch_count;
    piece *pieces;
    size_t piece_count;
    node *nodes;
    size_t node_count;
};

/* Building */

static void box_of(const net_point *net, size_t count, const double centre[3], double lower[3], double upper[3])
{
    for (int c = 0; c < 3; ++c) lower[c] = INFINITY, upper[c] = -INFINITY;
    for (size_t k = 0; k < count; ++k)
        for (int c = 0; c < 3; ++c) {
            const double x = centre[c] + net[k][c] / net[k][3];
            lower[c] = fmin(lower[c], x);
            upper[c] = fmax(upper[c], x);
        }
}

static bool add_patch(oracle *o, const oracle_patch *in)
{
    patch *p = &o->patches[o->patch_count];
    p->shape = (net_shape){in->triangle, in->degree_u, in->degree_v};
    const size_t count = net_count(p->shape);
    p->points = malloc(count * sizeof *p->points);
    if (!p->points) return false;
    ++o->patch_count;

    static const double origin[3] = {0, 0, 0};
    double lower[3], upper[3];
    net_point *q = p->points;
    for (size_t k = 0; k < count; ++k) {
        const double *x = in->points + 4 * k;
        for (int c = 0; c < 4; ++c) q[k][c] = c < 3 ? x[3] * x[c] : x[3];
    }
    box_of(q, count, origin, lower, upper);
    p->radius = 0;
    for (int c = 0; c < 3; ++c) {
        p->centre[c] = lower[c] / 2 + upper[c] / 2;
        p->radius = fmax(p->radius, upper[c] / 2 - lower[c] / 2);
    }
    /* floats do not tell the points of a smaller one apart */
    for (int c = 0; c < 3; ++c) p->radius = fmax(p->radius, 0x1p-24 * fabs(p->centre[c]));
    for (size_t k = 0; k < count; ++k) {
        const double *x = in->points + 4 * k;
        for (int c = 0; c < 3; ++c) q[k][c] = x[3] * (x[c] - p->centre[c]);
    }
    return true;
}

/* In the domain. */
static unsigned longest_edge(net_shape s, const net_part *p)
{
    const double a = hypot(p->a[0], p->a[1]), b = hypot(p->b[0], p->b[1]);
    const double c = s.triangle ? hypot(p->a[0] - p->b[0], p->a[1] - p->b[1]) : 0;
    return c > fmax(a, b) ? 2 : b > a;
}

static bool cut_pieces(oracle *o, uint32_t index, const net_point *net, const net_part *part, unsigned cuts)
{
    const patch *p = &o->patches[index];
    const size_t count = net_count(p->shape);
    if (!cuts) {
        piece *to = &o->pieces[o->piece_count];
        *to = (piece){.patch = index, .part = *part, .net = malloc(count * sizeof *to->net)};
        if (!to->net) return false;
        ++o->piece_count;
        memcpy(to->net, net, count * sizeof *net);
        box_of(net, count, p->centre, to->lower, to->upper);
        for (int c = 0; c < 3; ++c) {
            to->lower[c] -= ORACLE_NEAR * p->radius;
            to->upper[c] += ORACLE_NEAR * p->radius;
        }
        return true;
    }
    net_point first[NET_POINTS], second[NET_POINTS];
    net_part a, b;
    const unsigned edge = longest_edge(p->shape, part);
    net_cut(p->shape, net, edge, first, second);
    net_cut_part(p->shape, part, edge, &a, &b);
    return cut_pieces(o, index, first, &a, cuts - 1) && cut_pieces(o, index, second, &b, cuts - 1);
}

static bool add_pieces(oracle *o, uint32_t index)
{
    const patch *p = &o->patches[index];
    const double side = p->shape.triangle ? 1 + 3 * extension : 1 + 2 * extension;
    const net_part whole = {{-extension, -extension}, {side, 0}, {0, side}};
    net_point net[NET_POINTS];
    net_extend(p->shape, p->points, extension, net);
    return cut_pieces(o, index, net, &whole, PIECE_CUTS);
}

static int by_middle(const void *a, const void *b, int axis)
{
    const piece *p = a, *q = b;
    const double x = p->lower[axis] + p->upper[axis], y = q->lower[axis] + q->upper[axis];
    return (x > y) - (x < y);
}

static int by_x(const void *a, const void *b)
{
    return by_middle(a, b, 0);
}

static int by_y(const void *a, const void *b)
{
    return by_middle(a, b, 1);
}

static int by_z(const void *a, const void *b)
{
    return by_middle(a, b, 2);
}

static void build_tree(oracle *o, size_t first, size_t count)
{
    const size_t at = o->node_count++;
    node n = {.first = first, .count = count};
    for (int c = 0; c < 3; ++c) n.lower[c] = INFINITY, n.upper[c] = -INFINITY;
    for (size_t k = first; k < first + count; ++k)
        for (int c = 0; c < 3; ++c) {
            n.lower[c] = fmin(n.lower[c], o->pieces[k].lower[c]);
            n.upper[c] = fmax(n.upper[c], o->pieces[k].upper[c]);
        }
    if (count > LEAF_PIECES) {
        static int (*const by[3])(const void *, const void *) = {by_x, by_y, by_z};
        int axis = 0;
        for (int c = 1; c < 3; ++c)
            if (n.upper[c] - n.lower[c] > n.upper[axis] - n.lower[axis]) axis = c;
        qsort(o->pieces + first, count, sizeof *o->pieces, by[axis]);
        build_tree(o, first, count / 2);
        n.right = o->node_count;
        build_tree(o, first + count / 2, count - count / 2);
    }
    o->nodes[at] = n;
}

oracle *oracle_new(const oracle_patch *patches, size_t count)
{
    oracle *o = calloc(1, sizeof *o);
    if (!o) return NULL;
    const size_t pieces = count << PIECE_CUTS;
    o->patches = calloc(count + 1, sizeof *o->patches);
    o->pieces = calloc(pieces + 1, sizeof *o->pieces);
    o->nodes = calloc(2 * pieces + 1, sizeof *o->nodes);
    bool complete = o->patches && o->pieces && o->nodes;
    for (size_t i = 0; i < count && complete; ++i) complete = add_patch(o, &patches[i]) && add_pieces(o, (uint32_t)i);
    if (!complete) {
        oracle_free(o);
        return NULL;
    }
    if (pieces) build_tree(o, 0, pieces);
    return o;
}

void oracle_free(oracle *o)
{
    if (!o) return;
    for (size_t i = 0; i < o->patch_count; ++i) free(o->patches[i].points);
    for (size_t i = 0; i < o->piece_count; ++i) free(o->pieces[i].net);
    free(o->patches);
    free(o->pieces);
    free(o->nodes);
    free(o);
}

void oracle_evaluate(const oracle *o, uint32_t index, double u, double v, double p[3], double pu[3], double pv[3])
{
    const patch *q = &o->patches[index];
    net_point x, xu, xv;
    net_evaluate(q->shape, q->points, u, v, x, xu, xv);
    for (int c = 0; c < 3; ++c) {
        const double local = x[c] / x[3];
        if (p) p[c] = q->centre[c] + local;
        if (pu) pu[c] = (xu[c] - xu[3] * local) / x[3];
        if (pv) pv[c] = (xv[c] - xv[3] * local) / x[3];
    }
}

void oracle_bounds(const oracle *o, double lower[3], double upper[3])
{
    for (int c = 0; c < 3; ++c) {
        lower[c] = o->node_count ? o->nodes[0].lower[c] : 0;
        upper[c] = o->node_count ? o->nodes[0].upper[c] : 0;
    }
}

size_t oracle_patch_count(const oracle *o)
{
    return o->patch_count;
}

bool oracle_is_triangle(const oracle *o, uint32_t index)
{
    return o->patches[index].shape.triangle;
}

double oracle_radius(const oracle *o, uint32_t index)
{
    return o->patches[index].radius;
}

/* Searching */

typedef struct query {
    const oracle *o;
    const patch *patch;
    uint32_t index;
    const double *org, *dir;
    double tnear, tfar;
    double t0;      /* t of the point of the ray that is nearest to the patch's centre */
    unsigned parts; /* searched in this piece */
    oracle_root *roots;
    size_t count;
    double left_out; /* the least t_low of a root that there was no room for */
} query;

typedef struct range {
    double low, high;
} range;

static void include(range *r, double x)
{
    if (x < r->low) r->low = x;
    if (x > r->high) r->high = x;
}

static const range nothing = {INFINITY, -INFINITY};

static bool holds_zero(range r, double slack)
{
    return r.low <= slack && r.high >= -slack;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double r[3])
{
    for (int c = 0; c < 3; ++c) r[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static double border_of(net_shape s, double u, double v)
{
    return s.triangle ? fmin(fmin(u, v), 1 - u - v) : fmin(fmin(u, v), fmin(1 - u, 1 - v));
}

/* Roots that are the same from two parts, and undecided parts that touch, become one. */
static void add_root(query *q, const oracle_root *r)
{
    const double near = 1e-9 * (fabs(r->t_low) + q->patch->radius / sqrt(dot(q->dir, q->dir)));
    for (size_t k = 0; k < q->count; ++k) {
        oracle_root *old = &q->roots[k];
        if (old->patch != r->patch || old->t_low > r->t_high + near || old->t_high < r->t_low - near) continue;
        const bool ranges = old->t_high > old->t_low && r->t_high > r->t_low;
        const bool same = fabs(old->u - r->u) + fabs(old->v - r->v) < 1e-7;
        if (!ranges && !same) continue;
        old->t_low = fmin(old->t_low, r->t_low);
        old->t_high = fmax(old->t_high, r->t_high);
        old->doubtful = old->doubtful || r->doubtful;
        return;
    }
    if (q->count < ORACLE_ROOTS) {
        q->roots[q->count++] = *r;
        return;
    }
    oracle_root *last = q->roots;
    for (oracle_root *k = last + 1; k < q->roots + ORACLE_ROOTS; ++k)
        if (k->t_low > last->t_low) last = k;
    q->left_out = fmin(q->left_out, fmax(last->t_low, r->t_low));
    if (r->t_low < last->t_low) *last = *r;
}

/* What was left out may be anywhere from its first root on. */
static void close_list(query *q)
{
    if (!(q->left_out < INFINITY)) return;
    oracle_root *last = &q->roots[ORACLE_ROOTS - 1];
    last->t_low = fmin(last->t_low, q->left_out);
    last->t_high = INFINITY;
    last->doubtful = true;
}

/* What is known where the surface has the parameters u, v. */
static oracle_root root_at(const query *q, double u, double v)
{
    oracle_root r = {.u = u, .v = v, .patch = q->index, .border = border_of(q->patch->shape, u, v)};
    double pu[3], pv[3];
    oracle_evaluate(q->o, q->index, u, v, NULL, pu, pv);
    cross(pu, pv, r.normal);
    const double length = sqrt(dot(r.normal, r.normal));
    if (length > 1e-12 * (dot(pu, pu) + dot(pv, pv)))
        r.cosine = fabs(dot(r.normal, q->dir)) / (length * sqrt(dot(q->dir, q->dir)));
    return r;
}

/* A ray is in the band of a round silhouette for sqrt(2 ORACLE_NEAR) of its radius, of a flatter one for longer. */
static void widen(const query *q, oracle_root *r)
{
    const double band = 5 * sqrt(ORACLE_NEAR) * q->patch->radius / sqrt(dot(q->dir, q->dir));
    r->t_low -= band;
    r->t_high += band;
}

static void add_found(query *q, double u, double v, double t)
{
    oracle_root r = root_at(q, u, v);
    const double near_end = 1e-5 * (fabs(t) + q->patch->radius / sqrt(dot(q->dir, q->dir)));
    if (r.border < -ORACLE_BORDER || t <= q->tnear - near_end || t >= q->tfar + near_end) return;
    r.t_low = r.t_high = t;
    if (r.cosine < ORACLE_TANGENT) widen(q, &r);
    r.doubtful =
        r.border < ORACLE_BORDER || r.cosine < ORACLE_TANGENT || t < q->tnear + near_end || t > q->tfar - near_end;
    add_root(q, &r);
}

static void add_undecided(query *q, const net_part *part, range t)
{
    const double third = q->patch->shape.triangle ? 1.0 / 3 : 0.5;
    oracle_root r =
        root_at(q, part->at[0] + third * (part->a[0] + part->b[0]), part->at[1] + third * (part->a[1] + part->b[1]));
    r.t_low = t.low;
    r.t_high = t.high;
    r.doubtful = true;
    widen(q, &r);
    if (r.t_high > q->tnear && r.t_low < q->tfar) add_root(q, &r);
}

/* The hull of the derivatives of f1 and f2 over a net: middle and half width. */
typedef struct slopes {
    double mid[2][2], half[2][2]; /* [of f][along] */
} slopes;

static slopes slopes_of(net_shape s, const net_point *net)
{
    range r[2][2] = {{nothing, nothing}, {nothing, nothing}};
    for (unsigned j = 0; j <= s.n; ++j)
        for (unsigned i = 0; net_has(s, i, j); ++i) {
            const double *p = net[net_index(s, i, j)];
            for (int f = 0; f < 2; ++f) {
                if (net_has(s, i + 1, j)) include(&r[f][0], s.m * (net[net_index(s, i + 1, j)][f] - p[f]));
                if (net_has(s, i, j + 1)) include(&r[f][1], s.n * (net[net_index(s, i, j + 1)][f] - p[f]));
            }
        }
    slopes d;
    for (int f = 0; f < 2; ++f)
        for (int k = 0; k < 2; ++k) {
            d.mid[f][k] = r[f][k].low / 2 + r[f][k].high / 2;
            d.half[f][k] = r[f][k].high / 2 - r[f][k].low / 2;
        }
    return d;
}

/* The longest leg of the control net along each edge, in space. */
static void legs_of(const query *q, const net_point *net, double legs[3])
{
    static const unsigned from[3][2] = {{0, 0}, {0, 0}, {1, 0}}, to[3][2] = {{1, 0}, {0, 1}, {0, 1}};
    const net_shape s = q->patch->shape;
    const double along = sqrt(dot(q->dir, q->dir));
    for (int e = 0; e < 3; ++e) legs[e] = 0;
    for (int e = 0; e < (s.triangle ? 3 : 2); ++e)
        for (unsigned j = 0; j <= s.n; ++j)
            for (unsigned i = 0; net_has(s, i, j); ++i) {
                if (!net_has(s, i + from[e][0], j + from[e][1]) || !net_has(s, i + to[e][0], j + to[e][1])) continue;
                const double *p = net[net_index(s, i + from[e][0], j + from[e][1])];
                const double *r = net[net_index(s, i + to[e][0], j + to[e][1])];
                double d[3];
                for (int c = 0; c < 3; ++c) d[c] = r[c] / r[3] - p[c] / p[3];
                d[2] *= along;
                legs[e] = fmax(legs[e], sqrt(dot(d, d)));
            }
    legs[0] *= s.m, legs[1] *= s.n, legs[2] *= s.n;
}

/* The hull of a f1 + b f2 over a net. */
static range hull(const net_point *net, size_t count, double a, double b)
{
    range r = nothing;
    for (size_t k = 0; k < count; ++k) include(&r, a * net[k][0] + b * net[k][1]);
    return r;
}

/* A part's image seen along its longer side, and across. */
typedef struct image {
    range along, across;
} image;

static image image_of(const net_point *net, size_t count, const slopes *d)
{
    const double side[2] = {hypot(d->mid[0][0], d->mid[1][0]), hypot(d->mid[0][1], d->mid[1][1])};
    const int k = side[1] > side[0];
    const double a = side[k] > 0 ? d->mid[0][k] / side[k] : 1, b = side[k] > 0 ? d->mid[1][k] / side[k] : 0;
    return (image){hull(net, count, a, b), hull(net, count, -b, a)};
}

/* Whether the part can come within `slack` of the ray. */
static bool may_touch(const image *i, double slack)
{
    return holds_zero(i->along, slack) && holds_zero(i->across, slack);
}

/* At most one root: the derivative deviates from its middle J by less than half of it, |J^-1 (DF - J)| <= 1/2, its
 * rounding `noise` included. Then J^-1 F is nearly the identity, and its hull says well whether there is a root. Where
 * the ray sees the part as a line, near misses are doubtful, and not to be told so well. */
static bool one_at_most(const slopes *d, double noise, double inverse[2][2])
{
    const double det = d->mid[0][0] * d->mid[1][1] - d->mid[0][1] * d->mid[1][0];
    const double sides = hypot(d->mid[0][0], d->mid[1][0]) * hypot(d->mid[0][1], d->mid[1][1]);
    if (!(fabs(det) > edge_on * sides)) return false;
    inverse[0][0] = d->mid[1][1] / det, inverse[0][1] = -d->mid[0][1] / det;
    inverse[1][0] = -d->mid[1][0] / det, inverse[1][1] = d->mid[0][0] / det;
    for (int k = 0; k < 2; ++k) {
        double sum = 0;
        for (int f = 0; f < 2; ++f) sum += fabs(inverse[k][f]) * (d->half[f][0] + d->half[f][1] + noise);
        if (!(sum <= 0.5)) return false;
    }
    return true;
}

/* Newton's method from the middle; true if it ends in the part. */
static bool newton(net_shape s, const net_point *net, double *a, double *b, double *t)
{
    net_point p, pa, pb;
    *a = *b = s.triangle ? 1.0 / 3 : 0.5;
    for (int k = 0; k < 40; ++k) {
        net_evaluate(s, net, *a, *b, p, pa, pb);
        const double det = pa[0] * pb[1] - pb[0] * pa[1];
        const double da = (pb[0] * p[1] - pb[1] * p[0]) / det, db = (pa[1] * p[0] - pa[0] * p[1]) / det;
        *a += da;
        *b += db;
        *t = p[2] / p[3];
        if (!(fabs(*a - 0.5) < 2 && fabs(*b - 0.5) < 2)) return false;
        if (fabs(da) + fabs(db) < 1e-13) return border_of(s, *a, *b) >= -newton_slack;
    }
    return false;
}

static range t_range(const query *q, const net_point *net, size_t count)
{
    range t = nothing;
    for (size_t k = 0; k < count; ++k) include(&t, q->t0 + net[k][2] / net[k][3]);
    return t;
}

static void search(query *q, const net_point *net, const net_part *part)
{
    const net_shape s = q->patch->shape;
    const size_t count = net_count(s);
    const slopes d = slopes_of(s, net);
    double w = 0, inverse[2][2];
    for (size_t k = 0; k < count; ++k) w = fmax(w, net[k][3]);
    const double noise = rounding * w * q->patch->radius, near = w * ORACLE_NEAR * q->patch->radius;
    const image seen = image_of(net, count, &d);

    if (!may_touch(&seen, near)) return;
    if (one_at_most(&d, 2 * (s.m + s.n) * noise, inverse)) {
        double a, b, t;
        if (!may_touch(&seen, noise)) return;
        for (int k = 0; k < 2; ++k) {
            const double slack = noise * (fabs(inverse[k][0]) + fabs(inverse[k][1]));
            if (!holds_zero(hull(net, count, inverse[k][0], inverse[k][1]), slack)) return;
        }
        if (newton(s, net, &a, &b, &t)) {
            add_found(q, part->at[0] + a * part->a[0] + b * part->b[0], part->at[1] + a * part->a[1] + b * part->b[1],
                      q->t0 + t);
            return;
        }
    }
    double legs[3];
    legs_of(q, net, legs);
    const unsigned edge = legs[2] > fmax(legs[0], legs[1]) ? 2 : legs[1] > legs[0];
    const double size = fabs(part->a[0]) + fabs(part->a[1]) + fabs(part->b[0]) + fabs(part->b[1]);
    q->parts += seen.across.low >= -near && seen.across.high <= near ? EDGE_ON_PARTS : 1;
    if (size < smallest || legs[edge] <= ORACLE_NEAR * q->patch->radius || q->parts > SEARCH_PARTS) {
        add_undecided(q, part, t_range(q, net, count));
        return;
    }
    net_point first[count], second[count];
    net_part one, two;
    net_cut(s, net, edge, first, second);
    net_cut_part(s, part, edge, &one, &two);
    search(q, first, &one);
    search(q, second, &two);
}

static void search_piece(query *q, const piece *p)
{
    const size_t count = net_count(q->patch->shape);
    const double dd = dot(q->dir, q->dir), length = sqrt(dd);
    double o[3], n1[3], n2[3];
    for (int c = 0; c < 3; ++c) o[c] = q->org[c] - q->patch->centre[c];
    q->t0 = -dot(o, q->dir) / dd;
    for (int c = 0; c < 3; ++c) o[c] += q->t0 * q->dir[c];

    const int axis = fabs(q->dir[0]) < fabs(q->dir[1])   ? fabs(q->dir[0]) < fabs(q->dir[2]) ? 0 : 2
                     : fabs(q->dir[1]) < fabs(q->dir[2]) ? 1
                                                         : 2;
    const double e[3] = {axis == 0, axis == 1, axis == 2};
    cross(q->dir, e, n1);
    const double l1 = sqrt(dot(n1, n1));
    for (int c = 0; c < 3; ++c) n1[c] /= l1;
    cross(q->dir, n1, n2);
    for (int c = 0; c < 3; ++c) n2[c] /= length;

    net_point net[count];
    for (size_t k = 0; k < count; ++k) {
        double x[3];
        for (int c = 0; c < 3; ++c) x[c] = p->net[k][c] - p->net[k][3] * o[c];
        net[k][0] = dot(n1, x);
        net[k][1] = dot(n2, x);
        net[k][2] = dot(q->dir, x) / dd;
        net[k][3] = p->net[k][3];
    }
    q->parts = 0;
    search(q, net, &p->part);
}

static bool ray_in_box(const query *q, const double lower[3], const double upper[3])
{
    double in = q->tnear, out = q->tfar;
    for (int c = 0; c < 3; ++c) {
        if (q->dir[c] == 0) {
            if (q->org[c] < lower[c] || q->org[c] > upper[c]) return false;
            continue;
        }
        const double a = (lower[c] - q->org[c]) / q->dir[c], b = (upper[c] - q->org[c]) / q->dir[c];
        in = fmax(in, fmin(a, b));
        out = fmin(out, fmax(a, b));
    }
    return in <= out + 1e-12 * (fabs(in) + fabs(out));
}

static void walk(query *q, size_t at)
{
    const node *n = &q->o->nodes[at];
    if (!ray_in_box(q, n->lower, n->upper)) return;
    if (n->right) {
        walk(q, at + 1);
        walk(q, n->right);
        return;
    }
    for (size_t k = n->first; k < n->first + n->count; ++k) {
        const piece *p = &q->o->pieces[k];
        if (!ray_in_box(q, p->lower, p->upper)) continue;
        q->index = p->patch;
        q->patch = &q->o->patches[p->patch];
        search_piece(q, p);
    }
}

static int by_t(const void *a, const void *b)
{
    const oracle_root *r = a, *s = b;
    return (r->t_low > s->t_low) - (r->t_low < s->t_low);
}

size_t oracle_intersect(const oracle *o, const double org[3], const double dir[3], double tnear, double tfar,
                        oracle_root roots[ORACLE_ROOTS])
{
    query q = {.o = o, .org = org, .dir = dir, .tnear = tnear, .tfar = tfar, .roots = roots, .left_out = INFINITY};
    if (o->node_count && dot(dir, dir) > 0) walk(&q, 0);
    qsort(roots, q.count, sizeof *roots, by_t);
    close_list(&q);
    return q.count;
}
