/* cells.c - storing a part so that testing points against it takes next to no time. See trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Strip: all curves in the domain lie between two parallel lines. The domain beyond either line is convex and no curve
 * enters it, so it is inside or outside as a whole, however many curves and operators there are. In a sliver along a
 * trim curve nearly all points are decided by this.
 *
 * Cells: a part of many pieces is halved along u or v, whichever duplicates fewer pieces, as long as the stored lists
 * stay within a multiple of the pieces: memory is linear in their number. */
#include "trim/arcs.h"
#include "trim/node.h"

#include <string.h>

/* Lists that are not worth a split: testing a piece costs about as much as passing a split. */
enum { FEW_PIECES = 3 };
/* Entries of the stored lists for each piece of the part. */
static const double most_copies = 8;

typedef struct keeper {
    const ep_trim *trim;
    ep_trim_store *store;
    ep_message *message;
    unsigned most_depth;
} keeper;

static EPStatus put(keeper *k, size_t count, const uint32_t *words)
{
    ep_trim_store *s = k->store;
    if (s->count + count >= EP_NODE_MOST_WORDS) return ep_fail(k->message, EP_BAD_DATA, "too many trim curves");
    if (!ep_reserve((void **)&s->words, &s->room, s->count, count, sizeof *words))
        return ep_fail(k->message, EP_NO_MEMORY, "no memory to store a trim region");
    memcpy(s->words + s->count, words, count * sizeof *words);
    s->count += count;
    return EP_OK;
}

static void set_size(keeper *k, size_t head)
{
    k->store->words[head] |= (uint32_t)(k->store->count - head) << EP_NODE_SIZE_SHIFT;
}

/* A strip in five words, and how much of the domain's width it takes: 1 when there is none that leaves much beside
 * it. */
static void find_strip(keeper *k, const ep_trim_part *part, const ep_trim_domain *d, uint32_t words[5], double *share)
{
    *share = 1;
    ep_arcs arcs;
    const ep_trim_domain settled = ep_domain_settle(d, k->trim->scale);
    if (!ep_arcs_find(k->trim, part, &settled, &arcs) || !arcs.count) return;
    const ep_strip strip = ep_strip_around(arcs.point, arcs.count);
    const double *n = strip.n;
    double all_lo, all_hi;
    ep_strip_extent(n, d->corner, d->count, &all_lo, &all_hi);
    float f[4] = {(float)n[0], (float)n[1]};
    const double rounding = 2 * ep_domain_rounding(d, k->trim->scale); /* here and in the test */
    f[2] = ep_round_down(strip.lo - rounding);
    f[3] = ep_round_up(strip.hi + rounding);
    *share = (fmin(f[3], all_hi) - fmax(f[2], all_lo)) / (all_hi - all_lo);
    if (!(*share < 0.75)) {
        *share = 1;
        return;
    }
    /* Ask at points that are not in a seam along the border. A side that none of them reaches is left to the exact
     * test. */
    ep_point2 centre;
    ep_domain_centre(d, centre);
    uint32_t head = EP_NODE_STRIP;
    bool above = false, below = false;
    for (unsigned i = 0; i < d->count; ++i) {
        const double u = d->corner[i][0] + 0x1p-4 * (centre[0] - d->corner[i][0]);
        const double v = d->corner[i][1] + 0x1p-4 * (centre[1] - d->corner[i][1]), h = n[0] * u + n[1] * v;
        if (h <= f[3] && h >= f[2]) continue;
        const bool inside = ep_trim_inside_one(k->trim, part->words, 0, u, v);
        if (inside) head |= h > f[3] ? EP_NODE_BIT4 : EP_NODE_BIT3;
        above |= h > f[3], below |= h < f[2];
    }
    if (!above) f[3] = INFINITY;
    if (!below) f[2] = -INFINITY;
    words[0] = head;
    for (int i = 0; i < 4; ++i) words[i + 1] = ep_node_from_float(f[i]);
}

/* A way to halve a part: the domains and what is in them. */
typedef struct halving {
    int axis;
    float at;
    ep_trim_domain domain[2];
    ep_trim_part part[2];
} halving;

static size_t pieces_of(const ep_trim_part *p)
{
    return p->state == EP_TRIM_CROSSED ? p->pieces : 0;
}
static size_t total(const halving *h)
{
    return pieces_of(&h->part[0]) + pieces_of(&h->part[1]);
}

static void free_halving(halving *h)
{
    for (int i = 0; i < 2; ++i) ep_trim_part_free(&h->part[i]);
}

/* `possible` is false when the domain is too narrow. */
static EPStatus halve(keeper *k, const ep_trim_part *part, const ep_trim_domain *d, int axis, halving *h,
                      bool *possible)
{
    ep_point2 lo, hi;
    ep_domain_bounds(d, lo, hi);
    memset(h, 0, sizeof *h);
    h->axis = axis;
    h->at = (float)(0.5 * (lo[axis] + hi[axis]));
    *possible =
        ep_domain_clip(d, axis, h->at, false, &h->domain[0]) && ep_domain_clip(d, axis, h->at, true, &h->domain[1]);
    if (!*possible) return EP_OK;
    for (int i = 0; i < 2; ++i) {
        EPStatus s = ep_trim_cut(k->trim, part, &h->domain[i], &h->part[i], k->message);
        if (s) {
            free_halving(h);
            return s;
        }
    }
    return EP_OK;
}

/* The better of the two ways; `found` is false when neither sorts the pieces. */
static EPStatus choose(keeper *k, const ep_trim_part *part, const ep_trim_domain *d, double most, halving *best,
                       bool *found)
{
    *found = false;
    for (int axis = 0; axis < 2; ++axis) {
        halving h;
        bool possible;
        EPStatus s = halve(k, part, d, axis, &h, &possible);
        if (s) {
            if (*found) free_halving(best);
            return s;
        }
        if (!possible) continue;
        if (total(&h) < 2 * part->pieces && (double)total(&h) <= most && (!*found || total(&h) < total(best))) {
            if (*found) free_halving(best);
            *best = h;
            *found = true;
        } else {
            free_halving(&h);
        }
    }
    return EP_OK;
}

static EPStatus keep(keeper *k, const ep_trim_part *part, const ep_trim_domain *d, double most, unsigned depth);

static EPStatus keep_halves(keeper *k, halving *h, double most, unsigned depth)
{
    const size_t head = k->store->count;
    EPStatus s = put(k, 2, (const uint32_t[]){EP_NODE_SPLIT | (h->axis ? EP_NODE_BIT4 : 0), ep_node_from_float(h->at)});
    const double each = most / fmax((double)total(h), 1);
    for (int i = 0; i < 2 && !s; ++i)
        s = keep(k, &h->part[i], &h->domain[i], each * (double)pieces_of(&h->part[i]), depth + 1);
    if (!s) set_size(k, head);
    return s;
}

/* `most` entries may be stored for the part. */
static EPStatus keep(keeper *k, const ep_trim_part *part, const ep_trim_domain *d, double most, unsigned depth)
{
    if (part->state != EP_TRIM_CROSSED) {
        const uint32_t bit = part->state == EP_TRIM_INSIDE ? EP_NODE_BIT3 : 0;
        return put(k, 1, (const uint32_t[]){ep_node_word(EP_NODE_CONST, bit, 1)});
    }
    const size_t head = k->store->count;
    uint32_t strip[5];
    double share;
    find_strip(k, part, d, strip, &share);
    EPStatus s = share < 1 ? put(k, 5, strip) : EP_OK;
    if (s) return s;
    halving h;
    bool halved = false;
    if (share * (double)part->pieces > FEW_PIECES && depth < k->most_depth) s = choose(k, part, d, most, &h, &halved);
    if (s) return s;
    if (halved) {
        s = keep_halves(k, &h, most, depth);
        free_halving(&h);
    } else {
        s = put(k, ep_node_size(*part->words), part->words);
    }
    if (!s && share < 1) set_size(k, head);
    return s;
}

EPStatus ep_trim_keep(const ep_trim *trim, const ep_trim_part *part, const ep_trim_domain *domain, ep_trim_store *store,
                      uint32_t *node, ep_message *m)
{
    keeper k = {.trim = trim, .store = store, .message = m};
    /* twice what evenly spread pieces need, and some more for those that are not */
    for (k.most_depth = 8; part->state == EP_TRIM_CROSSED && part->pieces >> (k.most_depth - 8) / 2; ++k.most_depth) {
    }
    const size_t head = store->count;
    const EPStatus s = keep(&k, part, domain, most_copies * (double)part->pieces, 0);
    if (s) store->count = head;
    *node = (uint32_t)head;
    return s;
}
