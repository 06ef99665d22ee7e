/* support.c - see support.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"
#include "tools/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *style_name(patch_style style)
{
    static const char *const names[STYLES] = {"gentle", "wild", "flat", "collapsed", "degenerate"};
    return names[style];
}

/* Three random directions at right angles. */
static void random_axes(rng *r, double x[3], double y[3], double z[3])
{
    double d;
    do {
        rng_direction(r, x);
        rng_direction(r, y);
        d = x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    } while (fabs(d) > 0.9);
    double length = 0;
    for (int c = 0; c < 3; ++c) {
        y[c] -= d * x[c];
        length += y[c] * y[c];
    }
    for (int c = 0; c < 3; ++c) y[c] /= sqrt(length);
    for (int c = 0; c < 3; ++c) z[c] = x[(c + 1) % 3] * y[(c + 2) % 3] - x[(c + 2) % 3] * y[(c + 1) % 3];
}

static void copy_point(test_patch *p, unsigned i, unsigned j, const double from[3])
{
    memcpy(p->points[net_index(p->shape, i, j)], from, 3 * sizeof *from);
}

/* Takes away what makes a patch a surface, everywhere or at a border. */
static void degenerate(rng *r, test_patch *p)
{
    const net_shape s = p->shape;
    const unsigned how = rng_below(r, 6);
    double a[3], b[3];
    memcpy(a, p->points[0], sizeof a);
    memcpy(b, p->points[net_index(s, s.m, 0)], sizeof b);
    for (unsigned j = 0; j <= s.n; ++j)
        for (unsigned i = 0; net_has(s, i, j); ++i) {
            double *to = p->points[net_index(s, i, j)];
            switch (how) {
            case 0: /* a segment */
                for (int c = 0; c < 3; ++c) to[c] = a[c] + (b[c] - a[c]) * i / s.m;
                break;
            case 1: /* a segment, there and back */
                for (int c = 0; c < 3; ++c) to[c] = a[c] + (b[c] - a[c]) * (i + 2.0 * j) / s.m;
                break;
            case 2: copy_point(p, i, j, a); break; /* a point */
            case 3:                                /* no derivative at a corner */
                if (i + j <= 1) copy_point(p, i, j, a);
                break;
            case 4: /* two rows of points are one: no derivative across a side */
                if (j == 1 && net_has(s, i, 1)) copy_point(p, i, 1, p->points[net_index(s, i, 0)]);
                break;
            default: /* three sides of a tensor patch, or two of a triangle, are points */
                if (i == 0 || (j == 0 && i < s.m)) copy_point(p, i, j, a);
                if (!s.triangle && i == s.m) copy_point(p, i, j, b);
            }
        }
}

void random_patch(rng *r, patch_style style, bool triangle, patch_limits limits, test_patch *p)
{
    const unsigned m = 1 + rng_below(r, limits.most_degree);
    const unsigned n = triangle ? m : 1 + rng_below(r, limits.most_degree);
    p->shape = (net_shape){triangle, m, n};
    const double noise = style == STYLE_WILD ? 0.7 : style == STYLE_FLAT ? 0 : rng_in(r, 0.02, 0.3);
    const double lift = style == STYLE_FLAT && rng_below(r, 2) ? rng_scale(r, 1e-7, 1e-3) : noise;
    double x[3], y[3], z[3];
    random_axes(r, x, y, z);
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; net_has(p->shape, i, j); ++i) {
            double *to = p->points[net_index(p->shape, i, j)];
            const double a = i / (double)m + rng_in(r, -noise, noise) / m;
            const double b = style == STYLE_COLLAPSED && i == 0 ? 0 : j / (double)n + rng_in(r, -noise, noise) / n;
            const double h = style == STYLE_COLLAPSED && i == 0 ? 0 : rng_in(r, -lift, lift);
            for (int c = 0; c < 3; ++c)
                to[c] = (style == STYLE_COLLAPSED && i == 0 ? 0 : a * x[c]) + b * y[c] + h * z[c];
            to[3] = limits.most_weight > 1 ? rng_scale(r, 1 / limits.most_weight, limits.most_weight) : 1;
        }
    if (style == STYLE_DEGENERATE) degenerate(r, p);
    /* half of them with a corner at the origin, where rounding is large compared with the coordinate */
    if (rng_below(r, 2)) {
        const double first[3] = {-p->points[0][0], -p->points[0][1], -p->points[0][2]};
        move_patch(p, 1, first);
    }
}

void move_patch(test_patch *p, double scale, const double offset[3])
{
    for (size_t k = 0; k < net_count(p->shape); ++k)
        for (int c = 0; c < 3; ++c) p->points[k][c] = scale * p->points[k][c] + offset[c];
}

void evaluate_patch(const test_patch *p, double u, double v, double x[3], double xu[3], double xv[3])
{
    net_point net[NET_POINTS], h, hu, hv;
    for (size_t k = 0; k < net_count(p->shape); ++k)
        for (int c = 0; c < 4; ++c) net[k][c] = p->points[k][3] * (c < 3 ? p->points[k][c] : 1);
    net_evaluate(p->shape, net, u, v, h, hu, hv);
    for (int c = 0; c < 3; ++c) {
        x[c] = h[c] / h[3];
        xu[c] = (hu[c] - hu[3] * x[c]) / h[3];
        xv[c] = (hv[c] - hv[3] * x[c]) / h[3];
    }
}

static EPStatus add_patch(EPGeometry g, const test_patch *p)
{
    const size_t stride = sizeof p->points[0];
    return p->shape.triangle ? epAddBezierTriangles(g, p->shape.n, 1, EP_FORMAT_DOUBLE4, p->points, stride)
                             : epAddBezierPatches(g, p->shape.m, p->shape.n, 1, EP_FORMAT_DOUBLE4, p->points, stride);
}

EPGeometry new_geometry(const test_patch *patches, size_t count, const EPBuildSettings *settings)
{
    EPGeometry g = epNewGeometry();
    assert_non_null(g);
    if (settings) CHECK(epSetGeometryBuildSettings(g, settings) == EP_OK, "%s", epGetGeometryMessage(g));
    for (size_t i = 0; i < count; ++i) CHECK(add_patch(g, &patches[i]) == EP_OK, "%s", epGetGeometryMessage(g));
    CHECK(epCommitGeometry(g) == EP_OK, "%s", epGetGeometryMessage(g));
    return g;
}

oracle *new_oracle(const test_patch *patches, size_t count)
{
    oracle_patch *in = malloc((count + 1) * sizeof *in);
    assert_non_null(in);
    for (size_t i = 0; i < count; ++i) {
        const net_shape s = patches[i].shape;
        in[i] = (oracle_patch){s.triangle, s.m, s.n, patches[i].points[0]};
    }
    oracle *o = oracle_new(in, count);
    free(in);
    assert_non_null(o);
    return o;
}

test_scene scene_of(EPGeometry geometry)
{
    test_scene s = {.device = rtcNewDevice("threads=1"), .geometry = geometry};
    assert_non_null(s.device);
    s.scene = rtcNewScene(s.device);
    RTCGeometry g = epNewRTCGeometry(s.geometry, s.device);
    CHECK(g, "%s", epGetGeometryMessage(s.geometry));
    rtcAttachGeometry(s.scene, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(s.scene);
    return s;
}

test_scene new_scene(const test_patch *patches, size_t count, const EPBuildSettings *settings)
{
    return scene_of(new_geometry(patches, count, settings));
}

void free_scene(test_scene *s)
{
    rtcReleaseScene(s->scene);
    epReleaseGeometry(s->geometry);
    rtcReleaseDevice(s->device);
}

static void put_id(test_packet *p, unsigned n, unsigned field, unsigned lane, unsigned value)
{
    memcpy(&p->f[field * n + lane], &value, sizeof value);
}

unsigned get_id(const test_packet *p, unsigned n, unsigned field, unsigned lane)
{
    unsigned value;
    memcpy(&value, &p->f[field * n + lane], sizeof value);
    return value;
}

void set_ray(test_packet *p, unsigned n, unsigned lane, const float org[3], const float dir[3], float tnear, float tfar)
{
    for (unsigned c = 0; c < 3; ++c) {
        p->f[(EP_RAY_ORG + c) * n + lane] = org[c];
        p->f[(EP_RAY_DIR + c) * n + lane] = dir[c];
    }
    p->f[EP_RAY_TNEAR * n + lane] = tnear;
    p->f[EP_RAY_TFAR * n + lane] = tfar;
    p->f[7 * n + lane] = 0; /* time */
    put_id(p, n, 9, lane, ~0u);
    put_id(p, n, 10, lane, lane);
    put_id(p, n, 11, lane, 0);
    put_id(p, n, HIT_GEOM, lane, RTC_INVALID_GEOMETRY_ID);
    put_id(p, n, HIT_INST, lane, RTC_INVALID_GEOMETRY_ID);
    p->valid[lane] = -1;
}

judge_answer answer_of(const test_packet *p, unsigned n, unsigned lane)
{
    if (get_id(p, n, HIT_GEOM, lane) == RTC_INVALID_GEOMETRY_ID) return (judge_answer){.t = INFINITY, .patch = ~0u};
    return (judge_answer){.t = get_float(p, n, EP_RAY_TFAR, lane),
                          .u = get_float(p, n, HIT_U, lane),
                          .v = get_float(p, n, HIT_V, lane),
                          .patch = get_id(p, n, HIT_PRIM, lane),
                          .normal = {get_float(p, n, HIT_NG, lane), get_float(p, n, HIT_NG + 1, lane),
                                     get_float(p, n, HIT_NG + 2, lane)}};
}

bool same_answer(const judge_answer *a, const judge_answer *b)
{
    return a->t == b->t && a->u == b->u && a->v == b->v && a->patch == b->patch &&
           !memcmp(a->normal, b->normal, sizeof a->normal);
}

judge_answer trace_one(RTCScene scene, const float org[3], const float dir[3], float tnear, float tfar)
{
    test_packet p;
    set_ray(&p, 1, 0, org, dir, tnear, tfar);
    ep_rtc_intersect(scene, 1, p.valid, p.f, false);
    return answer_of(&p, 1, 0);
}

const char *ray_text(const float org[3], const float dir[3])
{
    static char text[5][160];
    static unsigned next;
    char *t = text[next++ % 5];
    snprintf(t, sizeof text[0], "org %.9g %.9g %.9g dir %.9g %.9g %.9g", org[0], org[1], org[2], dir[0], dir[1],
             dir[2]);
    return t;
}

test_patch *read_model(const char *name, size_t *count)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", EP_DATA, name);
    scene *s = scene_read(path);
    CHECK(s, "cannot read %s", path);
    const scene_geometry *g = s->geometries;
    test_patch *patches = calloc(g->patch_count, sizeof *patches);
    assert_non_null(patches);
    *count = g->patch_count;
    for (size_t i = 0; i < g->patch_count; ++i) {
        const patch *p = &g->patches[i];
        patches[i].shape = (net_shape){p->kind == PATCH_TRIANGLE, p->degree_u, p->degree_v};
        memcpy(patches[i].points, g->points + 4 * p->first, net_count(patches[i].shape) * sizeof patches[i].points[0]);
    }
    scene_free(s);
    return patches;
}
