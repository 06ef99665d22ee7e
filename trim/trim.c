/* trim.c - from a region to pieces and the root part. See trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/node.h"

#include <string.h>

/* What is under way. */
typedef struct maker {
    ep_trim *trim;
    ep_region_view region;
    size_t *first_piece; /* of each curve; one more for the end */
    ep_message *message;
} maker;

static EPStatus no_memory(ep_message *m)
{
    return ep_fail(m, EP_NO_MEMORY, "no memory to prepare a trim region");
}

static EPStatus make_pieces(maker *k)
{
    ep_trim *t = k->trim;
    size_t piece_room = 0, point_room = 0;
    for (size_t i = 0; i < k->region.curve_count; ++i) {
        const ep_region_curve *c = &k->region.curves[i];
        ep_piece pieces[EP_PIECES];
        ep_point2h points[EP_PIECES * EP_CURVE_POINTS];
        const unsigned n = ep_piece_cut(k->region.points + c->first, c->degree, c->end[0], c->end[1], pieces, points);
        const size_t more = (size_t)n * (c->degree + 1);
        k->first_piece[i] = t->piece_count;
        if (!n) continue;
        if (t->point_count + more > UINT32_MAX) return ep_fail(k->message, EP_BAD_DATA, "too many trim curves");
        if (!ep_reserve((void **)&t->pieces, &piece_room, t->piece_count, n, sizeof *t->pieces) ||
            !ep_reserve((void **)&t->points, &point_room, t->point_count, more, sizeof *t->points))
            return no_memory(k->message);
        for (unsigned j = 0; j < n; ++j) {
            pieces[j].first = (uint32_t)(t->point_count + (size_t)j * (c->degree + 1));
            pieces[j].curve = (uint32_t)i;
        }
        memcpy(t->pieces + t->piece_count, pieces, n * sizeof *pieces);
        memcpy(t->points + t->point_count, points, more * sizeof *points);
        t->piece_count += n;
        t->point_count += more;
    }
    k->first_piece[k->region.curve_count] = t->piece_count;
    return EP_OK;
}

static void find_bounds(ep_trim *t)
{
    for (int c = 0; c < 2; ++c) {
        t->lo[c] = INFINITY, t->hi[c] = -INFINITY;
        for (size_t i = 0; i < t->piece_count; ++i) {
            const ep_piece *p = &t->pieces[i];
            t->lo[c] = fmin(t->lo[c], fmin(p->low[c], p->high[c]));
            t->hi[c] = fmax(t->hi[c], fmax(p->low[c], p->high[c]));
        }
    }
}

/* Writes the nodes of a subtree; differences become intersections with the complement, and complements are passed down
 * to the contours. Returns the state of the subtree, which is written only when crossed. */
static ep_trim_state put_node(const maker *k, uint32_t node, bool complement, uint32_t *words, size_t *count)
{
    const ep_region_node *n = &k->region.nodes[node];
    const size_t head = (*count)++;
    if (n->kind >= EP_REGION_LOOPS) {
        const size_t first = k->first_piece[n->curves], last = k->first_piece[n->curves + n->curve_count];
        if (first == last) {
            *count = head;
            return complement ? EP_TRIM_INSIDE : EP_TRIM_OUTSIDE;
        }
        for (size_t i = first; i < last; ++i)
            words[(*count)++] = ep_entry_word((uint32_t)i, EP_BEYOND_NEVER, EP_BEYOND_NEVER);
        words[head] = ep_node_word(EP_NODE_LIST, complement ? EP_NODE_BIT3 : 0, *count - head);
        return EP_TRIM_CROSSED;
    }
    const bool any = (n->kind == EP_REGION_UNION) != complement;
    const ep_trim_state settles = any ? EP_TRIM_INSIDE : EP_TRIM_OUTSIDE;
    ep_trim_state state = any ? EP_TRIM_OUTSIDE : EP_TRIM_INSIDE;
    for (uint32_t child = node + 1; child < n->next; child = k->region.nodes[child].next) {
        const bool second = n->kind == EP_REGION_DIFFERENCE && child > node + 1;
        const ep_trim_state s = put_node(k, child, complement != second, words, count);
        if (s == settles) {
            *count = head;
            return s;
        }
        if (s == EP_TRIM_CROSSED) state = s;
    }
    if (state == EP_TRIM_CROSSED) words[head] = ep_node_word(any ? EP_NODE_ANY : EP_NODE_ALL, 0, *count - head);
    else *count = head;
    return state;
}

static EPStatus make_root(maker *k)
{
    ep_trim *t = k->trim;
    const size_t most = k->region.node_count + t->piece_count;
    if (most >= EP_NODE_MOST_WORDS) return ep_fail(k->message, EP_BAD_DATA, "too many trim curves");
    t->root.words = ep_alloc(most, sizeof *t->root.words);
    if (!t->root.words) return no_memory(k->message);
    size_t count = 0;
    t->root.state = put_node(k, 0, false, t->root.words, &count);
    t->root.pieces = t->piece_count;
    return EP_OK;
}

EPStatus ep_trim_new(const ep_region *region, ep_trim **trim, ep_message *m)
{
    *trim = NULL;
    maker k = {.message = m};
    EPStatus s = ep_region_look(region, &k.region, m);
    if (s) return s;
    ep_trim *t = k.trim = ep_alloc(1, sizeof *t);
    if (!t) return no_memory(m);
    memset(t, 0, sizeof *t);
    t->scale = k.region.scale;
    t->share = 1;
    k.first_piece = ep_alloc(k.region.curve_count + 1, sizeof *k.first_piece);
    s = k.first_piece ? make_pieces(&k) : no_memory(m);
    if (!s) {
        find_bounds(t);
        s = make_root(&k);
    }
    ep_free(k.first_piece);
    if (!s) s = ep_trim_keep_cells(t, m);
    if (s) ep_trim_free(t);
    else *trim = t;
    return s;
}

void ep_trim_free(ep_trim *t)
{
    if (!t) return;
    ep_free(t->pieces);
    ep_free(t->points);
    ep_free(t->root.words);
    ep_free(t->cells.words);
    ep_free(t->bands.words);
    ep_free(t);
}

size_t ep_trim_bytes(const ep_trim *t)
{
    const ep_grid grid = t->bands.words ? ep_node_grid(t->cells.words + EP_BOX_WORDS) : (ep_grid){0};
    return sizeof *t + 2 * ep_grid_cells(&grid) * sizeof *t->bands.words + t->piece_count * sizeof *t->pieces +
           t->point_count * sizeof *t->points +
           (t->cells.room + (t->root.state == EP_TRIM_CROSSED ? ep_node_size(*t->root.words) : 0)) * sizeof(uint32_t);
}
