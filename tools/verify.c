/* verify.c - see verify.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Rays go through in blocks. The first setup's answers are judged; another setup's only where they differ. Of the roots
 * on a trimmed patch those remain that the reference of the trims keeps; near a trim's border they are doubtful. */
#include "tools/verify.h"
#include "test/oracle/trim_reference.h"
#include "tools/progress.h"
#include "tools/report.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1 << 15 };

/* A geometry, traceable with each instruction set of the setups, and the buffers for a block. */
typedef struct bench {
    const verify_options *o;
    const scene_geometry *geometry;
    oracle *oracle;
    world *worlds[VERIFY_SETUPS]; /* setups of the same instruction set share one */
    trace_ray *rays, *cut;        /* `cut`: those that hit end right behind it */
    world_hit *first, *hits, *again;
    uint8_t *verdicts, *occluded, *faulty;
    unsigned explained;
} bench;

size_t verify_faults(const verify_row *row)
{
    size_t sum = row->occluded + row->bits;
    for (int k = JUDGE_MISSED; k < JUDGE_VERDICTS; ++k) sum += row->verdicts[k];
    return sum;
}

static oracle *oracle_of(const scene_geometry *g)
{
    oracle_patch *patches = malloc((g->patch_count + 1) * sizeof *patches);
    if (!patches) return NULL;
    for (size_t i = 0; i < g->patch_count; ++i) {
        const patch *p = &g->patches[i];
        patches[i] = (oracle_patch){p->kind == PATCH_TRIANGLE, p->degree_u, p->degree_v, g->points + 4 * p->first};
    }
    oracle *o = oracle_new(patches, g->patch_count);
    free(patches);
    return o;
}

static void bench_close(bench *b)
{
    for (size_t i = 0; i < b->o->setup_count; ++i) {
        bool shared = false;
        for (size_t k = 0; k < i; ++k) shared = shared || b->worlds[k] == b->worlds[i];
        if (!shared) world_free(b->worlds[i]);
    }
    oracle_free(b->oracle);
    free(b->rays);
    free(b->cut);
    free(b->first);
    free(b->hits);
    free(b->again);
    free(b->verdicts);
    free(b->occluded);
    free(b->faulty);
}

/* `one` is a scene of one untransformed geometry; it has to outlive the bench. */
static bool bench_open(bench *b, const scene *one, const verify_options *o, double distance)
{
    *b = (bench){.o = o, .geometry = one->geometries};
    b->oracle = oracle_of(one->geometries);
    b->rays = malloc(BLOCK * sizeof *b->rays);
    b->cut = malloc(BLOCK * sizeof *b->cut);
    b->first = malloc(BLOCK * sizeof *b->first);
    b->hits = malloc(BLOCK * sizeof *b->hits);
    b->again = malloc(BLOCK * sizeof *b->again);
    b->verdicts = malloc(BLOCK);
    b->occluded = malloc(BLOCK);
    b->faulty = malloc(BLOCK);
    bool complete =
        b->oracle && b->rays && b->cut && b->first && b->hits && b->again && b->verdicts && b->occluded && b->faulty;
    if (!complete) report_no_memory(one->path);
    for (size_t i = 0; i < o->setup_count && complete; ++i) {
        for (size_t k = 0; k < i && !b->worlds[i]; ++k)
            if (!strcmp(o->setups[k].isa, o->setups[i].isa)) b->worlds[i] = b->worlds[k];
        if (b->worlds[i]) continue;
        world_options w = {.threads = o->threads, .ray_distance = distance, .build = epDefaultBuildSettings()};
        w.build.isa = o->setups[i].isa;
        b->worlds[i] = world_new(one, &w);
        complete = b->worlds[i];
    }
    if (!complete) bench_close(b);
    return complete;
}

/* Where a root near a trim's border is a matter of rounding, in the domain: at least this; and what the judge allows in
 * space, seen in the domain along a ray that meets the surface at this angle. */
static const double trim_band = 2e-5;

/* A patch's parameters as its face has them, which its trim is given in; how much longer steps may be there. */
static double to_face(const scene_geometry *g, size_t patch, double *u, double *v)
{
    if (!g->places) return 1;
    const double *m = g->places[patch], s = *u, t = *v;
    *u = m[0] * s + m[2] * t + m[4];
    *v = m[1] * s + m[3] * t + m[5];
    return fmax(fabs(m[0]) + fabs(m[2]), fabs(m[1]) + fabs(m[3]));
}

static double band_at(const bench *b, const oracle_root *r)
{
    double p[3], pu[3], pv[3], u2 = 0, v2 = 0, n2 = 0;
    oracle_evaluate(b->oracle, r->patch, r->u, r->v, p, pu, pv);
    for (int c = 0; c < 3; ++c) {
        u2 += pu[c] * pu[c], v2 += pv[c] * pv[c];
        n2 += r->normal[c] * r->normal[c];
    }
    /* the least that a step in the domain moves the point */
    const double stretch = sqrt(n2 / fmax(u2, v2));
    return fmax(trim_band, b->o->limits.distance * oracle_radius(b->oracle, r->patch) / (stretch * r->cosine));
}

static size_t find_roots(const bench *b, const trace_ray *ray, const double org[3], const double dir[3],
                         oracle_root roots[ORACLE_ROOTS])
{
    const size_t count = oracle_intersect(b->oracle, org, dir, ray->tnear, ray->tfar, roots);
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        oracle_root r = roots[i];
        const trim_shape *shape = b->geometry->patches[r.patch].shape;
        if (shape) {
            const double band = band_at(b, &r);
            double u = r.u, v = r.v;
            const double longer = to_face(b->geometry, r.patch, &u, &v);
            const shape_side side = band < 1 ? shape_at(shape, u, v, longer * band) : SHAPE_NEAR;
            if (side == SHAPE_OUT && !r.doubtful) continue;
            r.doubtful = r.doubtful || side == SHAPE_NEAR;
        }
        roots[kept++] = r;
    }
    return kept;
}

/* What the rounding of a face's parameters is in those of one of its patches. */
static double finest_of(const scene_geometry *g, size_t patch, const world_hit *hit)
{
    if (!g->places) return 0;
    const double *m = g->places[patch], det = fabs(m[0] * m[3] - m[1] * m[2]);
    const double inverse = fmax(fabs(m[0]) + fabs(m[1]), fabs(m[2]) + fabs(m[3])) / det;
    return 0x1p-23 * inverse * fmax(fabs((double)hit->u), fabs((double)hit->v));
}

static judge_verdict judge_hit(const bench *b, const trace_ray *ray, const world_hit *hit, judge_errors *errors)
{
    double org[3], dir[3];
    for (int c = 0; c < 3; ++c) org[c] = ray->org[c], dir[c] = ray->dir[c];
    oracle_root roots[ORACLE_ROOTS];
    const size_t count = find_roots(b, ray, org, dir, roots);
    judge_answer a = {hit->t, hit->u, hit->v, hit->primID, {hit->Ng[0], hit->Ng[1], hit->Ng[2]}, 0};
    if (hit->geomID != ~0u) {
        a.patch = (uint32_t)patch_of(b->geometry, hit->primID, &a.u, &a.v);
        a.finest = finest_of(b->geometry, a.patch, hit);
    }
    return judge(b->oracle, org, dir, roots, count, &a, &b->o->limits, errors);
}

static void judge_all(bench *b, const world_hit *hits, bool all, size_t count, verify_row *row)
{
#pragma omp parallel num_threads((int)trace_threads(b->o->threads))
    {
        judge_errors most = {0, 0, 0};
#pragma omp for schedule(dynamic, 64)
        for (size_t i = 0; i < count; ++i) {
            judge_errors e = {0, 0, 0};
            if (!all && !memcmp(&hits[i], &b->first[i], sizeof *hits)) continue;
            b->verdicts[i] = (uint8_t)judge_hit(b, &b->rays[i], &hits[i], &e);
            if (b->verdicts[i] != JUDGE_RIGHT) continue;
            most.t = fmax(most.t, e.t);
            most.place = fmax(most.place, e.place);
            most.degrees = fmax(most.degrees, e.degrees);
        }
#pragma omp critical
        {
            row->most.t = fmax(row->most.t, most.t);
            row->most.place = fmax(row->most.place, most.place);
            row->most.degrees = fmax(row->most.degrees, most.degrees);
        }
    }
}

/* Everything that is needed to see what went wrong with ray i, and to trace it again. */
static void explain(const bench *b, size_t i, const verify_setup *s, const world_hit *hit, const char *what)
{
    const trace_ray *ray = &b->rays[i];
    double org[3], dir[3];
    for (int c = 0; c < 3; ++c) org[c] = ray->org[c], dir[c] = ray->dir[c];
    oracle_root roots[ORACLE_ROOTS];
    const size_t count = find_roots(b, ray, org, dir, roots);
    printf("%s, width %u, %s: org %.9g %.9g %.9g dir %.9g %.9g %.9g in (%.9g, %.9g)\n", what, s->width, s->isa,
           ray->org[0], ray->org[1], ray->org[2], ray->dir[0], ray->dir[1], ray->dir[2], ray->tnear, ray->tfar);
    printf("    answer       t %-18.9g patch %d u %.9g v %.9g Ng %.6g %.6g %.6g\n", hit->t, (int)hit->primID, hit->u,
           hit->v, hit->Ng[0], hit->Ng[1], hit->Ng[2]);
    for (size_t k = 0; k < count && k < 6; ++k) {
        const oracle_root *r = &roots[k];
        printf("    %-12s t %-18.12g", r->doubtful ? "perhaps" : "root", r->t_low);
        if (r->t_high > r->t_low) printf("to %-18.12g", r->t_high);
        printf("patch %u u %.12g v %.12g Ng %.6g %.6g %.6g cosine %.2g border %.2g\n", r->patch, r->u, r->v,
               r->normal[0], r->normal[1], r->normal[2], r->cosine, r->border);
    }
}

/* Traces and judges the block in one setup. */
static bool run_setup(bench *b, size_t setup, size_t count, verify_row *row)
{
    const verify_setup *s = &b->o->setups[setup];
    world_hit *hits = setup ? b->hits : b->first;
    trace_options t = {.width = s->width, .threads = b->o->threads};
    trace_result result;
    if (!trace_rays(b->worlds[setup], b->rays, count, &t, hits, &result)) return false;
    row->slow += result.cost.slow;
    for (size_t i = 0; i < count; ++i) {
        b->cut[i] = b->rays[i];
        if (hits[i].geomID != ~0u) b->cut[i].tfar = nextafterf(hits[i].t, INFINITY);
    }
    if (!trace_rays(b->worlds[setup], b->cut, count, &t, b->again, &result)) return false;
    t.occluded = true;
    if (!trace_rays(b->worlds[setup], b->rays, count, &t, b->occluded, &result)) return false;

    judge_all(b, hits, !setup, count, row);
    for (size_t i = 0; i < count; ++i) {
        const bool hit = hits[i].geomID != ~0u;
        const judge_verdict verdict = b->verdicts[i];
        const bool disagrees = hit != b->occluded[i], cut = memcmp(&hits[i], &b->again[i], sizeof *hits);
        const bool differs = cut || memcmp(&hits[i], &b->first[i], sizeof *hits);
        ++row->rays;
        row->hits += hit;
        ++row->verdicts[verdict];
        row->occluded += disagrees;
        row->bits += differs;
        if (!(verdict >= JUDGE_MISSED || disagrees || differs)) continue;
        b->faulty[i] = 1;
        if (++b->explained > b->o->explain) continue;
        explain(b, i, s, &hits[i],
                verdict >= JUDGE_MISSED ? judge_names[verdict]
                : disagrees             ? "occlusion disagrees"
                : cut                   ? "other bits if it ends there"
                                        : "other bits");
    }
    return true;
}

static bool keep_wrong(const bench *b, size_t count, verify_report *r)
{
    for (size_t i = 0; i < count; ++i) {
        if (!b->faulty[i]) continue;
        if (r->wrong_count == r->wrong_capacity) {
            const size_t capacity = r->wrong_capacity ? 2 * r->wrong_capacity : 64;
            trace_ray *more = realloc(r->wrong, capacity * sizeof *more);
            if (!more) return report_no_memory(NULL), false;
            r->wrong = more;
            r->wrong_capacity = capacity;
        }
        r->wrong[r->wrong_count++] = b->rays[i];
    }
    return true;
}

static bool run_block(bench *b, size_t count, aim_kind kind, verify_report *r)
{
    memset(b->faulty, 0, count);
    for (size_t k = 0; k < b->o->setup_count; ++k)
        if (!run_setup(b, k, count, &r->rows[kind][k])) return false;
    return keep_wrong(b, count, r);
}

/* Turns a ray that was aimed at some point of the geometry to one near a trim's border, if it meets a trimmed patch. */
static void aim_at_trim(const bench *b, rng *r, trace_ray *ray)
{
    size_t patch = rng_below(r, (unsigned)b->geometry->patch_count);
    const trim_shape *shape = b->geometry->patches[patch].shape;
    double uv[2];
    if (!shape || !shape_border(shape, r, &uv[0], &uv[1])) return;
    if (b->geometry->places) patch = patch_of(b->geometry, face_of(b->geometry, patch), &uv[0], &uv[1]);
    for (int c = 0; c < 2; ++c) uv[c] += rng_sign(r) * rng_scale(r, trim_band, 1e-2);
    if (!(uv[0] >= 0 && uv[1] >= 0 && uv[0] <= 1 && uv[1] <= 1)) return;
    if (oracle_is_triangle(b->oracle, (uint32_t)patch) && uv[0] + uv[1] > 1) return;
    double p[3];
    oracle_evaluate(b->oracle, (uint32_t)patch, uv[0], uv[1], p, NULL, NULL);
    for (int c = 0; c < 3; ++c) ray->dir[c] = (float)(p[c] - ray->org[c]);
}

/* Half of the rays at borders go to trims, where there are any. */
static void aim_block(bench *b, aim_kind kind, uint64_t geometry, size_t first, size_t count)
{
#pragma omp parallel for num_threads((int)trace_threads(b->o->threads))
    for (size_t i = 0; i < count; ++i) {
        rng r = rng_split(b->o->seed, geometry * AIM_KINDS + kind, first + i);
        trace_ray *ray = &b->rays[i];
        aim(b->oracle, kind, &r, ray->org, ray->dir);
        if (kind == AIM_BORDER && b->geometry->shape_count && rng_below(&r, 2)) aim_at_trim(b, &r, ray);
        ray->tnear = 0;
        ray->tfar = INFINITY;
    }
}

/* The scene of geometry g alone, where it is. */
static scene alone(const scene *s, size_t g, scene_object *object)
{
    scene one = *s;
    *object = (scene_object){.transform = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, .identity = true};
    one.geometries = &s->geometries[g];
    one.geometry_count = one.object_count = 1;
    one.objects = object;
    return one;
}

static bool prepare_shapes(const scene *s)
{
    const size_t originals = scene_originals(s);
    bool done = true;
    for (size_t g = 0; g < originals; ++g)
        for (size_t i = 0; i < s->geometries[g].shape_count; ++i)
            done = done && shape_prepare(s->geometries[g].shapes[i]);
    if (!done) report_no_memory(s->path);
    return done;
}

bool verify_scene(const scene *s, const verify_options *o, verify_report *report)
{
    *report = (verify_report){0};
    if (!prepare_shapes(s)) return false;
    const size_t originals = scene_originals(s);
    size_t geometries = 0;
    for (size_t g = 0; g < originals; ++g) geometries += s->geometries[g].patch_count > 0;
    progress p;
    progress_begin(&p, "verify", geometries * AIM_KINDS * (geometries ? (o->rays + geometries - 1) / geometries : 0));
    bool done = true;
    for (size_t g = 0; g < originals && done; ++g) {
        if (!s->geometries[g].patch_count) continue;
        scene_object object;
        const scene one = alone(s, g, &object);
        const size_t each = (o->rays + geometries - 1) / geometries;
        bench b;
        if (!bench_open(&b, &one, o, 0)) return free(report->wrong), false;
        for (aim_kind kind = 0; kind < AIM_KINDS && done; ++kind)
            for (size_t first = 0; first < each && done; first += BLOCK) {
                const size_t count = each - first < BLOCK ? each - first : BLOCK;
                aim_block(&b, kind, g, first, count);
                done = run_block(&b, count, kind, report);
                progress_add(&p, count);
            }
        bench_close(&b);
    }
    progress_end(&p);
    if (!done) free(report->wrong);
    return done;
}

bool verify_rays(const scene *s, const trace_ray *rays, size_t count, const verify_options *o, verify_report *report)
{
    *report = (verify_report){0};
    if (!prepare_shapes(s)) return false;
    const size_t originals = scene_originals(s);
    bool done = true;
    for (size_t g = 0; g < originals && done; ++g) {
        if (!s->geometries[g].patch_count) continue;
        scene_object object;
        const scene one = alone(s, g, &object);
        bench b;
        if (!bench_open(&b, &one, o, trace_farthest_origin(rays, count))) return free(report->wrong), false;
        for (size_t first = 0; first < count && done; first += BLOCK) {
            const size_t n = count - first < BLOCK ? count - first : BLOCK;
            memcpy(b.rays, rays + first, n * sizeof *rays);
            done = run_block(&b, n, AIM_AT, report);
        }
        bench_close(&b);
    }
    if (!done) free(report->wrong);
    return done;
}
