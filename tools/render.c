/* render.c - camera rays go as coherent packets, 4 x 4 pixels of one sample each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/render.h"
#include "tools/progress.h"

#include <omp.h>
#include <string.h>

#define TILE 16 /* pixels; a task for a thread    */
#define PACK 4  /* pixels; a packet is PACK x PACK */

/* Half the width of the tent that weights a pixel's samples. Narrower shows stairs, wider is soft. */
#define FILTER_RADIUS 0.8f

typedef struct camera_packet {
    _Alignas(64) struct RTCRayHit16 rh;
    _Alignas(64) int valid[16];
    shade_sample at[16];
} camera_packet;

/* The inverse of a tent's cumulative distribution, over [-1, 1]. */
static float tent(float x)
{
    return x < 0.5f ? sqrtf(2 * x) - 1 : 1 - sqrtf(2 - 2 * x);
}

/* Sample `sample` of the pixels from (x0, y0). */
static void fill_packet(camera_packet *p, const film *f, const view *v, unsigned x0, unsigned y0, unsigned sample,
                        unsigned spp)
{
    memset(&p->rh, 0, sizeof p->rh);
    memset(&p->rh.hit, 0xff, sizeof p->rh.hit); /* every id: none */
    for (unsigned k = 0; k < 16; ++k) {
        unsigned x = x0 + k % PACK, y = y0 + k / PACK;
        p->valid[k] = x < f->width && y < f->height ? -1 : 0;
        shade_sample *at = &p->at[k];
        *at = (shade_sample){.sampler = sampler_of_pixel(x, y, sample, spp)};

        float jx, jy;
        sampler_2d(&at->sampler, USE_PIXEL, &jx, &jy);
        double px = x + 0.5 + (double)(FILTER_RADIUS * tent(jx)), py = y + 0.5 + (double)(FILTER_RADIUS * tent(jy));
        at->x = (float)(2 * px / f->width - 1);
        at->y = (float)(2 * py / f->height - 1);
        vec3 d = view_direction(v, px, py);
        p->rh.ray.org_x[k] = v->eye.x;
        p->rh.ray.org_y[k] = v->eye.y;
        p->rh.ray.org_z[k] = v->eye.z;
        p->rh.ray.dir_x[k] = d.x;
        p->rh.ray.dir_y[k] = d.y;
        p->rh.ray.dir_z[k] = d.z;
        p->rh.ray.tfar[k] = INFINITY;
        p->rh.ray.mask[k] = ~0u;
    }
}

/* The colours of PACK x PACK pixels; returns the number of camera rays and adds to *rays all others. */
static uint64_t render_pack(const shader *s, const view *v, unsigned spp, const film *f, unsigned x0, unsigned y0,
                            uint64_t *rays)
{
    camera_packet p;
    vec3 sum[16] = {{0, 0, 0}};
    uint64_t camera_rays = 0;
    for (unsigned sample = 0; sample < spp; ++sample) {
        fill_packet(&p, f, v, x0, y0, sample, spp);
        ep_rtc_intersect(s->world->rtc, 16, p.valid, &p.rh, true);
        for (unsigned k = 0; k < 16; ++k) {
            if (!p.valid[k]) continue;
            world_hit hit = world_read_hit(s->world, &p.rh, 16, k);
            vec3 d = vec(p.rh.ray.dir_x[k], p.rh.ray.dir_y[k], p.rh.ray.dir_z[k]);
            sum[k] = vec_add(sum[k], shade(s, v->eye, d, &hit, &p.at[k]));
            ++camera_rays;
            *rays += p.at[k].rays;
        }
    }
    for (unsigned k = 0; k < 16; ++k) {
        if (!p.valid[k]) continue;
        float *to = film_pixel(f, x0 + k % PACK, y0 + k / PACK), scale = 1 / (float)spp;
        to[0] = scale * sum[k].x;
        to[1] = scale * sum[k].y;
        to[2] = scale * sum[k].z;
    }
    return camera_rays;
}

/* The layers of one pixel, from a ray of its own through the centre: ids and costs have no average. */
static void render_layers(const shader *s, const view *v, const film *f, unsigned x, unsigned y)
{
    struct RTCRayHit rh;
    vec3 d = view_direction(v, x + 0.5, y + 0.5);
    rh.ray = (struct RTCRay){.org_x = v->eye.x,
                             .org_y = v->eye.y,
                             .org_z = v->eye.z,
                             .dir_x = d.x,
                             .dir_y = d.y,
                             .dir_z = d.z,
                             .tfar = INFINITY,
                             .mask = ~0u};
    memset(&rh.hit, 0xff, sizeof rh.hit);
    EPCounters before, after;
    epGetThreadCounters(&before);
    ep_rtc_intersect(s->world->rtc, 1, NULL, &rh, false);
    epGetThreadCounters(&after);
    world_hit h = world_read_hit(s->world, &rh, 1, 0);

    bool hit = h.geomID != ~0u;
    vec3 n = vec_unit(vec(h.Ng[0], h.Ng[1], h.Ng[2]));
    const float values[LAYER_COUNT][3] = {
        [LAYER_DEPTH] = {h.t},
        [LAYER_NORMAL] = {n.x, n.y, n.z},
        [LAYER_UV] = {h.u, h.v},
        [LAYER_PRIM] = {hit ? (float)h.primID : -1},
        [LAYER_OBJECT] = {hit ? (float)h.geomID : -1},
        [LAYER_ITERATIONS] = {(float)(after.evaluations - before.evaluations)},
        [LAYER_SLOW] = {(float)(after.slow - before.slow)},
    };
    float *to = film_pixel(f, x, y);
    for (unsigned layer = 0; layer < LAYER_COUNT; ++layer)
        if (f->layers >> layer & 1) memcpy(to + f->first[layer], values[layer], film_layer_size(layer) * sizeof *to);
}

static unsigned least(unsigned a, unsigned b)
{
    return a < b ? a : b;
}

void render(const shader *s, const view *v, unsigned spp, unsigned threads, film *f, render_result *result)
{
    unsigned columns = (f->width + TILE - 1) / TILE, rows = (f->height + TILE - 1) / TILE;
    size_t tiles = (size_t)columns * rows;
    uint64_t camera_rays = 0, others = 0;
    int team = threads ? (int)threads : omp_get_max_threads();
    EPCounters before;
    progress bar;

    double start = wall_seconds();
    epGetCounters(&before);
    progress_begin(&bar, "render", tiles);
#pragma omp parallel for schedule(dynamic) reduction(+ : camera_rays, others) num_threads(team)
    for (size_t tile = 0; tile < tiles; ++tile) {
        unsigned x0 = (unsigned)(tile % columns) * TILE, y0 = (unsigned)(tile / columns) * TILE;
        unsigned x1 = least(x0 + TILE, f->width), y1 = least(y0 + TILE, f->height);
        for (unsigned y = y0; y < y1; y += PACK)
            for (unsigned x = x0; x < x1; x += PACK) camera_rays += render_pack(s, v, spp, f, x, y, &others);
        if (f->layers) {
            for (unsigned y = y0; y < y1; ++y)
                for (unsigned x = x0; x < x1; ++x) render_layers(s, v, f, x, y), ++others;
        }
        progress_add(&bar, 1);
    }
    progress_end(&bar);
    result->seconds = wall_seconds() - start;
    result->camera_rays = camera_rays;
    result->rays = camera_rays + others;

    epGetCounters(&result->cost);
    result->cost.visits -= before.visits;
    result->cost.solves -= before.solves;
    result->cost.evaluations -= before.evaluations;
    result->cost.cells -= before.cells;
    result->cost.slow -= before.slow;
}
