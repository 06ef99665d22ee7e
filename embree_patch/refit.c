/* refit.c - fits leaves anew where only points have moved. See refit.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * What decides a hit, frame, prism, certificate and coefficients, holds for the part of the surface that the leaf
 * covers, whatever the neighbours are and however the part was chosen. So the division of the domains may stay, with
 * the trims, which know the domain only: it covers each patch once as before. How well it fits is a matter of speed. A
 * build fits every inner piece as well, and finds where to split; that is what is saved. */
#include "embree_patch/refit.h"

/* The first leaf of a patch, or where it would be. */
static size_t first_leaf(const ep_hierarchy *h, size_t patch)
{
    size_t lo = 0, hi = h->leaf_count;
    while (lo < hi) {
        const size_t mid = lo + (hi - lo) / 2;
        if (h->leaves[mid].patch < patch) lo = mid + 1;
        else hi = mid;
    }
    return lo;
}

static void refit_patch(const void *hierarchy, const ep_patch *p, uint32_t index, ep_fit *fit, ep_list *l)
{
    const ep_hierarchy *old = hierarchy;
    ep_leaf_begin(p, fit);
    for (size_t i = first_leaf(old, index); i < old->leaf_count && old->leaves[i].patch == index; ++i) {
        const ep_domain d = ep_domain_of(old, i);
        ep_leaf_fit(&d, fit);
        ep_leaf_certify(&d, fit);
        ep_list_add(l, fit, &d, index, old->leaves[i].trim, 0);
        if (l->status != EP_OK) return;
    }
}

EPStatus ep_refit(ep_hierarchy *h, ep_patch *patches, const EPBuildSettings *settings, ep_message *message)
{
    ep_hierarchy fresh;
    const EPStatus status = ep_make_hierarchy(patches, h->patch_count, settings, refit_patch, h, message, &fresh);
    if (status != EP_OK) return status;
    /* the lists have no trims of their own, so that leaf.trim is as it was */
    ep_free(fresh.crossed);
    fresh.crossed = h->crossed;
    fresh.trim_words = h->trim_words;
    fresh.trims = h->trims;
    fresh.patches = patches;
    fresh.patch_count = h->patch_count;
    fresh.average_depth = h->average_depth;
    fresh.maximum_depth = h->maximum_depth;
    h->crossed = NULL;
    h->trims = NULL;
    ep_hierarchy_free(h);
    *h = fresh;
    return EP_OK;
}
