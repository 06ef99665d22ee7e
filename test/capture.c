/* capture.c - see capture.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/capture.h"

#include <stdlib.h>
#include <string.h>

/* The next line that says something; false at the end of the file. */
static bool next_line(FILE *file, char *line, int size)
{
    while (fgets(line, size, file)) {
        line[strcspn(line, "#\n")] = 0;
        if (line[strspn(line, " ")]) return true;
    }
    return false;
}

static bool read_head(const char *line, capture *c)
{
    *c = (capture){.settings = epDefaultBuildSettings()};
    net_shape *s = &c->patch.shape;
    s->triangle = sscanf(line, "triangle %u", &s->n) == 1;
    if (s->triangle) s->m = s->n;
    else if (sscanf(line, "tensor %u %u", &s->m, &s->n) < 2) return false;
    const char *from = strstr(line, " from "), *depth = strstr(line, " depth ");
    if (from && sscanf(from, " from %f", &c->settings.rayDistance) < 1) return false;
    if (depth && sscanf(depth, " depth %u", &c->settings.maxDepth) < 1) return false;
    return s->m >= 1 && s->m <= NET_DEGREE && s->n >= 1 && s->n <= NET_DEGREE;
}

static bool read_point(const char *line, double p[4])
{
    return sscanf(line, "%lf %lf %lf %lf", &p[0], &p[1], &p[2], &p[3]) == 4;
}

static bool read_ray(const char *line, capture *c)
{
    test_ray r;
    if (sscanf(line, "ray %f %f %f %f %f %f", &r.org[0], &r.org[1], &r.org[2], &r.dir[0], &r.dir[1], &r.dir[2]) != 6)
        return false;
    c->rays = realloc(c->rays, (c->ray_count + 1) * sizeof r);
    assert_non_null(c->rays);
    c->rays[c->ray_count++] = r;
    return true;
}

capture *read_captures(const char *path, size_t *count)
{
    FILE *file = fopen(path, "r");
    CHECK(file, "cannot read %s", path);
    capture *all = NULL;
    char line[400];
    *count = 0;
    while (next_line(file, line, sizeof line)) {
        if (*count && read_ray(line, &all[*count - 1])) continue;
        all = realloc(all, (*count + 1) * sizeof *all);
        assert_non_null(all);
        capture *c = &all[(*count)++];
        CHECK(read_head(line, c), "%s: '%s'", path, line);
        for (size_t k = 0; k < net_count(c->patch.shape); ++k) {
            CHECK(next_line(file, line, sizeof line) && read_point(line, c->patch.points[k]), "%s: '%s'", path, line);
        }
    }
    fclose(file);
    return all;
}

void free_captures(capture *captures, size_t count)
{
    for (size_t i = 0; i < count; ++i) free(captures[i].rays);
    free(captures);
}

void write_captured_patch(FILE *file, const test_patch *p, const EPBuildSettings *settings)
{
    if (p->shape.triangle) fprintf(file, "triangle %u", p->shape.n);
    else fprintf(file, "tensor %u %u", p->shape.m, p->shape.n);
    const EPBuildSettings usual = epDefaultBuildSettings();
    if (settings->rayDistance != usual.rayDistance) fprintf(file, " from %.9g", settings->rayDistance);
    if (settings->maxDepth != usual.maxDepth) fprintf(file, " depth %u", settings->maxDepth);
    fprintf(file, "\n");
    for (size_t k = 0; k < net_count(p->shape); ++k) {
        const double *x = p->points[k];
        fprintf(file, "%.17g %.17g %.17g %.17g\n", x[0], x[1], x[2], x[3]);
    }
}

void write_captured_ray(FILE *file, const test_ray *r)
{
    fprintf(file, "ray %.9g %.9g %.9g %.9g %.9g %.9g\n", r->org[0], r->org[1], r->org[2], r->dir[0], r->dir[1],
            r->dir[2]);
}
