/* bench_newton.c - what certainty costs.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The patches trace all rays by the library's kernels and by bench_newton_kernels.c, which certify nothing: the same
 * leaves in the same hierarchy of Embree's. Half of the rays before Newton's and half after, A B A, as in bench_run.c.
 * What a picture would lose without certificates is counted, too. */
#include "tools/bench.h"
#include "tools/bench_newton_kernels.h"
#include "tools/progress.h"
#include "tools/report.h"
#include "tools/stats.h"
#include "tools/table.h"

#include "embree_patch/geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A measurement takes at least so long. */
#define SECONDS 0.04

/* Hits are the same one if they are no farther apart than this part of the scene's diagonal. */
#define SAME 1e-4

/* How Newton's answers differ, in rays. */
typedef struct faults {
    size_t hits, lost, other, extra; /* other: another hit; extra: one for a miss */
} faults;

typedef struct newton_row {
    bench_figure certified, newton; /* millions of rays a second */
    bench_figure ratio;             /* of neighbours             */
    unsigned passes;
} newton_row;

typedef struct newton {
    world *world;
    bench_rays rays;
    const ep_kernels *certified;
    ep_kernels kernels; /* the same, but for Newton's */
    newton_row row[BENCH_WORKLOADS];
    faults of[BENCH_KINDS];
} newton;

static const newton_kernels *find_kernels(const char *isa)
{
#if EP_HAVE_X86
    if (!strcmp(isa, "avx512")) return &newton_kernels_avx512;
    if (!strcmp(isa, "avx2")) return &newton_kernels_avx2;
#else
    (void)isa;
#endif
    return &newton_kernels_plain;
}

static void use(newton *n, const ep_kernels *kernels)
{
    for (size_t i = 0; i < n->world->scene->geometry_count; ++i) n->world->geometries[i]->kernels = kernels;
}

static void make_kernels(newton *n)
{
    n->certified = n->world->geometries[0]->kernels;
    const newton_kernels *k = find_kernels(n->certified->isa);
    n->kernels = *n->certified;
    memcpy(n->kernels.packet, k->packet, sizeof k->packet);
    memcpy(n->kernels.single, k->single, sizeof k->single);
}

static bool is_hit(const world_hit *h)
{
    return h->geomID != UINT32_MAX;
}

static double length(const float d[3])
{
    return sqrt((double)d[0] * d[0] + (double)d[1] * d[1] + (double)d[2] * d[2]);
}

/* Answers every ray of a kind twice. */
static bool compare(newton *n, bench_kind kind, double diagonal)
{
    const trace_ray *rays = n->rays.of[kind];
    const size_t count = n->rays.count[kind];
    const trace_options o = {.width = 16, .coherent = kind == BENCH_PRIMARY};
    world_hit *hits = malloc(2 * count * sizeof *hits), *other = hits + count;
    trace_result result;
    bool done = hits;
    if (!hits) report_no_memory(NULL);
    done = done && trace_rays(n->world, rays, count, &o, hits, &result);
    use(n, &n->kernels);
    done = done && trace_rays(n->world, rays, count, &o, other, &result);
    use(n, n->certified);
    faults *f = &n->of[kind];
    for (size_t i = 0; done && i < count; ++i) {
        const double apart = fabs((double)hits[i].t - (double)other[i].t) * length(rays[i].dir);
        f->hits += is_hit(&hits[i]);
        f->lost += is_hit(&hits[i]) && !is_hit(&other[i]);
        f->other += is_hit(&hits[i]) && is_hit(&other[i]) && !(apart <= SAME * diagonal);
        f->extra += !is_hit(&hits[i]) && is_hit(&other[i]);
    }
    free(hits);
    return done;
}

static bool trace(newton *n, unsigned workload, const bench_options *o, const ep_kernels *kernels, size_t first,
                  size_t end, bench_timing *t)
{
    use(n, kernels);
    const bool done =
        bench_trace_warm(n->world->rtc, &bench_workloads[workload], &n->rays, first, end, o->threads[0], t);
    use(n, n->certified);
    return done;
}

static bool measure(newton *n, unsigned workload, const bench_options *o)
{
    newton_row *row = &n->row[workload];
    const size_t once = bench_blocks(&bench_workloads[workload], &n->rays);
    if (!row->passes) {
        bench_timing t = {0};
        if (!trace(n, workload, o, n->certified, 0, once, &t)) return false;
        row->passes = (unsigned)ceil(SECONDS / fmax(t.seconds, 1e-4));
    }
    const size_t blocks = once * row->passes * o->threads[0], half = (blocks + 1) / 2;
    bench_timing certified = {0}, plain = {0};
    if (!trace(n, workload, o, n->certified, 0, half, &certified) ||
        !trace(n, workload, o, &n->kernels, 0, blocks, &plain) ||
        !trace(n, workload, o, n->certified, half, blocks, &certified))
        return false;
    bench_add(&row->certified, bench_speed(&certified));
    bench_add(&row->newton, bench_speed(&plain));
    bench_add(&row->ratio, bench_speed(&certified) / bench_speed(&plain));
    return true;
}

static bool run(newton *n, const scene *s, const bench_options *o)
{
    n->world = bench_world(s, o, 0, WORLD_TRIANGLES, o->threads[0]);
    if (!n->world || !bench_rays_new(&n->rays, n->world, o)) return false;
    make_kernels(n);
    progress p;
    bool done = true;
    progress_begin(&p, "bench", BENCH_KINDS + o->runs * BENCH_WORKLOADS);
    for (bench_kind kind = 0; kind < BENCH_KINDS && done; ++kind) {
        done = compare(n, kind, bench_diagonal(n->world));
        progress_add(&p, 1);
    }
    for (unsigned i = 0; i < o->runs; ++i)
        for (unsigned k = 0; k < BENCH_WORKLOADS && done; ++k) {
            if (o->workloads >> k & 1) done = measure(n, k, o);
            progress_add(&p, 1);
        }
    progress_end(&p);
    return done;
}

static void print(const newton *n, const bench_options *o, bool markdown)
{
    table t = {0};
    printf("%s, %zu leaves, %s: millions of rays a second with %u thread%s, medians of %u runs.\n\n",
           n->world->scene->path, n->world->leaves, n->certified->isa, o->threads[0], o->threads[0] == 1 ? "" : "s",
           o->runs);
    table_row(&t);
    for (const char *const *name =
             (const char *const[]){"", "certified", "Newton", "ratio", "lost", "other", "extra", NULL};
         *name; ++name)
        table_cell(&t, "%s", *name);
    for (unsigned k = 0; k < BENCH_WORKLOADS; ++k) {
        if (!(o->workloads >> k & 1)) continue;
        const newton_row *row = &n->row[k];
        const faults *f = &n->of[bench_workloads[k].kind];
        table_row(&t);
        table_cell(&t, "%s", bench_workloads[k].name);
        table_figure(&t, bench_median(&row->certified));
        table_figure(&t, bench_median(&row->newton));
        table_cell(&t, "%.2f", bench_median(&row->ratio));
        table_cell(&t, "%.3f %%", f->hits ? 100.0 * (double)f->lost / (double)f->hits : 0);
        table_cell(&t, "%.3f %%", f->hits ? 100.0 * (double)f->other / (double)f->hits : 0);
        table_cell(&t, "%.3f %%", f->hits ? 100.0 * (double)f->extra / (double)f->hits : 0);
    }
    table_print(&t, markdown);
    printf(
        "\nNewton: the same leaves and start, but no certificates; a ray that is not at a root after %d steps misses.\n"
        "In parts of all hits: lost, where it misses; other, where it has another, as a rule what is behind, which "
        "does\nfor a shadow ray; extra, where it hits and there is none.\n",
        NEWTON_STEPS);
}

static json_t *as_json(const newton *n, const bench_options *o)
{
    json_t *rows = json_object();
    for (unsigned k = 0; k < BENCH_WORKLOADS; ++k) {
        if (!(o->workloads >> k & 1)) continue;
        const newton_row *row = &n->row[k];
        const faults *f = &n->of[bench_workloads[k].kind];
        json_t *of =
            json_pack("{s:f, s:f, s:f, s:I, s:I, s:I, s:I}", "mrays", bench_median(&row->certified), "mrays_newton",
                      bench_median(&row->newton), "ratio", bench_median(&row->ratio), "hits", (json_int_t)f->hits,
                      "lost", (json_int_t)f->lost, "other", (json_int_t)f->other, "extra", (json_int_t)f->extra);
        if (json_object_set_new(rows, bench_workloads[k].name, of)) return json_decref(rows), NULL;
    }
    return json_pack("{s:s, s:o, s:i, s:i, s:i, s:o}", "scene", n->world->scene->path, "machine",
                     bench_machine_json(o->build.isa), "threads", (int)o->threads[0], "runs", (int)o->runs, "steps",
                     NEWTON_STEPS, "workloads", rows);
}

bool bench_newton(const scene *s, const bench_options *o, bench_form form)
{
    newton n = {0};
    bool done = run(&n, s, o);
    if (done && form == BENCH_JSON) done = stats_write("-", as_json(&n, o));
    else if (done) print(&n, o, form == BENCH_MARKDOWN);
    bench_rays_free(&n.rays);
    world_free(n.world);
    return done;
}
