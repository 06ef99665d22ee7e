/* support.h - what the tests share: random patches, scenes of them, failures that say how to get them again.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef TEST_SUPPORT_H
#define TEST_SUPPORT_H

#include "embree_patch/geometry.h"
#include "embree_patch/rtc/rtc_compat.h"
#include "test/oracle/aim.h"
#include "test/oracle/judge.h"
#include "test/oracle/net.h"
#include "test/oracle/rng.h"

/* cmocka wants these before itself */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

/* Prints what the arguments say and where, and fails the test. */
#define FAIL(...) (print_error("%s:%d: ", __FILE__, __LINE__), print_error(__VA_ARGS__), print_error("\n"), fail())
#define CHECK(condition, ...)                                                                                          \
    do {                                                                                                               \
        if (!(condition)) FAIL(#condition ": " __VA_ARGS__);                                                           \
    } while (0)

/* A patch as a file would give it: Euclidean points and weights. */
typedef struct test_patch {
    net_shape shape;
    double points[NET_POINTS][4];
} test_patch;

/* What random patches look like. */
typedef enum patch_style {
    STYLE_GENTLE,     /* a grid, bent by a few tenths           */
    STYLE_WILD,       /* points anywhere in a box; folds        */
    STYLE_FLAT,       /* in a plane, or nearly                  */
    STYLE_COLLAPSED,  /* one side is a point                    */
    STYLE_DEGENERATE, /* a segment, a point, a cusp, two poles  */
    STYLES
} patch_style;

typedef struct patch_limits {
    unsigned most_degree;
    double most_weight; /* weights between its reciprocal and it; 1: polynomial */
} patch_limits;

void random_patch(rng *r, patch_style style, bool triangle, patch_limits limits, test_patch *p);
const char *style_name(patch_style style);

/* x -> scale x + offset. */
void move_patch(test_patch *p, double scale, const double offset[3]);

/* Point and derivatives, by the oracle's evaluation. */
void evaluate_patch(const test_patch *p, double u, double v, double x[3], double xu[3], double xv[3]);

/* A committed geometry of the patches; fails the test otherwise. NULL: default settings. */
EPGeometry new_geometry(const test_patch *patches, size_t count, const EPBuildSettings *settings);
/* The same patches for the oracle. */
oracle *new_oracle(const test_patch *patches, size_t count);

/* A geometry in a scene. */
typedef struct test_scene {
    RTCDevice device;
    RTCScene scene;
    EPGeometry geometry;
} test_scene;
test_scene new_scene(const test_patch *patches, size_t count, const EPBuildSettings *settings);
/* The same of a committed geometry, which it takes over. */
test_scene scene_of(EPGeometry geometry);
void free_scene(test_scene *s);

/* One ray or a packet of 4, 8 or 16 in Embree's layout, field f of lane i at f[f * n + i]. */
typedef struct test_packet {
    alignas(64) float f[EP_RTC_RAYHIT_FIELDS * EP_PACKET];
    alignas(64) int valid[EP_PACKET];
} test_packet;
enum { HIT_NG = EP_RAY_FIELDS, HIT_U = EP_RAY_FIELDS + 3, HIT_V, HIT_PRIM, HIT_GEOM, HIT_INST };

void set_ray(test_packet *p, unsigned n, unsigned lane, const float org[3], const float dir[3], float tnear,
             float tfar);
static inline float get_float(const test_packet *p, unsigned n, unsigned field, unsigned lane)
{
    return p->f[field * n + lane];
}
unsigned get_id(const test_packet *p, unsigned n, unsigned field, unsigned lane);

/* What a lane of a traced packet has hit, and whether two lanes have to the bit. */
judge_answer answer_of(const test_packet *p, unsigned n, unsigned lane);
bool same_answer(const judge_answer *a, const judge_answer *b);

/* One ray through rtcIntersect1. */
judge_answer trace_one(RTCScene scene, const float org[3], const float dir[3], float tnear, float tfar);

/* "org 1 2 3 dir 4 5 6", exact; overwritten by the fifth call after it. */
const char *ray_text(const float org[3], const float dir[3]);

/* The model of that name in the folder of models, as patches; `count` is their number. Fails the test otherwise. */
test_patch *read_model(const char *name, size_t *count);

#endif
