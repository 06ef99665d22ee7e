/* search.c - nearly tangent rays: the roots in a leaf, all at once, cell by cell, or by subdivision in double.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * What is found must not depend on what the ray has met before, or answers would differ with the order in which Embree
 * visits leaves. So where a ray is cut into cells, and from where to where cells are subdivided, does not depend on
 * tfar; it only decides which of the cells are looked at. */
#include "embree_patch/rtc/search.h"

#include "embree_patch/line.h"
#include "embree_patch/solve.h"

/* Roots found so far, in the patch's parameters: several cells find the same one. What there is no room for may be
 * offered twice. */
typedef struct known_roots {
    unsigned count;
    struct {
        float u, v, radius;
    } root[16];
} known_roots;

/* How exact the parameters of a root found in double are: a float's last place. */
static const float exact_radius = 0x1p-24f;

/* One ray's. */
typedef struct search {
    ep_lane lane;
    float ray[EP_RAY_FIELDS]; /* without tfar */
    ep_candidates c;
    known_roots known;
    bool accepted, counted; /* counted: among the visits that subdivision has decided */
    EPCounters *counters;
} search;

static bool is_new(search *s, float radius)
{
    const float u = s->c.hit[EP_HIT_U], v = s->c.hit[EP_HIT_V];
    known_roots *known = &s->known;
    for (unsigned i = 0; i < known->count; ++i) {
        const float near = known->root[i].radius + radius;
        if (fabsf(u - known->root[i].u) <= near && fabsf(v - known->root[i].v) <= near) return false;
    }
    if (known->count < EP_ARRAY_LEN(known->root)) {
        known->root[known->count].u = u;
        known->root[known->count].v = v;
        known->root[known->count++].radius = radius;
    }
    return true;
}

/* Offers the candidate, unless it is known, to within `radius` in u, v. */
static void offer_root(search *s, float radius)
{
    if (is_new(s, radius) && ep_in_front(&s->lane.query, 0, &s->c)) s->accepted |= ep_offer(&s->lane.query, 1, &s->c);
}

static float tfar_of(const search *s)
{
    return s->lane.ray[EP_RAY_TFAR];
}

/* An occlusion query is answered by any hit. */
static bool is_done(const search *s)
{
    return s->accepted && !s->lane.query.intersect;
}

/* A ray that lies in a surface has no end of roots there: those that are no certain crossings count as one within this
 * part of the leaf's extent. */
enum { TANGENT_PARTS = 16 };

static double tangent_step(const search *s)
{
    const ep_hierarchy *h = s->lane.query.hierarchy;
    const ep_box *b = &h->boxes[s->lane.query.leaf - h->leaves];
    double size = 0, speed = 0;
    for (int k = 0; k < 3; ++k) {
        const double side = (double)b->upper[k] - (double)b->lower[k], d = (double)s->ray[EP_RAY_DIR + k];
        size += side * side;
        speed += d * d;
    }
    return sqrt(size / speed) / TANGENT_PARTS;
}

static void subdivide(search *s, double lo, double hi)
{
    const ep_query *q = &s->lane.query;
    const float tnear = s->ray[EP_RAY_TNEAR];
    /* half-way to the next float: what rounds to more than tnear */
    lo = fmax(lo, 0.5 * ((double)tnear + (double)nextafterf(tnear, INFINITY)));
    ep_root r;
    s->counters->slow += !s->counted;
    s->counted = true;
    while (!is_done(s) && lo < hi &&
           ep_solve(ep_patch_of(q), q->leaf, s->ray + EP_RAY_ORG, s->ray + EP_RAY_DIR, lo, hi, &r)) {
        /* the next one is told apart from this by more than the rounding of both */
        lo = r.t + (r.crossing ? 0x1p-40 * fabs(r.t) : tangent_step(s));
        if ((double)tfar_of(s) < r.t && tfar_of(s) < (float)r.t) return;
        s->c.t[0] = (float)r.t;
        for (unsigned f = 0; f < 3; ++f) s->c.hit[EP_HIT_NG + f] = (float)r.ng[f];
        s->c.hit[EP_HIT_U] = (float)r.u;
        s->c.hit[EP_HIT_V] = (float)r.v;
        offer_root(s, exact_radius);
    }
}

static void subdivide_leaf(search *s)
{
    const ep_query *q = &s->lane.query;
    double lo = -INFINITY, hi = INFINITY;
    ep_line line;
    if (ep_line_of(ep_patch_of(q), s->ray + EP_RAY_ORG, s->ray + EP_RAY_DIR, &line) &&
        ep_line_clip(ep_patch_of(q), q->leaf, &line, &lo, &hi))
        subdivide(s, lo, hi);
}

/* Rounds of cells before subdivision. */
enum { CELL_ROUNDS = 5 };

static void take_cells(search *s, const ep_cells *cells, unsigned first, float from, float to, unsigned round);

static void look_closer(search *s, float from, float to, unsigned round)
{
    const ep_query *q = &s->lane.query;
    static const unsigned only = 0;
    ep_cells cells;
    q->geometry->kernels->cells[q->leaf->shape](q->leaf, q->net, s->ray, 1, &only, 1, &from, &to, &cells);
    const uint32_t undecided = (cells.open | cells.more) & ((1u << EP_CELLS) - 1);
    if (__builtin_popcount(undecided) <= EP_CELLS / 2) {
        take_cells(s, &cells, 0, from, to, round);
        return;
    }
    /* as good as in the surface: parts of a part would fare no better */
    const unsigned last = EP_CELLS - 1;
    const double rounding = 0x1p-22 * fmax(fabsf(cells.middle[0]), fabsf(cells.middle[last]));
    subdivide(s, (double)cells.middle[0] - (double)cells.reach[0] - rounding,
              (double)cells.middle[last] + (double)cells.reach[last] + rounding);
}

/* Takes what was found in cells[first] to cells[first + EP_CELLS - 1], which divide the part `from` to `to` of the
 * ray's way. Undecided ones are cut into cells again. A cell answers for roots with a t of its own, or a neighbour's. A
 * certain one that is farther away is the only one in all that the cell may be: it has none, and whether the other one
 * counts must not depend on which cells tfar leaves. Where Newton goes on to another root when a vague one is polished,
 * it has not found its own. */
static void take_cells(search *s, const ep_cells *cells, unsigned first, float from, float to, unsigned round)
{
    const float length = (to - from) / EP_CELLS;
    const float extent = ep_leaf_extent(s->lane.query.leaf);
    for (unsigned k = 0; k < EP_CELLS && !is_done(s); ++k) {
        const unsigned at = first + k;
        const double t = (double)cells->middle[at], rounding = 0x1p-22 * fabs(t); /* cells are given in float */
        const double reach = (double)cells->reach[at] + rounding;
        bool open = (cells->open | cells->more) >> at & 1, lost = false;
        if ((cells->hit | cells->vague) >> at & 1) {
            s->c.t[0] = cells->t[at];
            for (unsigned f = 0; f < 5; ++f) s->c.hit[f] = cells->fields[f * EP_PACKET + at];
            const bool vague = cells->vague >> at & 1;
            const ep_polished found = vague ? ep_polish_candidate(&s->lane.query, 0, &s->c) : EP_POLISHED;
            const bool own = fabs((double)s->c.t[0] - t) <= 3 * reach;
            lost = found == EP_POLISHED_LOST || (vague && !own);
            if (found == EP_POLISHED && own) offer_root(s, vague ? exact_radius : extent * cells->radius[at]);
        }
        if (!(open || lost) || t - 2 * reach > (double)nextafterf(tfar_of(s), INFINITY)) continue;
        if (lost) subdivide(s, t - 2 * reach, t + 2 * reach);
        else if (round + 1 == CELL_ROUNDS) subdivide(s, t - reach, t + reach);
        else look_closer(s, from + length * (float)k, from + length * (float)(k + 1), round + 1);
    }
}

/* The roots of rays that the tangent kernel is asked about; those in the first place are among the packet's candidates,
 * those in the second are `other`. */
typedef struct pair {
    ep_roots roots;
    ep_candidates *c, other;
    float extent;
} pair;

/* Finds vague roots in place k again in double: hits are certain then. Lanes where one is lost are open. */
static void polish_roots(const ep_query *q, pair *p, unsigned k, uint32_t lanes)
{
    ep_roots *roots = &p->roots;
    for (lanes &= ~roots->open; lanes; lanes &= lanes - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(lanes);
        const uint32_t bit = 1u << lane;
        const ep_polished found = ep_polish_candidate(q, lane, k ? &p->other : p->c);
        roots->hit[k] = found == EP_POLISHED ? roots->hit[k] | bit : roots->hit[k] & ~bit;
        roots->vague[k] &= ~bit;
        if (found == EP_POLISHED) roots->radius[k][lane] = exact_radius / p->extent;
        if (found == EP_POLISHED_LOST) roots->open |= bit;
    }
}

static void swap_roots(unsigned n, unsigned lane, pair *p)
{
    float *first = &p->c->t[lane], *second = &p->other.t[lane];
    for (unsigned f = 0; f < 6; ++f) {
        const float x = *first;
        *first = *second;
        *second = x;
        first = &p->c->hit[f * n + lane];
        second = &p->other.hit[f * n + lane];
    }
    uint32_t *vague = p->roots.vague;
    const uint32_t differ = (vague[0] ^ vague[1]) & 1u << lane;
    vague[0] ^= differ;
    vague[1] ^= differ;
}

/* Where a ray has two roots the nearer one becomes the first. */
static void order_roots(unsigned n, pair *p)
{
    for (uint32_t rest = p->roots.hit[0] & p->roots.hit[1]; rest; rest &= rest - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(rest);
        if (p->other.t[lane] < p->c->t[lane]) swap_roots(n, lane, p);
    }
}

/* Where both are the same, among `lanes`, it keeps the first. */
static void keep_different(unsigned n, pair *p, uint32_t lanes)
{
    ep_roots *roots = &p->roots;
    for (lanes &= roots->hit[0] & roots->hit[1]; lanes; lanes &= lanes - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(lanes);
        const float near = p->extent * (roots->radius[0][lane] + roots->radius[1][lane]);
        const float *a = &p->c->hit[EP_HIT_U * n + lane], *b = &p->other.hit[EP_HIT_U * n + lane];
        if (fabsf(a[0] - b[0]) <= near && fabsf(a[n] - b[n]) <= near) roots->hit[1] &= ~(1u << lane);
    }
}

/* Those in place k that are in front of what their rays have. */
static uint32_t front_of(const ep_query *q, const pair *p, unsigned k)
{
    uint32_t front = p->roots.hit[k] & ~p->roots.open;
    for (uint32_t rest = front; rest; rest &= rest - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(rest);
        if (!ep_in_front(q, lane, k ? &p->other : p->c)) front &= ~(1u << lane);
    }
    return front;
}

/* Offers the packet's candidates in `front`, and the roots of rays that the tangent kernel decides; leaves the others
 * in *slow. */
static uint32_t take_roots(const ep_query *q, uint32_t *slow, uint32_t front, ep_candidates *c)
{
    pair p;
    p.c = c;
    p.extent = ep_leaf_extent(q->leaf);
    p.roots.t[0] = c->t;
    p.roots.hits[0] = c->hit;
    p.roots.t[1] = p.other.t;
    p.roots.hits[1] = p.other.hit;
    q->geometry->kernels->tangent[q->leaf->shape](q->leaf, q->net, q->ray, q->n, *slow, &p.roots);
    for (unsigned k = 0; k < 2; ++k) polish_roots(q, &p, k, ep_to_polish(q, p.roots.hit[k], p.roots.vague[k]));
    order_roots(q->n, &p);
    /* of what is still vague float cannot tell whether it is the same */
    const uint32_t vague = p.roots.vague[0] | p.roots.vague[1], unclear = vague & p.roots.hit[0] & p.roots.hit[1];
    keep_different(q->n, &p, ~unclear);
    ep_candidates first;
    if (unclear) first = *c; /* offers change it */
    front |= front_of(q, &p, 0);
    uint32_t accepted = front ? ep_offer(q, front, c) : 0;
    if (!q->intersect) p.roots.hit[1] &= ~accepted; /* any hit answers */
    const uint32_t refused = unclear & p.roots.hit[1];
    if (refused) {
        p.c = &first;
        for (unsigned k = 0; k < 2; ++k) polish_roots(q, &p, k, refused & p.roots.vague[k]);
        keep_different(q->n, &p, refused);
    }
    front = front_of(q, &p, 1);
    if (front) accepted |= ep_offer(q, front, &p.other);
    *slow = p.roots.open;
    return accepted;
}

uint32_t ep_search(const ep_query *q, uint32_t slow, uint32_t front, ep_candidates *c, EPCounters *counters)
{
    enum { RAYS = EP_PACKET / EP_CELLS };
    static const float begin[RAYS] = {-1, -1, -1, -1}, end[RAYS] = {1, 1, 1, 1};
    /* where the parametrisation folds or collapses, kernels cannot decide */
    const bool cut = q->leaf->height < INFINITY && q->leaf->stretch < EP_STRETCH;
    uint32_t accepted = cut ? take_roots(q, &slow, front, c) : front ? ep_offer(q, front, c) : 0;
    while (slow) {
        unsigned lanes[RAYS], count = 0;
        for (; slow && count < RAYS; slow &= slow - 1) lanes[count++] = (unsigned)__builtin_ctz(slow);
        ep_cells cells;
        if (cut)
            q->geometry->kernels->cells[q->leaf->shape](q->leaf, q->net, q->ray, q->n, lanes, count, begin, end,
                                                        &cells);
        for (unsigned r = 0; r < count; ++r) {
            search s = {.known.count = 0, .accepted = false, .counters = counters};
            ep_take_lane(q, lanes[r], &s.lane);
            ep_take_hit(q, lanes[r], &s.lane);
            for (unsigned f = 0; f < EP_RAY_FIELDS; ++f) s.ray[f] = s.lane.ray[f];
            s.ray[EP_RAY_TFAR] = INFINITY;
            if (cut && !(cells.hopeless >> r * EP_CELLS & 1)) {
                ++counters->cells;
                take_cells(&s, &cells, r * EP_CELLS, -1, 1, 0);
            } else {
                subdivide_leaf(&s);
            }
            if (!s.accepted) continue;
            accepted |= 1u << lanes[r];
            ep_put_lane(&s.lane, q, lanes[r]);
        }
    }
    return accepted;
}
