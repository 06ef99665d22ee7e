/* bench.h - what `epatch bench` measures: subjects, workloads, runs.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A subject is a way to represent the scene: the exact patches, the patches with a callback that costs next to nothing
 * (the limit), or a tessellation: of triangles, and where the scene is a cage, of Embree's grids and by Embree's own
 * subdivision. A workload is a set of rays and a way to send them. Every subject answers the same
 * rays. A run builds every subject and measures every workload on it; a figure is the median of the runs. */
#ifndef EPATCH_BENCH_H
#define EPATCH_BENCH_H

#include "tools/trace.h"

#include <jansson.h>

typedef enum bench_kind { BENCH_PRIMARY, BENCH_RANDOM, BENCH_BOUNCE, BENCH_OCCLUDED, BENCH_KINDS } bench_kind;

typedef struct bench_workload {
    const char *name; /* a key of the JSON */
    bench_kind kind;
    unsigned width; /* rays a packet */
    bool coherent, occluded;
} bench_workload;

enum { BENCH_WORKLOADS = 8 };
extern const bench_workload bench_workloads[BENCH_WORKLOADS];

enum {
    BENCH_RUNS_MAX = 99,
    BENCH_COLUMNS_MAX = 2,  /* numbers of threads measured in one go: one, and all */
    BENCH_FIRST_GRID = 8,   /* the coarsest tessellation                           */
    BENCH_LAST_GRID = 8192, /* the finest                                          */
    BENCH_GRIDS_MAX = 11,   /* powers of two from first to last                    */
    BENCH_FORMS = 3         /* of tessellations                                    */
};

/* One quantity over the runs. */
typedef struct bench_figure {
    double run[BENCH_RUNS_MAX];
    unsigned runs;
} bench_figure;

/* What one number of threads achieves. */
typedef struct bench_column {
    bench_figure build;                  /* seconds                   */
    bench_figure speed[BENCH_WORKLOADS]; /* millions of rays a second */
    bench_figure ratio[BENCH_WORKLOADS]; /* of a tessellation: the patches' speed, right before and after, by its own */
} bench_column;

typedef struct bench_subject {
    unsigned n;      /* steps a patch of a tessellation; 0: no tessellation */
    world_form form; /* of a tessellation                                   */
    world *world;    /* NULL for the limit, and when it is not its turn     */
    RTCScene rtc;
    size_t triangles, bytes;             /* bytes: ours and Embree's */
    double position_error, normal_error; /* largest; relative to the diagonal, in degrees */
    EPCounters cost[BENCH_WORKLOADS];    /* of every ray once        */
    size_t hits[BENCH_WORKLOADS];        /* of every ray once        */
    unsigned passes[BENCH_WORKLOADS];    /* over the rays, so that a measurement is long enough */
    bench_column columns[BENCH_COLUMNS_MAX];
} bench_subject;

/* The rays of every kind; counts are multiples of 16. */
typedef struct bench_rays {
    trace_ray *of[BENCH_KINDS];
    size_t count[BENCH_KINDS];
    bool takes_coherent[2]; /* rays; occlusion rays: see world_takes_coherent */
} bench_rays;

typedef struct bench_options {
    unsigned runs, workloads; /* workloads: one bit each                   */
    unsigned rays;            /* of the camera; a quarter of all others     */
    unsigned threads[BENCH_COLUMNS_MAX], columns;
    unsigned max_grid;
    size_t memory; /* bytes that a tessellation may take, building it included */
    bool scene_camera;
    EPBuildSettings build;
} bench_options;

/* Tessellations of one form, each twice as fine as the one before. */
typedef struct bench_family {
    world_form form;
    bench_subject grids[BENCH_GRIDS_MAX];
    unsigned count; /* all that memory allows, until one is as exact as the patches */
    bool matched;   /* the last one is                                              */
} bench_family;

typedef struct bench_limit bench_limit;

typedef struct bench {
    const scene *scene;
    bench_options options;
    bench_rays rays;
    double diagonal;
    bench_subject patches, limit;
    bench_family families[BENCH_FORMS]; /* triangles first */
    unsigned family_count;
    bench_limit *limit_scene;
} bench;

/* bench_run.c: builds, measures. False after a message; bench_free in any case. */
bool bench_run(bench *b, const scene *s, const bench_options *o);
void bench_free(bench *b);

/* What is called what, in figures for people: "triangles", "grids", "subdivision". */
extern const char *const bench_form_names[BENCH_FORMS];
const bench_subject *bench_finest(const bench_family *f);

/* The patches, or a tessellation. NULL after a message. */
world *bench_world(const scene *s, const bench_options *o, unsigned tessellation, world_form form, unsigned threads);
double bench_diagonal(const world *w); /* of the box around it */

/* bench_figure.c */
void bench_add(bench_figure *f, double value);
double bench_median(const bench_figure *f); /* 0 without runs */
double bench_least(const bench_figure *f);
double bench_most(const bench_figure *f);

/* bench_rays.c: the rays of all kinds, made for the patches. False after a message. */
bool bench_rays_new(bench_rays *r, const world *patches, const bench_options *o);
void bench_rays_free(bench_rays *r);

/* bench_trace.c: traces blocks first .. first + count - 1 of the rays, starting over where they end. */
typedef struct bench_timing {
    double seconds; /* of tracing alone */
    size_t rays, hits;
} bench_timing;
size_t bench_blocks(const bench_workload *w, const bench_rays *r);
/* Adds to *t. False after a message: no memory. */
bool bench_trace(RTCScene rtc, const bench_workload *w, const bench_rays *r, size_t first, size_t count,
                 unsigned threads, bench_timing *t);
/* The same with blocks first .. end - 1, after a block a thread that does not count: it fills the caches. */
bool bench_trace_warm(RTCScene rtc, const bench_workload *w, const bench_rays *r, size_t first, size_t end,
                      unsigned threads, bench_timing *t);
double bench_speed(const bench_timing *t); /* millions of rays a second */

/* bench_error.c: the largest errors of w's answers to primary and random rays. False after a message. */
bool bench_errors(const world *w, const bench_rays *r, double diagonal, bench_subject *to);

/* bench_limit.c: the leaves of `patches` in an RTCScene of their own, with a callback that only intersects the leaf's
 * plane. NULL after a message. */
bench_limit *bench_limit_new(const world *patches);
RTCScene bench_limit_scene(const bench_limit *l);
void bench_limit_free(bench_limit *l);

/* bench_print.c: tables on standard output. */
void bench_print(const bench *b, bool markdown);

/* bench_json.c: everything as one object; NULL without memory. */
json_t *bench_json(const bench *b);
json_t *bench_machine_json(const char *isa);

/* bench_plot.c: error against speed and memory, drawn by gnuplot. */
bool bench_plot_possible(const char *path);        /* false after a message: there is no gnuplot */
bool bench_plot(const bench *b, const char *path); /* false after a message */

/* bench_degrees.c: one patch of each degree fills the picture, beside the figures of Pabst et al. False after a
 * message. */
typedef enum bench_form { BENCH_TEXT, BENCH_MARKDOWN, BENCH_JSON } bench_form;
bool bench_degrees(const bench_options *o, bench_form form);

/* bench_newton.c: the kernels beside ordinary ones, which certify nothing. False after a message. */
bool bench_newton(const scene *s, const bench_options *o, bench_form form);

#endif
