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
#include <stdalign.h>
#include <stdlib.h>
#include <string.h>

struct bench_limit {
    RTCDevice device;
    RTCScene rtc;
    RTCScene *instanced; /* one a geometry, NULL when nothing instances it */
    size_t geometry_count;
};

enum { HIT_PRIM = 5, HIT_GEOM = 6, HIT_INST = 7 }; /* rows of an RTCHit<n>, after EP_HIT_V */

#ifdef __clang__
#pragma clang diagnostic ignored "-Wpass-failed" /* of `omp simd`: for one ray there is nothing to vectorize */
#endif

#define INLINE static inline __attribute__((always_inline))

/* A leaf as a piece of a plane: its frame, and what the prism cuts out of it. Only the next function knows what a leaf
 * holds. */
typedef struct plane {
    const float *centre, (*frame)[3]; /* frame: columns for x, y, z, relative to the centre; rows s, t, h */
    float least, most, most_sum;      /* of s and t, of s + t */
    unsigned patch;
} plane;

INLINE plane plane_of(const ep_hierarchy *h, unsigned leaf)
{
    const ep_leaf *l = &h->leaves[leaf];
    if (h->patches[l->patch].kind == EP_KIND_TRIANGLE) /* about the centroid */
        return (plane){l->centre, l->frame, -l->rim, INFINITY, 2 * l->rim - 1.0f / 3, l->patch};
    return (plane){l->centre, l->frame, -l->rim, l->rim, INFINITY, l->patch};
}

/* Where the rays of a packet meet the plane. */
typedef struct crossings {
    alignas(64) float t[EP_PACKET], s[EP_PACKET], r[EP_PACKET];
    alignas(64) int on[EP_PACKET]; /* inside the piece, and nearer than what the ray has */
} crossings;

/* n is a constant in every caller, so that the loop becomes straight vector code. Returns whether any ray is on. */
INLINE bool cross(const plane *q, const int *valid, const float *ray, unsigned n, crossings *c)
{
    const float(*f)[3] = q->frame;
    int any = 0;
#pragma omp simd reduction(| : any)
    for (unsigned i = 0; i < n; ++i) {
        const float x = ray[i] - q->centre[0], y = ray[n + i] - q->centre[1], z = ray[2 * n + i] - q->centre[2];
        const float *d = ray + EP_RAY_DIR * n + i;
        const float h = f[0][2] * x + f[1][2] * y + f[2][2] * z;
        const float t = -h / (f[0][2] * d[0] + f[1][2] * d[n] + f[2][2] * d[2 * n]);
        const float px = x + t * d[0], py = y + t * d[n], pz = z + t * d[2 * n];
        const float s = f[0][0] * px + f[1][0] * py + f[2][0] * pz;
        const float r = f[0][1] * px + f[1][1] * py + f[2][1] * pz;
        const int on = (t > ray[EP_RAY_TNEAR * n + i]) & (t < ray[EP_RAY_TFAR * n + i]) & (s >= q->least) &
                       (s <= q->most) & (r >= q->least) & (r <= q->most) & (s + r <= q->most_sum) & (valid[i] != 0);
        c->t[i] = t, c->s[i] = s, c->r[i] = r, c->on[i] = on;
        any |= on;
    }
    return any;
}

/* The smaller loops that follow are vector code, too: a blend each. */
INLINE void set(float *row, unsigned n, const crossings *c, const float *values)
{
#pragma omp simd
    for (unsigned i = 0; i < n; ++i) row[i] = c->on[i] ? values[i] : row[i];
}

INLINE void set_all(float *row, unsigned n, const crossings *c, float value)
{
#pragma omp simd
    for (unsigned i = 0; i < n; ++i) row[i] = c->on[i] ? value : row[i];
}

INLINE void set_id(float *row, unsigned n, const crossings *c, unsigned value)
{
    float bits;
    memcpy(&bits, &value, sizeof bits);
    set_all(row, n, c, bits);
}

INLINE void meet(const plane *q, int *valid, float *ray, unsigned n, bool occlusion, unsigned geom,
                 const ep_rtc_context *context)
{
    crossings c;
    const bool any = cross(q, valid, ray, n, &c);
    for (unsigned i = 0; i < n; ++i)
        if (valid[i]) ep_rtc_report(valid, i, c.on[i]);
    if (!any) return;
    if (occlusion) {
        set_all(ray + EP_RAY_TFAR * n, n, &c, -INFINITY);
        return;
    }
    float *const hit = ray + EP_RAY_FIELDS * n;
    set(ray + EP_RAY_TFAR * n, n, &c, c.t);
    for (unsigned k = 0; k < 3; ++k) set_all(hit + (EP_HIT_NG + k) * n, n, &c, q->frame[k][2]);
    set(hit + EP_HIT_U * n, n, &c, c.s);
    set(hit + EP_HIT_V * n, n, &c, c.r);
    set_id(hit + HIT_PRIM * n, n, &c, q->patch);
    set_id(hit + HIT_GEOM * n, n, &c, geom);
    for (unsigned l = 0; l < RTC_MAX_INSTANCE_LEVEL_COUNT; ++l)
        set_id(hit + (HIT_INST + l) * n, n, &c, context->instID[l]);
}

INLINE void meet_any(void *user, unsigned leaf, int *valid, void *rays, unsigned n, bool occlusion, unsigned geom,
                     const ep_rtc_context *context)
{
    const plane q = plane_of(&((EPGeometry)user)->hierarchy, leaf);
    switch (n) {
    case 1: meet(&q, valid, rays, 1, occlusion, geom, context); break;
    case 4: meet(&q, valid, rays, 4, occlusion, geom, context); break;
    case 8: meet(&q, valid, rays, 8, occlusion, geom, context); break;
    default: meet(&q, valid, rays, 16, occlusion, geom, context); break;
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
