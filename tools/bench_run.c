/* bench_run.c - who is measured, and in which order.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A run builds the patches and their limit, which stay, and one tessellation after the other, so that only one is in
 * memory at a time. The patches trace one half of the rays before it and the other half after it, A B A, and the limit
 * its share of them. Whatever slows the machine down for a while slows all of them, and a ratio is one of neighbours.
 * The first run also measures the errors, and ends with the first tessellation that is as exact as the patches, or with
 * the last that fits into memory; so do the others. */
#include "tools/bench.h"
#include "tools/cage_embree.h"
#include "tools/outline.h"
#include "tools/progress.h"
#include "tools/report.h"

#include <math.h>

/* A measurement takes at least so long: passes over the rays are repeated. */
#define SECONDS 0.04
#define PASSES_MAX 1000

/* What a triangle of a grid needs at most, while Embree builds: half a vertex and an index (18), Embree's hierarchy
 * (66), what it sorts (32), and what its allocator keeps. Measured: 128. */
#define BYTES_A_TRIANGLE 144

/* How long things take, for the progress bar: building with so many triangles as long as one workload. */
#define TRIANGLES_A_WORKLOAD 200000

world *bench_world(const scene *s, const bench_options *o, unsigned tessellation, world_form form, unsigned threads)
{
    const double reach = outline_reach(s, NULL), eye = o->scene_camera ? outline_reach(s, &s->camera) : 0;
    const world_options w = {.threads = threads,
                             .tessellation = tessellation,
                             .form = form,
                             .ray_distance = fmax(reach, eye),
                             .build = o->build};
    return world_new(s, &w);
}

double bench_diagonal(const world *w)
{
    const float *box = w->bounds;
    double squares = 0;
    for (int x = 0; x < 3; ++x) squares += ((double)box[3 + x] - box[x]) * ((double)box[3 + x] - box[x]);
    return sqrt(squares);
}

static bool build(bench *b, bench_subject *s, unsigned column)
{
    world_free(s->world);
    s->world = bench_world(b->scene, &b->options, s->n, s->form, b->options.threads[column]);
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
        for (size_t k = 0; k < chart_count(&s->geometries[i]); ++k)
            count += (chart_at(&s->geometries[i], k).kind == PATCH_TENSOR ? 2u : 1u) * (size_t)n * n;
    return count;
}

const char *const bench_form_names[BENCH_FORMS] = {
    [WORLD_TRIANGLES] = "triangles", [WORLD_GRIDS] = "grids", [WORLD_SUBDIVISION] = "subdivision"};

const bench_subject *bench_finest(const bench_family *f)
{
    return &f->grids[f->count - 1];
}

/* The most steps a chart that Embree takes. */
static unsigned most_steps(world_form form)
{
    return form == WORLD_SUBDIVISION ? 4096 : BENCH_LAST_GRID;
}

static void plan_family(bench *b, world_form form)
{
    bench_family *f = &b->families[b->family_count];
    f->form = form;
    for (unsigned n = BENCH_FIRST_GRID; n <= b->options.max_grid && n <= most_steps(form); n *= 2) {
        const size_t triangles = count_triangles(b->scene, n);
        if (triangles > b->options.memory / BYTES_A_TRIANGLE || triangles > UINT32_MAX / 2) break;
        f->grids[f->count++] = (bench_subject){.n = n, .form = form, .triangles = triangles};
    }
    b->family_count += f->count > 0;
}

/* All tessellations that are allowed. */
static bool plan_grids(bench *b)
{
    plan_family(b, WORLD_TRIANGLES);
    if (cage_embree_possible(b->scene)) {
        plan_family(b, WORLD_GRIDS);
        plan_family(b, WORLD_SUBDIVISION);
    }
    if (b->family_count) return true;
    report_file(b->scene->path, "%zu MB (--memory) are too little for any tessellation", b->options.memory >> 20);
    return false;
}

static unsigned count_grids(const bench *b)
{
    unsigned count = 0;
    for (unsigned i = 0; i < b->family_count; ++i) count += b->families[i].count;
    return count;
}

static EPCounters difference(const EPCounters *after, const EPCounters *before)
{
    return (EPCounters){after->visits - before->visits, after->solves - before->solves,
                        after->evaluations - before->evaluations, after->cells - before->cells,
                        after->slow - before->slow};
}

static bool is_measured(const bench *b, unsigned workload)
{
    return b->options.workloads >> workload & 1;
}

/* The rays once, to see what they cost and how long they take. */
static bool warm_up(const bench *b, bench_subject *s)
{
    for (unsigned i = 0; i < BENCH_WORKLOADS; ++i) {
        if (!is_measured(b, i)) continue;
        const bench_workload *w = &bench_workloads[i];
        bench_timing t = {0};
        EPCounters before, after;
        epGetCounters(&before);
        if (!bench_trace(s->rtc, w, &b->rays, 0, bench_blocks(w, &b->rays), b->options.threads[0], &t)) return false;
        epGetCounters(&after);
        s->hits[i] = t.hits;
        s->cost[i] = difference(&after, &before);
        s->passes[i] = (unsigned)fmin(ceil(SECONDS / fmax(t.seconds, SECONDS / PASSES_MAX)), PASSES_MAX);
    }
    return true;
}

/* What the limit has traced in a run so far. */
typedef struct share {
    bench_timing timing[BENCH_WORKLOADS];
    size_t blocks[BENCH_WORKLOADS];
} share;

static size_t all_blocks(const bench *b, const bench_subject *s, unsigned workload, unsigned column)
{
    return bench_blocks(&bench_workloads[workload], &b->rays) * s->passes[workload] * b->options.threads[column];
}

/* Blocks first .. end - 1. */
static bool trace(const bench *b, const bench_subject *s, unsigned workload, unsigned column, size_t first, size_t end,
                  bench_timing *t)
{
    return bench_trace_warm(s->rtc, &bench_workloads[workload], &b->rays, first, end, b->options.threads[column], t);
}

/* The share of the limit that goes with one of the tessellations, the grid-th. */
static bool trace_share(const bench *b, unsigned workload, unsigned column, unsigned grid, share *to)
{
    const size_t first = to->blocks[workload];
    to->blocks[workload] = all_blocks(b, &b->limit, workload, column) * (grid + 1) / count_grids(b);
    return trace(b, &b->limit, workload, column, first, to->blocks[workload], &to->timing[workload]);
}

static void add_speed(bench_subject *s, unsigned workload, unsigned column, const bench_timing *t)
{
    bench_add(&s->columns[column].speed[workload], bench_speed(t));
}

/* Tessellation `g` between the patches; what these do is added to *patches. */
static bool trace_between(bench *b, bench_subject *g, unsigned workload, unsigned column, bench_timing *patches)
{
    const size_t blocks = all_blocks(b, &b->patches, workload, column), half = (blocks + 1) / 2;
    bench_timing own = {0}, t = {0};
    if (!trace(b, &b->patches, workload, column, 0, half, &own) ||
        !trace(b, g, workload, column, 0, all_blocks(b, g, workload, column), &t) ||
        !trace(b, &b->patches, workload, column, half, blocks, &own))
        return false;
    add_speed(g, workload, column, &t);
    bench_add(&g->columns[column].ratio[workload], bench_speed(&own) / bench_speed(&t));
    patches->seconds += own.seconds;
    patches->rays += own.rays;
    return true;
}

static bool build_patches(bench *b, unsigned column, bool first)
{
    bench_limit_free(b->limit_scene);
    b->limit_scene = NULL;
    if (!build(b, &b->patches, column)) return false;
    b->limit_scene = bench_limit_new(b->patches.world);
    if (!b->limit_scene) return false;
    b->limit.rtc = bench_limit_scene(b->limit_scene);
    if (!first) return true;

    b->diagonal = bench_diagonal(b->patches.world);
    return bench_rays_new(&b->rays, b->patches.world, &b->options) &&
           bench_errors(b->patches.world, &b->rays, b->diagonal, &b->patches) && warm_up(b, &b->patches) &&
           warm_up(b, &b->limit);
}

static bool build_grid(bench *b, bench_family *f, unsigned grid, unsigned column, bool first)
{
    bench_subject *g = &f->grids[grid];
    if (!build(b, g, column)) return false;
    if (!first) return true;
    if (!bench_errors(g->world, &b->rays, b->diagonal, g) || !warm_up(b, g)) return false;
    f->matched = g->position_error <= b->patches.position_error;
    if (f->matched) f->count = grid + 1;
    return true;
}

static size_t effort(const bench_subject *g)
{
    return g->triangles + BENCH_WORKLOADS * TRIANGLES_A_WORKLOAD;
}

/* One tessellation between the patches, and the limit's share that goes with it. */
static bool measure_grid(bench *b, bench_subject *g, unsigned number, unsigned column, bench_timing *patches,
                         share *limit, progress *p)
{
    bool done = true;
    progress_add(p, g->triangles);
    for (unsigned w = 0; w < BENCH_WORKLOADS && done; ++w) {
        if (is_measured(b, w))
            done = trace_between(b, g, w, column, &patches[w]) && trace_share(b, w, column, number, limit);
        progress_add(p, TRIANGLES_A_WORKLOAD);
    }
    world_free(g->world);
    g->world = NULL;
    return done;
}

static bool measure(bench *b, unsigned column, bool first, progress *p)
{
    bench_timing patches[BENCH_WORKLOADS] = {0};
    share limit = {0};
    bool done = build_patches(b, column, first);
    for (unsigned k = 0, number = 0; k < b->family_count; ++k) {
        bench_family *f = &b->families[k];
        for (unsigned i = 0; i < f->count && done; ++i, ++number)
            done =
                build_grid(b, f, i, column, first) && measure_grid(b, &f->grids[i], number, column, patches, &limit, p);
    }
    for (unsigned w = 0; w < BENCH_WORKLOADS && done; ++w) {
        if (!is_measured(b, w)) continue;
        add_speed(&b->patches, w, column, &patches[w]);
        add_speed(&b->limit, w, column, &limit.timing[w]);
    }
    return done;
}

bool bench_run(bench *b, const scene *s, const bench_options *o)
{
    *b = (bench){.scene = s, .options = *o};
    if (!plan_grids(b)) return false;
    const unsigned turns = o->runs * o->columns;
    unsigned planned[BENCH_FORMS];
    size_t total = 0;
    for (unsigned k = 0; k < b->family_count; ++k) {
        planned[k] = b->families[k].count;
        for (unsigned i = 0; i < planned[k]; ++i) total += effort(&b->families[k].grids[i]);
    }
    progress p;
    progress_begin(&p, "bench", turns * total);
    bool done = true;
    for (unsigned turn = 0; turn < turns && done; ++turn) {
        done = measure(b, turn % o->columns, !turn, &p);
        for (unsigned k = 0; k < b->family_count; ++k)
            for (unsigned i = b->families[k].count; i < planned[k]; ++i)
                progress_add(&p, effort(&b->families[k].grids[i]));
    }
    progress_end(&p);
    return done;
}

void bench_free(bench *b)
{
    bench_limit_free(b->limit_scene);
    bench_rays_free(&b->rays);
    for (unsigned k = 0; k < b->family_count; ++k)
        for (unsigned i = 0; i < b->families[k].count; ++i) world_free(b->families[k].grids[i].world);
    world_free(b->patches.world);
}
