/* cmd_trace.c - `epatch trace`: a file of rays in, a file of hits out.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/args.h"
#include "tools/commands.h"
#include "tools/files.h"
#include "tools/report.h"
#include "tools/stats.h"
#include "tools/trace.h"

#include <stdlib.h>
#include <string.h>

typedef struct trace_command {
    const char *scene, *rays, *hits, *stats;
    trace_options trace;
    world_options world;
} trace_command;

static bool write_stats(const trace_command *c, const world *w, size_t count, const trace_result *r)
{
    double speed = r->seconds > 0 ? (double)count / r->seconds : 0;
    json_t *o =
        json_pack("{s:I, s:I, s:f, s:f, s:i, s:i, s:b, s:b}", "rays", (json_int_t)count, "hits", (json_int_t)r->hits,
                  "seconds", r->seconds, "rays_per_second", speed, "threads", (int)trace_threads(c->trace.threads),
                  "width", (int)c->trace.width, "coherent", c->trace.coherent, "occluded", c->trace.occluded);
    bool complete = stats_add(o, stats_of_world(w));
    complete = stats_add(o, stats_of_cost(&r->cost)) && complete;
    if (!complete) json_decref(o), o = NULL;
    return stats_write(c->stats, o);
}

static bool answer(const trace_command *c, const world *w, const trace_ray *rays, size_t count, output *hits)
{
    size_t size = c->trace.occluded ? 1 : sizeof(world_hit);
    void *answers = malloc(count ? count * size : 1);
    trace_result result;
    if (!answers) {
        report_no_memory(c->hits);
        output_discard(hits);
        return false;
    }
    bool done = trace_rays(w, rays, count, &c->trace, answers, &result);
    /* The hits get their name last: when the statistics cannot be written, there are none of either. */
    if (done)
        done = fwrite(answers, size, count, hits->file) < count || fflush(hits->file) || !c->stats ||
               write_stats(c, w, count, &result);
    free(answers);
    if (done) return output_close(hits);
    output_discard(hits);
    return false;
}

static bool run(trace_command *c, const trace_ray *rays, size_t count)
{
    output hits;
    c->world.threads = c->trace.threads;
    c->world.ray_distance = trace_farthest_origin(rays, count);
    if (!output_open(&hits, c->hits)) return false;

    bool done = false;
    scene *s = scene_read(c->scene);
    world *w = s ? world_new(s, &c->world) : NULL;
    if (w) done = answer(c, w, rays, count, &hits);
    else output_discard(&hits);
    world_free(w);
    scene_free(s);
    return done;
}

int cmd_trace(int argc, char **argv)
{
    static const unsigned widths[] = {1, 4, 8, 16};
    static const char *const sets[] = {NULL, "plain", "avx2", "avx512"};
    trace_command c = {.world.build = epDefaultBuildSettings()};
    unsigned width = 3, isa = 0;
    bool on_demand = false;
    const arg_option options[] = {
        ARG_STRING("--rays", "FILE", &c.rays,
                   "8 little-endian float32 a ray: org.x org.y org.z tnear\ndir.x dir.y dir.z tfar"),
        ARG_STRING("--hits", "FILE", &c.hits,
                   "8 words a ray: float32 t u v, uint32 geomID primID,\nfloat32 Ng.x Ng.y Ng.z"),
        ARG_CHOICE("--width", "1|4|8|16", &width, "rays a packet (16)"),
        ARG_FLAG("--coherent", &c.trace.coherent, "tell Embree that neighbouring rays are alike"),
        ARG_FLAG("--occluded", &c.trace.occluded, "only whether anything is hit: one byte a ray, 1 or 0"),
        ARG_CHOICE_N("--as", "patches|triangles:N", &c.world.tessellation, 1, 8192,
                     "exact patches, or each an N x N grid of Embree\ntriangles (patches)"),
        ARG_FLAG("--on-demand", &on_demand, "cut a patch into leaves when a ray first meets it"),
        ARG_UNSIGNED("--threads", "N", &c.trace.threads, 0, 1024, "at most so many threads; 0: all (0)"),
        ARG_STRING("--stats", "FILE", &c.stats, "counts and times as JSON"),
        ARG_CHOICE("--isa", "best|plain|avx2|avx512", &isa, "instruction set of the kernels (best)"),
    };
    const arg_table table = {
        "trace SCENE --rays FILE --hits FILE",
        "Answers every ray of a file with its nearest hit on the scene. '-' as a FILE is standard\n"
        "input or output.",
        "SCENE",
        &c.scene,
        options,
        ARG_COUNT(options)};
    int status = args_parse(&table, argc, argv);
    if (status != ARGS_GO) return status;
    if (!c.rays) return args_wrong(&table, "--rays FILE is missing");
    if (!c.hits) return args_wrong(&table, "--hits FILE is missing");
    if (on_demand && c.world.tessellation) return args_wrong(&table, "--on-demand is for exact patches");
    if (!strcmp(c.scene, "-") && !strcmp(c.rays, "-"))
        return args_wrong(&table, "the scene and the rays cannot both come from standard input");
    if (c.stats && !strcmp(c.hits, c.stats))
        return args_wrong(&table, "the hits and the stats cannot both go to %s",
                          strcmp(c.hits, "-") ? c.hits : "standard output");
    c.trace.width = widths[width];
    c.world.build.isa = sets[isa];
    c.world.build.onDemand = on_demand;

    size_t count;
    trace_ray *rays = trace_read_rays(c.rays, &count);
    bool done = rays && run(&c, rays, count);
    free(rays);
    return done ? 0 : 1;
}
