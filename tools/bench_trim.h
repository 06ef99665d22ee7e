/* bench_trim.h - one geometry, trimmed in several ways, traced by the same rays.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A geometry stands by itself, wherever it is. It is traced whole; whole, with an Embree filter that tests every hit
 * against the region as it stands, by one of trim/'s methods; and trimmed by the library, its crossed parts divided in
 * one of the ways that EPTrimSplit names. The rays are those of `epatch bench`, made for the whole geometry: where
 * something was trimmed away they go on, as any ray does. */
#ifndef EPATCH_BENCH_TRIM_H
#define EPATCH_BENCH_TRIM_H

#include "tools/bench.h"
#include "tools/table.h"
#include "trim/methods.h"

typedef enum trim_way_kind { TRIM_WHOLE, TRIM_BY_FILTER, TRIM_BY_LEAVES } trim_way_kind;

typedef struct trim_way {
    trim_way_kind kind;
    ep_trim_method method; /* of a filter */
    EPTrimSplit split;     /* of leaves   */
    const char *name, *key;
} trim_way;

enum { TRIM_WAYS = 1 + EP_TRIM_METHODS + EP_TRIM_SPLIT_NONE + 1 };
/* Whole, filters, leaves; the usual one is last. */
extern const trim_way trim_ways[TRIM_WAYS];

typedef struct trim_subject trim_subject;

/* Of a geometry that outlives it. NULL after a message. */
trim_subject *trim_subject_new(const scene *s, size_t geometry, const trim_way *way, const bench_options *o);
void trim_subject_free(trim_subject *t);

const trim_way *trim_subject_way(const trim_subject *t);
const world *trim_subject_world(const trim_subject *t);
/* Of a workload, in millions of rays a second; 0 when it was not measured. */
double trim_subject_speed(const trim_subject *t, unsigned workload);
/* What part of the domains is covered by leaves that test. */
double trim_subject_crossed(const trim_subject *t);

/* Measures all of them, in turn. False after a message. */
bool trim_subjects_measure(trim_subject **t, size_t count, const bench_rays *rays, const bench_options *o,
                           const char *label);

/* What every such table shows of a subject: leaves, how deep, the crossed part, time to build, memory. */
enum { TRIM_SUBJECT_CELLS = 6 };
void trim_subject_head(table *t);
void trim_subject_cells(table *t, const trim_subject *s);
/* The same and the speeds; NULL without memory. */
json_t *trim_subject_json(const trim_subject *t);

/* The commands; false after a message. bench_trim_scene.c: the trimmed geometries of a scene, trimmed in every way.
 * `methods`: one bit each. */
bool bench_trims(const char *path, const bench_options *o, unsigned methods, bench_form form);
/* bench_trim_curves.c: more and more trim curves on one patch. */
bool bench_trim_curves(const bench_options *o, unsigned methods, bench_form form);
/* bench_trim_costs.c: what the parts of a test cost. */
bool bench_trim_costs(const bench_options *o, bench_form form);

#endif
