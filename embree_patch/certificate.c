/* certificate.c - what certifies the hits of a leaf that is kept: the model's errors, and rounding. See leaf.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Half of the pieces that are fitted are split again; what does not decide about that is computed here, for the others.
 */
#include "embree_patch/leaf.h"
#include "embree_patch/taylor.h"

#include <string.h>

static double largest_entry(ep_vec3 a)
{
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}

/* Of the frame. */
static double largest_in_rows(const ep_fit *f)
{
    return fmax(largest_entry(f->row[0]), fmax(largest_entry(f->row[1]), largest_entry(f->row[2])));
}

/* Sum of |coefficient c| times its monomial's maximum, (each + its degree if `degrees`) times. */
static double magnitude(const ep_fit *f, const ep_point *net, unsigned m, unsigned n, int c, unsigned each,
                        bool degrees)
{
    double sum = 0;
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= m; ++i) {
            const size_t at = f->kind->index(m, n, i, j);
            if (at != SIZE_MAX) sum += (each + degrees * (i + j)) * fabs(net[at][c]) * ep_monomial(f, i, j);
        }
    return sum;
}

/* What Horner's scheme with fused multiply-adds may be off by, in eps: (i, j) is rounded as a coefficient, where it is
 * added, i times more in s, then where its row is added, j times more in t. */
static double horner(const ep_fit *f, const ep_point *net, unsigned m, unsigned n, int c)
{
    return magnitude(f, net, m, n, c, 3, true);
}

/* The largest contribution to a coordinate of the terms that a series of degree (m, n) has no place for. */
static double beyond(const ep_fit *f, unsigned m, unsigned n)
{
    double largest = 0;
    for (int c = 0; c < 4; ++c) {
        double sum = 0;
        for (unsigned j = 0; j <= f->n; ++j)
            for (unsigned i = 0; i <= f->m; ++i) {
                const size_t at = f->kind->index(f->m, f->n, i, j);
                if (at == SIZE_MAX || f->kind->index(m, n, i, j) != SIZE_MAX) continue;
                sum += fabs(f->series[at][c]) * ep_monomial(f, i, j);
            }
        largest = fmax(largest, sum);
    }
    return largest;
}

/* The kernel needs no term that is lost in one rounding of a coordinate: small pieces of surfaces of high degree, and
 * of surfaces that are less curved than their degree allows, get by with fewer. Returns what is left out. */
static double reduce(ep_fit *f)
{
    ep_leaf *leaf = &f->leaf;
    const bool triangle = f->kind == &ep_kinds[EP_KIND_TRIANGLE];
    unsigned m = f->m, n = f->n;
    while (m > 1 && beyond(f, m - 1, triangle ? m - 1 : n) <= EP_EPS_F) --m;
    if (triangle) n = m;
    while (!triangle && n > 1 && beyond(f, m, n - 1) <= EP_EPS_F) --n;
    const double lost = beyond(f, m, n);
    /* a weight that is one to within a rounding is one */
    const double off = magnitude(f, f->series, f->m, f->n, 3, 1, false) - 1;
    if (leaf->rational && off <= EP_EPS_F) leaf->rational = 0;
    const unsigned special = m > n ? m : n;
    if (special <= EP_SPECIAL_DEGREES) m = n = special;
    leaf->degree_s = (uint8_t)m;
    leaf->degree_t = (uint8_t)n;
    leaf->shape = (uint8_t)((triangle * 2u + leaf->rational) * (EP_SPECIAL_DEGREES + 1) +
                            (special <= EP_SPECIAL_DEGREES ? special : 0));
    f->net_floats = ep_leaf_stride(leaf) * f->kind->point_count(m, n);
    return lost + fmax(off, 0) * !leaf->rational;
}

/* Coordinate c of `series` as far as its terms go. */
static ep_taylor taylor_of(const ep_fit *f, int c)
{
    ep_taylor a = {{0}, 0};
    for (unsigned j = 0; j <= f->n; ++j)
        for (unsigned i = 0; i <= f->m; ++i) {
            const size_t at = f->kind->index(f->m, f->n, i, j);
            if (at == SIZE_MAX) continue;
            if (i + j <= EP_TAYLOR_DEGREE) a.c[ep_taylor_index(i, j)] = f->series[at][c];
            else a.rest += fabs(f->series[at][c]) * ep_monomial(f, i, j);
        }
    return a;
}

/* H x²/2 for the second derivatives of coordinate c; squares: x_s², x_s x_t, x_t². */
static ep_taylor half_form(const ep_leaf *leaf, int c, const ep_taylor squares[3])
{
    const ep_taylor none = {{0}, 0};
    ep_taylor r = ep_taylor_add(&none, leaf->half[0][c], &squares[0]);
    r = ep_taylor_add(&r, 2.0 * leaf->half[1][c], &squares[1]);
    return ep_taylor_add(&r, leaf->half[2][c], &squares[2]);
}

static void square(const ep_taylor x[2], const ep_monomials *m, ep_taylor squares[3])
{
    squares[0] = ep_taylor_multiply(&x[0], &x[0], m);
    squares[1] = ep_taylor_multiply(&x[0], &x[1], m);
    squares[2] = ep_taylor_multiply(&x[1], &x[1], m);
}

/* How far the model may be off, whose own middle is where it errs least. The graph: r_h - middle - H_h u²/2 over the
 * feet u = x + r_st. The foot: x less what w_over makes of u. Bounds on r's derivatives would not do: what distortion
 * adds to r_h is in u too, and cancels. */
static void model(ep_fit *f, double lost)
{
    ep_leaf *leaf = &f->leaf;
    static const ep_monomials square_piece = {.corners = 4, .corner = {{-.5, -.5}, {.5, -.5}, {.5, .5}, {-.5, .5}}},
                              triangle_piece = {
                                  .corners = 3,
                                  .corner = {{-1.0 / 3, -1.0 / 3}, {2.0 / 3, -1.0 / 3}, {-1.0 / 3, 2.0 / 3}}};
    ep_monomials m = f->kind == &ep_kinds[EP_KIND_TRIANGLE] ? triangle_piece : square_piece;
    for (unsigned d = 0, n = 0; d <= EP_TAYLOR_DEGREE; ++d)
        for (unsigned j = 0; j <= d; ++j, ++n) m.max[n] = f->kind->monomial(d - j, j);

    ep_taylor surface[3], squares[3];
    for (int c = 0; c < 3; ++c) surface[c] = taylor_of(f, c);
    if (leaf->rational) {
        const ep_taylor weight = taylor_of(f, 3);
        for (int c = 0; c < 3; ++c) surface[c] = ep_taylor_divide(&surface[c], &weight, f->weight_low, &m);
    }
    square(surface, &m, squares);
    const ep_taylor arc = half_form(leaf, 2, squares);
    const ep_taylor left = ep_taylor_add(&surface[2], -1, &arc);
    const ep_range graph = ep_taylor_range(&left, &m);
    leaf->middle = (float)ep_mid(graph);
    leaf->graph = ep_round_up(fmax(graph.hi - leaf->middle, leaf->middle - graph.lo) + lost);

    const ep_taylor m_u[2] = {half_form(leaf, 0, squares), half_form(leaf, 1, squares)};
    double foot = 0;
    for (unsigned c = 0; c < 2; ++c) {
        ep_taylor x = ep_taylor_add(&surface[c], -1, &m_u[c]);
        x.c[ep_taylor_index(1 - c, c)] -= 1;
        foot = fmax(foot, ep_mag(ep_taylor_range(&x, &m)));
    }
    /* and what the kernels' arithmetic adds to two dozen terms below this */
    leaf->foot = ep_round_up(foot + lost + 32 * EP_EPS_F * (1 + 2 * f->side));
}

/* Rounding of F in leaf coordinates; eps = 2^-24.
 *
 * The series errs by `horner`; a quotient adds the same for its denominator, times the value, which is at most one, and
 * two. The moved origin is right to 2 eps of itself, and M adds 3 eps of the terms that it adds up: 5 eps of those of
 * the hit, which is in the prism, and of the way from the one to the other, which is on the ray's account below. Adding
 * x - M(o') and r takes 2 eps of two at most, each. */
static void rounding(ep_fit *f, double lost)
{
    const ep_patch *p = f->patch;
    ep_leaf *leaf = &f->leaf;
    double error[3], moved[3], origin[3], total[3];
    for (int c = 0; c < 3; ++c) {
        if (leaf->rational)
            error[c] = (horner(f, f->series, f->m, f->n, c) + horner(f, f->series, f->m, f->n, 3)) / f->weight_low + 2;
        else error[c] = horner(f, f->rest, ep_rest_m(f), ep_rest_n(f), c);
        error[c] *= EP_EPS_F;
    }
    const double *a = &f->column[0].x, *b = &f->column[1].x, *h = &f->column[2].x;
    const double span = (f->kind == &ep_kinds[EP_KIND_TRIANGLE] ? 2 : 1) * (f->kind->middle + f->side);
    for (int k = 0; k < 3; ++k) moved[k] = span * (fabs(a[k]) + fabs(b[k])) + leaf->height * fabs(h[k]);
    /* the series was computed in double from points of the size of the patch, anywhere in space */
    const double far = fabs(p->centre[0]) + fabs(p->centre[1]) + fabs(p->centre[2]);
    const double made = 16 * EP_EPS_D * far + f->loss * p->radius;
    for (int c = 0; c < 3; ++c) {
        const double row[3] = {fabs(f->row[c].x), fabs(f->row[c].y), fabs(f->row[c].z)};
        const double frame_sum = row[0] * moved[0] + row[1] * moved[1] + row[2] * moved[2];
        origin[c] = 5 * EP_EPS_F * frame_sum;
        total[c] = error[c] + lost + origin[c] + ep_norm1(f->row[c]) * made;
        if (c < 2) total[c] += 4 * EP_EPS_F;
        total[c] *= 1 + 0x1p-10;
    }
    /* a hit's, whose ray may come from as far beside the leaf as that is long */
    f->error =
        (ep_norm1(f->column[0]) + ep_norm1(f->column[1])) * fmax(total[0] + 2 * origin[0], total[1] + 2 * origin[1]) +
        ep_norm1(f->column[2]) * (total[2] + 2 * origin[2]);
    leaf->noise_st = ep_round_up(fmax(total[0], total[1]));
    leaf->noise_h = ep_round_up(total[2]);
}

/* What the rays add, those for which a leaf's constants hold (leaf.h).
 *
 * The plane's point from the unmoved origin: both o and t d are in it, 5 eps each; o is as long as t d but for the
 * piece's size: 12 eps of far = |t| |d| in all. By so much is a foot on the plane off, and by_foot times as much the
 * graph's equation.
 *
 * Through the prism a ray goes no farther than (height + reach far) (|p| C_st + C_h), C being what leaf coordinates are
 * in space. Its direction in leaf coordinates is right to 3 eps of its terms and p to 2 more, and the moved origin to 5
 * eps of what it is beside the hit: F's noise grows by 10 eps of that way. All lengths are sum norms, of which a row of
 * M makes no more than its largest entry.
 *
 * The plane's point and the way p tau are no longer than `along`. c0, c1 tau and c2 tau² of the graph's equation are
 * right to a few roundings of terms below bend_h along² and 2 high; convex in reach far, so below a straight line. The
 * foot is right to 4 eps of `along`, and so is its H_st, to 4 eps of bend_st along. */
static double way_along(const ep_leaf *leaf, double room, double astray)
{
    return room + astray + 2 * EP_STEEP * (leaf->height + astray);
}

static double graph_terms(const ep_leaf *leaf, double room, double astray)
{
    const double high = leaf->height + astray, along = way_along(leaf, room, astray);
    return 0x1p-19 * ((double)leaf->bend_h * along * along + 2 * high);
}

static void allow_for_rays(ep_fit *f)
{
    ep_leaf *leaf = &f->leaf;
    const bool triangle = f->kind == &ep_kinds[EP_KIND_TRIANGLE];
    const double per = 12 * EP_EPS_F * largest_in_rows(f);
    const double way = EP_STEEP * (ep_norm1(f->column[0]) + ep_norm1(f->column[1])) + ep_norm1(f->column[2]);
    const double noise = 2 * per * leaf->height * way;
    const double noise_st = leaf->noise_st + noise, noise_h = leaf->noise_h + noise;
    const double side = f->side + noise_st;
    leaf->height = ep_round_up(leaf->height + noise_h);
    leaf->rim = ep_round_up(f->kind->middle + side + 4 * EP_EPS_F);

    const double extent = triangle ? 2.0 / 3 : 0.5, room = extent + side;
    const double cancelled = 8 * EP_EPS_F * (1 + (double)leaf->bend_st) * way_along(leaf, room, EP_ASTRAY);
    leaf->foot = ep_round_up(leaf->foot + (double)ep_leaf_from_foot(leaf, triangle) * noise_st + cancelled);
    const double by_foot = 1 + (double)leaf->bend_h * room, terms = graph_terms(leaf, room, 0);
    leaf->graph = ep_round_up(leaf->graph + noise_h + (by_foot - 1) * noise_st + terms);
    const double more = 1 + 4 * per * way * by_foot + 2 * (graph_terms(leaf, room, EP_ASTRAY) - terms) / EP_ASTRAY;
    leaf->reach = ep_round_up(per * by_foot * more);
}

/* Factors of the normal go with the third power of the leaf's size, and with its inverse square. The first is a mere
 * factor, for which a few bits less than a float's would do: the direction does not depend on it. */
static bool floats_hold_normal(const ep_fit *f)
{
    const float volume = fabsf(f->leaf.volume);
    const double row = largest_in_rows(f);
    return volume >= 0x1p-140f && volume < INFINITY && isnormal((float)(row * row)) && isnormal((float)(4 * row * row));
}

static ep_vec3 euclidean(const ep_point p)
{
    return ep_scale(1 / p[3], ep_v3(p[0], p[1], p[2]));
}

/* What a piece without a frame has instead (leaf.h): the line from its first control point to the one that is farthest
 * from that, and how far others are from it, for the hull has the piece. */
static void wrap(const ep_domain *d, ep_fit *f)
{
    ep_leaf *leaf = &f->leaf;
    const ep_patch *p = f->patch;
    const size_t count = f->kind->point_count(f->m, f->n);
    ep_point net[EP_NET_POINTS];
    f->kind->restrict_to(f->local, f->m, f->n, d, net);
    const ep_vec3 first = euclidean(net[0]);
    ep_vec3 along = ep_v3(1, 0, 0);
    double length = 0, radius = 0;
    for (size_t k = 1; k < count; ++k) {
        const ep_vec3 far = ep_sub(euclidean(net[k]), first);
        if (ep_length(far) <= length) continue;
        length = ep_length(far);
        along = ep_scale(1 / length, far);
    }
    ep_vec3 at = first;
    ep_leaf_put_centre(f, &at);
    leaf->frame[0][0] = (float)along.x, leaf->frame[1][0] = (float)along.y, leaf->frame[2][0] = (float)along.z;
    along = ep_v3(leaf->frame[0][0], leaf->frame[1][0], leaf->frame[2][0]);
    for (size_t k = 0; k < count; ++k) radius = fmax(radius, ep_length(ep_cross(ep_sub(euclidean(net[k]), at), along)));
    /* sixteen times what subdivision takes for a hit */
    const double noise = (f->m + f->n + 4) * 256 * EP_EPS_D * p->weight_max / p->weight_min * p->radius;
    leaf->foot = ep_round_up(radius / ep_length(along) + noise);
}

void ep_leaf_certify(const ep_domain *d, ep_fit *f)
{
    ep_leaf *leaf = &f->leaf;
    if (!f->regular) {
        wrap(d, f);
        return;
    }
    const double lost = reduce(f);
    model(f, lost);
    rounding(f, lost);
    /* For the frame's matrix M, M a x M b = det M M^-T (a x b); and S_s x S_t = (uu vv - uv vu) S_u x S_v. */
    leaf->volume = (float)(1 / (ep_dot(f->row[0], ep_cross(f->row[1], f->row[2])) * f->area));
    if (!floats_hold_normal(f)) leaf->noise_st = fmaxf(leaf->noise_st, EP_VAGUE);
    allow_for_rays(f);
}

void ep_leaf_pack(const ep_fit *f, float *net)
{
    const ep_leaf *leaf = &f->leaf;
    if (!f->net_floats) return;
    const unsigned m = leaf->degree_s, n = leaf->degree_t, stride = ep_leaf_stride(leaf);
    memset(net, 0, f->net_floats * sizeof *net);
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= m; ++i) {
            const size_t to = f->kind->index(m, n, i, j), from = f->kind->index(f->m, f->n, i, j);
            if (to == SIZE_MAX || from == SIZE_MAX) continue;
            double x[4];
            memcpy(x, f->series[from], sizeof x);
            if (!leaf->rational) {
                x[0] -= i == 1 && j == 0;
                x[1] -= i == 0 && j == 1;
            }
            for (unsigned c = 0; c < stride; ++c) net[stride * to + c] = (float)x[c];
        }
}
