/* model_bpt.c - Bézier patches as plain text: their number, then for each its two degrees and its points.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The degrees are those in u and v; points are three numbers each, u running fastest. White space separates, lines
 * mean nothing. Memory grows with what is read, never with what the first number promises. */
#include "tools/files.h"
#include "tools/model.h"
#include "tools/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct text {
    const char *path;
    const char *at, *line_begin;
    size_t line;
} text;

static place here(const text *t)
{
    return (place){t->path, t->line, (size_t)(t->at - t->line_begin) + 1};
}

static void skip_space(text *t)
{
    for (; *t->at == ' ' || (*t->at >= '\t' && *t->at <= '\r'); ++t->at)
        if (*t->at == '\n') ++t->line, t->line_begin = t->at + 1;
}

/* The next number; `what` names it in the message when there is none. */
static bool read_number(text *t, const char *what, double *to)
{
    skip_space(t);
    if (!*t->at) return report(here(t), "the file ends before %s", what), false;

    char *end;
    *to = strtod(t->at, &end);
    size_t length = strcspn(t->at, " \t\n\v\f\r");
    if (end == t->at || (size_t)(end - t->at) != length) {
        report(here(t), "'%.*s' is not %s", (int)(length < 30 ? length : 30), t->at, what);
        return false;
    }
    t->at = end;
    return true;
}

/* A whole number in [least, most]. */
static bool read_whole(text *t, const char *what, double least, double most, double *to)
{
    skip_space(t);
    place where = here(t);
    if (!read_number(t, what, to)) return false;
    if (*to >= least && *to <= most && *to == (double)(unsigned long long)*to) return true;
    report(where, "%g is not %s from %g to %g", *to, what, least, most);
    return false;
}

static bool read_points(text *t, size_t count, double *p)
{
    for (size_t i = 0; i < count; ++i, p += 4) {
        skip_space(t);
        place where = here(t);
        for (int k = 0; k < 3; ++k)
            if (!read_number(t, "a coordinate", &p[k])) return false;
        p[3] = 1;
        const char *problem = point_problem(p);
        if (problem) return report(where, "%s", problem), false;
    }
    return true;
}

static bool read_patches(text *t, scene_geometry *g)
{
    double count, m, n;
    if (!read_whole(t, "the number of patches", 0, 4294967295.0, &count)) return false;
    for (double i = 0; i < count; ++i) {
        if (!read_whole(t, "a degree", 1, EP_MAX_DEGREE, &m) || !read_whole(t, "a degree", 1, EP_MAX_DEGREE, &n))
            return false;
        double *p = geometry_add_patch(g, PATCH_TENSOR, (unsigned)m, (unsigned)n);
        if (!p) return report_no_memory(t->path), false;
        if (!read_points(t, patch_point_count(PATCH_TENSOR, (unsigned)m, (unsigned)n), p)) return false;
    }
    skip_space(t);
    if (!*t->at) return true;
    report(here(t), "the file goes on after its %.0f patches", count);
    return false;
}

bool model_read_bpt(const char *path, const model_options *o, scene_geometry *g)
{
    (void)o;
    size_t size;
    char *data = input_read(path, &size);
    if (!data) return false;

    text t = {path, data, data, 1};
    bool done = read_patches(&t, g);
    if (done && strlen(data) != size) {
        report(here(&t), "a zero byte in a text file");
        done = false;
    }
    free(data);
    return done;
}
