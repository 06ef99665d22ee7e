/* bench_json.c - the figures for programs.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/bench.h"
#include "tools/machine.h"
#include "tools/stats.h"

json_t *bench_machine_json(const char *isa)
{
    const machine m = machine_describe();
    return json_pack("{s:s, s:i, s:s, s:s, s:s, s:s}", "cpu", m.cpu, "cores", (int)m.cores, "isa", isa ? isa : m.isa,
                     "compiler", m.compiler, "embree", m.embree, "epatch", EP_VERSION_STRING);
}

/* An object with one member a workload, made by `value`. */
static json_t *by_workload(const bench *b, const bench_subject *s, unsigned column,
                           json_t *(*value)(const bench *, const bench_subject *, unsigned column, unsigned workload))
{
    json_t *o = json_object();
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w)
        if (b->options.workloads >> w & 1 && json_object_set_new(o, bench_workloads[w].name, value(b, s, column, w)))
            return json_decref(o), NULL;
    return o;
}

static json_t *speed(const bench *b, const bench_subject *s, unsigned column, unsigned w)
{
    (void)b;
    return json_real(bench_median(&s->columns[column].speed[w]));
}

static json_t *runs(const bench_figure *f)
{
    json_t *a = json_array();
    for (unsigned i = 0; i < f->runs; ++i)
        if (json_array_append_new(a, json_real(f->run[i]))) return json_decref(a), NULL;
    return a;
}

static json_t *speeds(const bench *b, const bench_subject *s, unsigned column, unsigned w)
{
    (void)b;
    return runs(&s->columns[column].speed[w]);
}

static json_t *ratio(const bench *b, const bench_subject *s, unsigned column, unsigned w)
{
    return json_real(bench_median(&b->patches.columns[column].speed[w]) / bench_median(&s->columns[column].speed[w]));
}

/* The same of neighbours, as in the tables. */
static json_t *ratio_between(const bench *b, const bench_subject *s, unsigned column, unsigned w)
{
    (void)b;
    return json_real(bench_median(&s->columns[column].ratio[w]));
}

/* The part of the rays that hit. */
static json_t *hits(const bench *b, const bench_subject *s, unsigned column, unsigned w)
{
    (void)column;
    return json_real((double)s->hits[w] / (double)b->rays.count[bench_workloads[w].kind]);
}

/* Of one ray, on average. */
static json_t *cost(const bench *b, const bench_subject *s, unsigned column, unsigned w)
{
    (void)column;
    const EPCounters *c = &s->cost[w];
    const double rays = (double)b->rays.count[bench_workloads[w].kind];
    return json_pack("{s:f, s:f, s:f, s:f, s:f}", "visits", (double)c->visits / rays, "solves",
                     (double)c->solves / rays, "evaluations", (double)c->evaluations / rays, "cells",
                     (double)c->cells / rays, "slow", (double)c->slow / rays);
}

/* Speeds of the first number of threads under the plain names, of all threads under names of their own. */
static bool add_columns(json_t *o, const bench *b, const bench_subject *s, bool built)
{
    bool done = stats_add(
        o, json_pack("{s:o, s:o}", "mrays", by_workload(b, s, 0, speed), "mrays_runs", by_workload(b, s, 0, speeds)));
    if (b->options.columns > 1)
        done = stats_add(o, json_pack("{s:o, s:o}", "mrays_all_threads", by_workload(b, s, 1, speed),
                                      "mrays_runs_all_threads", by_workload(b, s, 1, speeds))) &&
               done;
    if (b->options.columns > 1 && built)
        done =
            stats_add(o, json_pack("{s:f}", "build_seconds_all_threads", bench_median(&s->columns[1].build))) && done;
    return done;
}

static json_t *subject(const bench *b, const bench_subject *s)
{
    const bench_figure *built = &s->columns[0].build;
    json_t *o = json_pack("{s:i, s:I, s:I, s:f, s:o, s:f, s:f, s:o}", "n", (int)s->n, "triangles",
                          (json_int_t)s->triangles, "bytes", (json_int_t)s->bytes, "build_seconds", bench_median(built),
                          "build_seconds_runs", runs(built), "max_position_error", s->position_error,
                          "max_normal_error_degrees", s->normal_error, "hits", by_workload(b, s, 0, hits));
    bool done = add_columns(o, b, s, true);
    if (s->n) done = stats_add(o, json_pack("{s:o}", "patches_ratio", by_workload(b, s, 0, ratio_between))) && done;
    if (!done) json_decref(o), o = NULL;
    return o;
}

static json_t *patches(const bench *b)
{
    json_t *o = subject(b, &b->patches);
    if (!stats_add(o, json_pack("{s:I, s:o}", "leaves", (json_int_t)b->patches.world->leaves, "cost",
                                by_workload(b, &b->patches, 0, cost))))
        json_decref(o), o = NULL;
    return o;
}

static json_t *limit(const bench *b)
{
    json_t *o = json_object();
    if (!add_columns(o, b, &b->limit, false)) json_decref(o), o = NULL;
    return o;
}

static json_t *matched(const bench *b)
{
    const bench_subject *p = &b->patches, *s = bench_finest(&b->families[0]);
    json_t *o = json_pack("{s:i, s:b, s:f, s:f}", "n", (int)s->n, "as_exact", b->families[0].matched, "bytes",
                          (double)p->bytes / (double)s->bytes, "build_seconds",
                          bench_median(&p->columns[0].build) / bench_median(&s->columns[0].build));
    if (!stats_add(o, by_workload(b, s, 0, ratio))) json_decref(o), o = NULL;
    return o;
}

static json_t *family(const bench *b, const bench_family *f)
{
    json_t *grids = json_array();
    for (unsigned i = 0; i < f->count; ++i)
        if (json_array_append_new(grids, subject(b, &f->grids[i]))) return json_decref(grids), NULL;
    return grids;
}

json_t *bench_json(const bench *b)
{
    EPStatistics statistics;
    epGetGeometryStatistics(b->patches.world->geometries[0], &statistics);
    json_t *o = json_pack("{s:o, s:o, s:i, s:i, s:I, s:o, s:o, s:o, s:o}", "scene", stats_name(b->scene->path),
                          "machine", bench_machine_json(statistics.isa), "threads", (int)b->options.threads[0], "runs",
                          (int)b->options.runs, "rays", (json_int_t)b->rays.count[BENCH_PRIMARY], "tessellation",
                          family(b, &b->families[0]), "patches", patches(b), "limit", limit(b), "matched", matched(b));
    for (unsigned k = 1; o && k < b->family_count; ++k) {
        const bench_family *f = &b->families[k];
        if (json_object_set_new(o, bench_form_names[f->form], family(b, f))) json_decref(o), o = NULL;
    }
    return o;
}
