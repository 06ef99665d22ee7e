/* geometry.c - the public object: what embree_patch.h promises about patches, settings and evaluation.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/geometry.h"
#include "embree_patch/refit.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

EPGeometry epNewGeometry(void)
{
    EPGeometry g = ep_alloc(1, sizeof *g);
    if (!g) return NULL;
    memset(g, 0, sizeof *g);
    atomic_init(&g->references, 1);
    g->settings = epDefaultBuildSettings();
    g->kernels = ep_find_kernels(NULL);
    return g;
}

void epRetainGeometry(EPGeometry g)
{
    if (g) atomic_fetch_add(&g->references, 1);
}

void epReleaseGeometry(EPGeometry g)
{
    if (!g || atomic_fetch_sub(&g->references, 1) != 1) return;
    ep_demand_free(g);
    ep_hierarchy_free(&g->hierarchy);
    ep_added_free(g);
    ep_free(g);
}

const char *epGetGeometryMessage(EPGeometry g)
{
    return g->message.text;
}

EPStatus epSetGeometryBuildSettings(EPGeometry g, const EPBuildSettings *settings)
{
    EPBuildSettings s = epDefaultBuildSettings();
    if (!settings || settings->size < offsetof(EPBuildSettings, isa))
        return ep_fail(&g->message, EP_INVALID, "build settings did not start from epDefaultBuildSettings()");
    memcpy(&s, settings, settings->size < sizeof s ? settings->size : sizeof s);
    s.size = sizeof s;
    if (!(s.thickness > 0 && s.thickness <= 1))
        return ep_fail(&g->message, EP_INVALID, "a thickness of %g is not in (0, 1]", s.thickness);
    if (s.maxDepth > 40) return ep_fail(&g->message, EP_INVALID, "a depth of %u is not in 0..40", s.maxDepth);
    if (!(s.rayDistance >= 0 && s.rayDistance < INFINITY))
        return ep_fail(&g->message, EP_INVALID, "a ray distance of %g is not finite and positive", s.rayDistance);
    if ((unsigned)s.trimSplit > EP_TRIM_SPLIT_NONE)
        return ep_fail(&g->message, EP_INVALID, "%d is no way to split trimmed parts", (int)s.trimSplit);
    const ep_kernels *kernels = ep_find_kernels(s.isa);
    if (!kernels)
        return ep_fail(&g->message, EP_UNSUPPORTED, "this machine has no instruction set '%s' that we know", s.isa);
    s.isa = kernels->isa;
    g->settings = s;
    g->kernels = kernels;
    g->committed = false;
    return EP_OK;
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int by_address(const void *a, const void *b)
{
    const uintptr_t x = (uintptr_t) * (const EPRegion *)a, y = (uintptr_t) * (const EPRegion *)b;
    return (x > y) - (x < y);
}

/* Of the regions, each counted once; sorts them. */
static size_t bytes_of_regions(EPRegion *regions, size_t count)
{
    size_t bytes = 0;
    qsort(regions, count, sizeof *regions, by_address);
    for (size_t i = 0; i < count; ++i)
        if (regions[i] && (!i || regions[i] != regions[i - 1])) bytes += ep_region_object_bytes(regions[i]);
    return bytes;
}

/* What was added, for the build to measure and cut; NULL: no memory. */
static ep_patch *new_patches(EPGeometry g)
{
    ep_patch *patches = ep_alloc(g->added_count, sizeof *patches);
    for (size_t i = 0; patches && i < g->added_count; ++i) {
        const ep_added *a = &g->added[i];
        patches[i] = (ep_patch){.points = g->points + a->first,
                                .kind = a->kind,
                                .degree_u = a->degree_u,
                                .degree_v = a->degree_v,
                                .rational = a->rational};
    }
    return patches;
}

/* A face's patches share the largest of their errors. */
static void share_errors(EPGeometry g)
{
    ep_patch *patches = g->hierarchy.patches;
    for (size_t face = 0; ep_faces_exist(&g->faces) && face < g->faces.count; ++face) {
        double error = 0;
        size_t first, end;
        ep_faces_patches(&g->faces, (uint32_t)face, &first, &end);
        for (size_t i = first; i < end; ++i) error = fmax(error, patches[i].error);
        for (size_t i = first; i < end; ++i) patches[i].error = error;
    }
}

EPStatus epCommitGeometry(EPGeometry g)
{
    const double start = seconds();
    if (!ep_added_shrink(g)) return ep_fail(&g->message, EP_NO_MEMORY, "no memory for %zu patches", g->added_count);
    ep_patch *patches = new_patches(g);
    const ep_trim **trims = ep_alloc(g->added_count, sizeof *trims);
    EPRegion *regions = ep_alloc(g->added_count, sizeof *regions);
    if (!patches || !trims || !regions) {
        ep_free(regions);
        ep_free(patches);
        ep_free(trims);
        return ep_fail(&g->message, EP_NO_MEMORY, "no memory for %zu patches", g->added_count);
    }
    size_t trim_bytes = 0;
    for (size_t i = 0; i < g->added_count; ++i) {
        regions[i] = g->added[i].region;
        trims[i] = ep_added_trim(&g->added[i]);
        trim_bytes += g->added[i].trim ? ep_trim_bytes(g->added[i].trim) : 0;
    }
    const size_t region_bytes = bytes_of_regions(regions, g->added_count) + trim_bytes;
    ep_free(regions);
    ep_hierarchy h;
    const bool on_demand = g->settings.onDemand;
    const EPStatus status =
        (on_demand ? ep_build_boxes : ep_build)(patches, trims, g->added_count, &g->settings, &g->message, &h);
    if (status != EP_OK) {
        ep_free(patches);
        ep_free(trims);
        return status;
    }
    ep_demand_free(g);
    ep_hierarchy_free(&g->hierarchy);
    g->hierarchy = h;
    g->on_demand = on_demand;
    g->region_bytes = region_bytes;
    share_errors(g);
    g->committed = true;
    g->moved = false;
    g->build_seconds = seconds() - start;
    return EP_OK;
}

static EPStatus refit_leaves(EPGeometry g, ep_patch *patches)
{
    return ep_refit(&g->hierarchy, patches, &g->settings, &g->message);
}

/* What was built before is no more: it is built again when it is met. */
static EPStatus refit_boxes(EPGeometry g, ep_patch *patches)
{
    ep_hierarchy h;
    const EPStatus status =
        ep_build_boxes(patches, g->hierarchy.trims, g->hierarchy.patch_count, &g->settings, &g->message, &h);
    if (status != EP_OK) return status;
    ep_demand_clear(g);
    g->hierarchy.trims = NULL;
    ep_hierarchy_free(&g->hierarchy);
    g->hierarchy = h;
    return EP_OK;
}

EPStatus epRefitGeometry(EPGeometry g)
{
    const double start = seconds();
    if (!g->committed) return ep_fail(&g->message, EP_INVALID, "epRefitGeometry before epCommitGeometry");
    ep_patch *patches = new_patches(g);
    if (!patches) return ep_fail(&g->message, EP_NO_MEMORY, "no memory for %zu patches", g->added_count);
    const EPStatus status = (g->on_demand ? refit_boxes : refit_leaves)(g, patches);
    if (status != EP_OK) {
        ep_free(patches);
        return status;
    }
    share_errors(g);
    g->moved = false;
    g->build_seconds = seconds() - start;
    return EP_OK;
}

static void store(double out[3], ep_vec3 v)
{
    if (!out) return;
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

/* With patches? */
static bool is_face(EPGeometry g, uint32_t face)
{
    if (face >= ep_face_count(g)) return false;
    size_t first, end;
    ep_faces_patches(&g->faces, face, &first, &end);
    return first < end;
}

static ep_frame evaluate(EPGeometry g, size_t patch, double s, double t)
{
    const ep_added *a = &g->added[patch];
    ep_jet jet;
    ep_kinds[a->kind].eval(g->points + a->first, a->degree_u, a->degree_v, s, t, &jet);
    return ep_project(&jet);
}

/* The patch whose part of the plane (u, v) is in or, in units of the patch, the least outside of. */
static size_t nearest_patch(EPGeometry g, uint32_t face, double u, double v)
{
    size_t best = ep_faces_at(&g->faces, face, u, v);
    if (best != SIZE_MAX) return best;
    size_t i, end;
    double least = INFINITY;
    for (ep_faces_patches(&g->faces, face, &i, &end); i < end && least > 0; ++i) {
        double s, t;
        ep_place_inverse(&g->faces.places[i], u, v, &s, &t);
        const double far = g->added[i].kind == EP_KIND_TRIANGLE ? s + t : fmax(s, t);
        const double out = fmax(fmax(fmax(-s, -t), far - 1), 0);
        if (out < least) least = out, best = i;
    }
    return best;
}

static ep_frame evaluate_face(EPGeometry g, uint32_t face, double u, double v)
{
    const size_t i = nearest_patch(g, face, u, v);
    double s, t;
    ep_place_inverse(&g->faces.places[i], u, v, &s, &t);
    ep_frame f = evaluate(g, i, s, t);
    ep_place_derivatives(&g->faces.places[i], &f);
    return f;
}

EPStatus epEvaluate(EPGeometry g, uint32_t primID, double u, double v, double P[3], double dPdu[3], double dPdv[3],
                    double d2[9])
{
    if (!is_face(g, primID)) return EP_INVALID;
    const ep_frame f = ep_faces_exist(&g->faces) ? evaluate_face(g, primID, u, v) : evaluate(g, primID, u, v);
    store(P, f.p);
    store(dPdu, f.pu);
    store(dPdv, f.pv);
    if (d2) {
        store(d2, f.puu);
        store(d2 + 3, f.puv);
        store(d2 + 6, f.pvv);
    }
    return EP_OK;
}

/* A hit's point is off by the leaf's rounding, the ray's position error and the rounding of t. A ray that is nearly
 * tangent has its root displaced along the surface, but the bound is on the distance to the surface, which is not
 * amplified. */
float epGetHitError(EPGeometry g, uint32_t primID, const float org[3], const float dir[3], float t)
{
    if (!g->committed || !is_face(g, primID)) return 0;
    size_t first, end;
    ep_faces_patches(&g->faces, primID, &first, &end);
    double error = g->hierarchy.patches[first].error;
    for (size_t i = first; g->on_demand && i < end; ++i) error = fmax(error, ep_demand_error(g, (uint32_t)i));
    for (int c = 0; c < 3; ++c) error += 4 * EP_EPS_F * (fabs(org[c]) + fabs((double)t * dir[c]));
    return ep_round_up(2 * error);
}

void epGetGeometryBounds(EPGeometry g, float bounds[6])
{
    memcpy(bounds, g->hierarchy.bounds, 6 * sizeof(float));
}

void epGetGeometryStatistics(EPGeometry g, EPStatistics *s)
{
    const ep_hierarchy *h = &g->hierarchy;
    *s = (EPStatistics){
        .faces = ep_face_count(g),
        .patches = g->added_count,
        .leaves = h->leaf_count,
        .uncertified = h->uncertified,
        .averageDepth = h->average_depth,
        .maximumDepth = h->maximum_depth,
        .averageThickness = h->average_thickness,
        .bytes = sizeof *g + g->added_capacity * sizeof *g->added + g->point_capacity * sizeof *g->points +
                 ep_faces_bytes(&g->faces) + ep_hierarchy_bytes(h) + g->region_bytes,
        .buildSeconds = g->build_seconds,
        .isa = g->kernels->isa,
    };
    ep_demand_statistics(g, s);
}
