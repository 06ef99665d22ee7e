/* inside.c - testing points against a stored node. See trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/node.h"

enum { MOST_POINTS = 32 };

typedef struct points {
    const ep_trim *trim;
    double x[2][MOST_POINTS];
} points;

/* The loops run over the lanes that are on: they come in packets, but soon part ways. */

static uint32_t below(const points *p, uint32_t mask, int axis, double c)
{
    uint32_t in = 0;
    for (; mask; mask &= mask - 1) {
        const int i = __builtin_ctz(mask);
        in |= (uint32_t)(p->x[axis][i] < c) << i;
    }
    return in;
}

static uint32_t in_box(const points *p, uint32_t mask, const uint32_t *node)
{
    const double u0 = ep_node_float(node[1]), v0 = ep_node_float(node[2]);
    const double u1 = ep_node_float(node[3]), v1 = ep_node_float(node[4]);
    uint32_t in = 0;
    for (; mask; mask &= mask - 1) {
        const int i = __builtin_ctz(mask);
        const double u = p->x[0][i], v = p->x[1][i];
        in |= (uint32_t)(u >= u0 && u <= u1 && v >= v0 && v <= v1) << i;
    }
    return in;
}

/* Lanes between the lines; those beyond them that are inside go to `known`. */
static uint32_t in_strip(const points *p, uint32_t mask, const uint32_t *node, uint32_t *known)
{
    const double a = ep_node_float(node[1]), b = ep_node_float(node[2]);
    const double lo = ep_node_float(node[3]), hi = ep_node_float(node[4]);
    const uint32_t all = mask;
    uint32_t under = 0, over = 0;
    for (; mask; mask &= mask - 1) {
        const int i = __builtin_ctz(mask);
        const double h = a * p->x[0][i] + b * p->x[1][i];
        under |= (uint32_t)(h < lo) << i;
        over |= (uint32_t)(h > hi) << i;
    }
    *known = (*node & EP_NODE_BIT3 ? under : 0) | (*node & EP_NODE_BIT4 ? over : 0);
    return all & ~(under | over);
}

static uint32_t in_list(const points *p, uint32_t mask, const uint32_t *node)
{
    uint32_t in = 0;
    for (; mask; mask &= mask - 1) {
        const int i = __builtin_ctz(mask);
        in |= (uint32_t)ep_list_has(p->trim, node, p->x[0][i], p->x[1][i]) << i;
    }
    return in;
}

static uint32_t cell_of(const uint32_t *node, double x, double y)
{
    const ep_grid g = ep_node_grid(node);
    return node[EP_GRID_HEAD + ep_grid_at(&g, 1, y) * g.count[0] + ep_grid_at(&g, 0, x)];
}

/* One point: no lanes to keep apart. */
static bool test_one(const ep_trim *t, const uint32_t *node, double x, double y)
{
    for (;;) {
        const uint32_t *end = node + ep_node_size(*node);
        bool any;
        double h;
        uint32_t cell;
        switch (ep_node_kind_of(*node)) {
        case EP_NODE_LIST: return ep_list_has(t, node, x, y);
        case EP_NODE_ANY:
        case EP_NODE_ALL:
            any = ep_node_kind_of(*node) == EP_NODE_ANY;
            for (++node; node < end; node += ep_node_size(*node))
                if (test_one(t, node, x, y) == any) return any;
            return !any;
        case EP_NODE_SPLIT:
            h = *node & EP_NODE_BIT4 ? y : x;
            node += h < ep_node_float(node[1]) ? 2 : 2 + ep_node_size(node[2]);
            break;
        case EP_NODE_STRIP:
            h = (double)ep_node_float(node[1]) * x + (double)ep_node_float(node[2]) * y;
            if (h < ep_node_float(node[3])) return *node & EP_NODE_BIT3;
            if (h > ep_node_float(node[4])) return *node & EP_NODE_BIT4;
            node += 5;
            break;
        case EP_NODE_BOX:
            if (!(x >= ep_node_float(node[1]) && y >= ep_node_float(node[2]) && x <= ep_node_float(node[3]) &&
                  y <= ep_node_float(node[4])))
                return false;
            node += 5;
            break;
        case EP_NODE_GRID:
            cell = cell_of(node, x, y);
            if (cell <= 1) return cell;
            node += cell;
            break;
        case EP_NODE_CONST: return *node & EP_NODE_BIT3;
        }
    }
}

static uint32_t in_grid(const points *p, uint32_t mask, const uint32_t *node)
{
    uint32_t in = 0;
    for (; mask; mask &= mask - 1) {
        const int i = __builtin_ctz(mask);
        const double x = p->x[0][i], y = p->x[1][i];
        const uint32_t cell = cell_of(node, x, y);
        in |= (uint32_t)(cell <= 1 ? cell : test_one(p->trim, node + cell, x, y)) << i;
    }
    return in;
}

static uint32_t test(const points *p, const uint32_t *node, uint32_t mask)
{
    if (!mask) return 0;
    if ((mask & (mask - 1)) == 0) {
        const int i = __builtin_ctz(mask);
        return (uint32_t)test_one(p->trim, node, p->x[0][i], p->x[1][i]) << i;
    }
    const uint32_t *end = node + ep_node_size(*node);
    uint32_t known, in, rest;
    switch (ep_node_kind_of(*node)) {
    case EP_NODE_LIST: return in_list(p, mask, node);
    case EP_NODE_ANY:
        in = 0;
        for (++node; node < end && in != mask; node += ep_node_size(*node)) in |= test(p, node, mask & ~in);
        return in;
    case EP_NODE_ALL:
        in = mask;
        for (++node; node < end && in; node += ep_node_size(*node)) in = test(p, node, in);
        return in;
    case EP_NODE_SPLIT:
        rest = below(p, mask, *node >> 4 & 1, ep_node_float(node[1]));
        node += 2;
        return test(p, node, rest) | test(p, node + ep_node_size(*node), mask & ~rest);
    case EP_NODE_STRIP: rest = in_strip(p, mask, node, &known); return known | test(p, node + 5, rest);
    case EP_NODE_BOX: return test(p, node + 5, in_box(p, mask, node));
    case EP_NODE_GRID: return in_grid(p, mask, node);
    case EP_NODE_CONST: return *node & EP_NODE_BIT3 ? mask : 0;
    }
    return 0;
}

uint32_t ep_trim_inside(const ep_trim *trim, const uint32_t *words, uint32_t node, unsigned count, const float *u,
                        const float *v, uint32_t mask)
{
    points p;
    p.trim = trim;
    uint32_t numbers = 0;
    for (unsigned i = 0; i < count; ++i) {
        p.x[0][i] = u[i], p.x[1][i] = v[i];
        numbers |= (uint32_t)(u[i] == u[i] && v[i] == v[i]) << i;
    }
    return test(&p, words + node, mask & numbers);
}

bool ep_trim_inside_one(const ep_trim *trim, const uint32_t *words, uint32_t node, double u, double v)
{
    return u == u && v == v && test_one(trim, words + node, u, v);
}

/* A monotone piece that enters the square leaves two of its corners on different sides: those across the way it goes.
 */
static bool piece_is_near(const ep_trim *t, const ep_piece *p, double x, double y, double reach)
{
    if (y < p->low[1] - reach || y > p->high[1] + reach) return false;
    if (x < fmin(p->low[0], p->high[0]) - reach || x > fmax(p->low[0], p->high[0]) + reach) return false;
    if (y - reach < p->low[1] || y + reach >= p->high[1]) return true;
    const double side = p->falls ? -reach : reach;
    const ep_point2h *points = t->points + p->first;
    return ep_piece_is_right(p, points, x - side, y + reach) != ep_piece_is_right(p, points, x + side, y - reach);
}

static bool is_near(const ep_trim *t, const uint32_t *node, double x, double y, double reach);

static bool grid_is_near(const ep_trim *t, const uint32_t *node, double x, double y, double reach)
{
    const ep_grid g = ep_node_grid(node);
    const uint32_t last[2] = {ep_grid_at(&g, 0, x + reach), ep_grid_at(&g, 1, y + reach)};
    for (uint32_t j = ep_grid_at(&g, 1, y - reach); j <= last[1]; ++j)
        for (uint32_t i = ep_grid_at(&g, 0, x - reach); i <= last[0]; ++i) {
            const uint32_t cell = node[EP_GRID_HEAD + j * g.count[0] + i];
            if (cell > 1 && is_near(t, node + cell, x, y, reach)) return true;
        }
    return false;
}

static bool is_near(const ep_trim *t, const uint32_t *node, double x, double y, double reach)
{
    for (;;) {
        const uint32_t *end = node + ep_node_size(*node);
        double a, b, h;
        switch (ep_node_kind_of(*node)) {
        case EP_NODE_LIST:
            for (++node; node < end; ++node)
                if (piece_is_near(t, &t->pieces[ep_entry_piece(*node)], x, y, reach)) return true;
            return false;
        case EP_NODE_ANY:
        case EP_NODE_ALL:
            for (++node; node < end; node += ep_node_size(*node))
                if (is_near(t, node, x, y, reach)) return true;
            return false;
        case EP_NODE_SPLIT:
            h = (*node & EP_NODE_BIT4 ? y : x) - ep_node_float(node[1]);
            node += 2;
            if (fabs(h) <= reach && is_near(t, node, x, y, reach)) return true;
            if (h >= -reach) node += ep_node_size(*node);
            break;
        case EP_NODE_STRIP:
            a = ep_node_float(node[1]), b = ep_node_float(node[2]);
            h = a * x + b * y;
            if (h < ep_node_float(node[3]) - 2 * reach || h > ep_node_float(node[4]) + 2 * reach) return false;
            node += 5;
            break;
        case EP_NODE_BOX: node += 5; break;
        case EP_NODE_GRID: return grid_is_near(t, node, x, y, reach);
        case EP_NODE_CONST: return false;
        }
    }
}

bool ep_trim_is_near(const ep_trim *trim, const uint32_t *words, uint32_t node, double u, double v, double reach)
{
    return is_near(trim, words + node, u, v, reach);
}

bool ep_trim_reaches(const ep_trim *trim, const uint32_t *words, uint32_t node, double u, double v, double reach)
{
    static const int corner[5][2] = {{0, 0}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    for (int i = 0; i < 5; ++i)
        if (ep_trim_inside_one(trim, words, node, u + corner[i][0] * reach, v + corner[i][1] * reach)) return true;
    return false;
}
