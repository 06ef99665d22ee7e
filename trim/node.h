/* node.h - reading the words of a part (trim.h).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_TRIM_NODE_H
#define EP_TRIM_NODE_H

#include "trim/trim.h"

#include <string.h>

static inline ep_node_kind ep_node_kind_of(uint32_t word)
{
    return (ep_node_kind)(word & EP_NODE_KIND);
}
static inline size_t ep_node_size(uint32_t word)
{
    return word >> EP_NODE_SIZE_SHIFT;
}
static inline uint32_t ep_node_word(ep_node_kind kind, uint32_t bits, size_t size)
{
    return (uint32_t)kind | bits | (uint32_t)size << EP_NODE_SIZE_SHIFT;
}

static inline float ep_node_float(uint32_t word)
{
    float f;
    memcpy(&f, &word, sizeof f);
    return f;
}
static inline uint32_t ep_node_from_float(float f)
{
    uint32_t word;
    memcpy(&word, &f, sizeof f);
    return word;
}

/* A grid's words before its cells. */
enum { EP_GRID_HEAD = 10, EP_BOX_WORDS = 5, EP_STRIP_WORDS = 5 };

typedef struct ep_grid {
    double lo[2], per_unit[2];
    uint32_t count[2];
} ep_grid;

static inline ep_grid ep_node_grid(const uint32_t *node)
{
    ep_grid g = {.count = {node[9] & 0xFFFF, node[9] >> 16}};
    memcpy(g.lo, node + 1, sizeof g.lo);
    memcpy(g.per_unit, node + 5, sizeof g.per_unit);
    return g;
}

static inline size_t ep_grid_cells(const ep_grid *g)
{
    return (size_t)g->count[0] * g->count[1];
}

/* The row or column of a coordinate; the first and the last go on for ever. */
static inline uint32_t ep_grid_at(const ep_grid *g, int axis, double x)
{
    const double f = (x - g->lo[axis]) * g->per_unit[axis];
    const uint32_t last = g->count[axis] - 1;
    return f > 0 ? f < last ? (uint32_t)f : last : 0;
}

static inline uint32_t ep_entry_word(uint32_t piece, ep_beyond low, ep_beyond high)
{
    return piece << 4 | (uint32_t)low << 2 | (uint32_t)high;
}
static inline uint32_t ep_entry_piece(uint32_t entry)
{
    return entry >> 4;
}

/* Does an entry of a list count for the point? */
static inline bool ep_entry_crosses(const ep_trim *t, uint32_t entry, double x, double y)
{
    const ep_piece *p = &t->pieces[ep_entry_piece(entry)];
    const bool below = y < p->low[1];
    if (!below && y < p->high[1]) return ep_piece_is_right(p, t->points + p->first, x, y);
    const uint32_t beyond = (below ? entry >> 2 : entry) & 3;
    return beyond == EP_BEYOND_LEFT_OF ? x < (below ? p->low : p->high)[0] : beyond == EP_BEYOND_ALWAYS;
}

static inline bool ep_list_has(const ep_trim *t, const uint32_t *node, double x, double y)
{
    bool inside = *node & EP_NODE_BIT3;
    const size_t size = ep_node_size(*node);
    for (size_t i = 1; i < size; ++i) inside ^= ep_entry_crosses(t, node[i], x, y);
    return inside;
}

/* Is all of the square of half side `reach` about the point on one side of all borders? */
typedef enum ep_clearance { EP_CLEAR_OUTSIDE, EP_CLEAR_INSIDE, EP_CLEAR_OF_NOTHING } ep_clearance;
ep_clearance ep_node_clears(const ep_trim *t, const uint32_t *node, double x, double y, double reach);

#endif
