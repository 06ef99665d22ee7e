/* cmd_bench.c - `epatch bench`: why not tessellate?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/args.h"
#include "tools/bench_trim.h"
#include "tools/commands.h"
#include "tools/files.h"
#include "tools/machine.h"
#include "tools/report.h"
#include "tools/stats.h"

#include <string.h>

typedef struct bench_command {
    const char *scene, *stats, *plot;
    bool json, markdown, degrees, newton, trims, trim_curves, trim_costs, all_threads;
    unsigned threads, megabytes, methods;
    bench_options options;
} bench_command;

/* Whether the file can be written, before a minute is spent on what goes into it. */
static bool can_write(const char *path)
{
    output o;
    if (!output_open(&o, path)) return false;
    output_discard(&o);
    return true;
}

static bool write_results(const bench_command *c, const bench *b)
{
    bool done = true;
    if (c->json) done = stats_write("-", bench_json(b));
    else bench_print(b, c->markdown);
    if (c->stats) done = done && stats_write(c->stats, bench_json(b));
    return done && (!c->plot || bench_plot(b, c->plot));
}

/* NULL after a message. */
static scene *read_scene(const bench_command *c)
{
    scene *s = scene_read(c->scene);
    if (!s || !c->options.scene_camera || s->has_camera) return s;
    report_file(s->path, "there is no camera for --scene-camera");
    scene_free(s);
    return NULL;
}

static bool run(const bench_command *c)
{
    bench b = {0};
    if (c->plot && !(bench_plot_possible(c->plot) && can_write(c->plot))) return false;
    if (c->stats && !can_write(c->stats)) return false;

    scene *s = read_scene(c);
    if (!s) return false;
    const bool done = bench_run(&b, s, &c->options) && write_results(c, &b);
    bench_free(&b);
    scene_free(s);
    return done;
}

static bool run_newton(const bench_command *c, bench_form form)
{
    scene *s = read_scene(c);
    if (!s) return false;
    const bool done = bench_newton(s, &c->options, form);
    scene_free(s);
    return done;
}

/* What is not about tessellations. */
static bool run_other(const bench_command *c)
{
    const bench_form form = c->json ? BENCH_JSON : c->markdown ? BENCH_MARKDOWN : BENCH_TEXT;
    if (c->degrees) return bench_degrees(&c->options, form);
    if (c->newton) return run_newton(c, form);
    if (c->trims) return bench_trims(c->scene, &c->options, c->methods, form);
    return c->trim_curves ? bench_trim_curves(&c->options, c->methods, form) : bench_trim_costs(&c->options, form);
}

/* Unless more is asked for: beyond it, building alone takes minutes. */
#define MEMORY_DEFAULT ((size_t)4 << 30)

/* Columns of threads, and memory. */
static void settle(bench_command *c)
{
    bench_options *o = &c->options;
    o->threads[0] = c->all_threads ? 1 : trace_threads(c->threads);
    o->threads[1] = trace_threads(0);
    o->columns = c->all_threads ? 2 : 1;
    const size_t half = machine_free_memory() / 2;
    o->memory = c->megabytes ? (size_t)c->megabytes << 20 : half < MEMORY_DEFAULT ? half : MEMORY_DEFAULT;
}

static bool is_power_of_two(unsigned n)
{
    return !(n & (n - 1));
}

int cmd_bench(int argc, char **argv)
{
    static const char *const sets[] = {NULL, "plain", "avx2", "avx512"};
    bench_command c = {.threads = 1,
                       .methods = (1u << EP_TRIM_METHODS) - 1,
                       .options = {.runs = 5,
                                   .rays = 1 << 19,
                                   .workloads = (1u << BENCH_WORKLOADS) - 1,
                                   .max_grid = BENCH_LAST_GRID,
                                   .build = epDefaultBuildSettings()}};
    unsigned isa = 0;
    bool no_scene = false;
    for (int i = 1; i < argc; ++i) {
        c.degrees |= !strcmp(argv[i], "--degrees");
        no_scene |= !strcmp(argv[i], "--trim-curves") || !strcmp(argv[i], "--trim-costs");
    }
    no_scene |= c.degrees;
    if (c.degrees) c.threads = 0;
    const arg_option options[] = {
        ARG_FLAG("--json", &c.json, "one JSON object instead of the table"),
        ARG_FLAG("--table", &c.markdown, "the table as Markdown"),
        ARG_STRING("--stats", "FILE", &c.stats, "the JSON object into a file, besides the table"),
        ARG_STRING("--plot", "FILE.svg", &c.plot, "error against speed, memory and build time, drawn by\ngnuplot"),
        ARG_UNSIGNED("--runs", "N", &c.options.runs, 1, BENCH_RUNS_MAX, "runs; figures are their medians (5)"),
        ARG_UNSIGNED("--rays", "N", &c.options.rays, 16, 1u << 28,
                     "camera rays, about; a quarter as many of the other\nkinds (524288)"),
        ARG_SET("--workloads", "primary1,primary16,random1,random16,bounce1,bounce16,occluded1,occluded16",
                &c.options.workloads, "only these; 1: single rays, 16: packets (all)"),
        ARG_UNSIGNED("--threads", "N", &c.threads, 0, 1024,
                     "for building and tracing; 0: all (1; with --degrees: all)"),
        ARG_FLAG("--all-threads", &c.all_threads, "measure with one thread and with all"),
        ARG_UNSIGNED("--max-tessellation", "N", &c.options.max_grid, BENCH_FIRST_GRID, BENCH_LAST_GRID,
                     "the finest tessellation, a power of two\n(what memory allows)"),
        ARG_UNSIGNED("--memory", "MB", &c.megabytes, 1, 1u << 30,
                     "that a tessellation may take while it is built\n(half of what is free, 4096 at most)"),
        ARG_FLAG("--scene-camera", &c.options.scene_camera,
                 "the scene's camera for primary rays, not one that fills\nthe picture"),
        ARG_FLAG("--degrees", &c.degrees,
                 "instead of a SCENE: patches of degree 2x2 to 6x6 that\nfill the picture, beside the speeds that "
                 "Pabst et al.\nmeasured on a GPU in 2006"),
        ARG_FLAG("--newton", &c.newton,
                 "instead of tessellations: the same kernels without\ncertificates, which is Newton's method as usual, "
                 "and\nwhat that loses"),
        ARG_FLAG("--trims", &c.trims,
                 "instead of tessellations: each trimmed geometry of the\nscene, all of its hits tested, or its leaves "
                 "divided in\nseveral ways"),
        ARG_FLAG("--trim-curves", &c.trim_curves, "instead of a SCENE: a patch with 4 to 10,000 trim curves"),
        ARG_FLAG("--trim-costs", &c.trim_costs, "instead of a SCENE: what testing a point costs here"),
        ARG_SET("--trim-tests", "cells,strips,clipping,left", &c.methods,
                "the ways to test hits that --trims and --trim-curves\ncompare (all)"),
        ARG_CHOICE("--isa", "best|plain|avx2|avx512", &isa, "instruction set of the kernels (best)"),
    };
    const arg_table table = {"bench SCENE",
                             "Measures exact patches against tessellations, each patch 8 x 8, 16 x 16, ... cells of\n"
                             "Embree triangles until they are as exact as the patches or memory ends: speed, error,\n"
                             "memory and time to build, all in one run. Of a cage, Embree's grids and its own\n"
                             "subdivision geometry, too.",
                             no_scene ? NULL : "SCENE",
                             &c.scene,
                             options,
                             ARG_COUNT(options)};
    int status = args_parse(&table, argc, argv);
    if (status != ARGS_GO) return status;
    if (c.json && c.markdown) return args_wrong(&table, "--json and --table exclude each other");
    if (c.stats && !strcmp(c.stats, "-")) return args_wrong(&table, "--stats is '-'; --json writes to standard output");
    if (c.all_threads && !c.degrees && c.threads != 1)
        return args_wrong(&table, "--threads and --all-threads exclude each other");
    if (!is_power_of_two(c.options.max_grid))
        return args_wrong(&table, "--max-tessellation is '%u', not a power of two", c.options.max_grid);
    if (c.plot && (strlen(c.plot) < 5 || strcmp(c.plot + strlen(c.plot) - 4, ".svg")))
        return args_wrong(&table, "--plot is '%s', not the name of an .svg file", c.plot);
    if (c.degrees && (c.plot || c.stats || c.all_threads))
        return args_wrong(&table, "--degrees goes with none of --plot, --stats and --all-threads");
    if (c.degrees + c.newton + c.trims + c.trim_curves + c.trim_costs > 1)
        return args_wrong(&table, "--degrees, --newton, --trims, --trim-curves and --trim-costs exclude each other");
    if (c.newton && (c.plot || c.stats || c.all_threads))
        return args_wrong(&table, "--newton goes with none of --plot, --stats and --all-threads");
    if ((c.trims || c.trim_curves || c.trim_costs) && (c.plot || c.stats || c.all_threads || c.options.scene_camera))
        return args_wrong(&table, "--trims, --trim-curves and --trim-costs go with none of --plot, --stats, "
                                  "--scene-camera and --all-threads");
    c.options.build.isa = sets[isa];
    settle(&c);
    return (c.degrees || c.newton || c.trims || c.trim_curves || c.trim_costs ? run_other(&c) : run(&c)) ? 0 : 1;
}
