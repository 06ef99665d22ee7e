/* scene.c - the memory of scenes, what makes a point or a camera valid, and which reader a file goes to.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/scene_json.h"
#include "tools/scene_place.h"
#include "tools/args.h"
#include "tools/files.h"
#include "tools/model.h"
#include "tools/report.h"
#include "test/oracle/trim_reference.h"

#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* Embree ignores geometry farther out: squares of coordinates must be floats. Weights scale coordinates. */
#define COORDINATE_MAX 1e18
#define WEIGHT_MIN 1e-18
#define WEIGHT_MAX 1e18

typedef struct model_format {
    const char *extension;
    bool (*read)(const char *path, const model_options *o, scene_geometry *g);
    unsigned up;
} model_format;

static const model_format formats[] = {
    {".bpt", model_read_bpt, 2},   {".obj", model_read_obj, 1},   {".step", model_read_step, 2},
    {".stp", model_read_step, 2},  {".iges", model_read_iges, 2}, {".igs", model_read_iges, 2},
    {".brep", model_read_brep, 2},
};

static const char *extension(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
    return dot && dot != name ? dot : "";
}

/* NULL when there is none. */
static const model_format *format_of(const char *path)
{
    const char *e = extension(path);
    for (size_t i = 0; i < ARG_COUNT(formats); ++i)
        if (!strcasecmp(e, formats[i].extension)) return &formats[i];
    return NULL;
}

bool model_read(const char *path, const model_options *o, scene_geometry *g)
{
    const model_format *f = format_of(path);
    if (f) return f->read(path, o, g);
    struct stat st;
    if (stat(path, &st)) return report_file(path, "cannot open: %s", strerror(errno)), false;
    if (S_ISDIR(st.st_mode)) return report_file(path, "cannot read: %s", strerror(EISDIR)), false;
    if (!strcasecmp(extension(path), ".json")) return report_file(path, "a scene cannot be a part of a scene"), false;
    return report_file(path, "'%s' is no kind of file that is known here; try .json, .bpt, .obj, .step, .iges or .brep",
                       extension(path)),
           false;
}

size_t patch_point_count(patch_kind kind, unsigned degree_u, unsigned degree_v)
{
    size_t m = degree_u, n = degree_v;
    return kind == PATCH_TRIANGLE ? (n + 1) * (n + 2) / 2 : (m + 1) * (n + 1);
}

/* Room for `more` items behind `count`: the capacity is always the next power of two. */
static void *grow(void *items, size_t size, size_t count, size_t more)
{
    size_t before = count ? 1 : 0, after = 1;
    while (before && before < count) before *= 2;
    while (after < count + more) after *= 2;
    if (after == before) return items;
    return after <= SIZE_MAX / size ? realloc(items, after * size) : NULL;
}

double *geometry_add_points(scene_geometry *g, size_t count)
{
    double *points = grow(g->points, 4 * sizeof *points, g->point_count, count);
    if (!points) return NULL;
    g->points = points;
    g->point_count += count;
    return points + 4 * (g->point_count - count);
}

double *geometry_add_patch(scene_geometry *g, patch_kind kind, unsigned degree_u, unsigned degree_v)
{
    patch *patches = grow(g->patches, sizeof *patches, g->patch_count, 1);
    if (!patches) return NULL;
    g->patches = patches;
    const size_t first = g->point_count;
    double *points = geometry_add_points(g, patch_point_count(kind, degree_u, degree_v));
    if (points) patches[g->patch_count++] = (patch){kind, degree_u, degree_v, first, false, NULL, NULL};
    return points;
}

bool geometry_place_patch(scene_geometry *g, const double place[6])
{
    double(*places)[6] = grow(g->places, sizeof *places, g->patch_count - 1, 1);
    if (!places) return false;
    g->places = places;
    memcpy(places[g->patch_count - 1], place, sizeof *places);
    return true;
}

bool geometry_add_chart(scene_geometry *g, const chart *at)
{
    chart *charts = grow(g->charts, sizeof *charts, g->chart_count, 1);
    if (!charts) return false;
    g->charts = charts;
    charts[g->chart_count++] = *at;
    return true;
}

bool geometry_add_shape(scene_geometry *g, struct trim_shape *shape)
{
    struct trim_shape **shapes = grow(g->shapes, sizeof *shapes, g->shape_count, 1);
    if (!shapes) return false;
    g->shapes = shapes;
    shapes[g->shape_count++] = shape;
    return true;
}

const char *point_problem(const double p[4])
{
    for (int i = 0; i < 4; ++i)
        if (!isfinite(p[i])) return i < 3 ? "a coordinate is not finite" : "the weight is not finite";
    for (int i = 0; i < 3; ++i)
        if (fabs(p[i]) > COORDINATE_MAX) return "a coordinate is beyond 1e18";
    if (p[3] <= 0) return "the weight is not positive";
    if (p[3] < WEIGHT_MIN || p[3] > WEIGHT_MAX) return "the weight is outside 1e-18 to 1e18";
    return NULL;
}

const char *camera_problem(const camera *c)
{
    double f[3], cross[3], f2 = 0, up2 = 0, cross2 = 0;
    for (int i = 0; i < 3; ++i) {
        if (!(fabs(c->eye[i]) <= COORDINATE_MAX) || !(fabs(c->target[i]) <= COORDINATE_MAX) ||
            !(fabs(c->up[i]) <= COORDINATE_MAX))
            return "a number of the camera is beyond 1e18";
        f[i] = c->target[i] - c->eye[i];
    }
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        cross[i] = f[j] * c->up[k] - f[k] * c->up[j];
        f2 += f[i] * f[i], up2 += c->up[i] * c->up[i], cross2 += cross[i] * cross[i];
    }
    if (f2 == 0) return "the camera's eye is its target";
    if (up2 == 0) return "the camera's up is zero";
    if (cross2 <= 1e-24 * f2 * up2) return "the camera's up points along its view"; /* a sine of 1e-12 */
    if (!(c->fov > 0 && c->fov < 180)) return "the camera's fov is not between 0 and 180 degrees";
    return NULL;
}

static void find_rational(scene_geometry *g)
{
    for (size_t i = 0; i < g->patch_count; ++i) {
        patch *p = &g->patches[i];
        size_t n = patch_point_count(p->kind, p->degree_u, p->degree_v);
        for (size_t k = 0; k < n && !p->rational; ++k) p->rational = g->points[4 * (p->first + k) + 3] != 1;
    }
}

/* Without objects, each geometry stands once. */
static bool place_all(scene *s)
{
    s->objects = calloc(s->geometry_count ? s->geometry_count : 1, sizeof *s->objects);
    if (!s->objects) return report_no_memory(s->path), false;
    for (size_t i = 0; i < s->geometry_count; ++i)
        s->objects[i] = (scene_object){i, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, true, NULL};
    s->object_count = s->geometry_count;
    return true;
}

static bool read_model_scene(scene *s)
{
    s->geometries = calloc(1, sizeof *s->geometries);
    if (!s->geometries) return report_no_memory(s->path), false;
    s->geometry_count = 1;
    const model_options usual = {POLYGONS_ALONE, CAGE_CATMULL_CLARK, CAGE_LEVEL_DEFAULT, NULL};
    const model_format *f = format_of(s->path);
    if (f) s->up = f->up;
    return model_read(s->path, &usual, s->geometries);
}

scene *scene_read(const char *path)
{
    scene *s = calloc(1, sizeof *s);
    if (s) s->path = strdup(input_name(path));
    if (!s || !s->path) {
        report_no_memory(path);
        scene_free(s);
        return NULL;
    }
    s->up = 2;
    const char *e = extension(path);
    bool json = !*e || !strcasecmp(e, ".json");
    bool done = json ? scene_read_json(path, s) : read_model_scene(s);
    if (done && !s->objects) done = place_all(s);
    for (size_t i = 0; done && i < s->geometry_count; ++i) find_rational(&s->geometries[i]);
    if (done && scene_place(s)) return s;
    scene_free(s);
    return NULL;
}

size_t chart_count(const scene_geometry *g)
{
    return g->charts ? g->chart_count : g->patch_count;
}

chart chart_at(const scene_geometry *g, size_t i)
{
    if (g->charts) return g->charts[i];
    return (chart){g->patches[i].kind, (uint32_t)i, 0, 0, 1, 1, i, 1};
}

void chart_place(const chart *c, double s, double t, double *u, double *v)
{
    *u = c->u0 + c->du * s;
    *v = c->v0 + c->dv * t;
}

/* How far (s, t) is outside the unit square or triangle. */
static double outside(patch_kind kind, double s, double t)
{
    return fmax(fmax(fmax(-s, -t), (kind == PATCH_TRIANGLE ? s + t : fmax(s, t)) - 1), 0);
}

uint32_t face_of(const scene_geometry *g, size_t patch)
{
    if (!g->charts) return (uint32_t)patch;
    size_t low = 0, high = g->chart_count; /* charts[low].first <= patch */
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (g->charts[middle].first <= patch) low = middle;
        else high = middle;
    }
    return g->charts[low].face;
}

size_t chart_of(const scene_geometry *g, uint32_t face, double u, double v)
{
    if (!g->charts) return face;
    size_t low = 0, high = g->chart_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (g->charts[middle].face < face) low = middle + 1;
        else high = middle;
    }
    size_t best = low;
    double least = INFINITY;
    for (size_t i = low; i < g->chart_count && g->charts[i].face == face; ++i) {
        const chart *c = &g->charts[i];
        const double out = outside(c->kind, (u - c->u0) / c->du, (v - c->v0) / c->dv);
        if (out < least) least = out, best = i;
    }
    return best;
}

size_t patch_of(const scene_geometry *g, uint32_t face, double *u, double *v)
{
    if (!g->charts) return face;
    const chart c = g->charts[chart_of(g, face, *u, *v)];
    size_t best = c.first;
    double least = INFINITY, at[2] = {0, 0};
    for (size_t i = c.first; i < c.first + c.count; ++i) {
        const double *m = g->places[i], det = m[0] * m[3] - m[1] * m[2], x = *u - m[4], y = *v - m[5];
        const double s = (m[3] * x - m[2] * y) / det, t = (m[0] * y - m[1] * x) / det;
        const double out = outside(c.kind, s, t);
        if (out < least) least = out, best = i, at[0] = s, at[1] = t;
    }
    *u = at[0], *v = at[1];
    return best;
}

size_t scene_originals(const scene *s)
{
    size_t n = 0;
    while (n < s->geometry_count && !s->geometries[n].original) ++n;
    return n;
}

void geometry_free(scene_geometry *g)
{
    free(g->points);
    if (g->original) return;
    for (size_t i = 0; i < g->patch_count; ++i) epReleaseRegion(g->patches[i].trim);
    for (size_t i = 0; i < g->shape_count; ++i) shape_free(g->shapes[i]);
    free(g->shapes);
    free(g->patches);
    free(g->places);
    free(g->charts);
    cage_free(g->cage);
    free(g->name);
}

void scene_free(scene *s)
{
    if (!s) return;
    for (size_t i = 0; i < s->geometry_count; ++i) geometry_free(&s->geometries[i]);
    for (size_t i = 0; i < s->object_count; ++i) free(s->objects[i].material);
    free(s->geometries);
    free(s->objects);
    free(s->path);
    free(s);
}
