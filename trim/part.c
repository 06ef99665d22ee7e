/* part.c - what of a region can decide in a domain.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Why a list of the pieces that enter a domain is enough. Over the whole plane a point is inside when an odd number of
 * pieces count for it: g(p) = [low.y <= y < high.y][p is on the right there]. Let the domain be convex. A piece that
 * does not enter it is, as far as the domain's levels go, wholly on its left and never counts, or wholly on its right,
 * and counts for the levels between its ends alone. So the pieces that are left out count together for some function of
 * y, which steps at those of their ends that lie on the right. Pieces come in closed loops: two ends meet, and where
 * both belong to pieces that are left out the two steps cancel. Where one belongs to a piece in the list, let this
 * piece count beyond that end, too: its own step is gone, and with it the other's partner. Then no steps remain, and
 * the function is a constant, found at one point of the domain where the count before is known. Which ends lie on the
 * right need not be known for ends in the domain, as long as both pieces that meet there get the same answer.
 *
 * For an end below or above the domain nothing needs to be done: it is beyond all points. Those in a seam are best
 * served by a piece that goes on straight.
 *
 * A level piece has no height and never counts, but its ends are two steps like any others; counting beyond one of them
 * it divides the domain as it must. */
#include "trim/node.h"

typedef struct cutter {
    const ep_trim *trim;
    ep_trim_edges edges;
    ep_point2 at; /* a point in the domain */
    uint32_t *out;
    size_t count, pieces;
} cutter;

static ep_trim_state cut_list(cutter *c, const uint32_t *node)
{
    const ep_trim *t = c->trim;
    const size_t head = c->count++, size = ep_node_size(*node);
    bool inside = ep_list_has(t, node, c->at[0], c->at[1]);
    for (size_t i = 1; i < size; ++i) {
        const uint32_t index = ep_entry_piece(node[i]);
        const ep_piece *p = &t->pieces[index];
        if (!ep_edges_meet(&c->edges, p, t->points + p->first)) continue;
        const uint32_t entry =
            ep_entry_word(index, ep_edges_beyond(&c->edges, p->low), ep_edges_beyond(&c->edges, p->high));
        inside ^= ep_entry_crosses(t, entry, c->at[0], c->at[1]);
        c->out[c->count++] = entry;
    }
    if (c->count == head + 1) {
        c->count = head;
        return inside ? EP_TRIM_INSIDE : EP_TRIM_OUTSIDE;
    }
    c->pieces += c->count - head - 1;
    c->out[head] = ep_node_word(EP_NODE_LIST, inside ? EP_NODE_BIT3 : 0, c->count - head);
    return EP_TRIM_CROSSED;
}

static ep_trim_state cut_node(cutter *c, const uint32_t *node)
{
    const ep_node_kind kind = ep_node_kind_of(*node);
    if (kind == EP_NODE_LIST) return cut_list(c, node);
    /* the state of a child that settles the whole */
    const ep_trim_state settles = kind == EP_NODE_ANY ? EP_TRIM_INSIDE : EP_TRIM_OUTSIDE;
    const size_t head = c->count++, pieces = c->pieces;
    const uint32_t *end = node + ep_node_size(*node);
    unsigned crossed = 0;
    for (const uint32_t *child = node + 1; child < end; child += ep_node_size(*child)) {
        const ep_trim_state s = cut_node(c, child);
        if (s == settles) {
            c->count = head, c->pieces = pieces;
            return s;
        }
        crossed += s == EP_TRIM_CROSSED;
    }
    if (crossed == 0) {
        c->count = head;
        return kind == EP_NODE_ANY ? EP_TRIM_OUTSIDE : EP_TRIM_INSIDE;
    }
    if (crossed == 1) {
        --c->count;
        memmove(c->out + head, c->out + head + 1, (c->count - head) * sizeof *c->out);
    } else {
        c->out[head] = ep_node_word(kind, 0, c->count - head);
    }
    return EP_TRIM_CROSSED;
}

EPStatus ep_trim_cut(const ep_trim *trim, const ep_trim_part *parent, const ep_trim_domain *domain, ep_trim_part *part,
                     ep_message *m)
{
    *part = (ep_trim_part){.state = parent->state};
    if (parent->state != EP_TRIM_CROSSED) return EP_OK;
    const ep_trim_domain d = ep_domain_settle(domain, trim->scale);
    cutter c = {.trim = trim, .edges = ep_domain_edges(&d)};
    c.out = ep_alloc(ep_node_size(*parent->words), sizeof *c.out);
    if (!c.out) return ep_fail(m, EP_NO_MEMORY, "no memory to cut a trim region");
    ep_domain_centre(&d, c.at);
    part->state = cut_node(&c, parent->words);
    part->pieces = c.pieces;
    if (part->state == EP_TRIM_CROSSED) part->words = c.out;
    else ep_free(c.out);
    return EP_OK;
}

void ep_trim_part_free(ep_trim_part *part)
{
    ep_free(part->words);
    part->words = NULL;
}

size_t ep_trim_part_pieces(const uint32_t *node, uint32_t *pieces)
{
    const size_t size = ep_node_size(*node);
    size_t count = 0;
    if (ep_node_kind_of(*node) == EP_NODE_LIST) {
        for (size_t i = 1; i < size; ++i) pieces[count++] = ep_entry_piece(node[i]);
        return count;
    }
    for (size_t i = 1; i < size; i += ep_node_size(node[i])) count += ep_trim_part_pieces(node + i, pieces + count);
    return count;
}

double ep_trim_part_length(const ep_trim *trim, const uint32_t *node, double most)
{
    const size_t size = ep_node_size(*node);
    double sum = 0;
    if (ep_node_kind_of(*node) == EP_NODE_LIST) {
        for (size_t i = 1; i < size; ++i) {
            const ep_piece *p = &trim->pieces[ep_entry_piece(node[i])];
            sum += fmin(hypot(p->high[0] - p->low[0], p->high[1] - p->low[1]), most);
        }
        return sum;
    }
    for (size_t i = 1; i < size; i += ep_node_size(node[i])) sum += ep_trim_part_length(trim, node + i, most);
    return sum;
}
