/* build.h - from patches to leaves.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_BUILD_H
#define EP_BUILD_H

#include "embree_patch/leaf.h"
#include "embree_patch/trimmed.h"

/* The hierarchy as tracing needs it. Leaves and boxes go together by index. */
typedef struct ep_hierarchy {
    ep_patch *patches;
    const ep_trim **trims; /* of each patch, NULL where there is none */
    ep_leaf *leaves;
    ep_box *boxes;
    float *nets;       /* the leaves' coefficients, one after the other */
    uint32_t *crossed; /* the nodes of leaves that trim curves cross, which leaf.trim addresses; word 0 is none */
    size_t patch_count, leaf_count, net_floats, trim_words;
    float bounds[6];
    /* statistics */
    size_t uncertified;
    double average_depth, average_thickness;
    unsigned maximum_depth;
} ep_hierarchy;

/* Cuts patches[0..count), whose kind, degrees and points are set, into leaves of what the trims keep. Takes `patches`
 * and `trims` over: on success they belong to *out, on failure to the caller as before. The leaves do not depend on the
 * number of threads. */
EPStatus ep_build(ep_patch *patches, const ep_trim **trims, size_t count, const EPBuildSettings *settings,
                  ep_message *message, ep_hierarchy *out);
void ep_hierarchy_free(ep_hierarchy *h); /* zeroes *h */

#endif
