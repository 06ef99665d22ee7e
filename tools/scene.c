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
    bool (*read)(const char *path, scene_geometry *g);
} model_format;

static const model_format formats[] = {
    {".bpt", model_read_bpt}, {".obj", NULL}, {".step", NULL}, {".stp", NULL},
    {".iges", NULL},          {".igs", NULL}, {".brep", NULL},
};

static const char *extension(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
    return dot && dot != name ? dot : "";
}

bool model_read(const char *path, scene_geometry *g)
{
    const char *e = extension(path);
    for (size_t i = 0; i < ARG_COUNT(formats); ++i) {
        if (strcasecmp(e, formats[i].extension)) continue;
        if (formats[i].read) return formats[i].read(path, g);
        return report_file(path, "%s files are not supported yet", formats[i].extension), false;
    }
    struct stat st;
    if (stat(path, &st)) return report_file(path, "cannot open: %s", strerror(errno)), false;
    if (S_ISDIR(st.st_mode)) return report_file(path, "cannot read: %s", strerror(EISDIR)), false;
    return report_file(path, "'%s' is no kind of file that is known here; try .json or .bpt", e), false;
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

double *geometry_add_patch(scene_geometry *g, patch_kind kind, unsigned degree_u, unsigned degree_v)
{
    size_t n = patch_point_count(kind, degree_u, degree_v);
    patch *patches = grow(g->patches, sizeof *patches, g->patch_count, 1);
    if (!patches) return NULL;
    g->patches = patches;

    double *points = grow(g->points, 4 * sizeof *points, g->point_count, n);
    if (!points) return NULL;
    g->points = points;

    patches[g->patch_count++] = (patch){kind, degree_u, degree_v, g->point_count, false, NULL, NULL};
    g->point_count += n;
    return points + 4 * (g->point_count - n);
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
    return model_read(s->path, s->geometries);
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
    const char *e = extension(path);
    bool json = !*e || !strcasecmp(e, ".json");
    bool done = json ? scene_read_json(path, s) : read_model_scene(s);
    if (done && !s->objects) done = place_all(s);
    for (size_t i = 0; done && i < s->geometry_count; ++i) find_rational(&s->geometries[i]);
    if (done && scene_place(s)) return s;
    scene_free(s);
    return NULL;
}

size_t scene_originals(const scene *s)
{
    size_t n = 0;
    while (n < s->geometry_count && !s->geometries[n].original) ++n;
    return n;
}

static void geometry_free(scene_geometry *g)
{
    free(g->points);
    if (g->original) return;
    for (size_t i = 0; i < g->patch_count; ++i) epReleaseRegion(g->patches[i].trim);
    for (size_t i = 0; i < g->shape_count; ++i) shape_free(g->shapes[i]);
    free(g->shapes);
    free(g->patches);
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
