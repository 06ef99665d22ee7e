/* cells.c - storing a part so that testing points against it takes next to no time. See trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Strip: all curves in the domain lie between two parallel lines. The domain beyond either line is convex and no curve
 * enters it, so it is inside or outside as a whole, however many curves and operators there are. In a sliver along a
 * trim curve nearly all points are decided by this.
 *
 * Cells: a rectangle with many pieces becomes a grid with more cells than pieces, most of them empty: two products and
 * a word of memory decide nearly every point, however many curves there are. The region as a whole has such a grid,
 * with a band (band.h) for each cell, and leaves with many pieces refer to it. Where pieces are too long for that, or
 * the domain is no rectangle, it is halved along u or v, whichever duplicates fewer pieces. Either way the stored lists
 * stay within a multiple of the pieces: memory is linear in their number. */
#include "trim/arcs.h"
#include "trim/band.h"
#include "trim/node.h"

#include <string.h>

/* Lists that are not worth a split: testing a piece costs about as much as passing a split. */
enum { FEW_PIECES = 3 };
/* Entries of the stored lists for each piece of the part. */
static const double most_copies = 16;

typedef struct keeper {
    const ep_trim *trim;
    ep_trim_store *store;
    ep_message *message;
    unsigned most_depth;
    bool own; /* the region's own cells are being made: nothing can refer to them */
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
    float f[4] = {(float)strip.n[0], (float)strip.n[1]};
    const double n[2] = {f[0], f[1]};
    double lo, hi, all_lo, all_hi;
    ep_strip_extent(n, arcs.point, arcs.count, &lo, &hi);
    ep_strip_extent(n, d->corner, d->count, &all_lo, &all_hi);
    const double rounding = 2 * ep_domain_rounding(d, k->trim->scale); /* here and in the test */
    f[2] = ep_round_down(lo - rounding);
    f[3] = ep_round_up(hi + rounding);
    *share = (fmin(f[3], all_hi) - fmax(f[2], all_lo)) / (all_hi - all_lo);
    if (!(*share < 0.75)) {
        *share = 1;
        return;
    }
    /* Ask at points that are not in a seam along the border. A side that none of them reaches is left to the exact
     * test. */
    ep_point2 centre;
    ep_domain_centre(d, centre);
    const double inwards = d->margin < 0 ? 0x1p-4 : 0;
    uint32_t head = EP_NODE_STRIP;
    bool above = false, below = false;
    for (unsigned i = 0; i < d->count; ++i) {
        const double u = d->corner[i][0] + inwards * (centre[0] - d->corner[i][0]);
        const double v = d->corner[i][1] + inwards * (centre[1] - d->corner[i][1]), h = n[0] * u + n[1] * v;
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

/* Fewer pieces than that are no work for a grid; each gets so many of its cells, which costs as much memory as it has
 * itself. */
enum { GRID_PIECES = 12, GRID_CELLS = 8, GRID_MOST_SIDE = (1 << 12) - 2 };

static EPStatus keep(keeper *k, const ep_trim_part *part, const ep_trim_domain *d, double most, unsigned depth);

typedef struct filler {
    keeper *keeper;
    size_t head; /* of the node */
    ep_grid grid;
    double margin, room; /* room: entries that may still be stored */
    unsigned depth;
    uint32_t *bands; /* of the cells, or NULL */
} filler;

static bool is_rectangle(const ep_trim_domain *d)
{
    if (d->count != 4) return false;
    for (int i = 0; i < 4; ++i) {
        const double *a = d->corner[i], *b = d->corner[(i + 1) % 4];
        if ((a[0] == b[0]) == (a[1] == b[1])) return false;
    }
    return true;
}

static double edge_of(const filler *f, int axis, uint32_t i)
{
    return f->grid.lo[axis] + i / f->grid.per_unit[axis];
}

/* Cells from[] to to[] - 1 of either axis; `part` is what is in them. Ends early when there is no room. */
static EPStatus fill(filler *f, const ep_trim_part *part, const uint32_t from[2], const uint32_t to[2])
{
    keeper *k = f->keeper;
    const uint32_t nu = to[0] - from[0], nv = to[1] - from[1];
    const size_t cells = f->head + EP_GRID_HEAD;
    if (part->state != EP_TRIM_CROSSED) {
        for (uint32_t j = from[1]; j < to[1]; ++j)
            for (uint32_t i = from[0]; i < to[0]; ++i) {
                const size_t at = (size_t)j * f->grid.count[0] + i;
                k->store->words[cells + at] = part->state == EP_TRIM_INSIDE;
                if (f->bands) ep_band_even(part->state == EP_TRIM_INSIDE, f->bands + 2 * at);
            }
        return EP_OK;
    }
    if (nu == 1 && nv == 1) {
        f->room -= (double)part->pieces;
        if (f->room < 0) return EP_OK;
        const size_t at = (size_t)from[1] * f->grid.count[0] + from[0];
        k->store->words[cells + at] = (uint32_t)(k->store->count - f->head);
        ep_trim_domain d = ep_domain_rectangle(edge_of(f, 0, from[0]), edge_of(f, 0, to[0]), edge_of(f, 1, from[1]),
                                               edge_of(f, 1, to[1]), f->margin);
        if (f->bands) {
            const uint32_t *n = f->grid.count;
            ep_band_fit(k->trim, part, &d, n[0] > n[1] ? n[0] : n[1], f->bands + 2 * at);
            d.margin = 0; /* what the bands leave open is tested cell by cell */
        }
        return keep(k, part, &d, 2 * (double)part->pieces, f->depth);
    }
    const int axis = nv > nu;
    EPStatus s = EP_OK;
    for (int i = 0; i < 2 && !s && f->room >= 0; ++i) {
        uint32_t a[2] = {from[0], from[1]}, b[2] = {to[0], to[1]};
        *(i ? &a[axis] : &b[axis]) = (from[axis] + to[axis]) / 2;
        const ep_trim_domain d = ep_domain_rectangle(edge_of(f, 0, a[0]), edge_of(f, 0, b[0]), edge_of(f, 1, a[1]),
                                                     edge_of(f, 1, b[1]), f->margin);
        ep_trim_part half;
        s = ep_trim_cut(k->trim, part, &d, &half, k->message);
        if (!s) s = fill(f, &half, a, b);
        ep_trim_part_free(&half);
    }
    return s;
}

/* About square cells. */
static void choose_grid(const ep_trim_part *part, const ep_trim_domain *d, ep_grid *g)
{
    ep_point2 hi;
    ep_domain_bounds(d, g->lo, hi);
    const double cells = GRID_CELLS * (double)part->pieces;
    for (int c = 0; c < 2; ++c) {
        const double size = hi[c] - g->lo[c], other = hi[!c] - g->lo[!c];
        const double n = fmin(fmax(ceil(sqrt(cells * size / other)), 1), fmin(cells, GRID_MOST_SIDE));
        g->count[c] = (uint32_t)n;
        g->per_unit[c] = n / size;
    }
}

/* Can float tell where in the grid's cells a point is? */
static bool is_told_apart(const ep_trim_part *part, const ep_trim_domain *d)
{
    ep_grid g;
    const ep_point2 *corner = d->corner;
    if (!(corner[2][0] > corner[0][0] && corner[2][1] > corner[0][1])) return false;
    choose_grid(part, d, &g);
    return 0x1p-22 * ep_domain_scale(d) * fmax(g.per_unit[0], g.per_unit[1]) < 0.1 * EP_BAND_MARGIN;
}

/* One more cell all around, so that there is nothing beyond the last. */
static void widen(ep_grid *g)
{
    for (int c = 0; c < 2; ++c) {
        g->lo[c] = (double)ep_round_down(g->lo[c] - 1 / g->per_unit[c]); /* a float, for the bands */
        g->count[c] += 2;
    }
}

static EPStatus start_bands(keeper *k, const ep_grid *g, ep_bands *b)
{
    b->words = ep_alloc(2 * ep_grid_cells(g), sizeof *b->words);
    if (!b->words) return ep_fail(k->message, EP_NO_MEMORY, "no memory to store a trim region");
    for (int c = 0; c < 2; ++c) {
        b->lo[c] = (float)g->lo[c], b->per_unit[c] = (float)g->per_unit[c];
        b->last[c] = nextafterf((float)g->count[c], 0);
    }
    b->columns = (float)g->count[0];
    b->reach = 0.9 * EP_BAND_MARGIN / fmax(g->per_unit[0], g->per_unit[1]);
    return EP_OK;
}

/* `kept` is false when long pieces would be in too many cells. Half of the entries may stand in cells, so that each
 * cell may have twice as many when it is divided further. */
static EPStatus keep_grid(keeper *k, const ep_trim_part *part, const ep_trim_domain *d, double most, unsigned depth,
                          ep_bands *bands, bool *kept)
{
    filler f = {.keeper = k, .head = k->store->count, .margin = d->margin, .room = most / 2, .depth = depth};
    choose_grid(part, d, &f.grid);
    if (bands) widen(&f.grid);
    const uint32_t *n = f.grid.count;
    for (size_t i = ep_grid_cells(&f.grid); i > 1; i /= 2) ++f.depth;
    /* a piece is in about as many cells as it is long, and one more for either coordinate */
    const double width = n[0] / f.grid.per_unit[0], height = n[1] / f.grid.per_unit[1];
    const double length = ep_trim_part_length(k->trim, part->words, hypot(width, height));
    *kept = (double)part->pieces + 2 * length * fmax(f.grid.per_unit[0], f.grid.per_unit[1]) <= 2 * f.room;
    if (!*kept) return EP_OK;
    uint32_t head[EP_GRID_HEAD] = {EP_NODE_GRID};
    memcpy(head + 1, f.grid.lo, sizeof f.grid.lo);
    memcpy(head + 5, f.grid.per_unit, sizeof f.grid.per_unit);
    head[9] = n[0] | n[1] << 16;
    EPStatus s = put(k, EP_GRID_HEAD, head);
    for (uint32_t j = 0; j < n[1] && !s; ++j)
        for (uint32_t i = 0; i < n[0] && !s; ++i) s = put(k, 1, (const uint32_t[]){0});
    if (!s && bands) {
        s = start_bands(k, &f.grid, bands);
        f.bands = bands->words;
        f.margin = bands->reach / 0.9; /* which leaves room for what rounds */
    }
    if (!s) s = fill(&f, part, (const uint32_t[]){0, 0}, n);
    *kept = f.room >= 0;
    if (*kept && !s) set_size(k, f.head);
    else k->store->count = f.head;
    return s;
}

/* `kept` is false when halving does not sort the pieces. */
static EPStatus keep_halves(keeper *k, const ep_trim_part *part, const ep_trim_domain *d, double most, unsigned depth,
                            bool *kept)
{
    halving h;
    const size_t head = k->store->count;
    EPStatus s = choose(k, part, d, most, &h, kept);
    if (s || !*kept) return s;
    s = put(k, 2, (const uint32_t[]){EP_NODE_SPLIT | (h.axis ? EP_NODE_BIT4 : 0), ep_node_from_float(h.at)});
    const double each = most / fmax((double)total(&h), 1);
    for (int i = 0; i < 2 && !s; ++i)
        s = keep(k, &h.part[i], &h.domain[i], each * (double)pieces_of(&h.part[i]), depth + 1);
    free_halving(&h);
    if (!s) set_size(k, head);
    return s;
}

/* `most` entries may be stored for the part. */
static EPStatus keep(keeper *k, const ep_trim_part *part, const ep_trim_domain *d, double most, unsigned depth)
{
    if (part->state != EP_TRIM_CROSSED) {
        const uint32_t bit = part->state == EP_TRIM_INSIDE ? EP_NODE_BIT3 : 0;
        return put(k, 1, (const uint32_t[]){ep_node_word(EP_NODE_LIST, bit, 1)});
    }
    const size_t head = k->store->count;
    uint32_t strip[5];
    double share;
    find_strip(k, part, d, strip, &share);
    EPStatus s = share < 1 ? put(k, 5, strip) : EP_OK;
    const bool many = share * (double)part->pieces > FEW_PIECES && depth < k->most_depth;
    bool kept = false;
    if (!s && many && part->pieces >= GRID_PIECES && !k->own && k->trim->bands.words) {
        s = put(k, 1, (const uint32_t[]){ep_node_word(EP_NODE_REGION, 0, 1)});
        kept = true;
    }
    if (!s && many && !kept && part->pieces >= GRID_PIECES && is_rectangle(d))
        s = keep_grid(k, part, d, most, depth, NULL, &kept);
    if (!s && many && !kept) s = keep_halves(k, part, d, most, depth, &kept);
    if (!s && !kept) s = put(k, ep_node_size(*part->words), part->words);
    if (!s && share < 1) set_size(k, head);
    return s;
}

/* Twice what evenly spread pieces need, and some more for those that are not. */
static unsigned most_depth(const ep_trim_part *part)
{
    unsigned depth = 8;
    while (part->pieces >> (depth - 8) / 2) ++depth;
    return depth;
}

EPStatus ep_trim_keep(const ep_trim *trim, const ep_trim_part *part, const ep_trim_domain *domain, ep_trim_store *store,
                      uint32_t *node, ep_message *m)
{
    keeper k = {.trim = trim, .store = store, .message = m, .most_depth = most_depth(part)};
    const size_t head = store->count;
    const EPStatus s = keep(&k, part, domain, most_copies * (double)part->pieces, 0);
    if (s) store->count = head;
    *node = (uint32_t)head;
    return s;
}

/* For points anywhere: a box around the cells. */
EPStatus ep_trim_keep_cells(ep_trim *t, ep_message *m)
{
    const ep_trim_part *part = &t->root;
    keeper k = {.trim = t, .store = &t->cells, .message = m, .most_depth = most_depth(part), .own = true};
    t->bands.reach = -1;
    if (part->state != EP_TRIM_CROSSED) return keep(&k, part, &(ep_trim_domain){0}, 0, 0);
    const float box[4] = {ep_round_down(t->lo[0]), ep_round_down(t->lo[1]), ep_round_up(t->hi[0]),
                          ep_round_up(t->hi[1])};
    const ep_trim_domain d = ep_domain_rectangle((double)box[0], (double)box[2], (double)box[1], (double)box[3], 0);
    uint32_t words[EP_BOX_WORDS] = {EP_NODE_BOX};
    for (int i = 0; i < 4; ++i) words[i + 1] = ep_node_from_float(box[i]);
    const double most = most_copies * (double)part->pieces;
    bool kept = false;
    EPStatus s = put(&k, EP_BOX_WORDS, words);
    if (!s && part->pieces >= GRID_PIECES && is_told_apart(part, &d))
        s = keep_grid(&k, part, &d, most, 0, &t->bands, &kept);
    if (!kept) {
        ep_free(t->bands.words);
        t->bands = (ep_bands){.reach = -1};
        if (!s) s = keep(&k, part, &d, most, 0);
    }
    if (!s) set_size(&k, 0);
    return s;
}
