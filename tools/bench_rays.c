/* bench_rays.c - the rays of the workloads.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 *   primary   a picture that the model fills to its edges, in tiles of 4 x 4 pixels, four times as many as of the rest
 *   random    from a sphere around the box of everything to points of that box: nothing in common
 *   bounce    from what the primary rays hit, distributed as a matt surface scatters light
 *   occluded  from what the primary rays hit to points of a light
 *
 * Bounces and segments start where the patches were hit, for every subject; they follow each other as the pixels do. */
#include "tools/bench.h"
#include "tools/camera.h"
#include "tools/outline.h"
#include "tools/report.h"

#include <math.h>
#include <stdlib.h>

const bench_workload bench_workloads[BENCH_WORKLOADS] = {
    {"primary1", BENCH_PRIMARY, 1, true, false},   {"primary16", BENCH_PRIMARY, 16, true, false},
    {"random1", BENCH_RANDOM, 1, false, false},    {"random16", BENCH_RANDOM, 16, false, false},
    {"bounce1", BENCH_BOUNCE, 1, false, false},    {"bounce16", BENCH_BOUNCE, 16, false, false},
    {"occluded1", BENCH_OCCLUDED, 1, false, true}, {"occluded16", BENCH_OCCLUDED, 16, false, true},
};

#define TILE 4
#define PI 3.14159265358979323846

/* The box of everything. */
typedef struct surroundings {
    double centre[3], half[3], radius;
} surroundings;

/* Where a primary ray hit, a little off the surface on the side that was seen. */
typedef struct site {
    vec3 p, n;
} site;

/* Splitmix64 [Steele, Lea, Flood 2014]: the same rays on every machine. */
static double uniform(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static vec3 on_unit_sphere(uint64_t *state)
{
    double z = 1 - 2 * uniform(state), phi = 2 * PI * uniform(state), r = sqrt(1 - z * z);
    return vec((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
}

static trace_ray ray(vec3 org, vec3 dir, float tfar)
{
    return (trace_ray){{org.x, org.y, org.z}, 0, {dir.x, dir.y, dir.z}, tfar};
}

static surroundings box_of(const world *w)
{
    surroundings s = {.radius = 0};
    for (int x = 0; x < 3; ++x) {
        s.centre[x] = 0.5 * ((double)w->bounds[x] + w->bounds[3 + x]);
        s.half[x] = 0.5 * ((double)w->bounds[3 + x] - w->bounds[x]);
        s.radius += s.half[x] * s.half[x];
    }
    s.radius = sqrt(s.radius);
    return s;
}

/* The part of a picture, in pixels of the view, that a model fills. */
typedef struct window {
    double x0, y0, width, height;
} window;

static window filled_by(const view *v, const double (*points)[3], size_t count)
{
    double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
    const double eye[3] = {(double)v->eye.x, (double)v->eye.y, (double)v->eye.z};
    for (size_t i = 0; i < count; ++i) {
        /* origin + x step_x + y step_y is parallel to the point; steps and the forward axis are orthogonal. */
        double d[3], z = 0, xy[2] = {0, 0}, step2 = 0, start[2] = {0, 0};
        for (int k = 0; k < 3; ++k) d[k] = points[i][k] - eye[k];
        const float f[3] = {v->forward.x, v->forward.y, v->forward.z};
        for (int k = 0; k < 3; ++k) {
            z += d[k] * (double)f[k];
            xy[0] += d[k] * v->step_x[k], xy[1] += d[k] * v->step_y[k];
            start[0] += v->origin[k] * v->step_x[k], start[1] += v->origin[k] * v->step_y[k];
            step2 += v->step_x[k] * v->step_x[k];
        }
        for (int k = 0; k < 2; ++k) {
            double at = (xy[k] / z - start[k]) / step2;
            least[k] = fmin(least[k], at), most[k] = fmax(most[k], at);
        }
    }
    return (window){least[0], least[1], most[0] - least[0], most[1] - least[1]};
}

/* Pixels along each side: about `count` in all, squares, whole tiles. A window without area is made one. */
static void divide(window *w, size_t count, size_t *columns, size_t *rows)
{
    const double slim = fmax(w->width, w->height) / 16;
    if (w->width < slim) w->x0 -= 0.5 * (slim - w->width), w->width = slim;
    if (w->height < slim) w->y0 -= 0.5 * (slim - w->height), w->height = slim;
    const double side = sqrt((double)count * w->width / w->height) / TILE;
    *columns = side < 1 ? 1 : (size_t)side;
    *rows = count / (TILE * TILE * *columns);
    if (!*rows) *rows = 1;
    *columns *= TILE;
    *rows *= TILE;
}

/* Which view, and which part of it. False after a message. */
static bool choose_view(const world *w, const bench_options *o, view *v, window *part)
{
    if (o->scene_camera) {
        *part = (window){0, 0, 1280, 720};
        if (view_of_camera(v, &w->scene->camera, 1280, 720)) return true;
        return report_file(w->scene->path, "the camera sees nothing"), false;
    }
    const unsigned size = 1024, up = 2;
    size_t count;
    double(*points)[3] = outline_new(w, &count);
    if (!points) return report_no_memory(w->scene->path), false;
    camera c = camera_framing((const double(*)[3])points, count, up, size, size);
    bool done = count && view_of_camera(v, &c, size, size);
    if (done) *part = filled_by(v, (const double(*)[3])points, count);
    else report_file(w->scene->path, "there is nothing to see");
    free(points);
    return done;
}

static bool primary(const world *w, const bench_options *o, bench_rays *r)
{
    view v;
    window part;
    size_t columns, rows, n = 0;
    if (!choose_view(w, o, &v, &part)) return false;
    divide(&part, o->rays, &columns, &rows);
    for (int k = 0; k < BENCH_KINDS; ++k) {
        r->count[k] = columns * rows;
        if (k != BENCH_PRIMARY && r->count[k] > 64) r->count[k] = r->count[k] / 64 * 16;
        r->of[k] = malloc(r->count[k] * sizeof *r->of[k]);
    }
    if (!r->of[0] || !r->of[1] || !r->of[2] || !r->of[3]) return report_no_memory(w->scene->path), false;

    for (size_t y = 0; y < rows; y += TILE)
        for (size_t x = 0; x < columns; x += TILE)
            for (size_t k = 0; k < TILE * TILE; ++k) {
                double px = part.x0 + part.width * ((double)(x + k % TILE) + 0.5) / (double)columns;
                double py = part.y0 + part.height * ((double)(y + k / TILE) + 0.5) / (double)rows;
                r->of[BENCH_PRIMARY][n++] = ray(v.eye, view_direction(&v, px, py), INFINITY);
            }
    return true;
}

static void random_rays(const surroundings *s, bench_rays *r)
{
    uint64_t state = 1;
    for (size_t i = 0; i < r->count[BENCH_RANDOM]; ++i) {
        const vec3 from = on_unit_sphere(&state);
        const double sphere[3] = {(double)from.x, (double)from.y, (double)from.z};
        double org[3], dir[3];
        for (int x = 0; x < 3; ++x) {
            org[x] = s->centre[x] + 1.2 * s->radius * sphere[x];
            dir[x] = s->centre[x] + s->half[x] * (2 * uniform(&state) - 1) - org[x];
        }
        r->of[BENCH_RANDOM][i] = ray(vec((float)org[0], (float)org[1], (float)org[2]),
                                     vec_unit(vec((float)dir[0], (float)dir[1], (float)dir[2])), INFINITY);
    }
}

/* What the primary rays hit: `*count` of them, malloc'ed. NULL after a message. */
static site *find_sites(const world *w, const bench_rays *r, size_t *count)
{
    const trace_options options = {.width = 16, .coherent = true};
    trace_result result;
    const size_t rays = r->count[BENCH_PRIMARY];
    site *sites = malloc(rays * sizeof *sites);
    world_hit *hits = malloc(rays * sizeof *hits);
    bool done = sites && hits;
    if (!done) report_no_memory(w->scene->path);
    done = done && trace_rays(w, r->of[BENCH_PRIMARY], rays, &options, hits, &result);
    *count = 0;
    for (size_t i = 0; done && i < rays; ++i) {
        if (hits[i].geomID == ~0u) continue;
        const trace_ray *a = &r->of[BENCH_PRIMARY][i];
        const vec3 org = vec(a->org[0], a->org[1], a->org[2]), dir = vec(a->dir[0], a->dir[1], a->dir[2]);
        vec3 n = vec_unit(vec(hits[i].Ng[0], hits[i].Ng[1], hits[i].Ng[2]));
        if (vec_dot(n, dir) > 0) n = vec_scale(-1, n);
        if (!(vec_dot(n, n) > 0.5f)) n = vec_scale(-1, dir); /* no normal, at a pole */
        /* Well above the rounding of either subject's hits, well below the error of all but the finest grids. */
        const float away = 0x1p-18f * (fabsf(org.x) + fabsf(org.y) + fabsf(org.z) + hits[i].t);
        sites[(*count)++] = (site){vec_madd(vec_madd(org, hits[i].t, dir), away, n), n};
    }
    free(hits);
    if (done && !*count) report_file(w->scene->path, "no ray of the view hits anything"), done = false;
    if (done) return sites;
    free(sites);
    return NULL;
}

/* Where ray i of n starts: runs of 16 neighbours, spread evenly over all sites. */
static const site *site_of_ray(const site *sites, size_t count, size_t i, size_t n)
{
    if (count < 16) return &sites[i % count];
    return &sites[i / 16 * (count / 16) / (n / 16) * 16 + i % 16];
}

static void bounces(const site *sites, size_t count, bench_rays *r)
{
    uint64_t state = 2;
    const size_t n = r->count[BENCH_BOUNCE];
    for (size_t i = 0; i < n; ++i) {
        const site *at = site_of_ray(sites, count, i, n);
        const double x = uniform(&state), phi = 2 * PI * uniform(&state), sine = sqrt(x);
        vec3 s, t;
        vec_frame(at->n, &s, &t);
        vec3 d = vec_scale((float)sqrt(1 - x), at->n);
        d = vec_madd(vec_madd(d, (float)(sine * cos(phi)), s), (float)(sine * sin(phi)), t);
        r->of[BENCH_BOUNCE][i] = ray(at->p, d, INFINITY);
    }
}

/* Moves the sites that face a point to the front; returns their number. */
static size_t facing(site *sites, size_t count, vec3 light)
{
    size_t n = 0;
    for (size_t i = 0; i < count; ++i)
        if (vec_dot(vec_sub(light, sites[i].p), sites[i].n) > 0) sites[n++] = sites[i];
    return n;
}

/* Segments to points of a spherical light. */
static void segments(const site *sites, size_t count, vec3 light, float radius, bench_rays *r)
{
    uint64_t state = 3;
    const size_t n = r->count[BENCH_OCCLUDED];
    for (size_t i = 0; i < n; ++i) {
        const site *at = site_of_ray(sites, count, i, n);
        r->of[BENCH_OCCLUDED][i] = ray(at->p, vec_sub(vec_madd(light, radius, on_unit_sphere(&state)), at->p), 1);
    }
}

bool bench_rays_new(bench_rays *r, const world *w, const bench_options *o)
{
    const surroundings s = box_of(w);
    *r = (bench_rays){.takes_coherent = {world_takes_coherent(w, false), world_takes_coherent(w, true)}};
    if (!(s.radius > 0 && s.radius < (double)INFINITY))
        return report_file(w->scene->path, "there is nothing to measure: no patch has an extent"), false;
    if (!primary(w, o, r)) return false;
    random_rays(&s, r);

    size_t count;
    site *sites = find_sites(w, r, &count);
    if (!sites) return false;
    bounces(sites, count, r);
    /* Over the left shoulder of whoever looks, high up, and as large in the sky as a window in a room. */
    const trace_ray *first = &r->of[BENCH_PRIMARY][0];
    const vec3 eye = vec(first->org[0], first->org[1], first->org[2]);
    const vec3 centre = vec((float)s.centre[0], (float)s.centre[1], (float)s.centre[2]);
    const vec3 back = vec_unit(vec_sub(eye, centre)), side = vec_unit(vec_cross(back, vec(0, 0, 1)));
    const vec3 to_light = vec_unit(vec_madd(vec_madd(back, 0.7f, side), 1.2f, vec(0, 0, 1)));
    const float radius = (float)s.radius;
    const vec3 light = vec_madd(centre, 4 * radius, to_light);
    const size_t lit = facing(sites, count, light);
    if (lit) segments(sites, lit, light, 0.5f * radius, r);
    else segments(sites, count, eye, 0, r); /* nothing that is seen faces the light, but all of it faces the eye */
    free(sites);
    return true;
}

void bench_rays_free(bench_rays *r)
{
    for (int k = 0; k < BENCH_KINDS; ++k) free(r->of[k]);
    *r = (bench_rays){0};
}
