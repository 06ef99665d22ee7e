/* bench_run.c - who is measured, and in which order.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * First the patches are built, then one tessellation after the other, each twice as fine, until one is as exact as the
 * patches or the next does not fit into memory. That was the first of the runs that measure building; the rest follow,
 * in the same order. Then all of them are in memory and the runs that measure tracing begin. */
#include "tools/bench.h"
#include "tools/outline.h"
#include "tools/progress.h"
#include "tools/report.h"

#include <math.h>
#include <string.h>

/* A measurement takes at least so long: passes over the rays are repeated. It is done in slices, between which the
 * other subjects have their turn, and a slice starts with a block that does not count: it fills the caches again. */
#define SECONDS 0.04
#define PASSES_MAX 1000
#define SLICES 4

enum { SUBJECTS_MAX = BENCH_GRIDS_MAX + 2 };

/* What a triangle of a grid needs while Embree builds: half a vertex and an index (18), Embree's hierarchy (66), and
 * what it sorts (32); rounded up. */
#define BYTES_A_TRIANGLE 128

static bool build(bench *b, bench_subject *s, unsigned column)
{
    const scene *scene = b->scene;
    const double reach = outline_reach(scene, NULL);
    const double eye = b->options.scene_camera ? outline_reach(scene, &scene->camera) : 0;
    const world_options o = {b->options.threads[column], s->n, fmax(reach, eye), b->options.build};
    world_free(s->world);
    s->world = world_new(scene, &o);
    if (!s->world) return false;
    s->rtc = s->world->rtc;
    s->bytes = s->world->bytes_patches + s->world->bytes_embree;
    bench_add(&s->columns[column].build, s->world->build_seconds);
    return true;
}

static size_t count_triangles(const scene *s, unsigned n)
{
    size_t count = 0;
    for (size_t i = 0; i < s->geometry_count; ++i)
        for (size_t k = 0; k < s->geometries[i].patch_count; ++k)
            count += (s->geometries[i].patches[k].kind == PATCH_TENSOR ? 2u : 1u) * (size_t)n * n;
    return count;
}

static bool build_patches(bench *b)
{
    if (!build(b, &b->patches, 0)) return false;
    const float *box = b->patches.world->bounds;
    double squares = 0;
    for (int x = 0; x < 3; ++x) squares += ((double)box[3 + x] - box[x]) * ((double)box[3 + x] - box[x]);
    b->diagonal = sqrt(squares);
    return bench_rays_new(&b->rays, b->patches.world, &b->options) &&
           bench_errors(b->patches.world, &b->rays, b->diagonal, &b->patches);
}

static bool build_grids(bench *b)
{
    const size_t room = b->options.memory / BYTES_A_TRIANGLE;
    const size_t most = b->options.max_grid;
    size_t used = 0;
    progress p;
    bool done = true;
    progress_begin(&p, "tessellate", most * most);
    for (unsigned n = BENCH_FIRST_GRID; n <= most && !b->matched; n *= 2) {
        bench_subject *g = &b->grids[b->grid_count];
        g->n = n;
        g->triangles = count_triangles(b->scene, n);
        if (g->triangles > room - used || g->triangles > UINT32_MAX / 2) break;
        used += g->triangles;
        ++b->grid_count;
        done = build(b, g, 0) && bench_errors(g->world, &b->rays, b->diagonal, g);
        if (!done) break;
        b->matched = g->position_error <= b->patches.position_error;
        progress_add(&p, (size_t)n * n);
    }
    progress_end(&p);
    if (b->grid_count) return done;
    report_file(b->scene->path, "%zu MB are too little for any tessellation", b->options.memory >> 20);
    return false;
}

/* Everything again, for the medians of build_seconds. */
static bool rebuild(bench *b)
{
    const bench_options *o = &b->options;
    progress p;
    bool done = true;
    size_t triangles = 0;
    for (unsigned i = 0; i < b->grid_count; ++i) triangles += b->grids[i].triangles;
    progress_begin(&p, "build", (o->runs * o->columns - 1) * triangles);
    for (unsigned run = 0; run < o->runs && done; ++run)
        for (unsigned column = run ? 0 : 1; column < o->columns && done; ++column) {
            done = build(b, &b->patches, column);
            for (unsigned i = 0; i < b->grid_count && done; ++i) {
                done = build(b, &b->grids[i], column);
                progress_add(&p, b->grids[i].triangles);
            }
        }
    progress_end(&p);
    return done;
}

static EPCounters difference(const EPCounters *after, const EPCounters *before)
{
    return (EPCounters){after->visits - before->visits, after->solves - before->solves,
                        after->evaluations - before->evaluations, after->cells - before->cells,
                        after->slow - before->slow};
}

/* The rays once, to see what they cost and how long they take. */
static bool warm_up(const bench *b, bench_subject *s, unsigned workload)
{
    const bench_workload *w = &bench_workloads[workload];
    bench_timing t = {0};
    EPCounters before, after;
    epGetCounters(&before);
    if (!bench_trace(s->rtc, w, &b->rays, 0, bench_blocks(w, &b->rays), b->options.threads[0], &t)) return false;
    epGetCounters(&after);
    s->hits[workload] = t.hits;
    s->cost[workload] = difference(&after, &before);
    s->passes[workload] = (unsigned)fmin(ceil(SECONDS / fmax(t.seconds, SECONDS / PASSES_MAX)), PASSES_MAX);
    return true;
}

/* One workload on all subjects, A B C ... A B C ...: one run of its figures. */
static bool measure(const bench *b, bench_subject *const *subjects, unsigned count, unsigned workload, unsigned column)
{
    const bench_workload *w = &bench_workloads[workload];
    const unsigned threads = b->options.threads[column];
    bench_timing t[SUBJECTS_MAX] = {0}, unused;
    for (size_t slice = 0; slice < SLICES; ++slice)
        for (unsigned i = 0; i < count; ++i) {
            const size_t turns = bench_blocks(w, &b->rays) * subjects[i]->passes[workload] * threads;
            const size_t first = turns * slice / SLICES, end = turns * (slice + 1) / SLICES;
            if (!bench_trace(subjects[i]->rtc, w, &b->rays, first, threads, threads, &unused) ||
                !bench_trace(subjects[i]->rtc, w, &b->rays, first, end - first, threads, &t[i]))
                return false;
        }
    for (unsigned i = 0; i < count; ++i)
        bench_add(&subjects[i]->columns[column].speed[workload], 1e-6 * (double)t[i].rays / t[i].seconds);
    return true;
}

static bool trace_all(bench *b)
{
    const bench_options *o = &b->options;
    bench_subject *subjects[SUBJECTS_MAX] = {&b->patches, &b->limit};
    const unsigned count = b->grid_count + 2;
    for (unsigned i = 0; i < b->grid_count; ++i) subjects[2 + i] = &b->grids[i];

    progress p;
    bool done = true;
    progress_begin(&p, "trace", (o->runs + 1) * BENCH_WORKLOADS);
    for (unsigned run = 0; run <= o->runs && done; ++run)
        for (unsigned w = 0; w < BENCH_WORKLOADS && done; ++w) {
            if (o->workloads >> w & 1) {
                for (unsigned i = 0; i < count && done && !run; ++i) done = warm_up(b, subjects[i], w);
                for (unsigned c = 0; c < o->columns && done && run; ++c) done = measure(b, subjects, count, w, c);
            }
            progress_add(&p, 1);
        }
    progress_end(&p);
    return done;
}

bool bench_run(bench *b, const scene *s, const bench_options *o)
{
    *b = (bench){.scene = s, .options = *o};
    if (!build_patches(b) || !build_grids(b) || !rebuild(b)) return false;
    b->limit_scene = bench_limit_new(b->patches.world);
    if (!b->limit_scene) return false;
    b->limit.rtc = bench_limit_scene(b->limit_scene);
    return trace_all(b);
}

void bench_free(bench *b)
{
    bench_limit_free(b->limit_scene);
    bench_rays_free(&b->rays);
    for (unsigned i = 0; i < b->grid_count; ++i) world_free(b->grids[i].world);
    world_free(b->patches.world);
}
