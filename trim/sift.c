/* sift.c - deciding a packet of points. See trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Nearly all points are clear of what crosses their leaf, or their cell of the region's grid: a strip or a band tells.
 * The loops over the lanes do the same for all of them, so that a compiler makes them vectors. What they compute is the
 * same with any. Only what is left is tested one by one. */
#include "trim/band.h"
#include "trim/node.h"

#include <string.h>

enum { LANES = EP_TRIM_LANES };

/* The best that the machine has, where the C library can choose when it links. Clang's choice would be a symbol of the
 * library. */
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__)
#define EP_VECTORS __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define EP_VECTORS
#endif

static const uint32_t bit[LANES] = {1u << 0, 1u << 1, 1u << 2,  1u << 3,  1u << 4,  1u << 5,  1u << 6,  1u << 7,
                                    1u << 8, 1u << 9, 1u << 10, 1u << 11, 1u << 12, 1u << 13, 1u << 14, 1u << 15};

/* Lanes that are inside, and further than `reach` from every border; or outside. */
typedef struct verdict {
    uint32_t in, out;
} verdict;

static inline verdict beside_strip(const uint32_t *strip, unsigned lanes, const float *u, const float *v, double reach)
{
    const double a = ep_node_float(strip[1]), b = ep_node_float(strip[2]);
    const double lo = ep_node_float(strip[3]) - 2 * reach, hi = ep_node_float(strip[4]) + 2 * reach;
    uint32_t under = 0, over = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        const double h = a * (double)u[i] + b * (double)v[i];
        under |= h < lo ? bit[i] : 0;
        over |= h > hi ? bit[i] : 0;
    }
    const uint32_t in = (*strip & EP_NODE_BIT3 ? under : 0) | (*strip & EP_NODE_BIT4 ? over : 0);
    return (verdict){in, (under | over) & ~in};
}

/* Points beyond the grid get the answer of the nearest in it: there all is outside. */
static inline verdict beside_bands(const ep_bands *g, unsigned lanes, const float *u, const float *v, float reach)
{
    const uint32_t *words = g->words;
    const float u0 = g->lo[0], v0 = g->lo[1], to_x = g->per_unit[0], to_y = g->per_unit[1];
    const float last_x = g->last[0], last_y = g->last[1], columns = g->columns;
    const float step = reach * (to_x > to_y ? to_x : to_y);
    uint32_t in = 0, out = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        float x = (u[i] - u0) * to_x, y = (v[i] - v0) * to_y;
        x = x > 0 ? x : 0, y = y > 0 ? y : 0;
        x = x < last_x ? x : last_x, y = y < last_y ? y : last_y;
        const float column = (float)(int32_t)x, row = (float)(int32_t)y;
        const int32_t at = 2 * (int32_t)(row * columns + column); /* exact below 2^24 */
        const uint32_t form = words[at], range = words[at + 1];
        const float a = (float)((int32_t)form >> 20), b = (float)((int32_t)(form << 12) >> 20);
        const float c = EP_BAND_BEND * (float)((int32_t)(form << 24) >> 24);
        const float s = x - column - 0.5f, r = y - row - 0.5f, w = b * s - a * r, q = a * s + b * r + c * w * w;
        /* by how much q may differ within `reach` */
        const float e = (fabsf(a) + fabsf(b)) * step, slack = e + e * fabsf(c) * (2 * fabsf(w) + e);
        in |= q - slack > EP_BAND_FINE * (float)((int32_t)range >> 16) ? bit[i] : 0;
        out |= q + slack < EP_BAND_FINE * (float)((int32_t)(range << 16) >> 16) ? bit[i] : 0;
    }
    return (verdict){in, out};
}

static inline uint32_t sift(const ep_trim *t, const uint32_t *node, unsigned lanes, const float *u, const float *v,
                            uint32_t mask, double reach, uint32_t *open)
{
    uint32_t in = 0;
    *open = mask;
    if (ep_node_kind_of(*node) == EP_NODE_STRIP) {
        const verdict s = beside_strip(node, lanes, u, v, reach);
        in = s.in & mask;
        *open &= ~(s.in | s.out);
        node += EP_STRIP_WORDS;
    }
    if (*open && ep_node_kind_of(*node) == EP_NODE_REGION && reach <= t->bands.reach) {
        const verdict c = beside_bands(&t->bands, lanes, u, v, (float)reach);
        in |= c.in & *open;
        *open &= ~(c.in | c.out);
    }
    for (uint32_t rest = *open; rest; rest &= rest - 1) {
        const int i = __builtin_ctz(rest);
        if (u[i] != u[i] || v[i] != v[i]) {
            *open &= ~bit[i];
            continue;
        }
        const ep_clearance c = ep_node_clears(t, node, (double)u[i], (double)v[i], reach);
        if (c == EP_CLEAR_OF_NOTHING) continue;
        *open &= ~bit[i];
        in |= c == EP_CLEAR_INSIDE ? bit[i] : 0;
    }
    return in;
}

/* static: what is chosen at link time is visible outside the library otherwise */
EP_VECTORS static uint32_t sift_packet(const ep_trim *t, const uint32_t *node, const float *u, const float *v,
                                       uint32_t mask, double reach, uint32_t *open)
{
    return sift(t, node, LANES, u, v, mask, reach, open);
}

uint32_t ep_trim_sift(const ep_trim *trim, const uint32_t *words, uint32_t node, unsigned count, const float *u,
                      const float *v, uint32_t mask, double reach, uint32_t *open)
{
    if (count == 1) return sift(trim, words + node, 1, u, v, mask, reach, open);
    if (count == LANES) return sift_packet(trim, words + node, u, v, mask, reach, open);
    float point[2][LANES] = {{0}};
    memcpy(point[0], u, count * sizeof *u);
    memcpy(point[1], v, count * sizeof *v);
    return sift_packet(trim, words + node, point[0], point[1], mask, reach, open);
}

uint32_t ep_trim_inside(const ep_trim *trim, const uint32_t *words, uint32_t node, unsigned count, const float *u,
                        const float *v, uint32_t mask)
{
    /* all but what rounding may decide */
    uint32_t open, in = ep_trim_sift(trim, words, node, count, u, v, mask, 0x1p-44 * trim->scale, &open);
    for (; open; open &= open - 1) {
        const int i = __builtin_ctz(open);
        in |= ep_trim_inside_one(trim, words, node, (double)u[i], (double)v[i]) ? bit[i] : 0;
    }
    return in;
}
