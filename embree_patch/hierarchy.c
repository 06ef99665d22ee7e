/* hierarchy.c - see hierarchy.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/hierarchy.h"

#include <omp.h>
#include <string.h>

/* Leaves and boxes grow together. */
static bool reserve(ep_list *l, size_t net_floats)
{
    size_t leaves = l->capacity, boxes = l->capacity;
    const bool full = !ep_reserve((void **)&l->leaves, &leaves, l->count, 1, sizeof *l->leaves) ||
                      !ep_reserve((void **)&l->boxes, &boxes, l->count, 1, sizeof *l->boxes) ||
                      !ep_reserve((void **)&l->nets, &l->net_capacity, l->net_count, net_floats, sizeof *l->nets);
    if (full) l->status = EP_NO_MEMORY;
    else l->capacity = leaves;
    return !full;
}

/* leaf.domain as it was before it was rounded, if it was not. */
static ep_domain widened(const ep_leaf *leaf)
{
    const float *f = leaf->domain;
    return (ep_domain){.u0 = f[0], .v0 = f[1], .uu = f[2], .vv = f[3], .uv = f[4], .vu = f[5]};
}

static bool keep_domain(ep_list *l, const ep_leaf *leaf, const ep_domain *d)
{
    const ep_domain w = widened(leaf);
    if (w.u0 == d->u0 && w.v0 == d->v0 && w.uu == d->uu && w.vv == d->vv && w.uv == d->uv && w.vu == d->vu) return true;
    if (!ep_reserve((void **)&l->exact, &l->exact_capacity, l->exact_count, 1, sizeof *l->exact)) return false;
    l->exact[l->exact_count++] = (ep_exact_domain){l->count, *d};
    return true;
}

void ep_list_add(ep_list *l, const ep_fit *f, const ep_domain *d, uint32_t patch, uint32_t trim, unsigned depth)
{
    if (!reserve(l, f->net_floats)) return;
    if (!keep_domain(l, &f->leaf, d)) {
        l->status = EP_NO_MEMORY;
        return;
    }
    ep_leaf *leaf = &l->leaves[l->count];
    ep_box *box = &l->boxes[l->count];
    *leaf = f->leaf;
    leaf->patch = patch;
    leaf->net = (uint32_t)l->net_count;
    leaf->trim = trim;
    ep_leaf_pack(f, l->nets + l->net_count);
    l->net_count += f->net_floats;
    double lower[3], upper[3];
    ep_leaf_box(f, d, lower, upper);
    for (int c = 0; c < 3; ++c) {
        box->lower[c] = ep_round_down(lower[c]);
        box->upper[c] = ep_round_up(upper[c]);
    }
    if (!f->regular) ++l->uncertified;
    else l->thickness_sum += f->thickness;
    l->error = fmax(l->error, f->error);
    l->depth_sum += depth;
    if (depth > l->depth_max) l->depth_max = depth;
    ++l->count;
}

void ep_list_free(ep_list *l)
{
    ep_free(l->leaves);
    ep_free(l->boxes);
    ep_free(l->nets);
    ep_free(l->exact);
    ep_free(l->crossed.words);
}

/* Embree's traversal of user geometry is never the robust one: its slab test rounds in proportion to the coordinates
 * and to the ray's distance. One unit in the last place of their sum a side was enough in every measurement; this is
 * four. */
static double padding_of(const float b[6], const EPBuildSettings *settings)
{
    double size = 0, far = 0;
    for (int c = 0; c < 3; ++c) {
        size = fmax(size, (double)b[3 + c] - b[c]);
        far = fmax(far, fmax(fabsf(b[c]), fabsf(b[3 + c])));
    }
    const double distance = settings->rayDistance > 0 ? settings->rayDistance : 64 * size;
    return 0x1p-22 * (far + distance);
}

void ep_pad(ep_box *boxes, size_t count, double padding)
{
    for (size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) {
            boxes[i].lower[c] = ep_round_down(boxes[i].lower[c] - padding);
            boxes[i].upper[c] = ep_round_up(boxes[i].upper[c] + padding);
        }
}

void ep_include_box(float bounds[6], const ep_box *box)
{
    for (int c = 0; c < 3; ++c) {
        bounds[c] = fminf(bounds[c], box->lower[c]);
        bounds[3 + c] = fmaxf(bounds[3 + c], box->upper[c]);
    }
}

void ep_finish_boxes(ep_hierarchy *h, const EPBuildSettings *settings)
{
    static const float none[6] = EP_NO_BOUNDS;
    memcpy(h->bounds, none, sizeof none);
    for (size_t i = 0; i < h->box_count; ++i) ep_include_box(h->bounds, &h->boxes[i]);
    if (!h->box_count) return;
    h->padding = padding_of(h->bounds, settings);
    ep_pad(h->boxes, h->box_count, h->padding);
}

EPStatus ep_join(const ep_list *lists, size_t count, ep_hierarchy *out)
{
    size_t total = 0, floats = 0, words = 0, exact = 0;
    for (size_t i = 0; i < count; ++i) {
        if (lists[i].status != EP_OK) return lists[i].status;
        total += lists[i].count;
        floats += lists[i].net_count;
        words += lists[i].crossed.count;
        exact += lists[i].exact_count;
    }
    if (total > UINT32_MAX || floats > UINT32_MAX || words > UINT32_MAX) return EP_UNSUPPORTED;
    out->leaves = ep_alloc(total, sizeof(ep_leaf));
    out->boxes = ep_alloc(total, sizeof(ep_box));
    out->nets = ep_alloc(floats + 1, sizeof(float)); /* a coefficient is read as if of four */
    out->crossed = ep_alloc(words, sizeof(uint32_t));
    out->exact = ep_alloc(exact, sizeof(ep_exact_domain));
    if (!out->leaves || !out->boxes || !out->nets || !out->crossed || !out->exact) return EP_NO_MEMORY;
    out->nets[floats] = 0;
    double depth = 0, thickness = 0;
    for (size_t i = 0; i < count; ++i) {
        const ep_list *l = &lists[i];
        if (!l->count) continue;
        ep_leaf *leaves = out->leaves + out->leaf_count;
        memcpy(leaves, l->leaves, l->count * sizeof(ep_leaf));
        for (size_t k = 0; k < l->count; ++k) {
            leaves[k].net += (uint32_t)out->net_floats;
            if (leaves[k].trim) leaves[k].trim += (uint32_t)out->trim_words;
        }
        memcpy(out->boxes + out->leaf_count, l->boxes, l->count * sizeof(ep_box));
        if (l->net_count) memcpy(out->nets + out->net_floats, l->nets, l->net_count * sizeof(float));
        if (l->crossed.count) memcpy(out->crossed + out->trim_words, l->crossed.words, l->crossed.count * 4);
        for (size_t k = 0; k < l->exact_count; ++k)
            out->exact[out->exact_count++] = (ep_exact_domain){l->exact[k].leaf + out->leaf_count, l->exact[k].d};
        out->trim_words += l->crossed.count;
        out->leaf_count += l->count;
        out->net_floats += l->net_count;
        out->uncertified += l->uncertified;
        depth += l->depth_sum;
        thickness += l->thickness_sum;
        if (l->depth_max > out->maximum_depth) out->maximum_depth = l->depth_max;
    }
    out->box_count = total;
    out->average_depth = total ? depth / (double)total : 0;
    out->average_thickness = total > out->uncertified ? thickness / (double)(total - out->uncertified) : 0;
    return EP_OK;
}

static EPStatus fail(ep_message *message, EPStatus status, size_t count)
{
    if (status == EP_UNSUPPORTED) return ep_fail(message, status, "more than 2^32 leaves; raise the thickness");
    return ep_fail(message, status, "no memory for the leaves of %zu patches", count);
}

EPStatus ep_make_hierarchy(ep_patch *patches, size_t count, const EPBuildSettings *settings, ep_make_leaves *make,
                           const void *what, ep_message *message, ep_hierarchy *out)
{
    memset(out, 0, sizeof *out);
    const int threads = settings->threads ? (int)settings->threads : omp_get_max_threads();
    ep_list *lists = ep_alloc(count, sizeof *lists);
    ep_fit *fits = ep_alloc((size_t)threads, sizeof *fits);
    EPStatus status = lists && fits ? EP_OK : EP_NO_MEMORY;
    if (status == EP_OK) {
        memset(lists, 0, count * sizeof *lists);
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t i = 0; i < count; ++i) {
            ep_patch_measure(&patches[i]);
            make(what, &patches[i], (uint32_t)i, &fits[omp_get_thread_num()], &lists[i]);
            patches[i].error = lists[i].error;
        }
        status = ep_join(lists, count, out);
        for (size_t i = 0; i < count; ++i) ep_list_free(&lists[i]);
    }
    ep_free(fits);
    ep_free(lists);
    if (status != EP_OK) {
        ep_hierarchy_free(out);
        return fail(message, status, count);
    }
    ep_finish_boxes(out, settings);
    return EP_OK;
}

ep_domain ep_domain_of(const ep_hierarchy *h, size_t leaf)
{
    size_t lo = 0, hi = h->exact_count;
    while (lo < hi) {
        const size_t mid = lo + (hi - lo) / 2;
        if (h->exact[mid].leaf < leaf) lo = mid + 1;
        else hi = mid;
    }
    return lo < h->exact_count && h->exact[lo].leaf == leaf ? h->exact[lo].d : widened(&h->leaves[leaf]);
}

size_t ep_hierarchy_bytes(const ep_hierarchy *h)
{
    return h->patch_count * (sizeof *h->patches + sizeof *h->trims) + h->trim_words * sizeof *h->crossed +
           h->net_floats * sizeof *h->nets + h->leaf_count * sizeof *h->leaves + h->box_count * sizeof *h->boxes +
           h->exact_count * sizeof *h->exact;
}

void ep_hierarchy_free(ep_hierarchy *h)
{
    ep_free(h->patches);
    ep_free(h->trims);
    ep_free(h->crossed);
    ep_free(h->nets);
    ep_free(h->exact);
    ep_free(h->leaves);
    ep_free(h->boxes);
    memset(h, 0, sizeof *h);
}
