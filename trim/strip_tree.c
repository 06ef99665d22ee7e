/* strip_tree.c - strip trees and trees of parallelograms [Ballard 1981; Stürzlinger 1998, section 2.2].
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Each node holds a run of the contour in a rectangle along the chord from the run's beginning to its end: at the
 * bottom thin parts of monotone pieces, above them runs of more and more pieces. A point outside of the rectangle is
 * decided by the ends alone: the rectangle meets the point's level on one side of it, and the run crosses that level
 * an odd number of times when its ends are on either side. Only rectangles that hold the point are opened. */
#include "trim/methods.h"

#include <string.h>

typedef struct strip_node {
    double d[2], along[2], across[2]; /* direction; least and largest along it and to the left of it */
    double y[2];                      /* of the ends */
    uint32_t right;                   /* the left child is the next node; 0: a leaf */
    uint32_t piece;
} strip_node;

struct ep_strip_tree {
    const ep_trim *trim;
    strip_node *nodes; /* a tree for each closed loop */
    size_t count, room;
    uint32_t *roots;
    size_t root_count, root_room;
};

/* A thin part of a piece, in the contour's direction, and its hull. */
typedef struct part {
    ep_point2 end[2];
    size_t first, count;
    uint32_t piece;
} part;

typedef struct maker {
    ep_strip_tree *tree;
    part *parts;
    ep_point2 *hull;
    size_t count, room, hull_count, hull_room;
} maker;

/* Rectangles higher than this against their length are divided. */
static const double thin = 1.0 / 16;

static void measure(const ep_point2 from, const ep_point2 to, const ep_point2 *p, size_t count, strip_node *n)
{
    const double x = to[0] - from[0], y = to[1] - from[1], length = sqrt(x * x + y * y);
    n->d[0] = length > 0 ? x / length : 1, n->d[1] = length > 0 ? y / length : 0;
    n->along[0] = n->across[0] = INFINITY, n->along[1] = n->across[1] = -INFINITY;
    for (size_t i = 0; i < count; ++i) {
        const double a = n->d[0] * p[i][0] + n->d[1] * p[i][1], b = n->d[0] * p[i][1] - n->d[1] * p[i][0];
        n->along[0] = fmin(n->along[0], a), n->along[1] = fmax(n->along[1], a);
        n->across[0] = fmin(n->across[0], b), n->across[1] = fmax(n->across[1], b);
    }
}

/* Cuts the part of a piece between two of its points until it is thin; `points` run from `from` to `to`. */
static bool add_parts(maker *k, uint32_t piece, const ep_point2h *points, unsigned n, const ep_point2 from,
                      const ep_point2 to)
{
    ep_point2 hull[EP_CURVE_POINTS];
    for (unsigned i = 0; i <= n; ++i)
        hull[i][0] = points[i][0] / points[i][2], hull[i][1] = points[i][1] / points[i][2];
    memcpy(hull[0], from, sizeof hull[0]);
    memcpy(hull[n], to, sizeof hull[n]);
    strip_node s;
    measure(from, to, hull, n + 1, &s);
    if (n > 1 && s.across[1] - s.across[0] > thin * (s.along[1] - s.along[0])) {
        ep_point2h left[EP_CURVE_POINTS], right[EP_CURVE_POINTS];
        ep_curve_halve(points, n, left, right);
        const ep_point2 mid = {right[0][0] / right[0][2], right[0][1] / right[0][2]};
        return add_parts(k, piece, left, n, from, mid) && add_parts(k, piece, right, n, mid, to);
    }
    if (!ep_reserve((void **)&k->parts, &k->room, k->count, 1, sizeof *k->parts) ||
        !ep_reserve((void **)&k->hull, &k->hull_room, k->hull_count, n + 1, sizeof *k->hull))
        return false;
    part *p = &k->parts[k->count++];
    *p = (part){{{from[0], from[1]}, {to[0], to[1]}}, k->hull_count, n + 1, piece};
    memcpy(k->hull + k->hull_count, hull, (n + 1) * sizeof *hull);
    k->hull_count += n + 1;
    return true;
}

static bool add_piece(maker *k, uint32_t index, bool upward)
{
    const ep_piece *p = &k->tree->trim->pieces[index];
    const ep_point2h *points = k->tree->trim->points + p->first;
    if (upward) return add_parts(k, index, points, p->degree, p->low, p->high);
    ep_point2h back[EP_CURVE_POINTS];
    for (unsigned i = 0; i <= p->degree; ++i) memcpy(back[i], points[p->degree - i], sizeof back[i]);
    return add_parts(k, index, back, p->degree, p->high, p->low);
}

static bool same(const ep_point2 a, const ep_point2 b)
{
    return a[0] == b[0] && a[1] == b[1];
}

/* The parts of pieces first to last in the contour's order: the pieces of a curve may stand in the opposite one. */
static bool add_contour(maker *k, const ep_region_curve *curves, uint32_t first, uint32_t last)
{
    const ep_piece *pieces = k->tree->trim->pieces;
    for (uint32_t i = first, end; i < last; i = end) {
        const ep_region_curve *c = &curves[pieces[i].curve];
        for (end = i + 1; end < last && pieces[end].curve == pieces[i].curve;) ++end;
        const bool back = !same(pieces[i].low, c->end[0]) && !same(pieces[i].high, c->end[0]);
        const double *at = c->end[0];
        for (uint32_t j = 0; j < end - i; ++j) {
            const uint32_t index = back ? end - 1 - j : i + j;
            const bool upward = same(pieces[index].low, at);
            if (!add_piece(k, index, upward)) return false;
            at = upward ? pieces[index].high : pieces[index].low;
        }
    }
    return true;
}

/* The tree over parts first to last; balanced, so that its depth is the logarithm of their number. */
static bool add_nodes(maker *k, size_t first, size_t last)
{
    ep_strip_tree *t = k->tree;
    if (!ep_reserve((void **)&t->nodes, &t->room, t->count, 1, sizeof *t->nodes)) return false;
    const part *a = &k->parts[first], *b = &k->parts[last - 1];
    const size_t index = t->count++;
    strip_node *n = &t->nodes[index];
    measure(a->end[0], b->end[1], k->hull + a->first, b->first + b->count - a->first, n);
    const double margin = 0x1p-45 * t->trim->scale; /* more than what rounds (ep_domain_rounding()) */
    for (int i = 0; i < 2; ++i) {
        n->along[i] += i ? margin : -margin, n->across[i] += i ? margin : -margin;
        n->y[i] = (i ? b->end[1] : a->end[0])[1];
    }
    n->piece = a->piece;
    n->right = 0;
    if (last - first == 1) return true;
    const size_t mid = first + (last - first) / 2;
    if (!add_nodes(k, first, mid)) return false;
    t->nodes[index].right = (uint32_t)t->count;
    return add_nodes(k, mid, last);
}

static bool add_trees(maker *k)
{
    ep_strip_tree *t = k->tree;
    for (size_t i = 0, end; i < k->count; i = end) {
        for (end = i + 1; end < k->count && same(k->parts[end - 1].end[1], k->parts[end].end[0]);) ++end;
        if (!ep_reserve((void **)&t->roots, &t->root_room, t->root_count, 1, sizeof *t->roots)) return false;
        t->roots[t->root_count++] = (uint32_t)t->count;
        if (!add_nodes(k, i, end)) return false;
    }
    return true;
}

EPStatus ep_strip_tree_new(const ep_trim *trim, const ep_region_curve *curves, uint32_t first, uint32_t last,
                           ep_strip_tree **tree, ep_message *m)
{
    *tree = ep_alloc(1, sizeof **tree);
    if (!*tree) return ep_fail(m, EP_NO_MEMORY, "no memory for a strip tree");
    **tree = (ep_strip_tree){.trim = trim};
    maker k = {.tree = *tree};
    const bool made = add_contour(&k, curves, first, last) && add_trees(&k);
    ep_free(k.parts);
    ep_free(k.hull);
    if (made) return EP_OK;
    ep_strip_tree_free(*tree);
    *tree = NULL;
    return ep_fail(m, EP_NO_MEMORY, "no memory for a strip tree");
}

void ep_strip_tree_free(ep_strip_tree *t)
{
    if (!t) return;
    ep_free(t->nodes);
    ep_free(t->roots);
    ep_free(t);
}

static bool node_crosses(const ep_strip_tree *t, uint32_t index, double x, double y)
{
    const strip_node *n = &t->nodes[index];
    const double a = n->d[0] * x + n->d[1] * y, b = n->d[0] * y - n->d[1] * x;
    const bool parted = (n->y[0] <= y) != (n->y[1] <= y);
    if (a < n->along[0]) return n->d[0] > 0 && parted;
    if (a > n->along[1]) return n->d[0] < 0 && parted;
    if (b < n->across[0]) return n->d[1] < 0 && parted;
    if (b > n->across[1]) return n->d[1] > 0 && parted;
    if (n->right) return node_crosses(t, index + 1, x, y) != node_crosses(t, n->right, x, y);
    const ep_piece *p = &t->trim->pieces[n->piece];
    return parted && ep_piece_is_right(p, t->trim->points + p->first, x, y);
}

bool ep_strip_tree_crosses(const ep_strip_tree *t, double u, double v)
{
    bool odd = false;
    for (size_t i = 0; i < t->root_count; ++i) odd ^= node_crosses(t, t->roots[i], u, v);
    return odd;
}

size_t ep_strip_tree_bytes(const ep_strip_tree *t)
{
    return sizeof *t + t->count * sizeof *t->nodes + t->root_count * sizeof *t->roots;
}
