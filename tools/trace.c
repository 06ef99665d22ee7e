/* trace.c - rays in, answers out.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Rays go through in blocks: packed into Embree's layout, then traced in place against the clock, then unpacked. A
 * block is small enough to stay near the caches and large enough that starting the threads costs nothing. */
#include "tools/trace.h"
#include "tools/files.h"
#include "tools/progress.h"
#include "tools/report.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

static_assert(sizeof(trace_ray) == 32, "a record of a file of rays");
static_assert(sizeof(world_hit) == 32, "a record of a file of hits");
static_assert(sizeof(struct RTCRay) == 12 * 4 && offsetof(struct RTCRayHit16, hit.instID) == 19 * 16 * 4 &&
                  sizeof(struct RTCRayHit16) <= EP_RTC_RAYHIT_FIELDS * 16 * 4,
              "fields by number");

#define BLOCK_RAYS 131072 /* a multiple of every width */
#define PACKETS_A_TURN 64 /* that a thread takes at once */

enum { RAY_FIELDS = 12, RAYHIT_FIELDS = EP_RTC_RAYHIT_FIELDS };

/* Field f of lane k of a packet stands at [f * width + k]. */
enum { ORG = 0, TNEAR = 3, DIR = 4, TIME = 7, TFAR = 8, MASK = 9, ID = 10, FLAGS = 11, GEOM_ID = 18, INST_ID = 19 };

trace_ray *trace_read_rays(const char *path, size_t *count)
{
    size_t size;
    char *data = input_read(path, &size);
    if (!data) return NULL;
    *count = size / sizeof(trace_ray);
    if (size % sizeof(trace_ray)) {
        report_file(input_name(path), "ray %zu is cut off: %zu bytes are no multiple of %zu", *count, size,
                    sizeof(trace_ray));
        free(data);
        return NULL;
    }
    return (trace_ray *)data;
}

/* Embree takes no coordinates above 1.8e18, where there can be no geometry either, and takes a direction of 1e-18 for
 * one of 0: others should be longer by far. */
#define EMBREE_MOST 0x1p60f
#define EMBREE_EXPONENT 40

static float largest(const float x[3])
{
    return fmaxf(fmaxf(fabsf(x[0]), fabsf(x[1])), fabsf(x[2]));
}

/* Whether Embree may see the ray at all. Comparisons are false for NaN. */
static bool can_hit(const trace_ray *r)
{
    float sum = 0;
    for (int i = 0; i < 3; ++i) sum += 0 * r->org[i] + 0 * r->dir[i]; /* NaN unless all are finite */
    return sum == 0 && largest(r->org) < EMBREE_MOST && largest(r->dir) > 0 && r->tnear <= r->tfar && r->tfar >= 0;
}

/* Embree sees a direction that is too long or too short for it divided by this power of two, and t multiplied. */
static int exponent_of(const trace_ray *r)
{
    int e;
    frexpf(largest(r->dir), &e);
    return abs(e) > EMBREE_EXPONENT ? e : 0;
}

double trace_farthest_origin(const trace_ray *rays, size_t count)
{
    double most = 0;
    for (size_t i = 0; i < count; ++i) {
        const float *o = rays[i].org;
        double d2 = (double)o[0] * o[0] + (double)o[1] * o[1] + (double)o[2] * o[2];
        if (d2 > most && can_hit(&rays[i])) most = d2;
    }
    return sqrt(most);
}

unsigned trace_threads(unsigned threads)
{
    return threads ? threads : (unsigned)omp_get_max_threads();
}

/* Packs `count` rays, at most a packet; the lanes after them are off. */
static void pack(const trace_ray *rays, size_t count, unsigned width, bool occluded, void *packet, int *valid)
{
    static const trace_ray nothing = {{0, 0, 0}, 0, {0, 0, 1}, 0};
    for (unsigned k = 0; k < width; ++k) {
        bool on = k < count && can_hit(&rays[k]);
        const trace_ray *r = on ? &rays[k] : &nothing;
        const int e = exponent_of(r);
        float *real = (float *)packet + k;
        uint32_t *id = (uint32_t *)packet + k;
        for (unsigned x = 0; x < 3; ++x) {
            real[(ORG + x) * width] = r->org[x];
            real[(DIR + x) * width] = ldexpf(r->dir[x], -e);
        }
        real[TNEAR * width] = r->tnear > 0 ? ldexpf(r->tnear, e) : 0;
        real[TIME * width] = 0;
        real[TFAR * width] = e ? ldexpf(fminf(r->tfar, FLT_MAX), e) : r->tfar; /* no t that is no float */
        id[MASK * width] = ~0u;
        id[ID * width] = 0;
        id[FLAGS * width] = 0;
        valid[k] = on ? -1 : 0;
        if (occluded) continue;
        id[GEOM_ID * width] = RTC_INVALID_GEOMETRY_ID;
        id[INST_ID * width] = RTC_INVALID_GEOMETRY_ID;
    }
}

/* Returns the number of hits. */
static size_t unpack(const world *w, const trace_ray *rays, const void *packet, size_t count, unsigned width,
                     bool occluded, void *answers)
{
    size_t hits = 0;
    for (unsigned k = 0; k < count; ++k) {
        if (occluded) {
            bool hit = ((const float *)packet)[TFAR * width + k] == -INFINITY;
            if (answers) ((uint8_t *)answers)[k] = hit;
            hits += hit;
        } else {
            world_hit h = world_read_hit(w, packet, width, k);
            if (h.geomID != ~0u) h.t = ldexpf(h.t, -exponent_of(&rays[k])), ++hits;
            if (answers) ((world_hit *)answers)[k] = h;
        }
    }
    return hits;
}

static EPCounters difference(const EPCounters *after, const EPCounters *before)
{
    return (EPCounters){
        .visits = after->visits - before->visits,
        .solves = after->solves - before->solves,
        .evaluations = after->evaluations - before->evaluations,
        .cells = after->cells - before->cells,
        .slow = after->slow - before->slow,
    };
}

bool trace_rays(const world *w, const trace_ray *rays, size_t count, const trace_options *o, void *answers,
                trace_result *result)
{
    const unsigned width = o->width;
    const bool occluded = o->occluded, coherent = o->coherent;
    const int threads = (int)trace_threads(o->threads);
    const size_t ray_bytes = (occluded ? RAY_FIELDS : RAYHIT_FIELDS) * sizeof(float), stride = ray_bytes * width;
    const size_t answer_bytes = occluded ? 1 : sizeof(world_hit);

    char *packets = aligned_alloc(64, BLOCK_RAYS * ray_bytes);
    int *valid = aligned_alloc(64, BLOCK_RAYS * sizeof *valid);
    EPCounters before, after;
    *result = (trace_result){0};
    if (!packets || !valid) {
        report_no_memory(NULL);
        free(packets);
        free(valid);
        return false;
    }
    epGetCounters(&before);
    for (size_t first = 0; first < count; first += BLOCK_RAYS) {
        const trace_ray *in = rays + first;
        char *out = answers ? (char *)answers + first * answer_bytes : NULL;
        size_t n = count - first < BLOCK_RAYS ? count - first : BLOCK_RAYS, packet_count = (n + width - 1) / width;
        size_t hits = 0;

#pragma omp parallel for schedule(static) num_threads(threads)
        for (size_t p = 0; p < packet_count; ++p)
            pack(in + p * width, n - p * width, width, occluded, packets + p * stride, valid + p * width);

        const bool said = coherent && world_takes_coherent(w, occluded);
        double start = wall_seconds();
#pragma omp parallel for schedule(dynamic, PACKETS_A_TURN) num_threads(threads)
        for (size_t p = 0; p < packet_count; ++p) {
            void *packet = packets + p * stride;
            const int *on = valid + p * width;
            if (width == 1 && !*on) continue;
            if (occluded) ep_rtc_occluded(w->rtc, width, on, packet, said);
            else ep_rtc_intersect(w->rtc, width, on, packet, said);
        }
        result->seconds += wall_seconds() - start;

#pragma omp parallel for schedule(static) reduction(+ : hits) num_threads(threads)
        for (size_t p = 0; p < packet_count; ++p) {
            size_t lanes = n - p * width < width ? n - p * width : width;
            hits += unpack(w, in + p * width, packets + p * stride, lanes, width, occluded,
                           out ? out + p * width * answer_bytes : NULL);
        }
        result->hits += hits;
    }
    epGetCounters(&after);
    result->cost = difference(&after, &before);
    free(packets);
    free(valid);
    return true;
}
