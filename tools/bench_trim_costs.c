/* bench_trim_costs.c - `epatch bench --trim-costs`: what testing points costs on this machine.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Table 3 of W. Stürzlinger, "Ray-tracing triangular trimmed free-form surfaces" (1998): the costs that decide whether
 * a part of a patch is divided or its points are tested, and the tests themselves by every method. The paper's figures
 * have a unit of their own; only their proportions mean anything. */
#include "tools/bench_trim.h"
#include "tools/model.h"
#include "tools/report.h"
#include "tools/stats.h"
#include "trim/costs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A level of the hierarchy: patches with 2^FIRST to 2^LAST leaves, traced by the same rays. */
enum { FIRST = 4, LAST = 10, STEP = 2, HIERARCHIES = (LAST - FIRST) / STEP + 1 };

/* Of the workloads: camera rays, single and in packets. */
enum { SINGLE = 0, PACKETS = 1 };

/* So flat that every piece is as good as the whole: only the leaves' number differs. */
static scene *new_sheet(void)
{
    scene *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    s->path = strdup("a patch");
    s->geometries = calloc(1, sizeof *s->geometries);
    s->geometry_count = s->geometries ? 1 : 0;
    double *p = s->path && s->geometries ? geometry_add_patch(s->geometries, PATCH_TENSOR, 2, 2) : NULL;
    if (!p) return scene_free(s), NULL;
    for (int i = 0; i < 9; ++i, p += 4) p[0] = i % 3, p[1] = i / 3, p[2] = i == 4 ? 0.01 : 0, p[3] = 1;
    return s;
}

/* The slope of the line through the points (x, y) that fits best. */
static double slope(unsigned n, const double *x, const double *y)
{
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (unsigned i = 0; i < n; ++i) sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i];
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/* Nanoseconds that twice as many leaves add to a ray, by workload. False after a message. */
static bool measure_level(const bench_options *given, double ns[2])
{
    bench_options o = *given;
    o.workloads = 1u << SINGLE | 1u << PACKETS;
    o.build.thickness = 1e-6f; /* never reached: the depth decides */
    trim_subject *t[HIERARCHIES] = {NULL};
    bench_rays rays = {0};
    double x[HIERARCHIES], y[HIERARCHIES];
    scene *s = new_sheet();
    bool done = s;
    if (!s) report_no_memory(NULL);
    for (unsigned i = 0; i < HIERARCHIES && done; ++i) {
        o.build.maxDepth = FIRST + STEP * i;
        t[i] = trim_subject_new(s, 0, &trim_ways[0], &o);
        done = t[i];
    }
    done = done && bench_rays_new(&rays, trim_subject_world(t[0]), &o) &&
           trim_subjects_measure(t, HIERARCHIES, &rays, &o, "levels");
    for (unsigned w = SINGLE; w <= PACKETS && done; ++w) {
        for (unsigned i = 0; i < HIERARCHIES; ++i) {
            x[i] = log2((double)trim_subject_world(t[i])->leaves);
            y[i] = 1e3 / trim_subject_speed(t[i], w);
        }
        ns[w] = slope(HIERARCHIES, x, y);
    }
    for (unsigned i = 0; i < HIERARCHIES; ++i) trim_subject_free(t[i]);
    bench_rays_free(&rays);
    if (s) scene_free(s);
    return done;
}

typedef struct cost_line {
    const char *name, *key, *paper;
    double ns;
} cost_line;

enum { LINES = 8 };

static void fill(const ep_trim_costs *c, const double level[2], cost_line lines[LINES])
{
    const cost_line all[LINES] = {
        {"point beside a leaf's strip", "strip", "", c->strip},
        {"straight segment", "straight", "45", c->straight},
        {"curved segment", "curved", "13900", c->curved},
        {"... for each degree", "degree", "140", c->degree},
        {"operator", "operation", "510", c->operation},
        {"twice as many leaves, packets", "level16", "2360", level[PACKETS]},
        {"twice as many leaves, single", "level1", "", level[SINGLE]},
        {"to cut a leaf, for each piece", "cut", "", c->cut},
    };
    memcpy(lines, all, sizeof all);
}

static void print(const cost_line lines[LINES], const ep_trim_cost_row *rows, bool markdown)
{
    table costs = {0}, methods = {0};
    printf("What a point costs at a crossed leaf, in packets of 16, and the paper's figures (1998, in units of their "
           "own).\n\n");
    table_row(&costs);
    for (int i = 0; i < 3; ++i) table_cell(&costs, "%s", ((const char *[]){"", "ns", "paper"})[i]);
    for (int i = 0; i < LINES; ++i) {
        table_row(&costs);
        table_cell(&costs, "%s", lines[i].name);
        table_figure(&costs, lines[i].ns);
        table_cell(&costs, "%s", lines[i].paper);
    }
    table_print(&costs, markdown);
    printf("\nWhole regions: nanoseconds for a point of the unit square, one by one.\n\n");
    table_row(&methods);
    table_cell(&methods, "%s", "");
    for (int k = 0; k < EP_TRIM_METHODS; ++k) table_cell(&methods, "%s", ep_trim_method_name[k]);
    table_cell(&methods, "paper");
    for (int i = 0; i < EP_TRIM_COST_ROWS; ++i) {
        table_row(&methods);
        table_cell(&methods, "%s", rows[i].object);
        for (int k = 0; k < EP_TRIM_METHODS; ++k) table_figure(&methods, rows[i].ns[k]);
        table_cell(&methods, "%.0f", rows[i].paper);
    }
    table_print(&methods, markdown);
}

static json_t *as_json(const cost_line lines[LINES], const ep_trim_cost_row *rows)
{
    json_t *costs = json_object(), *objects = json_array();
    for (int i = 0; i < LINES; ++i) json_object_set_new(costs, lines[i].key, json_real(lines[i].ns));
    for (int i = 0; i < EP_TRIM_COST_ROWS; ++i) {
        json_t *ns = json_object(), *bytes = json_object();
        for (int k = 0; k < EP_TRIM_METHODS; ++k) {
            json_object_set_new(ns, ep_trim_method_name[k], json_real(rows[i].ns[k]));
            json_object_set_new(bytes, ep_trim_method_name[k], json_integer((json_int_t)rows[i].bytes[k]));
        }
        json_array_append_new(objects, json_pack("{s:s, s:o, s:o, s:f}", "object", rows[i].object, "ns", ns, "bytes",
                                                 bytes, "paper", rows[i].paper));
    }
    const bool complete = json_object_size(costs) == LINES && json_array_size(objects) == EP_TRIM_COST_ROWS;
    json_t *o = complete
                    ? json_pack("{s:o, s:O, s:O}", "machine", bench_machine_json(NULL), "ns", costs, "objects", objects)
                    : NULL;
    json_decref(costs);
    json_decref(objects);
    return o;
}

bool bench_trim_costs(const bench_options *o, bench_form form)
{
    ep_message m;
    ep_trim_costs costs;
    ep_trim_cost_row rows[EP_TRIM_COST_ROWS];
    cost_line lines[LINES];
    double level[2];
    if (ep_trim_measure(&costs, &m) || ep_trim_measure_rows(rows, &m)) return report_file(NULL, "%s", m.text), false;
    if (!measure_level(o, level)) return false;
    fill(&costs, level, lines);
    if (form == BENCH_JSON) return stats_write("-", as_json(lines, rows));
    print(lines, rows, form == BENCH_MARKDOWN);
    return true;
}
