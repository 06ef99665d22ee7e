/* build.c - cuts patches into leaves.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A piece is split until its certificate (leaf.h) holds for all but nearly tangent rays and its prism is thin:
 * Stürzlinger's criterion, with the thickness taken relative to the piece, so that it means the same at any scale and
 * bounds how far the surface turns within a leaf. At a pole, cusp or fold the certificate never holds; there splitting
 * ends early, because a fold is a curve and the pieces along it double at each level, and subdivision along the ray
 * takes over. Rectangles are halved along the side that turns more, triangles are quartered.
 *
 * Patches are independent, so they are built in parallel into lists of their own, which are joined in order. */
#include "embree_patch/build.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

/* How far the parametrisation of a leaf may be from affine. */
static const double max_distortion = 0.57;

/* Halvings after which a piece that folds or collapses within is left to subdivision along the ray. */
enum { FOLD_DEPTH = 12 };

/* The leaves of one patch. */
typedef struct list {
    ep_leaf *leaves;
    ep_box *boxes;
    float *nets;
    ep_trim_store crossed;
    size_t count, capacity, net_count, net_capacity;
    size_t uncertified;
    double depth_sum, thickness_sum;
    unsigned depth_max;
    double error;
    EPStatus status; /* once it is not EP_OK the list is dropped */
} list;

/* Leaves and boxes grow together. */
static bool reserve(list *l, size_t net_floats)
{
    size_t leaves = l->capacity, boxes = l->capacity;
    const bool full = !ep_reserve((void **)&l->leaves, &leaves, l->count, 1, sizeof *l->leaves) ||
                      !ep_reserve((void **)&l->boxes, &boxes, l->count, 1, sizeof *l->boxes) ||
                      !ep_reserve((void **)&l->nets, &l->net_capacity, l->net_count, net_floats, sizeof *l->nets);
    if (full) l->status = EP_NO_MEMORY;
    else l->capacity = leaves;
    return !full;
}

static void list_free(list *l)
{
    ep_free(l->leaves);
    ep_free(l->boxes);
    ep_free(l->nets);
    ep_free(l->crossed.words);
}

typedef struct piece_args {
    const ep_patch *patch;
    const ep_trim *trim;
    const ep_point *local;
    uint32_t index;
    const EPBuildSettings *settings;
    ep_fit *fit; /* scratch */
} piece_args;

/* What decides within the leaf; the words of the patch begin at 1. */
static bool keep_part(const piece_args *a, const ep_domain *d, const ep_trim_part *part, ep_leaf *leaf, list *l)
{
    ep_message unused;
    uint32_t node;
    const ep_trim_domain domain = ep_trimmed_domain(a->patch->kind, d);
    l->status = ep_trim_keep(a->trim, part, &domain, &l->crossed, &node, &unused);
    leaf->trim = node + 1;
    return l->status == EP_OK;
}

static void add_leaf(const piece_args *a, const ep_domain *d, const ep_trim_part *part, unsigned depth, list *l)
{
    const ep_fit *f = a->fit;
    if (!reserve(l, f->net_floats)) return;
    ep_leaf *leaf = &l->leaves[l->count];
    ep_box *box = &l->boxes[l->count];
    *leaf = f->leaf;
    leaf->patch = a->index;
    leaf->net = (uint32_t)l->net_count;
    if (part && !keep_part(a, d, part, leaf, l)) return;
    ep_leaf_pack(f, l->nets + l->net_count);
    l->net_count += f->net_floats;
    for (int c = 0; c < 3; ++c) {
        box->lower[c] = ep_round_down(f->lower[c]);
        box->upper[c] = ep_round_up(f->upper[c]);
    }
    if (!f->regular) ++l->uncertified;
    else l->thickness_sum += f->thickness;
    l->error = fmax(l->error, f->error);
    l->depth_sum += depth;
    if (depth > l->depth_max) l->depth_max = depth;
    ++l->count;
}

/* A series of high degree over a large piece loses more than this of the patch; over smaller ones it does not. */
static const double max_loss = 0x1p-26;

/* What is to be done with a piece that the surface is content with: in a slender triangle the thickness, which is
 * relative to its width, says nothing any more. */
typedef enum stage { SURFACE, TRIM } stage;

static void build_piece(const piece_args *a, const ep_domain *d, const ep_trim_part *part, stage stage, unsigned depth,
                        list *l);

/* The parts of a piece that the trim keeps something of. `part`: of the piece, NULL when it is inside. */
static void build_parts(const piece_args *a, const ep_domain *d, unsigned count, const ep_trim_part *part, stage stage,
                        unsigned depth, list *l)
{
    for (unsigned k = 0; k < count && l->status == EP_OK; ++k) {
        if (!part) {
            build_piece(a, &d[k], NULL, stage, depth, l);
            continue;
        }
        ep_message unused;
        ep_trim_part own = {0};
        const ep_trim_domain domain = ep_trimmed_domain(a->patch->kind, &d[k]);
        l->status = ep_trim_cut(a->trim, part, &domain, &own, &unused);
        if (l->status == EP_OK && own.state != EP_TRIM_OUTSIDE)
            build_piece(a, &d[k], own.state == EP_TRIM_CROSSED ? &own : NULL, stage, depth, l);
        ep_trim_part_free(&own);
    }
}

static void build_piece(const piece_args *a, const ep_domain *d, const ep_trim_part *part, stage stage, unsigned depth,
                        list *l)
{
    ep_fit *f = a->fit;
    const ep_kind_id kind = a->patch->kind;
    ep_leaf_fit(a->patch, a->local, d, f);
    if (depth < a->settings->maxDepth) {
        const bool good = (f->thickness <= a->settings->thickness || stage == TRIM) &&
                          f->distortion <= max_distortion && f->loss <= max_loss;
        const bool hopeless = stage == SURFACE && !(f->distortion < 1) && depth * ep_kinds[kind].halvings >= FOLD_DEPTH;
        ep_domain parts[EP_TRIMMED_PARTS];
        if (!good && !hopeless) {
            const unsigned n = ep_kinds[kind].split(d, f->turn[1] > f->turn[0], parts);
            build_parts(a, parts, n, part, stage, depth + 1, l);
            return;
        }
        if (part && ep_trimmed_wants_split(a->trim, part, kind, d, a->settings->trimSplit)) {
            const unsigned n = ep_trimmed_split(a->trim, part, kind, d, a->settings->trimSplit, f->distortion, parts);
            build_parts(a, parts, n, part, hopeless ? SURFACE : TRIM, depth + 1, l);
            return;
        }
    }
    add_leaf(a, d, part, depth, l);
}

static void build_patch(const ep_patch *p, const ep_trim *trim, uint32_t index, const EPBuildSettings *settings,
                        ep_fit *fit, list *l)
{
    static const ep_domain whole = {0, 0, 1, 0, 0, 1};
    ep_point local[EP_NET_POINTS];
    ep_patch_local(p, local);
    const piece_args a = {p, trim, local, index, settings, fit};
    build_parts(&a, &whole, 1, trim ? &trim->root : NULL, SURFACE, 0, l);
}

/* Embree's traversal of user geometry is never the robust one: its slab test rounds in proportion to the coordinates
 * and to the ray's distance. One unit in the last place of their sum a side was enough in every measurement; this is
 * four. */
static void pad_boxes(ep_hierarchy *h, const EPBuildSettings *settings)
{
    float *b = h->bounds;
    for (int c = 0; c < 3; ++c) b[c] = INFINITY, b[3 + c] = -INFINITY;
    for (size_t i = 0; i < h->leaf_count; ++i)
        for (int c = 0; c < 3; ++c) {
            b[c] = fminf(b[c], h->boxes[i].lower[c]);
            b[3 + c] = fmaxf(b[3 + c], h->boxes[i].upper[c]);
        }
    if (!h->leaf_count) return;
    double size = 0, far = 0;
    for (int c = 0; c < 3; ++c) {
        size = fmax(size, (double)b[3 + c] - b[c]);
        far = fmax(far, fmax(fabsf(b[c]), fabsf(b[3 + c])));
    }
    const double distance = settings->rayDistance > 0 ? settings->rayDistance : 64 * size;
    const double pad = 0x1p-22 * (far + distance);
    for (size_t i = 0; i < h->leaf_count; ++i)
        for (int c = 0; c < 3; ++c) {
            h->boxes[i].lower[c] = ep_round_down(h->boxes[i].lower[c] - pad);
            h->boxes[i].upper[c] = ep_round_up(h->boxes[i].upper[c] + pad);
        }
}

static EPStatus join(list *lists, size_t count, ep_hierarchy *out)
{
    size_t total = 0, floats = 0, words = 1;
    for (size_t i = 0; i < count; ++i) {
        if (lists[i].status != EP_OK) return lists[i].status;
        total += lists[i].count;
        floats += lists[i].net_count;
        words += lists[i].crossed.count;
    }
    if (total > UINT32_MAX || floats > UINT32_MAX || words > UINT32_MAX) return EP_UNSUPPORTED;
    out->leaves = ep_alloc(total, sizeof(ep_leaf));
    out->boxes = ep_alloc(total, sizeof(ep_box));
    out->nets = ep_alloc(floats, sizeof(float));
    out->crossed = ep_alloc(words, sizeof(uint32_t));
    if (!out->leaves || !out->boxes || !out->nets || !out->crossed) return EP_NO_MEMORY;
    out->crossed[0] = 0;
    out->trim_words = 1;
    double depth = 0, thickness = 0;
    for (size_t i = 0; i < count; ++i) {
        const list *l = &lists[i];
        if (!l->count) continue;
        ep_leaf *leaves = out->leaves + out->leaf_count;
        memcpy(leaves, l->leaves, l->count * sizeof(ep_leaf));
        for (size_t k = 0; k < l->count; ++k) {
            leaves[k].net += (uint32_t)out->net_floats;
            /* 1 counts from the list's first word */
            if (leaves[k].trim) leaves[k].trim += (uint32_t)out->trim_words - 1;
        }
        memcpy(out->boxes + out->leaf_count, l->boxes, l->count * sizeof(ep_box));
        if (l->net_count) memcpy(out->nets + out->net_floats, l->nets, l->net_count * sizeof(float));
        if (l->crossed.count) memcpy(out->crossed + out->trim_words, l->crossed.words, l->crossed.count * 4);
        out->trim_words += l->crossed.count;
        out->leaf_count += l->count;
        out->net_floats += l->net_count;
        out->uncertified += l->uncertified;
        depth += l->depth_sum;
        thickness += l->thickness_sum;
        if (l->depth_max > out->maximum_depth) out->maximum_depth = l->depth_max;
    }
    out->average_depth = total ? depth / (double)total : 0;
    out->average_thickness = total > out->uncertified ? thickness / (double)(total - out->uncertified) : 0;
    return EP_OK;
}

static EPStatus fail(ep_message *message, EPStatus status, size_t count)
{
    if (status == EP_UNSUPPORTED) return ep_fail(message, status, "more than 2^32 leaves; raise the thickness");
    return ep_fail(message, status, "no memory for the leaves of %zu patches", count);
}

EPStatus ep_build(ep_patch *patches, const ep_trim **trims, size_t count, const EPBuildSettings *settings,
                  ep_message *message, ep_hierarchy *out)
{
    memset(out, 0, sizeof *out);
    out->patch_count = count;
    const int threads = settings->threads ? (int)settings->threads : omp_get_max_threads();
    list *lists = ep_alloc(count, sizeof *lists);
    ep_fit *fits = ep_alloc((size_t)threads, sizeof *fits);
    EPStatus status = lists && fits ? EP_OK : EP_NO_MEMORY;
    if (status == EP_OK) {
        memset(lists, 0, count * sizeof *lists);
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t i = 0; i < count; ++i) {
            ep_patch_measure(&patches[i]);
            build_patch(&patches[i], trims[i], (uint32_t)i, settings, &fits[omp_get_thread_num()], &lists[i]);
            patches[i].error = lists[i].error;
        }
        status = join(lists, count, out);
        for (size_t i = 0; i < count; ++i) list_free(&lists[i]);
    }
    ep_free(fits);
    ep_free(lists);
    if (status != EP_OK) {
        ep_hierarchy_free(out);
        return fail(message, status, count);
    }
    out->patches = patches;
    out->trims = trims;
    pad_boxes(out, settings);
    return EP_OK;
}

void ep_hierarchy_free(ep_hierarchy *h)
{
    ep_free(h->patches);
    ep_free(h->trims);
    ep_free(h->crossed);
    ep_free(h->nets);
    ep_free(h->leaves);
    ep_free(h->boxes);
    memset(h, 0, sizeof *h);
}
