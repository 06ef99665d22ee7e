/* hits.h - random patches, traced and judged.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef TEST_HITS_H
#define TEST_HITS_H

#include "test/support.h"

typedef struct hits_case {
    uint64_t seed;
    int patches, rays; /* rays of each patch */
    bool triangles, tensors;
    patch_limits limits;
    patch_style styles[STYLES]; /* STYLES ends the list early */
    int style_count;
    double scale, offset[3]; /* where the patch is moved */
    double distance;         /* > 0: rays start this far from the patch's centre */
} hits_case;

/* Every ray is traced one by one and in packets of 16, which have to agree bit for bit, and judged by the oracle. Prints
 * the first faults and fails when there is one. */
void check_hits(const hits_case *c);

#endif
