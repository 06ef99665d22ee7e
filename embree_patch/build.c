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
#include "embree_patch/kernels.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

/* How far the parametrisation of a leaf may be from affine. */
static const double max_distortion = 0.6;

/* Halvings after which a piece that folds or collapses within is left to subdivision along the ray. */
enum { FOLD_DEPTH = 8 };

/* The leaves of one patch. */
typedef struct list {
    ep_leaf *leaves;
    ep_box *boxes;
    size_t count, capacity;
    size_t uncertified;
    double depth_sum, thickness_sum;
    unsigned depth_max;
    bool no_memory;
} list;

static bool reserve(list *l)
{
    if (l->count < l->capacity) return true;
    const size_t capacity = l->capacity ? 2 * l->capacity : 16;
    ep_leaf *leaves = ep_alloc(capacity, sizeof *leaves);
    ep_box *boxes = ep_alloc(capacity, sizeof *boxes);
    if (!leaves || !boxes) {
        ep_free(leaves);
        ep_free(boxes);
        l->no_memory = true;
        return false;
    }
    if (l->count) {
        memcpy(leaves, l->leaves, l->count * sizeof *leaves);
        memcpy(boxes, l->boxes, l->count * sizeof *boxes);
    }
    ep_free(l->leaves);
    ep_free(l->boxes);
    l->leaves = leaves;
    l->boxes = boxes;
    l->capacity = capacity;
    return true;
}

static void list_free(list *l)
{
    ep_free(l->leaves);
    ep_free(l->boxes);
}

typedef struct piece_args {
    const ep_patch *patch;
    const ep_point *local;
    uint32_t index;
    const EPBuildSettings *settings;
} piece_args;

static void add_leaf(const piece_args *a, const ep_domain *d, unsigned depth, list *l)
{
    if (!reserve(l)) return;
    ep_leaf *leaf = &l->leaves[l->count];
    ep_box *box = &l->boxes[l->count];
    ep_fit_info info;
    ep_leaf_fit(a->patch, a->local, d, true, leaf, &info);
    leaf->patch = a->index;
    for (int c = 0; c < 3; ++c) {
        const double centre = (double)a->patch->centre[c] + (double)a->patch->centre_low[c];
        box->lower[c] = ep_round_down(centre + info.lower[c]);
        box->upper[c] = ep_round_up(centre + info.upper[c]);
    }
    if (!info.regular) ++l->uncertified;
    else l->thickness_sum += info.thickness;
    l->depth_sum += depth;
    if (depth > l->depth_max) l->depth_max = depth;
    ++l->count;
}

static void build_piece(const piece_args *a, const ep_domain *d, unsigned depth, list *l)
{
    ep_leaf leaf;
    ep_fit_info info;
    ep_domain part[4];
    if (depth < a->settings->maxDepth) {
        ep_leaf_fit(a->patch, a->local, d, false, &leaf, &info);
        const bool good = info.thickness <= a->settings->thickness && info.distortion <= max_distortion;
        const bool hopeless = !(info.distortion < 1) && depth >= FOLD_DEPTH;
        if (!good && !hopeless) {
            const unsigned n = ep_kinds[a->patch->kind].split(d, info.turn[1] > info.turn[0], part);
            for (unsigned k = 0; k < n && !l->no_memory; ++k) build_piece(a, &part[k], depth + 1, l);
            return;
        }
    }
    add_leaf(a, d, depth, l);
}

static void build_patch(const ep_patch *p, uint32_t index, const EPBuildSettings *settings, list *l)
{
    static const ep_domain whole = { 0, 0, 1, 0, 0, 1 };
    ep_point local[(EP_MAX_DEGREE + 1) * (EP_MAX_DEGREE + 1)];
    ep_patch_local(p, local);
    const piece_args a = { p, local, index, settings };
    build_piece(&a, &whole, 0, l);
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
    size_t total = 0;
    for (size_t i = 0; i < count; ++i) {
        if (lists[i].no_memory) return EP_NO_MEMORY;
        total += lists[i].count;
    }
    if (total > UINT32_MAX) return EP_UNSUPPORTED;
    out->leaves = ep_alloc(total, sizeof(ep_leaf));
    out->boxes = ep_alloc(total, sizeof(ep_box));
    if (!out->leaves || !out->boxes) return EP_NO_MEMORY;
    double depth = 0, thickness = 0;
    for (size_t i = 0; i < count; ++i) {
        list *l = &lists[i];
        memcpy(out->leaves + out->leaf_count, l->leaves, l->count * sizeof(ep_leaf));
        memcpy(out->boxes + out->leaf_count, l->boxes, l->count * sizeof(ep_box));
        out->leaf_count += l->count;
        out->uncertified += l->uncertified;
        depth += l->depth_sum;
        thickness += l->thickness_sum;
        if (l->depth_max > out->maximum_depth) out->maximum_depth = l->depth_max;
    }
    out->average_depth = total ? depth / (double)total : 0;
    out->average_thickness = total > out->uncertified ? thickness / (double)(total - out->uncertified) : 0;
    return EP_OK;
}

EPStatus ep_build(ep_patch *patches, size_t count, const EPBuildSettings *settings, ep_message *message,
                  ep_hierarchy *out)
{
    memset(out, 0, sizeof *out);
    out->patch_count = count;
    for (size_t i = 0; i < count; ++i)
        out->net_floats += 16 * ep_kinds[patches[i].kind].block_count(patches[i].degree_u, patches[i].degree_v);
    out->nets = ep_alloc(out->net_floats, sizeof(float));
    list *lists = ep_alloc(count, sizeof *lists);
    EPStatus status = out->nets && lists ? EP_OK : EP_NO_MEMORY;
    if (status == EP_OK) {
        memset(lists, 0, count * sizeof *lists);
        float *net = out->nets;
        for (size_t i = 0; i < count; ++i) {
            patches[i].shape = ep_shape(&patches[i]);
            patches[i].net = net;
            net += 16 * ep_kinds[patches[i].kind].block_count(patches[i].degree_u, patches[i].degree_v);
        }
        const int threads = settings->threads ? (int)settings->threads : omp_get_max_threads();
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t i = 0; i < count; ++i) {
            ep_patch_pack(&patches[i], (float *)patches[i].net);
            build_patch(&patches[i], (uint32_t)i, settings, &lists[i]);
        }
        status = join(lists, count, out);
        for (size_t i = 0; i < count; ++i) list_free(&lists[i]);
    }
    ep_free(lists);
    if (status != EP_OK) {
        ep_hierarchy_free(out);
        if (status == EP_UNSUPPORTED) return ep_fail(message, status, "more than 2^32 leaves; raise the thickness");
        return ep_fail(message, status, "no memory for the leaves of %zu patches", count);
    }
    out->patches = patches;
    pad_boxes(out, settings);
    return EP_OK;
}

void ep_hierarchy_free(ep_hierarchy *h)
{
    ep_free(h->patches);
    ep_free(h->nets);
    ep_free(h->leaves);
    ep_free(h->boxes);
    memset(h, 0, sizeof *h);
}
