/* verify.h - what the kernels answer, held against the oracle of test/oracle.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_VERIFY_H
#define EPATCH_VERIFY_H

#include "test/oracle/aim.h"
#include "test/oracle/judge.h"
#include "tools/trace.h"

enum { VERIFY_SETUPS = 12 }; /* 4 widths times 3 instruction sets */

/* One way to trace the same rays. */
typedef struct verify_setup {
    unsigned width;
    const char *isa;
} verify_setup;

/* How one kind of ray went in one setup. */
typedef struct verify_row {
    size_t rays, hits, verdicts[JUDGE_VERDICTS];
    size_t occluded; /* rays whose occlusion query disagrees with the intersection query */
    size_t bits;     /* ... whose hit has other bits in the first setup, or if the ray ends right behind it */
    judge_errors most;
    uint64_t slow;
} verify_row;

typedef struct verify_options {
    size_t rays; /* of each kind, over all geometries together */
    uint64_t seed;
    unsigned threads; /* 0: all */
    verify_setup setups[VERIFY_SETUPS];
    size_t setup_count;
    judge_limits limits;
    unsigned explain; /* so many faults of each geometry are printed to standard output */
} verify_options;

typedef struct verify_report {
    verify_row rows[AIM_KINDS][VERIFY_SETUPS];
    trace_ray *wrong; /* the rays with a fault, malloc'ed */
    size_t wrong_count, wrong_capacity;
} verify_report;

/* Traces every geometry of the scene by itself, without its copies: where scene_place() has put it, else untransformed.
 * False after a message; else free report->wrong. */
bool verify_scene(const scene *s, const verify_options *o, verify_report *report);

/* The same for rays that are given, as one kind (AIM_AT) and on every geometry. */
bool verify_rays(const scene *s, const trace_ray *rays, size_t count, const verify_options *o, verify_report *report);

/* Everything but what is right or left out. */
size_t verify_faults(const verify_row *row);

#endif
