/* inside.c - testing points against a stored node. See trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/node.h"

static const uint32_t *cell_of(const uint32_t *node, double x, double y)
{
    const ep_grid g = ep_node_grid(node);
    return node + EP_GRID_HEAD + ep_grid_at(&g, 1, y) * g.count[0] + ep_grid_at(&g, 0, x);
}

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
            node += EP_STRIP_WORDS;
            break;
        case EP_NODE_BOX:
            if (!(x >= ep_node_float(node[1]) && y >= ep_node_float(node[2]) && x <= ep_node_float(node[3]) &&
                  y <= ep_node_float(node[4])))
                return false;
            node += EP_BOX_WORDS;
            break;
        case EP_NODE_GRID:
            cell = *cell_of(node, x, y);
            if (cell <= 1) return cell;
            node += cell;
            break;
        case EP_NODE_REGION: node = t->cells.words; break;
        }
    }
}

bool ep_trim_inside_one(const ep_trim *trim, const uint32_t *words, uint32_t node, double u, double v)
{
    return u == u && v == v && test_one(trim, words + node, u, v);
}

static ep_clearance list_clears(const ep_trim *t, const uint32_t *node, double x, double y, double reach)
{
    bool inside = *node & EP_NODE_BIT3;
    const size_t size = ep_node_size(*node);
    for (size_t i = 1; i < size; ++i) {
        const ep_piece *p = &t->pieces[ep_entry_piece(node[i])];
        const bool beside = y < p->low[1] - reach || y > p->high[1] + reach ||
                            x < fmin(p->low[0], p->high[0]) - reach || x > fmax(p->low[0], p->high[0]) + reach;
        if (beside) {
            inside ^= ep_entry_crosses(t, node[i], x, y);
            continue;
        }
        const ep_side side = ep_piece_side(p, t->points + p->first, x, y, reach);
        if (side == EP_SIDE_NEAR) return EP_CLEAR_OF_NOTHING;
        inside ^= side == EP_SIDE_RIGHT;
    }
    return inside ? EP_CLEAR_INSIDE : EP_CLEAR_OUTSIDE;
}

ep_clearance ep_node_clears(const ep_trim *t, const uint32_t *node, double x, double y, double reach)
{
    for (;;) {
        const uint32_t *end = node + ep_node_size(*node);
        double a, b, h;
        const uint32_t *at;
        uint32_t cell;
        ep_clearance all, settles;
        switch (ep_node_kind_of(*node)) {
        case EP_NODE_LIST: return list_clears(t, node, x, y, reach);
        case EP_NODE_ANY:
        case EP_NODE_ALL:
            settles = ep_node_kind_of(*node) == EP_NODE_ANY ? EP_CLEAR_INSIDE : EP_CLEAR_OUTSIDE;
            all = settles == EP_CLEAR_INSIDE ? EP_CLEAR_OUTSIDE : EP_CLEAR_INSIDE;
            for (++node; node < end; node += ep_node_size(*node)) {
                const ep_clearance c = ep_node_clears(t, node, x, y, reach);
                if (c == settles) return c;
                if (c == EP_CLEAR_OF_NOTHING) all = c;
            }
            return all;
        case EP_NODE_SPLIT:
            h = (*node & EP_NODE_BIT4 ? y : x) - (double)ep_node_float(node[1]);
            if (fabs(h) <= reach) return EP_CLEAR_OF_NOTHING;
            node += h < 0 ? 2 : 2 + ep_node_size(node[2]);
            break;
        case EP_NODE_STRIP:
            a = ep_node_float(node[1]), b = ep_node_float(node[2]);
            h = a * x + b * y;
            if (h < ep_node_float(node[3]) - 2 * reach)
                return *node & EP_NODE_BIT3 ? EP_CLEAR_INSIDE : EP_CLEAR_OUTSIDE;
            if (h > ep_node_float(node[4]) + 2 * reach)
                return *node & EP_NODE_BIT4 ? EP_CLEAR_INSIDE : EP_CLEAR_OUTSIDE;
            node += EP_STRIP_WORDS;
            break;
        case EP_NODE_REGION: node = t->cells.words; break;
        case EP_NODE_BOX:
            if (!(x >= ep_node_float(node[1]) && y >= ep_node_float(node[2]) && x <= ep_node_float(node[3]) &&
                  y <= ep_node_float(node[4])))
                return EP_CLEAR_OF_NOTHING;
            node += EP_BOX_WORDS;
            break;
        case EP_NODE_GRID:
            at = cell_of(node, x - reach, y - reach);
            if (at != cell_of(node, x + reach, y + reach)) return EP_CLEAR_OF_NOTHING;
            cell = *at;
            if (cell <= 1) return cell ? EP_CLEAR_INSIDE : EP_CLEAR_OUTSIDE;
            node += cell;
            break;
        }
    }
}

bool ep_trim_reaches(const ep_trim *trim, const uint32_t *words, uint32_t node, double u, double v, double reach)
{
    const ep_clearance c = ep_node_clears(trim, words + node, u, v, reach);
    if (c != EP_CLEAR_OF_NOTHING) return c == EP_CLEAR_INSIDE;
    static const int corner[5][2] = {{0, 0}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    for (int i = 0; i < 5; ++i)
        if (ep_trim_inside_one(trim, words, node, u + corner[i][0] * reach, v + corner[i][1] * reach)) return true;
    return false;
}
