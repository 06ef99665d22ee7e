/* bench_trim_scene.c - `epatch bench SCENE --trims`: what leaves make of trims.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Table 4 of W. Stürzlinger, "Ray-tracing triangular trimmed free-form surfaces" (1998), for each trimmed geometry of
 * the scene: no optimisation (every hit is tested), the pruned tree, the tree that stops where descending costs more
 * than testing; and, besides, what dividing regularly and along the curves to the end makes of it. */
#include "tools/bench_trim.h"
#include "tools/report.h"
#include "tools/stats.h"

#include <stdio.h>

typedef struct trimmed_geometry {
    trim_subject *subjects[TRIM_WAYS];
    size_t count;
    bench_rays rays;
} trimmed_geometry;

static bool is_trimmed(const scene_geometry *g)
{
    for (size_t i = 0; i < g->patch_count; ++i)
        if (g->patches[i].trim) return true;
    return false;
}

static bool measure(trimmed_geometry *g, const scene *s, size_t geometry, unsigned methods, const bench_options *o)
{
    for (size_t i = 0; i < TRIM_WAYS; ++i) {
        const trim_way *way = &trim_ways[i];
        if (way->kind == TRIM_BY_FILTER && !(methods >> way->method & 1)) continue;
        g->subjects[g->count] = trim_subject_new(s, geometry, way, o);
        if (!g->subjects[g->count++]) return false;
    }
    const char *name = s->geometries[geometry].name;
    return bench_rays_new(&g->rays, trim_subject_world(g->subjects[0]), o) &&
           trim_subjects_measure(g->subjects, g->count, &g->rays, o, name ? name : "trims");
}

static void print(const trimmed_geometry *g, const bench_options *o, bool markdown)
{
    table t = {0};
    const trim_subject *whole = g->subjects[0], *usual = g->subjects[g->count - 1];
    table_row(&t);
    table_cell(&t, "%s", "");
    trim_subject_head(&t);
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w)
        if (o->workloads >> w & 1) table_cell(&t, "%s", bench_workloads[w].name);
    for (size_t i = 0; i < g->count; ++i) {
        table_row(&t);
        table_cell(&t, "%s", trim_subject_way(g->subjects[i])->name);
        trim_subject_cells(&t, g->subjects[i]);
        for (unsigned w = 0; w < BENCH_WORKLOADS; ++w)
            if (o->workloads >> w & 1) table_figure(&t, trim_subject_speed(g->subjects[i], w));
    }
    t.apart[t.rows] = true;
    table_row(&t);
    table_cell(&t, "by curves / untrimmed");
    for (int i = 0; i < TRIM_SUBJECT_CELLS; ++i) table_cell(&t, "%s", "");
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w)
        if (o->workloads >> w & 1) table_figure(&t, trim_subject_speed(usual, w) / trim_subject_speed(whole, w));
    table_print(&t, markdown);
}

static json_t *as_json(const trimmed_geometry *g, const char *name)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < g->count; ++i)
        if (json_array_append_new(rows, trim_subject_json(g->subjects[i]))) return json_decref(rows), NULL;
    return json_pack("{s:s?, s:o}", "name", name, "ways", rows);
}

static void release(trimmed_geometry *g)
{
    for (size_t i = 0; i < g->count; ++i) trim_subject_free(g->subjects[i]);
    bench_rays_free(&g->rays);
}

static bool run(const scene *s, const bench_options *o, unsigned methods, bench_form form)
{
    json_t *list = json_array();
    size_t found = 0;
    bool done = true;
    if (form != BENCH_JSON)
        printf(
            "%s, trimmed geometries, each by itself. Millions of rays a second with %u thread%s, medians of %u runs; "
            "the rays fill\nthe untrimmed geometry and go on where it is trimmed away. crossed: the part of the "
            "domain that is tested.\n",
            s->path, o->threads[0], o->threads[0] == 1 ? "" : "s", o->runs);
    const size_t originals = scene_originals(s);
    for (size_t i = 0; i < originals && done; ++i) {
        if (!is_trimmed(&s->geometries[i])) continue;
        trimmed_geometry g = {.count = 0};
        const char *name = s->geometries[i].name;
        done = measure(&g, s, i, methods, o);
        if (done && form == BENCH_JSON) {
            json_array_append_new(list, as_json(&g, name));
        } else if (done) {
            printf("\n%s\n\n", name ? name : "(no name)");
            print(&g, o, form == BENCH_MARKDOWN);
        }
        found += done;
        release(&g);
    }
    if (done && !found) done = (report_file(s->path, "nothing in it is trimmed"), false);
    if (done && form == BENCH_JSON) {
        json_t *all = json_array_size(list) == found ? json_incref(list) : NULL;
        done = stats_write("-", json_pack("{s:o, s:o, s:i, s:i, s:o}", "scene", stats_name(s->path), "machine",
                                          bench_machine_json(o->build.isa), "threads", (int)o->threads[0], "runs",
                                          (int)o->runs, "geometries", all));
    }
    json_decref(list);
    return done;
}

bool bench_trims(const char *path, const bench_options *o, unsigned methods, bench_form form)
{
    scene *s = scene_read(path);
    if (!s) return false;
    const bool done = run(s, o, methods, form);
    scene_free(s);
    return done;
}
