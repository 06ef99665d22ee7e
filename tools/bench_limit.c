/* bench_limit.c - how fast the patches could be if their kernel cost next to nothing.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The same leaves and boxes, so the same hierarchy in Embree, and callbacks that take the leaf for its plane: a ray
 * hits where it meets the plane h = 0 of the leaf's frame (embree_patch/leaf.h) inside the leaf's prism. That is the
 * least that any callback over this hierarchy has to do, so the difference to the patches is what their kernels cost
 * and the difference to triangles is what user geometry costs. Reads the library's own structures; nothing else in
 * tools/ does. */
#include "tools/bench.h"
#include "tools/report.h"

#include "embree_patch/geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct bench_limit {
    RTCDevice device;
    RTCScene rtc;
    RTCScene *instanced; /* one a geometry, NULL when nothing instances it */
    size_t geometry_count;
};

enum { HIT_PRIM = 5, HIT_GEOM = 6, HIT_INST = 7 };

#define INLINE static inline __attribute__((always_inline))

/* n is a constant in every caller: the loop becomes straight vector code. */
INLINE void meet(const ep_leaf *leaf, const ep_patch *patch, const int *valid, float *rayhit, unsigned n,
                 bool occlusion, unsigned geom, unsigned instance)
{
    float *const ray = rayhit, *const hit = rayhit + EP_RAY_FIELDS * n;
    unsigned *const id = (unsigned *)hit;
    const float *c = patch->centre;
    const bool triangle = patch->kind == EP_KIND_TRIANGLE;
    const float over_s = leaf->side_s, over_t = leaf->side_t, corner = 1 + over_s + over_t;

#pragma omp simd
    for (unsigned i = 0; i < n; ++i) {
        float o[3], d[3];
        for (unsigned r = 0; r < 3; ++r) {
            const float x = ray[i] - c[0], y = ray[n + i] - c[1], z = ray[2 * n + i] - c[2];
            const unsigned dir = EP_RAY_DIR * n + i;
            o[r] = leaf->frame[0][r] * x + leaf->frame[1][r] * y + leaf->frame[2][r] * z + leaf->frame[3][r];
            d[r] =
                leaf->frame[0][r] * ray[dir] + leaf->frame[1][r] * ray[dir + n] + leaf->frame[2][r] * ray[dir + 2 * n];
        }
        const float t = -o[2] / d[2], s = o[0] + t * d[0], r = o[1] + t * d[1];
        const float tfar = ray[EP_RAY_TFAR * n + i];
        const bool far_side = triangle ? s + r <= corner : (s <= 1 + over_s) & (r <= 1 + over_t);
        const bool on =
            (valid[i] != 0) & (t > ray[EP_RAY_TNEAR * n + i]) & (t < tfar) & (s >= -over_s) & (r >= -over_t) & far_side;
        if (occlusion) {
            ray[EP_RAY_TFAR * n + i] = on ? -INFINITY : tfar;
        } else {
            ray[EP_RAY_TFAR * n + i] = on ? t : tfar;
            for (unsigned k = 0; k < 3; ++k) hit[k * n + i] = on ? leaf->frame[k][2] : hit[k * n + i];
            hit[EP_HIT_U * n + i] = on ? s : hit[EP_HIT_U * n + i];
            hit[EP_HIT_V * n + i] = on ? r : hit[EP_HIT_V * n + i];
            id[HIT_PRIM * n + i] = on ? leaf->patch : id[HIT_PRIM * n + i];
            id[HIT_GEOM * n + i] = on ? geom : id[HIT_GEOM * n + i];
            id[HIT_INST * n + i] = on ? instance : id[HIT_INST * n + i];
        }
    }
}

INLINE void meet_any(void *user, unsigned primID, const int *valid, void *rays, unsigned n, bool occlusion,
                     unsigned geom, const ep_rtc_context *context)
{
    const ep_hierarchy *h = &((EPGeometry)user)->hierarchy;
    const ep_leaf *leaf = &h->leaves[primID];
    const ep_patch *patch = &h->patches[leaf->patch];
    const unsigned instance = context->instID[0];
    switch (n) {
    case 1: meet(leaf, patch, valid, rays, 1, occlusion, geom, instance); break;
    case 4: meet(leaf, patch, valid, rays, 4, occlusion, geom, instance); break;
    case 8: meet(leaf, patch, valid, rays, 8, occlusion, geom, instance); break;
    default: meet(leaf, patch, valid, rays, 16, occlusion, geom, instance); break;
    }
}

/* The pair of callbacks for one instruction set. */
#define CALLBACKS(isa, target)                                                                                         \
    target static void intersect_##isa(const struct RTCIntersectFunctionNArguments *a)                                 \
    {                                                                                                                  \
        meet_any(a->geometryUserPtr, a->primID, a->valid, a->rayhit, a->N, false, a->geomID, a->context);              \
    }                                                                                                                  \
    target static void occluded_##isa(const struct RTCOccludedFunctionNArguments *a)                                   \
    {                                                                                                                  \
        meet_any(a->geometryUserPtr, a->primID, a->valid, a->ray, a->N, true, a->geomID, a->context);                  \
    }

CALLBACKS(plain, )
#ifdef __x86_64__
CALLBACKS(avx2, __attribute__((target("avx2,fma"))))
CALLBACKS(avx512, __attribute__((target("avx2,fma,avx512f,avx512vl,avx512dq"))))
#endif

static void set_callbacks(RTCGeometry g, const char *isa)
{
    rtcSetGeometryIntersectFunction(g, intersect_plain);
    rtcSetGeometryOccludedFunction(g, occluded_plain);
#ifdef __x86_64__
    if (!strcmp(isa, "avx512")) {
        rtcSetGeometryIntersectFunction(g, intersect_avx512);
        rtcSetGeometryOccludedFunction(g, occluded_avx512);
    } else if (!strcmp(isa, "avx2")) {
        rtcSetGeometryIntersectFunction(g, intersect_avx2);
        rtcSetGeometryOccludedFunction(g, occluded_avx2);
    }
#else
    (void)isa;
#endif
}

static RTCScene new_scene(RTCDevice device)
{
    RTCScene s = rtcNewScene(device);
    if (s) rtcSetSceneBuildQuality(s, RTC_BUILD_QUALITY_HIGH); /* as world.c does for patches */
    return s;
}

static RTCGeometry new_leaves(const bench_limit *l, EPGeometry e)
{
    RTCGeometry g = epNewRTCGeometry(e, l->device);
    if (!g) return NULL;
    set_callbacks(g, e->kernels->isa);
    rtcCommitGeometry(g);
    return g;
}

/* The scene that the instances of geometry k show. */
static RTCScene instanced_scene(const bench_limit *l, const world *w, size_t k)
{
    RTCScene *s = &l->instanced[k];
    if (*s) return *s;
    RTCGeometry g = new_leaves(l, w->geometries[k]);
    *s = g ? new_scene(l->device) : NULL;
    if (*s) {
        rtcAttachGeometryByID(*s, g, 0);
        rtcCommitScene(*s);
    }
    if (g) rtcReleaseGeometry(g);
    return *s;
}

static RTCGeometry new_instance(const bench_limit *l, const world *w, const scene_object *o)
{
    RTCScene s = instanced_scene(l, w, o->geometry);
    RTCGeometry g = s ? rtcNewGeometry(l->device, RTC_GEOMETRY_TYPE_INSTANCE) : NULL;
    if (!g) return NULL;
    float m[12];
    for (int i = 0; i < 12; ++i) m[i] = (float)o->transform[i];
    rtcSetGeometryInstancedScene(g, s);
    rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
    rtcCommitGeometry(g);
    return g;
}

/* The objects stand as in world.c. */
static bool attach_objects(const bench_limit *l, const world *w)
{
    const scene *s = w->scene;
    for (size_t i = 0; i < s->object_count; ++i) {
        const scene_object *o = &s->objects[i];
        if (!s->geometries[o->geometry].patch_count) continue;
        RTCGeometry g = o->identity ? new_leaves(l, w->geometries[o->geometry]) : new_instance(l, w, o);
        if (!g) return false;
        rtcAttachGeometryByID(l->rtc, g, (unsigned)i);
        rtcReleaseGeometry(g);
    }
    rtcCommitScene(l->rtc);
    return rtcGetDeviceError(l->device) == RTC_ERROR_NONE;
}

static bool fill(bench_limit *l, const world *w)
{
    l->geometry_count = w->scene->geometry_count;
    l->instanced = calloc(l->geometry_count + 1, sizeof *l->instanced);
    l->device = l->instanced ? rtcNewDevice(NULL) : NULL;
    l->rtc = l->device ? new_scene(l->device) : NULL;
    return l->rtc && attach_objects(l, w);
}

bench_limit *bench_limit_new(const world *patches)
{
    bench_limit *l = calloc(1, sizeof *l);
    if (l && fill(l, patches)) return l;
    report_no_memory(patches->scene->path);
    bench_limit_free(l);
    return NULL;
}

RTCScene bench_limit_scene(const bench_limit *l)
{
    return l->rtc;
}

void bench_limit_free(bench_limit *l)
{
    if (!l) return;
    if (l->rtc) rtcReleaseScene(l->rtc);
    for (size_t i = 0; l->instanced && i < l->geometry_count; ++i)
        if (l->instanced[i]) rtcReleaseScene(l->instanced[i]);
    if (l->device) rtcReleaseDevice(l->device);
    free(l->instanced);
    free(l);
}
