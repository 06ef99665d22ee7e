/* test_certificate.c - is what a leaf's kernels conclude about a ray true?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The rays have roots that are known: each goes through a point of a leaf, or through two, and Newton's method in
 * double says where exactly. So one leaf and its kernels are asked, a cell at a time, and no other cell, leaf or
 * subdivision can make good what they lose. What is lost first, when a bound is too small, are roots for which it is
 * attained: most surfaces here are single powers in the leaf's coordinates, many roots on its border or at an end of a
 * cell, many rays nearly tangent.
 *
 *     test_certificate [RAYS [SEED]] */
#include "embree_patch/polish.h"
#include "test/piece.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t ray_count = 40000, seed = 1;
enum { RAYS_OF_PATCH = 50 };

/* What the kernels promise of a hit (newton_tmpl.h), as numbers of their own: half of what they say must fail here. */
static const double promised_accept = 4, promised_near = 0x1p-5, promised_sharp = 0x1p-18;

/* One leaf, and a ray. */
typedef struct visit {
    EPGeometry geometry;
    piece piece;
    const ep_patch *patch;
    const float *net;
    const ep_kernels *kernels;
    float ray[EP_RAY_FIELDS];
    double o[3], d[3], sum; /* org and dir in leaf coordinates; dir's sum norm in space */
} visit;

typedef struct root {
    double s, t, k; /* k: along the ray */
    double exact;   /* s and t are right to this */
    piece_jet jet;
} root;

typedef struct tally {
    uint64_t rays, roots, none, hit, vague, certain, slow, tangent_hit, tangent_open, cells, cell_hit, cell_open;
    double place, t, normal; /* the largest errors, in units of what is promised */
} tally;

static void ray_to_leaf(visit *v)
{
    const ep_leaf *leaf = v->piece.leaf;
    v->sum = 0;
    for (int row = 0; row < 3; ++row) {
        v->o[row] = v->d[row] = 0;
        for (int c = 0; c < 3; ++c) {
            const double m = leaf->frame[c][row];
            v->o[row] += m * ((double)v->ray[EP_RAY_ORG + c] - leaf->centre[c] - leaf->centre_low[c]);
            v->d[row] += m * v->ray[EP_RAY_DIR + c];
        }
        v->sum += fabs(v->ray[EP_RAY_DIR + row]);
    }
}

/* Newton's method in three unknowns, from (s, t, k). */
static bool find(const visit *v, double s, double t, double k, root *r)
{
    const double start[2] = {s, t};
    double far = 0, step = INFINITY;
    for (int row = 0; row < 3; ++row) far = fmax(far, 1e-2 * piece_noise(&v->piece, row) + 1e-15 * fabs(v->o[row]));
    for (int i = 0; i < 12 && step > 1e-13; ++i) {
        const piece_jet j = piece_at(&v->piece, s, t);
        double f[3], n[3], x[3], y[3];
        for (int c = 0; c < 3; ++c) f[c] = v->o[c] + k * v->d[c] - j.at[c];
        for (int c = 0; c < 3; ++c) {
            const int a = (c + 1) % 3, b = (c + 2) % 3;
            n[c] = j.ds[a] * j.dt[b] - j.ds[b] * j.dt[a];
            x[c] = j.dt[a] * v->d[b] - j.dt[b] * v->d[a];
            y[c] = v->d[a] * j.ds[b] - v->d[b] * j.ds[a];
        }
        double det = 0, ds = 0, dt = 0, dk = 0, size = 0;
        for (int c = 0; c < 3; ++c) {
            det += n[c] * v->d[c];
            ds += x[c] * f[c], dt += y[c] * f[c], dk -= n[c] * f[c];
            size += fabs(x[c]) + fabs(y[c]);
        }
        step = fmax(fabs(ds), fabs(dt)) / fabs(det);
        r->exact = far * size / fabs(det);
        s += ds / det, t += dt / det, k += dk / det;
        if (!(fabs(s - start[0]) < 0.1 && fabs(t - start[1]) < 0.1)) return false;
        r->jet = j;
    }
    *r = (root){s, t, k, fmax(r->exact, 4 * step), r->jet};
    return r->exact < 1e-6;
}

static double distance(const root *a, double s, double t)
{
    return fmax(fabs(a->s - s), fabs(a->t - t));
}

/* How far a hit may be from the root in s, t, for a ray that is followed for `way` in t. */
static double accuracy_at(const visit *v, const root *r, double way)
{
    const ep_leaf *leaf = v->piece.leaf;
    const double p[2] = {v->d[0] / v->d[2], v->d[1] / v->d[2]};
    const double st = leaf->noise_st + leaf->reach * way * v->sum, h = leaf->noise_h + leaf->reach * way * v->sum;
    const double *ds = r->jet.ds, *dt = r->jet.dt;
    const double a = ds[0] - p[0] * ds[2], b = dt[0] - p[0] * dt[2], c = ds[1] - p[1] * ds[2], d = dt[1] - p[1] * dt[2];
    const double det = fabs(a * d - b * c);
    const double i = fmax(fabs(d) + fabs(b), fabs(c) + fabs(a)) / det;
    const double q = fmax(fabs(d * p[0] - b * p[1]), fabs(a * p[1] - c * p[0])) / det;
    const double noise = i * st + q * h;
    /* and a tenth for where in its neighbourhood the kernel takes the tangents */
    const double place = 1.1 * (noise + fmax(noise, promised_accept * leaf->noise_st));
    return v->piece.patch->shape.triangle ? 2 * place : place;
}

/* How long the ray is in the prism, in t: what packets reckon with. */
static double way_of(const visit *v)
{
    const ep_leaf *leaf = v->piece.leaf;
    return (leaf->height + leaf->reach * fabs(v->o[2] / v->d[2]) * v->sum) / fabs(v->d[2]);
}

/* The parameters of a hit, in leaf coordinates. */
static void hit_place(const visit *v, double u, double w, double *s, double *t)
{
    const float *d = v->piece.leaf->domain;
    const double du = u - d[0], dv = w - d[1], det = (double)d[2] * d[3] - (double)d[4] * d[5];
    *s = (du * d[3] - dv * d[4]) / det + piece_corner(&v->piece);
    *t = (dv * d[2] - du * d[5]) / det + piece_corner(&v->piece);
}

/* What floats do to parameters, in leaf coordinates. */
static double parameter_rounding(const visit *v)
{
    const float *d = v->piece.leaf->domain;
    const double det = fabs((double)d[2] * d[3] - (double)d[4] * d[5]);
    return 0x1p-23 * fmax(fabs(d[3]) + fabs(d[4]), fabs(d[2]) + fabs(d[5])) / det;
}

static const char *describe(const visit *v, const root *r)
{
    static char text[400];
    const test_patch *p = v->piece.patch;
    snprintf(text, sizeof text, "%s %u %u: %s: root %.9g %.9g at %.9g", p->shape.triangle ? "triangle" : "tensor",
             p->shape.m, p->shape.n, ray_text(v->ray + EP_RAY_ORG, v->ray + EP_RAY_DIR), r->s, r->t, r->k);
    return text;
}

/* The largest error of a normal whose tangents differ from the surface's by what `twist` allows, for both together,
 * over the way that they are carried; by `bend` times how far the hit is away; and by rounding. */
static double normal_limit(const visit *v, const root *r, double place)
{
    const ep_leaf *leaf = v->piece.leaf;
    const double horner = 2 * (leaf->degree_s + leaf->degree_t) + 3;
    double off[3], a[3], most = 0;
    for (int c = 0; c < 3; ++c) {
        const double twist = c < 2 ? leaf->twist_st : leaf->twist_h, bend = c < 2 ? leaf->bend_st : leaf->bend_h;
        a[c] = fmax(fabs(r->jet.ds[c]), fabs(r->jet.dt[c]));
        off[c] = 1.5 * twist * promised_near * promised_near + bend * place +
                 0x1p-24 * (horner * horner * bend + 8 * (1 + a[c]));
    }
    for (int c = 0; c < 3; ++c) {
        const int k = (c + 1) % 3, l = (c + 2) % 3;
        most = fmax(most, off[k] * a[l] + off[l] * a[k] + off[k] * off[l]);
    }
    return most;
}

/* S_s x S_t in leaf coordinates, from Ng. */
static void normal_in_leaf(const visit *v, const float *ng, double n[3])
{
    const ep_leaf *leaf = v->piece.leaf;
    double m[3][3], det = 0; /* rows of M */
    for (int row = 0; row < 3; ++row)
        for (int c = 0; c < 3; ++c) m[row][c] = leaf->frame[c][row];
    double cof[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            cof[i][j] = m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3] -
                        m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3];
    for (int j = 0; j < 3; ++j) det += m[0][j] * cof[0][j];
    /* Ng = volume M^T n */
    for (int i = 0; i < 3; ++i) {
        n[i] = 0;
        for (int j = 0; j < 3; ++j) n[i] += cof[i][j] * ng[j] / (det * leaf->volume);
    }
}

/* How fast the ray comes away from the surface at a root. */
static double speed(const visit *v, const root *r)
{
    double nn = 0, nd = 0;
    for (int c = 0; c < 3; ++c) {
        const int a = (c + 1) % 3, b = (c + 2) % 3;
        const double x = r->jet.ps[a] * r->jet.pt[b] - r->jet.ps[b] * r->jet.pt[a];
        nn += x * x;
        nd += x * (double)v->ray[EP_RAY_DIR + c];
    }
    return fabs(nd) / sqrt(nn);
}

/* A hit that is not vague: there is a root, it is where the hit is, and the normal is the surface's. */
static void check_hit(const visit *v, float k, const float hit[5], double radius, double way, tally *tally)
{
    double s, t;
    root r;
    hit_place(v, hit[EP_HIT_U], hit[EP_HIT_V], &s, &t);
    CHECK(find(v, s, t, k, &r), "no root at a hit: %s: %.9g %.9g at %.9g", ray_text(v->ray, v->ray + EP_RAY_DIR), s, t,
          k);
    const double rounding = parameter_rounding(v) + r.exact, place = fmin(accuracy_at(v, &r, way), radius);
    const double off = fmax(distance(&r, s, t) - rounding, 0);
    CHECK(off <= place, "%s: hit is %.3g away, not %.3g", describe(v, &r), off, place);
    CHECK(piece_inside(&v->piece, r.s, r.t) >= -place - r.exact, "%s: outside", describe(v, &r));
    tally->place = fmax(tally->place, off / place);

    /* how far the point of the ray is from the surface: what epGetHitError says, which is for all of the patch */
    const double apart = fabs(k - r.k) * speed(v, &r);
    const double error = epGetHitError(v->geometry, 0, v->ray + EP_RAY_ORG, v->ray + EP_RAY_DIR, k);
    CHECK(apart <= error, "%s: t is %.9g, by %.3g from the surface, not %.3g", describe(v, &r), k, apart, error);
    tally->t = fmax(tally->t, apart / error);

    double n[3], wrong = 0;
    normal_in_leaf(v, hit + EP_HIT_NG, n);
    const double limit = normal_limit(v, &r, place);
    for (int c = 0; c < 3; ++c) {
        const int a1 = (c + 1) % 3, b1 = (c + 2) % 3;
        wrong = fmax(wrong, fabs(n[c] - (r.jet.ds[a1] * r.jet.dt[b1] - r.jet.ds[b1] * r.jet.dt[a1])));
    }
    /* the frame's inverse loses as much as it is skew */
    CHECK(wrong <= limit, "%s: normal is off by %.3g, not %.3g", describe(v, &r), wrong, limit);
    tally->normal = fmax(tally->normal, wrong / limit);
}

/* A hit that is vague, but certain: there is a root, in the leaf and between tnear and tfar. */
static void check_certain(const visit *v, float k, const float hit[5], tally *tally)
{
    double s, t;
    root r;
    hit_place(v, hit[EP_HIT_U], hit[EP_HIT_V], &s, &t);
    CHECK(find(v, s, t, k, &r), "no root at a certain hit: %s: %.9g %.9g at %.9g",
          ray_text(v->ray, v->ray + EP_RAY_DIR), s, t, k);
    const double error = 0x1p-45 * fabs(r.k);
    CHECK(piece_inside(&v->piece, r.s, r.t) >= -r.exact && r.k > (double)v->ray[EP_RAY_TNEAR] - error &&
              r.k < (double)v->ray[EP_RAY_TFAR] + error,
          "%s: outside", describe(v, &r));
    ++tally->certain;
}

/* Whether a hit, that may be vague, is the root: as offer.c and search.c go on with it. */
typedef enum found { FOUND, ANOTHER, LOOKED_FOR } found;

static found is_root(const visit *v, float *k, float hit[5], bool vague, double radius, const root *r)
{
    double s, t, exact[2];
    if (vague) {
        const ep_polished p =
            ep_polish(v->patch, v->piece.leaf, v->ray + EP_RAY_ORG, v->ray + EP_RAY_DIR, k, hit, exact);
        if (p == EP_POLISHED_LOST) return LOOKED_FOR;
        if (p == EP_POLISHED_AWAY) return ANOTHER;
        radius = 0x1p-20;
    }
    hit_place(v, hit[EP_HIT_U], hit[EP_HIT_V], &s, &t);
    /* or which leaf is met first would decide whose bits the hit has */
    const double beside = -piece_inside(&v->piece, s, t), most = promised_sharp + 4 * parameter_rounding(v);
    CHECK(!vague || beside <= most, "%s: a root %.3g outside the leaf", describe(v, r), beside);
    return distance(r, s, t) <= radius + 2 * parameter_rounding(v) + 2 * r->exact ? FOUND : ANOTHER;
}

/* Whether a root is certainly behind tnear: by more than its t may be off. */
static bool is_ahead(const visit *v, const root *r)
{
    const double error = epGetHitError(v->geometry, 0, v->ray + EP_RAY_ORG, v->ray + EP_RAY_DIR, (float)r->k);
    return r->k - (double)v->ray[EP_RAY_TNEAR] > 0x1p-22 * r->k + error / speed(v, r);
}

static void check_single(const visit *v, const root *roots, size_t count, tally *tally)
{
    EPCounters counters = {0};
    float k, hit[5];
    const double way = way_of(v);
    const ep_outcome o = v->kernels->single[v->piece.leaf->shape](v->piece.leaf, v->net, v->ray, &k, hit, &counters);
    tally->none += !o.hit && !o.vague && !o.slow;
    tally->slow += o.slow != 0;
    tally->hit += o.hit || o.vague;
    tally->vague += o.vague != 0;
    if (o.slow) return;
    if (o.hit && !o.vague) check_hit(v, k, hit, INFINITY, way, tally);
    if (o.hit && o.vague) check_certain(v, k, hit, tally);
    for (size_t i = 0; i < count; ++i) {
        if (!is_ahead(v, &roots[i])) continue;
        CHECK(o.hit || o.vague, "%s: certified to miss", describe(v, &roots[i]));
        float k2 = k, hit2[5];
        memcpy(hit2, hit, sizeof hit2);
        const found f = is_root(v, &k2, hit2, o.vague, accuracy_at(v, &roots[i], way), &roots[i]);
        CHECK(f != ANOTHER, "%s: another is certified to be the only one, at %.9g%s", describe(v, &roots[i]), k,
              o.vague ? ", vague" : "");
    }
}

/* What the tangent kernel says of any ray: each hit is a root, and all roots behind tnear are among them. */
static void check_tangent(const visit *v, const root *roots, size_t count, tally *tally)
{
    const double tnear = v->ray[EP_RAY_TNEAR];
    float k[2][EP_PACKET], hits[2][5 * EP_PACKET];
    ep_roots out = {.t = {k[0], k[1]}, .hits = {hits[0], hits[1]}};
    v->kernels->tangent[v->piece.leaf->shape](v->piece.leaf, v->net, v->ray, 1, 1, &out);
    tally->tangent_open += out.open;
    if (out.open) return;
    for (unsigned slot = 0; slot < 2; ++slot) {
        tally->tangent_hit += out.hit[slot] | out.vague[slot];
        if (out.hit[slot] && out.vague[slot]) check_certain(v, k[slot][0], hits[slot], tally);
        if (out.hit[slot] && !out.vague[slot])
            check_hit(v, k[slot][0], hits[slot], out.radius[slot][0], way_of(v), tally);
    }
    for (size_t i = 0; i < count; ++i) {
        bool answered = roots[i].k - tnear <= 0x1p-22 * roots[i].k;
        for (unsigned slot = 0; slot < 2; ++slot) {
            if (!out.hit[slot] && !out.vague[slot]) continue;
            float t = k[slot][0], hit[5];
            memcpy(hit, hits[slot], sizeof hit);
            answered |= is_root(v, &t, hit, out.vague[slot], out.radius[slot][0], &roots[i]) != ANOTHER;
        }
        CHECK(answered, "%s: not among the %u that a tangent ray is certified to have", describe(v, &roots[i]),
              (out.hit[0] | out.vague[0]) + (out.hit[1] | out.vague[1]));
    }
}

/* Whether cell c answers for the root: has found it, or asks for a closer look. */
static bool cell_answers(const visit *v, const ep_cells *cells, unsigned c, const root *r, char why[100])
{
    float k = cells->t[c], hit[5];
    for (unsigned f = 0; f < 5; ++f) hit[f] = cells->fields[f * EP_PACKET + c];
    const double middle = cells->middle[c], reach = cells->reach[c];
    const bool vague = cells->vague >> c & 1;
    if ((cells->open | cells->more) >> c & 1) return true;
    snprintf(why, 100, "none in %.9g +- %.3g", middle, reach);
    if (!((cells->hit | cells->vague) >> c & 1)) return false;
    const found f = is_root(v, &k, hit, vague, cells->radius[c], r);
    snprintf(why, 100, "another%s, at %.9g, in %.9g +- %.3g", vague ? ", vague" : "", k, middle, reach);
    return f != ANOTHER || (vague && !(fabs(k - middle) <= 3 * reach));
}

/* All four rays are the same, with other parts of its way. A root belongs to the cell in which it is; or, where cells
 * meet to within the rounding of t, to any of those. */
static void check_cells(const visit *v, const root *roots, size_t count, const float *from, const float *to,
                        tally *tally)
{
    static const unsigned lanes[EP_PACKET / EP_CELLS] = {0};
    ep_cells cells;
    v->kernels->cells[v->piece.leaf->shape](v->piece.leaf, v->net, v->ray, 1, lanes, EP_PACKET / EP_CELLS, from, to,
                                            &cells);
    for (unsigned c = 0; c < EP_PACKET; ++c) {
        if (cells.hopeless >> c / EP_CELLS * EP_CELLS & 1) continue;
        const bool hit = cells.hit >> c & 1, vague = cells.vague >> c & 1;
        const double way = cells.reach[c] * 2.0 * EP_CELLS / ((double)to[c / EP_CELLS] - from[c / EP_CELLS]);
        float fields[5];
        for (unsigned f = 0; f < 5; ++f) fields[f] = cells.fields[f * EP_PACKET + c];
        ++tally->cells;
        tally->cell_hit += hit || vague;
        tally->cell_open += (cells.open | cells.more) >> c & 1;
        if (hit) check_hit(v, cells.t[c], fields, cells.radius[c], way, tally);
    }
    for (unsigned ray = 0; ray < EP_PACKET; ray += EP_CELLS)
        for (size_t i = 0; i < count; ++i) {
            const root *r = &roots[i];
            const double band = 0x1p-22 * r->k + r->exact;
            const unsigned last = ray + EP_CELLS - 1;
            unsigned asked = 0, answers = 0;
            char why[100] = "";
            if (cells.hopeless >> ray & 1) continue;
            for (unsigned c = ray; c < ray + EP_CELLS; ++c) {
                const double off = fabs(r->k - cells.middle[c]) - cells.reach[c];
                if (off > band) continue;
                const bool answer = cell_answers(v, &cells, c, r, why);
                CHECK(answer || off > -band, "%s: %s", describe(v, r), why);
                ++asked;
                answers += answer;
            }
            const bool begun = from[ray / EP_CELLS] <= -1 || (double)cells.middle[ray] - cells.reach[ray] < r->k - band;
            const bool ended = to[ray / EP_CELLS] >= 1 || r->k + band < (double)cells.middle[last] + cells.reach[last];
            CHECK(answers || !begun || !ended, "%s: %s", describe(v, r), asked ? why : "in no cell");
        }
}

/* Parts of the ray's way whose cells have the root near one of their ends, or anywhere. */
static void choose_cells(const visit *v, rng *r, const root *root, float *from, float *to)
{
    static const unsigned lane = 0;
    ep_cells cells;
    const float begin = -1, end = 1;
    v->kernels->cells[v->piece.leaf->shape](v->piece.leaf, v->net, v->ray, 1, &lane, 1, &begin, &end, &cells);
    const double first = (double)cells.middle[0] - cells.reach[0];
    const double length = (double)cells.middle[EP_CELLS - 1] + cells.reach[EP_CELLS - 1] - first;
    const double at = 2 * (root->k - first) / length - 1;
    for (unsigned k = 0; k < EP_PACKET / EP_CELLS; ++k) {
        const double size = 2 * pow(EP_CELLS, -(double)rng_below(r, 5)) * rng_in(r, 0.5, 1) / EP_CELLS;
        const double place = rng_below(r, 3) ? rng_below(r, 2) + rng_sign(r) * rng_scale(r, 1e-7, 0.3) : rng_unit(r);
        from[k] = (float)(at - size * (rng_below(r, EP_CELLS) + place));
        to[k] = (float)(from[k] + size * EP_CELLS);
    }
    if (rng_below(r, 2)) from[0] = begin, to[0] = end;
}

/* Adds size s^i t^j along an axis. */
static void add_along(test_patch *p, unsigned i, unsigned j, double size, const double axis[3])
{
    const double x[3] = {size * axis[0], size * axis[1], size * axis[2]};
    add_power(p, i, j, x);
}

/* A surface that is a plane but for one or a few powers. */
static void power_patch(rng *r, test_patch *p)
{
    static const double magnitude[3] = {0.8, 0.8, 2};
    const unsigned degree = 2 + rng_below(r, 3);
    const bool few = rng_below(r, 4) == 0;
    double axes[3][3];
    skew_axes(r, rng_scale(r, 0.03, 0.5), axes);
    zero_patch((net_shape){rng_below(r, 2), degree, degree}, p);
    for (int k = 0; k < 2; ++k) add_along(p, k == 0, k == 1, rng_below(r, 2) ? 1 : rng_scale(r, 0.1, 1), axes[k]);
    const int only = (int)rng_below(r, 4); /* 3: both, and the height */
    for (int c = 0; c < 3; ++c) {
        if (!few && only < 3 && c != only && c != 2) continue;
        const unsigned order = 2 + rng_below(r, degree - 1), i = rng_below(r, order + 1);
        add_along(p, i, order - i, magnitude[c] * rng_scale(r, 1e-3, 1), axes[c]);
    }
    if (rng_below(r, 4) == 0) {
        const double offset[3] = {rng_in(r, -30, 30), rng_in(r, -30, 30), rng_in(r, -30, 30)};
        move_patch(p, 1, offset);
    }
}

/* Sides so skew that rounding in the leaf's coordinates is large, and a parametrisation so far from the model that
 * Newton's last step, which may be as long as rounding allows, is long. */
static void skew_patch(rng *r, test_patch *p)
{
    double axes[3][3];
    const double skew = rng_scale(r, 0.02, 0.08);
    skew_axes(r, 0.2, axes);
    for (int c = 0; c < 3; ++c) axes[1][c] = axes[0][c] + skew * axes[1][c];
    zero_patch((net_shape){rng_below(r, 2), 3, 3}, p);
    const double size = rng_scale(r, 0.05, 0.4);
    for (unsigned k = 0; k < 2; ++k) {
        add_along(p, k == 0, k == 1, 1, axes[k]);
        add_along(p, k == 0 ? 3 : 0, k == 1 ? 3 : 0, size, axes[k]);
    }
}

static void any_patch(rng *r, test_patch *p)
{
    static const patch_limits limits[] = {{4, 1}, {9, 1}, {3, 50}, {5, 3}, {15, 1}};
    random_patch(r, (patch_style)rng_below(r, STYLE_DEGENERATE), rng_below(r, 2), limits[rng_below(r, 5)], p);
}

/* A place of the leaf, many of them on its border or next to it. */
static void choose_place(const piece *p, rng *r, double x[2])
{
    for (int c = 0; c < 2; ++c) x[c] = rng_unit(r);
    if (p->patch->shape.triangle && x[0] + x[1] > 1) x[0] = 1 - x[0], x[1] = 1 - x[1];
    const unsigned side = rng_below(r, 8);
    const double inset = rng_below(r, 2) ? rng_scale(r, 1e-9, 1e-2) : 0;
    if (side < 4) x[side / 2] = side % 2 && !p->patch->shape.triangle ? 1 - inset : inset;
    if (side == 3 && p->patch->shape.triangle) x[1] = 1 - x[0] - inset;
    if (side == 4) x[0] = inset, x[1] = inset;
    for (int c = 0; c < 2; ++c) x[c] += piece_corner(p);
}

/* Leaf coordinates' first two axes in space. */
static void plane_of(const ep_leaf *leaf, double axis[2][3])
{
    double det = 0;
    for (int k = 0; k < 2; ++k)
        for (int c = 0; c < 3; ++c) {
            const int a = (c + 1) % 3, b = (c + 2) % 3, row = (k + 1) % 3, next = (k + 2) % 3;
            axis[k][c] =
                (double)leaf->frame[a][row] * leaf->frame[b][next] - (double)leaf->frame[b][row] * leaf->frame[a][next];
            det += k ? 0 : axis[k][c] * leaf->frame[c][0];
        }
    for (int k = 0; k < 2; ++k)
        for (int c = 0; c < 3; ++c) axis[k][c] /= det;
}

/* A ray through the piece's point at x; if not steep, nearly tangent more often than not, or through another point next
 * to it, or along the leaf's plane. */
static void choose_ray(visit *v, rng *r, bool steep, const double x[2], double y[2])
{
    const piece_jet j = piece_at(&v->piece, x[0], x[1]);
    const double angle = (rng_below(r, 2) ? rng_below(r, 8) / 8.0 : rng_unit(r)) * 6.283185307179586;
    double n[3], nn = 0, d[3], org[3], dir[3];
    for (int c = 0; c < 3; ++c) {
        n[c] = j.ps[(c + 1) % 3] * j.pt[(c + 2) % 3] - j.ps[(c + 2) % 3] * j.pt[(c + 1) % 3];
        nn += n[c] * n[c];
    }
    const double lift = rng_sign(r) * rng_scale(r, steep ? 1 : 1e-3, 10), apart = rng_scale(r, 1e-5, 1);
    const double away = rng_below(r, 8) ? rng_scale(r, 0.5, 8) : rng_scale(r, 8, 1000);
    y[0] = x[0] + apart * cos(angle), y[1] = x[1] + apart * sin(angle);
    for (int c = 0; c < 3; ++c) d[c] = cos(angle) * j.ps[c] + sin(angle) * j.pt[c] + lift * n[c] / sqrt(sqrt(nn));
    if (!steep && rng_below(r, 2)) {
        const piece_jet k = piece_at(&v->piece, y[0], y[1]);
        for (int c = 0; c < 3; ++c) d[c] = (k.p[c] - j.p[c]) / apart;
    } else if (!steep && !rng_below(r, 8)) {
        double axis[2][3];
        plane_of(v->piece.leaf, axis);
        for (int c = 0; c < 3; ++c) d[c] = cos(angle) * axis[0][c] + sin(angle) * axis[1][c];
    }
    for (int c = 0; c < 3; ++c) {
        org[c] = (float)(j.p[c] - away * d[c]);
        dir[c] = (float)(j.p[c] - org[c]);
        v->ray[EP_RAY_ORG + c] = (float)org[c];
        v->ray[EP_RAY_DIR + c] = (float)dir[c];
    }
    v->ray[EP_RAY_TNEAR] = 0;
    v->ray[EP_RAY_TFAR] = INFINITY;
}

/* The roots at two places, as far as they are certain, in the leaf and different. */
static size_t certain_roots(const visit *v, const double x[2], const double y[2], root roots[2])
{
    size_t n = 0;
    for (int i = 0; i < 2; ++i) {
        const double *at = i ? y : x;
        const piece_jet j = piece_at(&v->piece, at[0], at[1]);
        double k = 0, dd = 0;
        for (int c = 0; c < 3; ++c) {
            k += v->d[c] * (j.at[c] - v->o[c]);
            dd += v->d[c] * v->d[c];
        }
        root *r = &roots[n];
        if (!find(v, at[0], at[1], k / dd, r) || piece_inside(&v->piece, r->s, r->t) < r->exact || !(r->k > 0))
            continue;
        if (n && distance(&roots[0], r->s, r->t) <= 4 * (r->exact + roots[0].exact)) continue;
        ++n;
    }
    return n;
}

typedef enum family { POWERS, SKEW, ANY } family;

static void check_patch(uint64_t index, family family, tally *tally)
{
    rng r = rng_split(seed, family, index);
    const char *const *isas = epGetInstructionSets();
    unsigned isa_count = 0;
    while (isas[isa_count]) ++isa_count;
    test_patch p;
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.maxDepth = family == ANY ? rng_below(&r, 9) : 0;
    if (family == POWERS) power_patch(&r, &p);
    else if (family == SKEW) skew_patch(&r, &p);
    else any_patch(&r, &p);
    EPGeometry g = new_geometry(&p, 1, &settings);
    const ep_hierarchy *h = &g->hierarchy;
    for (int i = 0; i < RAYS_OF_PATCH; ++i) {
        const size_t leaf = rng_below(&r, (unsigned)h->leaf_count);
        if (!(h->leaves[leaf].height < INFINITY)) continue;
        visit v = {.geometry = g,
                   .piece = piece_of(&p, h, leaf),
                   .patch = &h->patches[0],
                   .net = h->nets + h->leaves[leaf].net,
                   .kernels = ep_find_kernels(isas[index % isa_count])};
        double x[2], y[2];
        root roots[2];
        choose_place(&v.piece, &r, x);
        choose_ray(&v, &r, family == SKEW, x, y);
        ray_to_leaf(&v);
        const size_t count = certain_roots(&v, x, y, roots);
        ++tally->rays;
        tally->roots += count;
        if (!count) continue;
        float from[EP_PACKET / EP_CELLS], to[EP_PACKET / EP_CELLS];
        check_single(&v, roots, count, tally);
        check_tangent(&v, roots, count, tally);
        visit later = v; /* from next to a root, or from within the prism */
        const root *near = &roots[rng_below(&r, (unsigned)count)];
        later.ray[EP_RAY_TNEAR] = (float)fmax(0, near->k - rng_scale(&r, 1e-6, 1) * way_of(&v));
        check_single(&later, roots, count, tally);
        check_tangent(&later, roots, count, tally);
        if (count == 2) { /* leaving the first one, towards the second */
            const double first = fmin(roots[0].k, roots[1].k), between = fabs(roots[1].k - roots[0].k);
            later.ray[EP_RAY_TNEAR] = (float)(first + rng_scale(&r, 1e-6, 0.9) * between);
            check_single(&later, roots, count, tally);
        }
        choose_cells(&v, &r, &roots[rng_below(&r, (unsigned)count)], from, to);
        check_cells(&v, roots, count, from, to, tally);
    }
    epReleaseGeometry(g);
}

static void check_patches(family family, uint64_t rays)
{
    tally t = {0};
    for (uint64_t k = 0; k < rays / RAYS_OF_PATCH; k += TEST_STEP) check_patch(k, family, &t);
    print_message("%.0f rays, %.0f roots; none %.0f, hit %.0f, vague %.0f, slow %.0f, vague and certain %.0f\n",
                  (double)t.rays, (double)t.roots, (double)t.none, (double)t.hit, (double)t.vague, (double)t.slow,
                  (double)t.certain);
    print_message("tangent kernel: hit %.0f, open %.0f\n", (double)t.tangent_hit, (double)t.tangent_open);
    print_message("%.0f cells, hit %.0f, open %.0f; errors of what is promised: place %.2g, t %.2g, normal %.2g\n",
                  (double)t.cells, (double)t.cell_hit, (double)t.cell_open, t.place, t.t, t.normal);
    assert_true(t.roots > t.rays / 2 && t.hit > t.roots / 10 && t.tangent_hit > t.roots / 10 &&
                t.cell_hit > t.roots / 3);
}

static void powers(void **state)
{
    (void)state;
    check_patches(POWERS, ray_count);
}

static void skew_sides(void **state)
{
    (void)state;
    check_patches(SKEW, ray_count / 2);
}

static void patches(void **state)
{
    (void)state;
    check_patches(ANY, ray_count / 2);
}

int main(int argc, char **argv)
{
    if (argc > 1) ray_count = strtoull(argv[1], NULL, 10);
    if (argc > 2) seed = strtoull(argv[2], NULL, 10);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(powers),
        cmocka_unit_test(skew_sides),
        cmocka_unit_test(patches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
