/* cage_embree.c - see cage_embree.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Embree's buffers are filled in place, so that its memory monitor counts them. */
#include "tools/cage_embree.h"
#include "tools/cage.h"

#include <math.h>
#include <string.h>

static bool is_same_to_embree(const cage *c)
{
    return c->scheme == CAGE_CATMULL_CLARK && !c->chaikin && !c->smooth_triangles && !c->hole_count;
}

bool cage_embree_possible(const scene *s)
{
    bool all = s->geometry_count > 0;
    for (size_t i = 0; i < s->geometry_count; ++i) {
        const scene_geometry *g = &s->geometries[i];
        all = all && (!g->patch_count || (g->cage && is_same_to_embree(g->cage)));
    }
    return all;
}

static void *new_buffer(RTCGeometry g, enum RTCBufferType type, enum RTCFormat format, size_t stride, size_t count)
{
    return count ? rtcSetNewGeometryBuffer(g, type, 0, format, stride, count) : NULL;
}

static void copy_words(RTCGeometry g, enum RTCBufferType type, const uint32_t *from, size_t count)
{
    void *to = new_buffer(g, type, RTC_FORMAT_UINT, sizeof *from, count);
    if (to) memcpy(to, from, count * sizeof *from);
}

static void set_vertices(RTCGeometry to, const scene_geometry *g)
{
    const size_t count = g->cage->vertex_count;
    const double *from = g->points + 4 * g->cage_first;
    float *x = new_buffer(to, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * sizeof(float), count);
    for (size_t i = 0; x && i < count; ++i)
        for (size_t k = 0; k < 3; ++k) x[3 * i + k] = (float)from[4 * i + k];
}

static float sharpness_of(float s)
{
    return s < CAGE_SHARP ? s : INFINITY;
}

static void set_creases(RTCGeometry to, const cage *c)
{
    const size_t edges = c->crease_count, vertices = c->sharp_count;
    uint32_t *edge = new_buffer(to, RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, RTC_FORMAT_UINT2, 2 * sizeof(uint32_t), edges);
    float *edge_weight = new_buffer(to, RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, RTC_FORMAT_FLOAT, sizeof(float), edges);
    for (size_t i = 0; edge && edge_weight && i < edges; ++i) {
        memcpy(edge + 2 * i, c->creases[i].vertex, sizeof c->creases[i].vertex);
        edge_weight[i] = sharpness_of(c->creases[i].sharpness);
    }
    uint32_t *vertex = new_buffer(to, RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX, RTC_FORMAT_UINT, sizeof(uint32_t), vertices);
    float *vertex_weight =
        new_buffer(to, RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT, RTC_FORMAT_FLOAT, sizeof(float), vertices);
    for (size_t i = 0; vertex && vertex_weight && i < vertices; ++i) {
        vertex[i] = c->sharp[i].vertex;
        vertex_weight[i] = sharpness_of(c->sharp[i].sharpness);
    }
}

RTCGeometry cage_embree_geometry(const scene_geometry *g, RTCDevice device, unsigned rate)
{
    static const enum RTCSubdivisionMode modes[] = {
        [CAGE_EDGE_ONLY] = RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY,
        [CAGE_EDGE_AND_CORNER] = RTC_SUBDIVISION_MODE_PIN_CORNERS,
        [CAGE_NO_BOUNDARY] = RTC_SUBDIVISION_MODE_NO_BOUNDARY,
    };
    const cage *c = g->cage;
    RTCGeometry to = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
    if (!to) return NULL;
    set_vertices(to, g);
    copy_words(to, RTC_BUFFER_TYPE_FACE, c->sizes, c->face_count);
    copy_words(to, RTC_BUFFER_TYPE_INDEX, c->corners, c->corner_count);
    copy_words(to, RTC_BUFFER_TYPE_HOLE, c->holes, c->hole_count);
    set_creases(to, c);
    rtcSetGeometrySubdivisionMode(to, 0, modes[c->boundary]);
    rtcSetGeometryTessellationRate(to, (float)rate);
    return to;
}
