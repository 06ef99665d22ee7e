/* hits.h - random patches, traced and judged.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef TEST_HITS_H
#define TEST_HITS_H

#include "test/support.h"

#include <stdio.h>

typedef struct test_ray {
    float org[3], dir[3];
} test_ray;

/* What became of a ray. */
typedef struct hits_answer {
    judge_answer alone; /* by rtcIntersect1                         */
    judge_verdict verdict;
    const char *fault; /* what is wrong with it; NULL: nothing      */
    unsigned width;    /* of the packet that got another answer ... */
    judge_answer many; /* ... which is this                         */
    oracle_root roots[ORACLE_ROOTS];
    size_t count;
} hits_answer;

/* Traces rays one by one, again up to right behind their hit, in packets of 4, 8 and 16, and for occlusion; all have to
 * agree, the hits bit for bit. The oracle judges them. */
void judge_rays(const oracle *o, RTCScene scene, const test_ray *rays, unsigned count, hits_answer *answers);

typedef struct hits_case {
    uint64_t seed;
    int patches, rays; /* rays of each patch */
    bool triangles, tensors;
    patch_limits limits;
    patch_style styles[STYLES]; /* STYLES ends the list early */
    int style_count;
    double scale, offset[3]; /* where the patch is moved */
    double distance;         /* > 0: rays start this far from the patch's centre */
    unsigned depths;         /* > 0: leaves are cut less often than that, or not at all */
} hits_case;

typedef struct hits_tally {
    unsigned long rays, hits, left_out, faults;
} hits_tally;

/* Judges rays at random patches and prints what is wrong with the first `explain` of those that are. Faulty rays go to
 * `captures`, which may be NULL, in the form of capture.h. */
hits_tally judge_hits(const hits_case *c, unsigned explain, FILE *captures);

/* Fails when there is a fault. */
void check_hits(const hits_case *c);

#endif
