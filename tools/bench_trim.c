/* bench_trim.c - see bench_trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/bench_trim.h"
#include "embree_patch/geometry.h"
#include "tools/progress.h"
#include "tools/report.h"

#include <math.h>
#include <stdlib.h>

/* A measurement takes at least so long, or traces every ray. A slow filter gets fewer rays, from all over the view. */
#define SECONDS 0.04
#define LEAST_BLOCKS 4

const trim_way trim_ways[TRIM_WAYS] = {
    {TRIM_WHOLE, 0, 0, "untrimmed", "untrimmed"},
    {TRIM_BY_FILTER, EP_TRIM_CELLS, 0, "test all, cells", "filter_cells"},
    {TRIM_BY_FILTER, EP_TRIM_STRIP_TREES, 0, "test all, strip trees", "filter_strip_trees"},
    {TRIM_BY_FILTER, EP_TRIM_CLIPPING, 0, "test all, clipping", "filter_clipping"},
    {TRIM_BY_FILTER, EP_TRIM_CLIPPING_LEFT, 0, "test all, clipping left", "filter_clipping_left"},
    {TRIM_BY_LEAVES, 0, EP_TRIM_SPLIT_NONE, "prune the tree", "split_none"},
    {TRIM_BY_LEAVES, 0, EP_TRIM_SPLIT_COST, "prune, split by cost", "split_cost"},
    {TRIM_BY_LEAVES, 0, EP_TRIM_SPLIT_REGULAR, "prune, split regularly", "split_regular"},
    {TRIM_BY_LEAVES, 0, EP_TRIM_SPLIT_CURVES, "prune, split by curves", "split_curves"},
};

struct trim_subject {
    const trim_way *way;
    scene scene;
    scene_geometry geometry;
    scene_object object;
    patch *patches;
    world *world;
    ep_trim_tester **testers; /* of each face; neighbours trimmed by the same region share one */
    size_t tester_count, tester_bytes;
    double seconds[BENCH_WORKLOADS]; /* that a block takes, about */
    size_t turns[BENCH_WORKLOADS];   /* over the blocks, so far   */
    EPCounters cost[BENCH_WORKLOADS];
    bench_timing warm[BENCH_WORKLOADS];
    bench_figure speed[BENCH_WORKLOADS];
};

/* The subject that is being traced: a filter is told nothing but the geometry's user data, which is the library's. */
static ep_trim_tester *const *filtering;

/* Rows of an RTCHitN. */
enum { HIT_U = 3, HIT_V = 4, HIT_PRIM = 5 };

static void filter(const struct RTCFilterFunctionNArguments *a)
{
    const float *real = (const float *)a->hit;
    const uint32_t *id = (const uint32_t *)a->hit;
    const unsigned n = a->N;
    for (unsigned i = 0; i < n; ++i) {
        if (!a->valid[i]) continue;
        const ep_trim_tester *t = filtering[id[HIT_PRIM * n + i]];
        if (t && !ep_trim_tester_has_point(t, real[HIT_U * n + i], real[HIT_V * n + i])) a->valid[i] = 0;
    }
}

static bool new_testers(trim_subject *t, const patch *trimmed)
{
    const scene_geometry *g = &t->geometry;
    ep_trim_tester *last = NULL; /* of the patch before */
    const size_t faces = g->patch_count ? (size_t)face_of(g, g->patch_count - 1) + 1 : 0;
    t->testers = calloc(faces + 1, sizeof *t->testers);
    if (!t->testers) return report_no_memory(t->scene.path), false;
    t->tester_count = faces;
    for (size_t i = 0; i < g->patch_count; ++i) {
        ep_message m;
        const EPRegion r = trimmed[i].trim;
        if (!r || !i || r != trimmed[i - 1].trim) last = NULL;
        if (!r) continue;
        if (!last) {
            if (ep_trim_tester_new(r->region, r->trim, t->way->method, &last, &m) != EP_OK)
                return report_file(t->scene.path, "%s", m.text), false;
            t->tester_bytes += ep_trim_tester_bytes(last);
        }
        t->testers[face_of(g, i)] = last;
    }
    RTCGeometry rtc = rtcGetGeometry(t->world->rtc, 0);
    rtcSetGeometryIntersectFilterFunction(rtc, filter);
    rtcSetGeometryOccludedFilterFunction(rtc, filter);
    rtcCommitGeometry(rtc);
    rtcCommitScene(t->world->rtc);
    return true;
}

static bool build(trim_subject *t, const scene *s, size_t geometry, const bench_options *o)
{
    const patch *trimmed = s->geometries[geometry].patches;
    const size_t count = s->geometries[geometry].patch_count;
    t->patches = malloc(count * sizeof *t->patches);
    if (!t->patches) return report_no_memory(s->path), false;
    for (size_t i = 0; i < count; ++i) {
        t->patches[i] = trimmed[i];
        if (t->way->kind != TRIM_BY_LEAVES) t->patches[i].trim = NULL;
    }
    t->geometry = s->geometries[geometry];
    t->geometry.patches = t->patches;
    t->object = (scene_object){.transform = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, .identity = true};
    t->scene = *s;
    t->scene.geometries = &t->geometry;
    t->scene.objects = &t->object;
    t->scene.geometry_count = t->scene.object_count = 1;

    world_options w = {.threads = o->threads[0], .build = o->build};
    w.build.trimSplit = t->way->split;
    t->world = world_new(&t->scene, &w);
    return t->world && (t->way->kind != TRIM_BY_FILTER || new_testers(t, trimmed));
}

trim_subject *trim_subject_new(const scene *s, size_t geometry, const trim_way *way, const bench_options *o)
{
    trim_subject *t = calloc(1, sizeof *t);
    if (!t) return report_no_memory(s->path), NULL;
    t->way = way;
    if (build(t, s, geometry, o)) return t;
    trim_subject_free(t);
    return NULL;
}

void trim_subject_free(trim_subject *t)
{
    if (!t) return;
    ep_trim_tester *last = NULL;
    for (size_t i = 0; i < t->tester_count; ++i) {
        if (!t->testers[i] || t->testers[i] == last) continue;
        last = t->testers[i];
        ep_trim_tester_free(last);
    }
    free(t->testers);
    world_free(t->world);
    free(t->patches);
    free(t);
}

const trim_way *trim_subject_way(const trim_subject *t)
{
    return t->way;
}

const world *trim_subject_world(const trim_subject *t)
{
    return t->world;
}

double trim_subject_speed(const trim_subject *t, unsigned workload)
{
    return bench_median(&t->speed[workload]);
}

double trim_subject_crossed(const trim_subject *t)
{
    const ep_hierarchy *h = &t->world->geometries[0]->hierarchy;
    double share = 0;
    for (size_t i = 0; i < h->leaf_count; ++i) {
        const float *d = h->leaves[i].domain;
        const bool tensor = t->patches[h->leaves[i].patch].kind == PATCH_TENSOR;
        if (h->leaves[i].trim) share += fabs((double)d[2] * d[3] - (tensor ? 0 : (double)d[4] * d[5]));
    }
    return t->way->kind == TRIM_BY_FILTER ? 1 : share / (double)t->geometry.patch_count;
}

/* `count` blocks, evenly over all rays. */
static bool trace(trim_subject *t, unsigned workload, const bench_rays *rays, size_t count, const bench_options *o,
                  bench_timing *timing)
{
    const bench_workload *w = &bench_workloads[workload];
    const size_t blocks = bench_blocks(w, rays);
    filtering = t->testers;
    if (count % blocks == 0) return bench_trace(t->world->rtc, w, rays, 0, count, o->threads[0], timing);
    const size_t each = o->threads[0]; /* a block for every thread */
    for (size_t i = 0; i < count; i += each)
        if (!bench_trace(t->world->rtc, w, rays, (t->turns[workload] + i) * blocks / count, each, o->threads[0],
                         timing))
            return false;
    ++t->turns[workload];
    return true;
}

/* So many blocks take as long as a measurement should. */
static size_t blocks_of(const trim_subject *t, unsigned workload, const bench_rays *rays)
{
    const size_t all = bench_blocks(&bench_workloads[workload], rays);
    const double wanted = ceil(SECONDS / t->seconds[workload]);
    if (wanted > (double)all) return (size_t)ceil(wanted / (double)all) * all;
    return wanted < LEAST_BLOCKS ? all < LEAST_BLOCKS ? all : LEAST_BLOCKS : (size_t)wanted;
}

static bool warm_up(trim_subject *t, unsigned workload, const bench_rays *rays, const bench_options *o)
{
    EPCounters before, after;
    bench_timing *w = &t->warm[workload];
    epGetCounters(&before);
    const size_t all = bench_blocks(&bench_workloads[workload], rays);
    const size_t blocks = all < LEAST_BLOCKS ? all : LEAST_BLOCKS;
    if (!trace(t, workload, rays, blocks, o, w)) return false;
    epGetCounters(&after);
    t->cost[workload] =
        (EPCounters){after.visits - before.visits, after.solves - before.solves, after.evaluations - before.evaluations,
                     after.cells - before.cells, after.slow - before.slow};
    t->seconds[workload] = w->seconds / (double)blocks;
    return true;
}

bool trim_subjects_measure(trim_subject **t, size_t count, const bench_rays *rays, const bench_options *o,
                           const char *label)
{
    progress p;
    bool done = true;
    progress_begin(&p, label, (o->runs + 1) * BENCH_WORKLOADS * count);
    for (unsigned run = 0; run <= o->runs && done; ++run)
        for (unsigned w = 0; w < BENCH_WORKLOADS; ++w)
            for (size_t i = 0; i < count && done; ++i) {
                progress_add(&p, 1);
                if (!(o->workloads >> w & 1)) continue;
                bench_timing timing = {0};
                done = run ? trace(t[i], w, rays, blocks_of(t[i], w, rays), o, &timing) : warm_up(t[i], w, rays, o);
                if (run) bench_add(&t[i]->speed[w], bench_speed(&timing));
            }
    progress_end(&p);
    return done;
}

void trim_subject_head(table *t)
{
    static const char *const names[TRIM_SUBJECT_CELLS] = {"leaves", "depth", "deepest", "crossed", "build", "memory"};
    for (int i = 0; i < TRIM_SUBJECT_CELLS; ++i) table_cell(t, "%s", names[i]);
}

void trim_subject_cells(table *t, const trim_subject *s)
{
    EPStatistics e;
    epGetGeometryStatistics(s->world->geometries[0], &e);
    table_cell(t, "%zu", e.leaves);
    table_cell(t, "%.2f", e.averageDepth);
    table_cell(t, "%u", e.maximumDepth);
    table_cell(t, "%.2f %%", 100 * trim_subject_crossed(s));
    table_seconds(t, s->world->build_seconds);
    table_bytes(t, s->world->bytes_patches + s->world->bytes_embree + s->tester_bytes);
}

json_t *trim_subject_json(const trim_subject *t)
{
    EPStatistics e;
    epGetGeometryStatistics(t->world->geometries[0], &e);
    json_t *speed = json_object(), *hits = json_object(), *cost = json_object();
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w) {
        const double traced = (double)t->warm[w].rays;
        const char *name = bench_workloads[w].name;
        if (!t->speed[w].runs) continue;
        json_object_set_new(speed, name, json_real(bench_median(&t->speed[w])));
        json_object_set_new(hits, name, json_real((double)t->warm[w].hits / traced));
        const EPCounters *c = &t->cost[w];
        json_object_set_new(cost, name,
                            json_pack("{s:f, s:f, s:f, s:f, s:f}", "visits", (double)c->visits / traced, "solves",
                                      (double)c->solves / traced, "evaluations", (double)c->evaluations / traced,
                                      "cells", (double)c->cells / traced, "slow", (double)c->slow / traced));
    }
    return json_pack("{s:s, s:I, s:f, s:i, s:f, s:f, s:I, s:o, s:o, s:o}", "trimming", t->way->key, "leaves",
                     (json_int_t)e.leaves, "depth_mean", e.averageDepth, "depth_max", (int)e.maximumDepth, "crossed",
                     trim_subject_crossed(t), "build_seconds", t->world->build_seconds, "bytes",
                     (json_int_t)(t->world->bytes_patches + t->world->bytes_embree + t->tester_bytes), "mrays", speed,
                     "hits", hits, "cost", cost);
}
