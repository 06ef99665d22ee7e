/* world.c - from a scene to a committed RTCScene, and from Embree's hits to those of the scene.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Object k has the id k in the top-level scene: as the geometry itself when it is not transformed (any more, see
 * scene_place.h), else as an instance of a scene that all transformed objects of that geometry share. */
#include "tools/world.h"
#include "tools/progress.h"
#include "tools/report.h"
#include "tools/tessellate.h"

#include <float.h>
#include <math.h>
#include <omp.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>

struct world_private {
    tessellation *tessellations; /* one a geometry, empty for exact patches */
    RTCScene *instanced;         /* one a geometry, NULL when nothing instances it */
    enum RTCBuildQuality quality;
    atomic_llong embree_bytes;
    char embree_error[200]; /* the first one */
};

static bool on_memory(void *user, ssize_t bytes, bool post)
{
    (void)post;
    atomic_fetch_add(&((struct world_private *)user)->embree_bytes, bytes);
    return true;
}

static void on_error(void *user, enum RTCError code, const char *message)
{
    struct world_private *p = user;
    if (p->embree_error[0]) return;
    const char *text = message && *message ? message : code == RTC_ERROR_OUT_OF_MEMORY ? "out of memory" : "error";
    strncpy(p->embree_error, text, sizeof p->embree_error - 1);
}

static bool embree_failed(const world *w)
{
    if (!w->p->embree_error[0]) return false;
    report_file(w->scene->path, "Embree: %s", w->p->embree_error);
    return true;
}

static bool allocate(world *w)
{
    size_t n = w->scene->geometry_count + 1; /* calloc(0) may return NULL */
    w->geometries = calloc(n, sizeof *w->geometries);
    w->p = calloc(1, sizeof *w->p);
    if (!w->geometries || !w->p) return false;
    w->p->tessellations = calloc(n, sizeof *w->p->tessellations);
    w->p->instanced = calloc(n, sizeof *w->p->instanced);
    return w->p->tessellations && w->p->instanced;
}

static bool open_device(world *w, unsigned threads)
{
    char config[40];
    snprintf(config, sizeof config, "threads=%u", threads);
    w->device = rtcNewDevice(config);
    if (!w->device) {
        enum RTCError code = rtcGetDeviceError(NULL);
        if (code == RTC_ERROR_OUT_OF_MEMORY) report_no_memory(w->scene->path);
        else report_file(w->scene->path, "Embree makes no device (error %d)", (int)code);
        return false;
    }
    rtcSetDeviceErrorFunction(w->device, on_error, w->p);
    rtcSetDeviceMemoryMonitorFunction(w->device, on_memory, w->p);
    return true;
}

/* How far from the geometry, in its own space, a ray may start that starts at most `far` from the world's origin. */
static double local_distance(const scene_object *o, double far)
{
    const double *m = o->transform;
    double cofactors = 0, det = 0, shift = 0;
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        for (int x = 0; x < 3; ++x) {
            int y = (x + 1) % 3, z = (x + 2) % 3;
            double c = m[3 * j + y] * m[3 * k + z] - m[3 * j + z] * m[3 * k + y];
            cofactors += c * c;
            if (i == 0) det += m[x] * c;
        }
        shift += m[9 + i] * m[9 + i];
    }
    /* Frobenius' norm of the inverse: at least the reciprocal of the smallest scale, at most sqrt(3) times it. */
    return (far + sqrt(shift)) * sqrt(cofactors) / fabs(det);
}

static double ray_distance(const scene *s, size_t geometry, double far)
{
    const scene_geometry *g = &s->geometries[geometry];
    double most = 0, radius2 = 0;
    if (far <= 0) return 0;
    for (size_t i = 0; i < s->object_count; ++i)
        if (s->objects[i].geometry == geometry) most = fmax(most, local_distance(&s->objects[i], far));
    for (size_t i = 0; i < g->point_count; ++i) {
        const double *p = g->points + 4 * i;
        radius2 = fmax(radius2, p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    }
    return most + sqrt(radius2);
}

static bool surface_failed(const world *w, size_t geometry, EPStatus status)
{
    if (status == EP_OK) return false;
    const char *name = w->scene->geometries[geometry].name;
    const char *message = w->geometries[geometry] ? epGetGeometryMessage(w->geometries[geometry]) : "out of memory";
    if (name) report_file(w->scene->path, "geometry '%s': %s", name, message);
    else report_file(w->scene->path, "geometry %zu: %s", geometry, message);
    return true;
}

static EPStatus add_run(EPGeometry e, const scene_geometry *g, size_t first, size_t count)
{
    const patch *p = &g->patches[first];
    const double *points = g->points + 4 * p->first;
    const size_t stride = 4 * sizeof(double);
    const EPFormat format = p->rational ? EP_FORMAT_DOUBLE4 : EP_FORMAT_DOUBLE3;
    return p->kind == PATCH_TRIANGLE ? epAddBezierTriangles(e, p->degree_u, count, format, points, stride)
                                     : epAddBezierPatches(e, p->degree_u, p->degree_v, count, format, points, stride);
}

/* Hands patches over in runs of the same kind and degree. */
static EPStatus add_patches(EPGeometry e, const scene_geometry *g, size_t first, size_t end)
{
    EPStatus status = EP_OK;
    for (size_t i = first, n; i < end && status == EP_OK; i += n) {
        const patch *p = &g->patches[i];
        for (n = 1; i + n < end; ++n) {
            const patch *q = p + n;
            if (q->kind != p->kind || q->degree_u != p->degree_u || q->degree_v != p->degree_v ||
                q->rational != p->rational)
                break;
        }
        status = add_run(e, g, i, n);
    }
    return status;
}

/* A face has all charts of its number; numbers without a chart are faces without patches. */
static EPStatus add_faces(EPGeometry e, const scene_geometry *g)
{
    EPStatus status = EP_OK;
    size_t patches = 0;
    for (size_t i = 0, face = 0; i < g->chart_count && status == EP_OK; ++face) {
        const size_t first = patches;
        for (; i < g->chart_count && g->charts[i].face == face; ++i) patches += g->charts[i].count;
        status = add_patches(e, g, first, patches);
        if (status == EP_OK)
            status = epJoinPatches(e, (uint32_t)first, patches - first, (const double(*)[6])(g->places + first));
    }
    return status;
}

static EPStatus add_surfaces(EPGeometry e, const scene_geometry *g)
{
    return g->charts ? add_faces(e, g) : add_patches(e, g, 0, g->patch_count);
}

static EPStatus trim_patches(EPGeometry e, const scene_geometry *g)
{
    EPStatus status = EP_OK;
    for (size_t i = 0; i < g->patch_count && status == EP_OK; ++i)
        if (g->patches[i].trim) status = epSetPatchTrim(e, (uint32_t)i, 1, g->patches[i].trim);
    return status;
}

static bool build_geometry(world *w, size_t i, const world_options *o, int threads)
{
    const scene_geometry *g = &w->scene->geometries[i];
    EPGeometry e = w->geometries[i] = epNewGeometry();
    if (surface_failed(w, i, e ? add_surfaces(e, g) : EP_NO_MEMORY)) return false;
    if (surface_failed(w, i, trim_patches(e, g))) return false;

    if (o->tessellation) {
        tessellation *t = &w->p->tessellations[i];
        return tessellate(w->scene->path, g, e, o->form, o->tessellation, threads, t);
    }
    EPBuildSettings settings = o->build;
    settings.threads = (unsigned)threads;
    settings.rayDistance = (float)fmin(ray_distance(w->scene, i, o->ray_distance), FLT_MAX);
    if (surface_failed(w, i, epSetGeometryBuildSettings(e, &settings))) return false;
    return !surface_failed(w, i, epCommitGeometry(e));
}

/* A committed RTCGeometry; NULL after a message. */
static RTCGeometry new_geometry(world *w, size_t i)
{
    const tessellation *t = &w->p->tessellations[i];
    RTCGeometry g = t->n ? tessellation_geometry(t, &w->scene->geometries[i], w->device)
                         : epNewRTCGeometry(w->geometries[i], w->device);
    if (!g) {
        if (!embree_failed(w)) surface_failed(w, i, EP_FOREIGN);
        return NULL;
    }
    if (t->n) rtcCommitGeometry(g);
    return g;
}

static RTCScene new_scene(world *w)
{
    RTCScene s = rtcNewScene(w->device);
    if (s) rtcSetSceneBuildQuality(s, w->p->quality);
    else if (!embree_failed(w)) report_no_memory(w->scene->path);
    return s;
}

/* The scene that the instances of geometry i show. */
static RTCScene instanced_scene(world *w, size_t i)
{
    RTCScene *s = &w->p->instanced[i];
    if (*s) return *s;
    RTCGeometry g = new_geometry(w, i);
    if (!g) return NULL;
    *s = new_scene(w);
    if (*s) {
        rtcAttachGeometryByID(*s, g, 0);
        rtcCommitScene(*s);
    }
    rtcReleaseGeometry(g);
    return *s;
}

static RTCGeometry new_instance(world *w, const scene_object *o)
{
    RTCScene s = instanced_scene(w, o->geometry);
    if (!s) return NULL;
    w->instances = true;
    RTCGeometry g = rtcNewGeometry(w->device, RTC_GEOMETRY_TYPE_INSTANCE);
    if (!g) {
        if (!embree_failed(w)) report_no_memory(w->scene->path);
        return NULL;
    }
    float m[12];
    for (int i = 0; i < 12; ++i) m[i] = (float)o->transform[i];
    rtcSetGeometryInstancedScene(g, s);
    rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
    rtcCommitGeometry(g);
    return g;
}

/* Enlarges the world by a geometry's box, corner by corner. False when that is beyond what Embree can hold. */
static bool extend_bounds(world *w, const scene_object *o)
{
    const tessellation *t = &w->p->tessellations[o->geometry];
    float b[6] = {FLT_MAX, FLT_MAX, FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX};
    if (t->n && t->form == WORLD_SUBDIVISION) {
        const scene_geometry *g = &w->scene->geometries[o->geometry];
        for (size_t i = 0; i < 4 * g->point_count; ++i) {
            if (i % 4 == 3) continue;
            b[i % 4] = fminf(b[i % 4], (float)g->points[i]);
            b[3 + i % 4] = fmaxf(b[3 + i % 4], (float)g->points[i]);
        }
    } else if (t->n) {
        for (size_t i = 0; i < 3 * t->vertex_count; ++i) {
            b[i % 3] = fminf(b[i % 3], t->vertices[i]);
            b[3 + i % 3] = fmaxf(b[3 + i % 3], t->vertices[i]);
        }
    } else {
        epGetGeometryBounds(w->geometries[o->geometry], b);
    }
    if (b[0] > b[3]) return true; /* trimmed away */
    for (int corner = 0; corner < 8; ++corner)
        for (int x = 0; x < 3; ++x) {
            const double *m = o->transform;
            double at = m[9 + x];
            for (int axis = 0; axis < 3; ++axis) at += m[3 * axis + x] * b[corner >> axis & 1 ? 3 + axis : axis];
            if (!(fabs(at) < 1e18)) return false;
            w->bounds[x] = fminf(w->bounds[x], (float)at);
            w->bounds[3 + x] = fmaxf(w->bounds[3 + x], (float)at);
        }
    return true;
}

static bool attach_objects(world *w)
{
    const scene *s = w->scene;
    for (size_t i = 0; i < s->object_count; ++i) {
        const scene_object *o = &s->objects[i];
        if (!s->geometries[o->geometry].patch_count) continue;
        if (!extend_bounds(w, o)) {
            report_file(s->path, "object %zu reaches beyond 1e18", i);
            return false;
        }
        RTCGeometry g = o->identity ? new_geometry(w, o->geometry) : new_instance(w, o);
        if (!g) return false;
        rtcAttachGeometryByID(w->rtc, g, (unsigned)i);
        rtcReleaseGeometry(g);
    }
    return true;
}

static bool build(world *w, const world_options *o)
{
    if (!allocate(w)) return report_no_memory(w->scene->path), false;
    for (int x = 0; x < 3; ++x) w->bounds[x] = INFINITY, w->bounds[3 + x] = -INFINITY;

    /* On the even grids of a tessellation HIGH takes three times as long to build and traces no faster. */
    w->p->quality = o->tessellation ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_HIGH;
    int threads = o->threads ? (int)o->threads : omp_get_max_threads();
    if (!open_device(w, o->threads)) return false;
    w->rtc = new_scene(w);
    if (!w->rtc) return false;
    for (size_t i = 0; i < w->scene->geometry_count; ++i)
        if (!build_geometry(w, i, o, threads)) return false;
    if (!attach_objects(w)) return false;
    rtcCommitScene(w->rtc);
    return !embree_failed(w);
}

/* What was done when the scene was read, for all but what Embree subdivides itself. */
static double cage_seconds(const scene *s, const world_options *o)
{
    double seconds = 0;
    for (size_t i = 0; i < s->geometry_count; ++i)
        if (!s->geometries[i].original) seconds += s->geometries[i].cage_seconds;
    return o->tessellation && o->form == WORLD_SUBDIVISION ? 0 : seconds;
}

world *world_new(const scene *s, const world_options *o)
{
    double start = wall_seconds();
    world *w = calloc(1, sizeof *w);
    if (!w) {
        report_no_memory(s->path);
        return NULL;
    }
    w->scene = s;
    if (!build(w, o)) {
        world_free(w);
        return NULL;
    }
    w->build_seconds = wall_seconds() - start + cage_seconds(s, o);
    const world_size size = world_measure(w);
    w->bytes_patches = size.bytes_patches;
    w->bytes_embree = size.bytes_embree;
    w->leaves = size.leaves;
    return w;
}

world_size world_measure(const world *w)
{
    world_size size = {.bytes_embree = (size_t)atomic_load(&w->p->embree_bytes)};
    for (size_t i = 0; i < w->scene->geometry_count; ++i) {
        const tessellation *t = &w->p->tessellations[i];
        EPStatistics statistics;
        epGetGeometryStatistics(w->geometries[i], &statistics);
        size.leaves += statistics.leaves;
        size.bytes_patches += t->n ? t->bytes : statistics.bytes;
    }
    return size;
}

void world_free(world *w)
{
    if (!w) return;
    size_t count = w->scene->geometry_count;
    if (w->rtc) rtcReleaseScene(w->rtc);
    if (w->p && w->p->instanced)
        for (size_t i = 0; i < count; ++i)
            if (w->p->instanced[i]) rtcReleaseScene(w->p->instanced[i]);
    if (w->geometries)
        for (size_t i = 0; i < count; ++i) epReleaseGeometry(w->geometries[i]);
    if (w->device) rtcReleaseDevice(w->device);
    if (w->p) {
        if (w->p->tessellations)
            for (size_t i = 0; i < count; ++i) tessellation_free(&w->p->tessellations[i]);
        free(w->p->tessellations);
        free(w->p->instanced);
        free(w->p);
    }
    free(w->geometries);
    free(w);
}

/* The normal of a transformed surface is the cofactor matrix times that of the original: M a x M b = cof(M) (a x b). */
static void transform_normal(const double m[12], float n[3])
{
    const double old[3] = {n[0], n[1], n[2]};
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
        const double *b = m + 3 * ((i + 1) % 3), *c = m + 3 * ((i + 2) % 3);
        for (int x = 0; x < 3; ++x) {
            int y = (x + 1) % 3, z = (x + 2) % 3;
            sum[x] += old[i] * (b[y] * c[z] - b[z] * c[y]);
        }
    }
    for (int x = 0; x < 3; ++x) n[x] = (float)sum[x];
}

world_hit world_read_hit(const world *w, const void *rayhit, unsigned width, unsigned lane)
{
    /* Field f of lane k stands at [f * width + k]: 12 fields of the ray, of which tfar is 8, then Ng, u, v and the ids
     * of the hit. */
    const float *real = (const float *)rayhit + lane;
    const uint32_t *id = (const uint32_t *)rayhit + lane;
    uint32_t geomID = id[18 * width], instID = id[19 * width];
    if (geomID == RTC_INVALID_GEOMETRY_ID) return (world_hit){INFINITY, 0, 0, ~0u, ~0u, {0, 0, 0}};

    world_hit h = {
        .t = real[8 * width],
        .u = real[15 * width],
        .v = real[16 * width],
        .geomID = instID == RTC_INVALID_GEOMETRY_ID ? geomID : instID,
        .primID = id[17 * width],
        .Ng = {real[12 * width], real[13 * width], real[14 * width]},
    };
    const scene_object *o = &w->scene->objects[h.geomID];
    const tessellation *t = &w->p->tessellations[o->geometry];
    if (t->n) tessellation_hit(t, &w->scene->geometries[o->geometry], &h);
    if (!o->identity) transform_normal(o->transform, h.Ng);
    return h;
}
