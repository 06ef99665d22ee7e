/* bench_trim_curves.c - `epatch bench --trim-curves`: does a patch with many trim curves cost more than one with few?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The setting of Table 4 in H.-F. Pabst, J. P. Springer, A. Schollmeyer, R. Lenhardt, C. Lessig, B. Froehlich, "Ray
 * casting of trimmed NURBS surfaces on the GPU" (2006): one bicubic patch fills the picture. It is trimmed by a single
 * contour, which is cut into ever more cubic curves; and by ever more round holes, of four arcs each. */
#include "tools/bench_trim.h"
#include "tools/model.h"
#include "tools/progress.h"
#include "tools/report.h"
#include "tools/stats.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum family { CONTOUR, HOLES, FAMILIES } family;
static const char *const family_name[FAMILIES] = {"one contour of cubic curves", "round holes of four arcs"};
static const char *const family_key[FAMILIES] = {"contour", "holes"};

enum { COUNTS = 4 };
static const unsigned counts[FAMILIES][COUNTS] = {{10, 100, 1000, 10000}, {4, 100, 1024, 10000}};

/* Packets of camera rays: what the paper drew. */
enum { PICTURE = 1 };

/* Draw times at 1000 x 1000 pixels, in ms; without trimming 25. */
static const struct {
    unsigned curves;
    double times;
} paper[] = {{2, 66.0 / 25}, {8, 134.0 / 25}, {9, 141.0 / 25}};
enum { PAPER = sizeof paper / sizeof paper[0] };

/* A point of the contour and, times f, its derivative by the angle. */
static void contour_point(double a, double f, double p[2], double d[2])
{
    const double r = 0.4 + 0.05 * cos(5 * a), dr = -0.25 * sin(5 * a);
    p[0] = 0.5 + r * cos(a), p[1] = 0.5 + r * sin(a);
    d[0] = f * (dr * cos(a) - r * sin(a)), d[1] = f * (dr * sin(a) + r * cos(a));
}

static EPStatus add_contour(EPRegion region, unsigned curves)
{
    const double step = 6.283185307179586 / curves;
    EPStatus status = epBeginRegion(region, EP_POLYGON, NULL);
    for (unsigned k = 0; k < curves && !status; ++k) {
        double p[2][2], d[2][2], c[4][3];
        for (unsigned i = 0; i < 2; ++i) contour_point(step * ((k + i) % curves), step / 3, p[i], d[i]);
        for (int x = 0; x < 2; ++x) c[0][x] = p[0][x], c[1][x] = p[0][x] + d[0][x];
        for (int x = 0; x < 2; ++x) c[2][x] = p[1][x] - d[1][x], c[3][x] = p[1][x];
        for (int i = 0; i < 4; ++i) c[i][2] = 1;
        status = epAddRegionBezier(region, 4, c[0]);
    }
    return status ? status : epEndRegion(region);
}

/* On a square grid; together they are as large, however many. */
static EPStatus add_holes(EPRegion region, unsigned curves)
{
    const unsigned side = (unsigned)sqrt(curves / 4);
    EPStatus status = epBeginRegion(region, EP_DIFFERENCE, NULL);
    if (!status) status = epAddRegionSquare(region, NULL);
    if (!status) status = epBeginRegion(region, EP_UNION, NULL);
    for (unsigned i = 0; i < side * side && !status; ++i) {
        const double f = 0.3 / side, at[2] = {(i % side + 0.5) / side, (i / side + 0.5) / side};
        status = epAddRegionCircle(region, (const double[6]){f, 0, 0, f, at[0], at[1]});
    }
    if (!status) status = epEndRegion(region);
    return status ? status : epEndRegion(region);
}

/* A patch with hills, seen in the picture from end to end. NULL after a message. */
static scene *new_scene(family f, unsigned curves)
{
    scene *s = calloc(1, sizeof *s);
    if (!s) return report_no_memory(NULL), NULL;
    s->path = strdup("a patch");
    s->geometries = calloc(1, sizeof *s->geometries);
    s->geometry_count = s->geometries ? 1 : 0;
    double *p = s->path && s->geometries ? geometry_add_patch(s->geometries, PATCH_TENSOR, 3, 3) : NULL;
    EPRegion region = p ? epNewRegion() : NULL;
    if (region) s->geometries->patches[0].trim = region;
    const EPStatus status = !region        ? EP_NO_MEMORY
                            : f == CONTOUR ? add_contour(region, curves)
                                           : add_holes(region, curves);
    for (int j = 0; j < 4 && p; ++j)
        for (int i = 0; i < 4; ++i, p += 4) {
            p[0] = 2 * i / 3.0 - 1, p[1] = 2 * j / 3.0 - 1, p[3] = 1;
            p[2] = 0.3 * sin(2.1 * i + 0.4) * cos(1.7 * j - 0.3);
        }
    if (status == EP_OK) return s;
    if (status == EP_NO_MEMORY) report_no_memory(NULL);
    else report_file(s->path, "%s", epGetRegionMessage(region));
    scene_free(s);
    return NULL;
}

/* One number of curves: its ways, of which the first is measured again for each. */
typedef struct row {
    scene *scene;
    trim_subject *subjects[TRIM_WAYS];
    size_t count;
    bench_rays rays;
} row;

static bool is_wanted(const trim_way *way, unsigned methods)
{
    return way->kind == TRIM_BY_FILTER ? methods >> way->method & 1
                                       : way->kind == TRIM_WHOLE || way->split == EP_TRIM_SPLIT_CURVES;
}

static bool measure(row *r, family f, unsigned curves, unsigned methods, const bench_options *o)
{
    char label[32];
    snprintf(label, sizeof label, "%s, %u", family_key[f], curves);
    r->scene = new_scene(f, curves);
    if (!r->scene) return false;
    for (size_t i = 0; i < TRIM_WAYS; ++i) {
        if (!is_wanted(&trim_ways[i], methods)) continue;
        r->subjects[r->count] = trim_subject_new(r->scene, 0, &trim_ways[i], o);
        if (!r->subjects[r->count++]) return false;
    }
    return bench_rays_new(&r->rays, trim_subject_world(r->subjects[0]), o) &&
           trim_subjects_measure(r->subjects, r->count, &r->rays, o, label);
}

static double ns(const trim_subject *t)
{
    return 1e3 / trim_subject_speed(t, PICTURE);
}

static void print(const row rows[COUNTS], family f, bool markdown)
{
    table t = {0};
    table_row(&t);
    table_cell(&t, "%s", family_name[f]);
    trim_subject_head(&t);
    for (size_t i = 0; i < rows[0].count; ++i) table_cell(&t, "%s", trim_subject_way(rows[0].subjects[i])->name);
    table_cell(&t, "times untrimmed");
    for (int k = 0; k < COUNTS; ++k) {
        const row *r = &rows[k];
        const trim_subject *usual = r->subjects[r->count - 1];
        table_row(&t);
        table_cell(&t, "%u curves", counts[f][k]);
        trim_subject_cells(&t, usual);
        for (size_t i = 0; i < r->count; ++i) table_figure(&t, ns(r->subjects[i]));
        table_figure(&t, ns(usual) / ns(r->subjects[0]));
    }
    if (f == CONTOUR) {
        t.apart[t.rows] = true;
        for (int k = 0; k < PAPER; ++k) {
            table_row(&t);
            table_cell(&t, "GPU of 2006, %u curves", paper[k].curves);
            while (t.cells[t.rows - 1] + 1 < t.cells[0]) table_cell(&t, "%s", "");
            table_figure(&t, paper[k].times);
        }
    }
    table_print(&t, markdown);
}

static json_t *as_json(const row rows[COUNTS], family f)
{
    json_t *list = json_array();
    for (int k = 0; k < COUNTS; ++k) {
        json_t *ways = json_array();
        for (size_t i = 0; i < rows[k].count; ++i) json_array_append_new(ways, trim_subject_json(rows[k].subjects[i]));
        if (json_array_size(ways) != rows[k].count) json_decref(ways), ways = NULL;
        if (json_array_append_new(list, json_pack("{s:i, s:o}", "curves", (int)counts[f][k], "ways", ways)))
            return json_decref(list), NULL;
    }
    return list;
}

static void release(row *r)
{
    for (size_t i = 0; i < r->count; ++i) trim_subject_free(r->subjects[i]);
    bench_rays_free(&r->rays);
    if (r->scene) scene_free(r->scene);
}

bool bench_trim_curves(const bench_options *given, unsigned methods, bench_form form)
{
    bench_options o = *given;
    o.workloads = 1u << PICTURE;
    json_t *families = json_object();
    bool done = true;
    if (form != BENCH_JSON)
        printf("A bicubic patch that fills the picture, trimmed. Nanoseconds a ray, packets of %u with %u thread%s, "
               "medians of %u runs;\nleaves, memory and the last column are those of the patches as they are.\n",
               bench_workloads[PICTURE].width, o.threads[0], o.threads[0] == 1 ? "" : "s", o.runs);
    for (family f = 0; f < FAMILIES && done; ++f) {
        row rows[COUNTS] = {0};
        for (int k = 0; k < COUNTS && done; ++k) done = measure(&rows[k], f, counts[f][k], methods, &o);
        if (done && form == BENCH_JSON) json_object_set_new(families, family_key[f], as_json(rows, f));
        else if (done) putchar('\n'), print(rows, f, form == BENCH_MARKDOWN);
        for (int k = 0; k < COUNTS; ++k) release(&rows[k]);
    }
    if (done && form == BENCH_JSON) {
        json_t *all = json_object_size(families) == FAMILIES ? json_incref(families) : NULL;
        done = stats_write("-", json_pack("{s:o, s:i, s:i, s:o}", "machine", bench_machine_json(o.build.isa), "threads",
                                          (int)o.threads[0], "runs", (int)o.runs, "trim_curves", all));
    }
    json_decref(families);
    return done;
}
