/* cmd_info.c - `epatch info`: what is in a scene, and what its hierarchy looks like.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/args.h"
#include "tools/cage.h"
#include "tools/commands.h"
#include "tools/domain_svg.h"
#include "tools/report.h"
#include "tools/stats.h"
#include "tools/trace.h"

#include <stdlib.h>
#include <string.h>

typedef struct info_command {
    const char *scene, *rays, *svg;
    unsigned patch;
    bool json;
    world_options world;
} info_command;

/* Patches of one kind and degree. */
typedef struct sort {
    patch_kind kind;
    unsigned degree_u, degree_v;
    bool rational;
    size_t count;
} sort;

typedef struct geometry_info {
    const char *name;
    sort *sorts;
    size_t sort_count, copies;
    EPStatistics statistics; /* with those of copies */
    float bounds[6];         /* with those of copies */
} geometry_info;

static int compare_sorts(const void *x, const void *y)
{
    const sort *a = x, *b = y;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    if (a->degree_u != b->degree_u) return a->degree_u < b->degree_u ? -1 : 1;
    if (a->degree_v != b->degree_v) return a->degree_v < b->degree_v ? -1 : 1;
    return (int)a->rational - (int)b->rational;
}

/* Sorted patches, then runs of equal ones counted. False when there is no memory. */
static bool count_sorts(const scene_geometry *g, geometry_info *info)
{
    sort *s = info->sorts = malloc((g->patch_count + 1) * sizeof *s);
    if (!s) return false;
    for (size_t i = 0; i < g->patch_count; ++i) {
        const patch *p = &g->patches[i];
        s[i] = (sort){p->kind, p->degree_u, p->degree_v, p->rational, 1};
    }
    qsort(s, g->patch_count, sizeof *s, compare_sorts);
    size_t n = 0;
    for (size_t i = 0; i < g->patch_count; ++i) {
        if (n && !compare_sorts(&s[n - 1], &s[i])) ++s[n - 1].count;
        else s[n++] = s[i];
    }
    info->sort_count = n;
    return true;
}

static void add_statistics(EPStatistics *total, const EPStatistics *s)
{
    double all = (double)(total->leaves + s->leaves), part = all > 0 ? (double)s->leaves / all : 0;
    total->averageDepth += part * (s->averageDepth - total->averageDepth);
    total->averageThickness += part * (s->averageThickness - total->averageThickness);
    if (s->maximumDepth > total->maximumDepth) total->maximumDepth = s->maximumDepth;
    total->faces += s->faces;
    total->patches += s->patches;
    total->leaves += s->leaves;
    total->uncertified += s->uncertified;
    total->bytes += s->bytes;
    total->buildSeconds += s->buildSeconds;
    if (s->isa) total->isa = s->isa;
}

static const char *kind_name(patch_kind kind)
{
    return kind == PATCH_TRIANGLE ? "triangle" : "tensor";
}

static void print_row(const char *name, const EPStatistics *s)
{
    printf("%-22.22s %8zu %9zu %8.2f %4u %9.4f %11zu %10.4f %10.1f\n", name, s->patches, s->leaves, s->averageDepth,
           s->maximumDepth, s->averageThickness, s->uncertified, s->buildSeconds, (double)s->bytes / 1024);
}

static void print_sort(const sort *s)
{
    char degree[24];
    if (s->kind == PATCH_TRIANGLE) snprintf(degree, sizeof degree, "%u", s->degree_u);
    else snprintf(degree, sizeof degree, "%u x %u", s->degree_u, s->degree_v);
    printf("  %zu %s%s of degree %s, %s\n", s->count, s->kind == PATCH_TRIANGLE ? "Bézier triangle" : "Bézier patch",
           s->count == 1               ? ""
           : s->kind == PATCH_TRIANGLE ? "s"
                                       : "es",
           degree, s->rational ? "rational" : "polynomial");
}

static void print_faces(const scene_geometry *g)
{
    const size_t faces = g->patch_count ? (size_t)face_of(g, g->patch_count - 1) + 1 : 0;
    if (g->cage) printf("  %zu faces of a cage of %zu vertices\n", g->cage->face_count, g->cage->vertex_count);
    else if (g->charts) printf("  %zu face%s\n", faces, faces == 1 ? "" : "s");
}

static void print_table(const world *w, const geometry_info *infos, const EPStatistics *total,
                        const trace_result *traced)
{
    const scene *s = w->scene;
    const size_t n = scene_originals(s);
    printf("%s: %zu geometr%s, %zu object%s, kernels %s\n", s->path, n, n == 1 ? "y" : "ies", s->object_count,
           s->object_count == 1 ? "" : "s", total->isa ? total->isa : "none");
    if (w->bounds[0] <= w->bounds[3])
        printf("box %g %g %g to %g %g %g\n", (double)w->bounds[0], (double)w->bounds[1], (double)w->bounds[2],
               (double)w->bounds[3], (double)w->bounds[4], (double)w->bounds[5]);
    printf("\n%-22s %8s %9s %8s %4s %9s %11s %10s %10s\n", "geometry", "patches", "leaves", "depth", "max", "thickness",
           "uncertified", "setup s", "kB");
    for (size_t i = 0; i < n; ++i) {
        char number[32];
        snprintf(number, sizeof number, "%zu", i);
        print_row(infos[i].name ? infos[i].name : number, &infos[i].statistics);
        print_faces(&s->geometries[i]);
        for (size_t k = 0; k < infos[i].sort_count; ++k) print_sort(&infos[i].sorts[k]);
        if (infos[i].copies)
            printf("  and %zu cop%s, where objects put them\n", infos[i].copies, infos[i].copies == 1 ? "y" : "ies");
    }
    if (n != 1) print_row("total", total);
    printf("\nwith Embree's hierarchy: %.4f s, %.1f kB ours and %.1f kB Embree's\n", w->build_seconds,
           (double)w->bytes_patches / 1024, (double)w->bytes_embree / 1024);
    if (traced)
        printf("rays: %zu hits, %.3f iterations on average, %.3f leaves a hit, %llu by subdivision\n", traced->hits,
               stats_mean_iterations(&traced->cost),
               traced->hits ? (double)traced->cost.visits / (double)traced->hits : 0,
               (unsigned long long)traced->cost.slow);
}

static json_t *bounds_json(const float b[6])
{
    if (!(b[0] <= b[3])) return json_null();
    return json_pack("[f, f, f, f, f, f]", (double)b[0], (double)b[1], (double)b[2], (double)b[3], (double)b[4],
                     (double)b[5]);
}

static json_t *statistics_json(const EPStatistics *s)
{
    return json_pack("{s:I, s:I, s:I, s:f, s:i, s:f, s:I, s:f, s:I}", "faces", (json_int_t)s->faces, "patches",
                     (json_int_t)s->patches, "leaves", (json_int_t)s->leaves, "average_depth", s->averageDepth,
                     "maximum_depth", (int)s->maximumDepth, "average_thickness", s->averageThickness, "uncertified",
                     (json_int_t)s->uncertified, "setup_seconds", s->buildSeconds, "bytes", (json_int_t)s->bytes);
}

static json_t *geometry_json(const geometry_info *info)
{
    json_t *kinds = json_array();
    for (size_t i = 0; i < info->sort_count; ++i) {
        const sort *s = &info->sorts[i];
        json_t *kind = json_pack("{s:s, s:[i, i], s:b, s:I}", "kind", kind_name(s->kind), "degree", (int)s->degree_u,
                                 (int)s->degree_v, "rational", s->rational, "count", (json_int_t)s->count);
        if (json_array_append_new(kinds, kind)) return json_decref(kinds), NULL;
    }
    json_t *o = json_pack("{s:s?, s:o, s:I, s:o}", "name", info->name, "kinds", kinds, "copies",
                          (json_int_t)info->copies, "bounds", bounds_json(info->bounds));
    if (!stats_add(o, statistics_json(&info->statistics))) return json_decref(o), NULL;
    return o;
}

static bool print_json(const world *w, const geometry_info *infos, const EPStatistics *total,
                       const trace_result *traced)
{
    json_t *geometries = json_array();
    for (size_t i = 0; i < scene_originals(w->scene); ++i)
        if (json_array_append_new(geometries, geometry_json(&infos[i]))) {
            json_decref(geometries);
            return stats_write("-", NULL);
        }
    json_t *o = json_pack("{s:o, s:i, s:o, s:o, s:o}", "scene", stats_name(w->scene->path), "objects",
                          (int)w->scene->object_count, "bounds", bounds_json(w->bounds), "geometries", geometries,
                          "total", statistics_json(total));
    bool complete = stats_add(o, stats_of_world(w));
    if (traced) complete = stats_add(o, stats_of_cost(&traced->cost)) && complete;
    if (!complete) json_decref(o), o = NULL;
    return stats_write("-", o);
}

/* What the copies of a geometry take, and where they are, is told with the geometry; its patches are counted once. */
static void add_copy(geometry_info *info, EPGeometry copy)
{
    EPStatistics s;
    float b[6];
    epGetGeometryStatistics(copy, &s);
    epGetGeometryBounds(copy, b);
    s.patches = s.faces = 0;
    add_statistics(&info->statistics, &s);
    for (int x = 0; x < 3; ++x) {
        if (b[x] < info->bounds[x]) info->bounds[x] = b[x];
        if (b[3 + x] > info->bounds[3 + x]) info->bounds[3 + x] = b[3 + x];
    }
    ++info->copies;
}

static bool describe(const info_command *c, const world *w, const trace_result *traced)
{
    const scene *s = w->scene;
    size_t n = scene_originals(s);
    geometry_info *infos = calloc(n + 1, sizeof *infos);
    EPStatistics total = {0};
    bool done = infos != NULL;
    for (size_t i = 0; done && i < n; ++i) {
        infos[i].name = s->geometries[i].name;
        epGetGeometryStatistics(w->geometries[i], &infos[i].statistics);
        epGetGeometryBounds(w->geometries[i], infos[i].bounds);
        done = count_sorts(&s->geometries[i], &infos[i]);
    }
    for (size_t i = n; done && i < s->geometry_count; ++i)
        add_copy(&infos[s->geometries[i].original - s->geometries], w->geometries[i]);
    for (size_t i = 0; done && i < n; ++i) add_statistics(&total, &infos[i].statistics);
    if (!done) report_no_memory(s->path);
    else if (c->json) done = print_json(w, infos, &total, traced);
    else print_table(w, infos, &total, traced);

    for (size_t i = 0; infos && i < n; ++i) free(infos[i].sorts);
    free(infos);
    return done;
}

static bool run(info_command *c, const trace_ray *rays, size_t count)
{
    const trace_options trace = {.width = 16, .threads = c->world.threads};
    trace_result traced;
    bool done = false;

    scene *s = scene_read(c->scene);
    world *w = s ? world_new(s, &c->world) : NULL;
    if (w && (!rays || trace_rays(w, rays, count, &trace, NULL, &traced))) {
        done = !c->svg || domain_svg_write(w, c->patch, c->svg);
        done = done && describe(c, w, rays ? &traced : NULL);
    }
    world_free(w);
    scene_free(s);
    return done;
}

int cmd_info(int argc, char **argv)
{
    info_command c = {.world.build = epDefaultBuildSettings()};
    const arg_option options[] = {
        ARG_FLAG("--json", &c.json, "one JSON object instead of the table"),
        ARG_STRING("--rays", "FILE", &c.rays, "trace these rays too, and tell what they cost"),
        ARG_STRING("--svg", "FILE", &c.svg, "draw the domain of a patch there: its leaves and its trim curves"),
        ARG_UNSIGNED("--patch", "N", &c.patch, 0, UINT32_MAX, "the patch to draw, counted through all geometries (0)"),
        ARG_UNSIGNED("--threads", "N", &c.world.threads, 0, 1024, "at most so many threads; 0: all (0)"),
    };
    const arg_table table = {"info SCENE", "Tells what is in a scene, and the statistics of its hierarchy.",
                             "SCENE",      &c.scene,
                             options,      ARG_COUNT(options)};
    int status = args_parse(&table, argc, argv);
    if (status != ARGS_GO) return status;
    if (c.rays && !strcmp(c.scene, "-") && !strcmp(c.rays, "-"))
        return args_wrong(&table, "the scene and the rays cannot both come from standard input");

    if (c.svg && !strcmp(c.svg, "-")) return args_wrong(&table, "--svg needs the name of a file");

    trace_ray *rays = NULL;
    size_t count = 0;
    if (c.rays) {
        rays = trace_read_rays(c.rays, &count);
        if (!rays) return 1;
        c.world.ray_distance = trace_farthest_origin(rays, count);
    }
    bool done = run(&c, rays, count);
    free(rays);
    return done ? 0 : 1;
}
