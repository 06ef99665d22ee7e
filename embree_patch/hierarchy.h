/* hierarchy.h - the leaves of one patch in the making, and those of all patches as tracing needs them.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Patches are independent, so their leaves are made in parallel into lists of their own, which are joined in order. */
#ifndef EP_HIERARCHY_H
#define EP_HIERARCHY_H

#include "embree_patch/leaf.h"
#include "trim/trim.h"

/* The domain of a leaf that leaf.domain only rounds: triangles cut along trim curves, and parts of more than 24
 * halvings. */
typedef struct ep_exact_domain {
    size_t leaf;
    ep_domain d;
} ep_exact_domain;

/* Leaves and boxes go together by index; a hierarchy without leaves, of patches that are cut on demand, has their
 * boxes.
 */
typedef struct ep_hierarchy {
    ep_patch *patches;
    const ep_trim **trims; /* of each patch, NULL where there is none */
    ep_leaf *leaves;       /* in the order of their patches           */
    ep_box *boxes;
    float *nets;            /* the leaves' coefficients, one after the other */
    uint32_t *crossed;      /* the nodes of leaves that trim curves cross, which leaf.trim - 1 addresses */
    ep_exact_domain *exact; /* in the order of their leaves */
    size_t patch_count, leaf_count, box_count, net_floats, trim_words, exact_count;
    float bounds[6];
    double padding; /* of the boxes, but not of `bounds` */
    /* statistics */
    size_t uncertified;
    double average_depth, average_thickness;
    unsigned maximum_depth;
} ep_hierarchy;

/* The leaves of one patch. */
typedef struct ep_list {
    ep_leaf *leaves;
    ep_box *boxes;
    float *nets;
    ep_exact_domain *exact;
    ep_trim_store crossed;
    size_t count, capacity, net_count, net_capacity, exact_count, exact_capacity;
    size_t uncertified;
    double depth_sum, thickness_sum;
    unsigned depth_max;
    double error;
    EPStatus status; /* once it is not EP_OK the list is dropped */
} ep_list;

/* Appends the leaf that was fitted to the part `d` of a patch. `trim`: leaf.trim, as if the list were the first. */
void ep_list_add(ep_list *l, const ep_fit *fit, const ep_domain *d, uint32_t patch, uint32_t trim, unsigned depth);
void ep_list_free(ep_list *l);

/* The lists' leaves one after the other, with their boxes as they are. EP_UNSUPPORTED: too many. */
EPStatus ep_join(const ep_list *lists, size_t count, ep_hierarchy *out);
void ep_pad(ep_box *boxes, size_t count, double padding);
/* Bounds of nothing, which grow by boxes. */
#define EP_NO_BOUNDS                                                                                                   \
    {                                                                                                                  \
        INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY                                                  \
    }
void ep_include_box(float bounds[6], const ep_box *box);
/* Sets the bounds, and pads all boxes by what these demand. */
void ep_finish_boxes(ep_hierarchy *h, const EPBuildSettings *settings);

/* Fills the list of patch `index`, with `fit` as scratch. Runs on many threads at a time. */
typedef void ep_make_leaves(const void *what, const ep_patch *patch, uint32_t index, ep_fit *fit, ep_list *l);

/* Measures the patches, makes the leaves of each and joins them to *out, boxes padded. The leaves do not depend on the
 * number of threads. The patches stay the caller's. */
EPStatus ep_make_hierarchy(ep_patch *patches, size_t count, const EPBuildSettings *settings, ep_make_leaves *make,
                           const void *what, ep_message *message, ep_hierarchy *out);

/* The domain of a leaf, exactly. */
ep_domain ep_domain_of(const ep_hierarchy *h, size_t leaf);

size_t ep_hierarchy_bytes(const ep_hierarchy *h);
void ep_hierarchy_free(ep_hierarchy *h); /* zeroes *h */

#endif
