/* bench_trace.c - the clock around rtcIntersect and rtcOccluded.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A thread takes a block of rays, packs them into a buffer that stays in its second-level cache, as a renderer's
 * packets would, starts the clock, traces, stops the clock, and looks at the answers. A single thread is timed by its
 * own processor time, which does not count what other programs take away; several are timed by the wall clock, since
 * what they win together is the question. */
#include "tools/bench.h"
#include "tools/report.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <time.h>

#define BLOCK_RAYS 4096 /* 320 kB, and half a per cent of the time for the clock at 50 million rays a second */

/* Field f of lane k of a packet stands at [f * width + k]. */
enum { ORG = 0, TNEAR = 3, DIR = 4, TIME = 7, TFAR = 8, MASK = 9, ID = 10, FLAGS = 11, GEOM_ID = 18, INST_ID = 19 };

/* Bytes between the rays of a block; those of a packet stand side by side. Newer Embrees have more instance ids. */
static size_t ray_bytes(const bench_workload *w)
{
    if (w->occluded) return sizeof(struct RTCRay);
    return w->width == 1 ? sizeof(struct RTCRayHit) : sizeof(struct RTCRayHit16) / 16;
}

static double seconds(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void pack(const trace_ray *rays, unsigned width, bool occluded, void *packet)
{
    for (unsigned k = 0; k < width; ++k) {
        const trace_ray *r = &rays[k];
        float *real = (float *)packet + k;
        uint32_t *id = (uint32_t *)packet + k;
        for (unsigned x = 0; x < 3; ++x) {
            real[(ORG + x) * width] = r->org[x];
            real[(DIR + x) * width] = r->dir[x];
        }
        real[TNEAR * width] = r->tnear;
        real[TIME * width] = 0;
        real[TFAR * width] = r->tfar;
        id[MASK * width] = ~0u;
        id[ID * width] = 0;
        id[FLAGS * width] = 0;
        if (occluded) continue;
        id[GEOM_ID * width] = RTC_INVALID_GEOMETRY_ID;
        id[INST_ID * width] = RTC_INVALID_GEOMETRY_ID;
    }
}

static size_t count_hits(const void *packet, unsigned width, bool occluded)
{
    size_t hits = 0;
    for (unsigned k = 0; k < width; ++k)
        hits += occluded ? ((const float *)packet)[TFAR * width + k] < 0
                         : ((const uint32_t *)packet)[GEOM_ID * width + k] != RTC_INVALID_GEOMETRY_ID;
    return hits;
}

size_t bench_blocks(const bench_workload *w, const bench_rays *r)
{
    return (r->count[w->kind] + BLOCK_RAYS - 1) / BLOCK_RAYS;
}

bool bench_trace(RTCScene rtc, const bench_workload *w, const bench_rays *r, size_t first, size_t count,
                 unsigned threads, bench_timing *t)
{
    _Alignas(64) static const int all[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
    const unsigned width = w->width;
    const bool occluded = w->occluded, coherent = w->coherent && r->takes_coherent[occluded];
    const clockid_t clock = threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC;
    const size_t block_bytes = ray_bytes(w) * BLOCK_RAYS, stride = ray_bytes(w) * width;
    const size_t blocks = bench_blocks(w, r), rays = r->count[w->kind];

    char *buffers = aligned_alloc(64, threads * block_bytes);
    if (!buffers) return report_no_memory(NULL), false;
    double busy = 0;
    size_t traced = 0, hits = 0;
    int team = 1;
#pragma omp parallel num_threads((int)threads) reduction(+ : busy, traced, hits)
    {
#pragma omp single
        team = omp_get_num_threads();
        char *buffer = buffers + (size_t)omp_get_thread_num() * block_bytes;
#pragma omp for schedule(dynamic)
        for (size_t turn = first; turn < first + count; ++turn) {
            const size_t start = turn % blocks * BLOCK_RAYS;
            const size_t packets = (rays - start < BLOCK_RAYS ? rays - start : BLOCK_RAYS) / width;
            for (size_t p = 0; p < packets; ++p)
                pack(r->of[w->kind] + start + p * width, width, occluded, buffer + p * stride);

            const double before = seconds(clock);
            if (occluded)
                for (size_t p = 0; p < packets; ++p) ep_rtc_occluded(rtc, width, all, buffer + p * stride, coherent);
            else
                for (size_t p = 0; p < packets; ++p) ep_rtc_intersect(rtc, width, all, buffer + p * stride, coherent);
            busy += seconds(clock) - before;

            traced += packets * width;
            for (size_t p = 0; p < packets; ++p) hits += count_hits(buffer + p * stride, width, occluded);
        }
    }
    free(buffers);
    t->seconds += busy / team;
    t->rays += traced;
    t->hits += hits;
    return true;
}

bool bench_trace_warm(RTCScene rtc, const bench_workload *w, const bench_rays *r, size_t first, size_t end,
                      unsigned threads, bench_timing *t)
{
    bench_timing unused = {0};
    return first == end || (bench_trace(rtc, w, r, first, threads, threads, &unused) &&
                            bench_trace(rtc, w, r, first, end - first, threads, t));
}

double bench_speed(const bench_timing *t)
{
    return 1e-6 * (double)t->rays / t->seconds;
}
