/* test_cage.c - do cages become the surfaces that their rules define?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Judged by a reference that subdivides whole meshes. */
#include "test/cages.h"

#include <stdlib.h>
#include <string.h>

/* The surface at a corner, and how far it is from the limit of the vertex there. */
static double corner_error(const subject *s, const ref_mesh *m, unsigned c, double off[3], double du[3], double dv[3])
{
    double want[3], got[3];
    ref_limit(m, m->vertex[c], want);
    CHECK(epEvaluate(s->g, m->cage_face[m->face[c]], m->place[c][0], m->place[c][1], got, du, dv, NULL) == EP_OK,
          "%s: %s", s->name, epGetGeometryMessage(s->g));
    for (int x = 0; x < 3; ++x) off[x] = want[x] - got[x];
    return sqrt(dot(off, off));
}

/* Along the edge that begins at the corner. Gregory patches have tangents that are not quite the limit's. */
static void check_tangent(const subject *s, const ref_mesh *m, unsigned c, const double du[3], const double dv[3])
{
    double want[3], got[3], turned[3];
    const double *from = m->place[c], *to = m->place[ref_next(m, c)];
    if (!ref_tangent(m, c, want)) return;
    for (int x = 0; x < 3; ++x) got[x] = (to[0] - from[0]) * du[x] + (to[1] - from[1]) * dv[x];
    cross(want, got, turned);
    const double lw = sqrt(dot(want, want)), lg = sqrt(dot(got, got)), sine = sqrt(dot(turned, turned)) / lw / lg;
    const unsigned valence = ref_valence(m, m->vertex[c]);
    const bool regular = valence == (m->loop ? 6 : 4);
    CHECK(sine < (regular ? 1e-11 : 1e-4) && dot(want, got) > 0, "%s: valence %u, turned by %g", s->name, valence,
          sine);
    CHECK(!regular || fabs(lg - lw) < 1e-12, "%s: derivative %g, not %g", s->name, lg, lw);
}

/* Holes, and they alone, have no patches. */
static void check_holes(const subject *s, const ref_mesh *m)
{
    bool has[REF_FACES] = {false};
    for (size_t i = 0; i < s->patches->chart_count; ++i) has[s->patches->charts[i].face] = true;
    for (unsigned f = 0; f < m->face_count; ++f)
        CHECK(has[m->cage_face[f]] == !m->hole[f], "%s: face %u", s->name, m->cage_face[f]);
}

/* Every sharpness that ends has ended after four levels, and the faces are larger than what is approximated. The tip of
 * a crease is: OpenSubdiv takes a smooth point's mask there, which the crease makes wrong by about 2^-level. */
static void limits(void **state)
{
    (void)state;
    for (const cage_case *k = cages; k < cages + CAGES; ++k) {
        subject s = new_subject(k, 1, true);
        ref_mesh *m = refined(&s.cage, 4);
        check_holes(&s, m);
        for (unsigned c = 0; c < m->corner_count; ++c) {
            double off[3], du[3], dv[3];
            if (m->hole[m->face[c]]) continue;
            const double is = corner_error(&s, m, c, off, du, dv);
            CHECK(is < (ref_rule_of(m, m->vertex[c]) == REF_DART ? 1e-4 : 1e-13), "%s: face %u at %g, %g is off by %g",
                  s.name, m->cage_face[m->face[c]], m->place[c][0], m->place[c][1], is);
            check_tangent(&s, m, c, du, dv);
        }
        ref_free(m);
        free_subject(&s);
    }
}

/* Where Gregory patches are: after ten levels. They are near the surface, not so near to the point at u, v. Their worst
 * are tips of cones (smooth but for a sharp point) and a valence so high that a level hardly makes faces smaller. */
static void check_around(const subject *s, const ref_mesh *m)
{
    const bool cone = ref_rule_of(m, 0) == REF_CORNER || ref_valence(m, 0) > 8;
    for (unsigned c = 0; c < m->corner_count; ++c) {
        double off[3], du[3], dv[3], n[3];
        const unsigned f = m->face[c];
        bool near = false;
        for (unsigned i = m->first[f]; i < m->first[f + 1]; ++i) near = near || !m->vertex[i];
        if (!near || m->hole[f]) continue;
        const double is = corner_error(s, m, c, off, du, dv);
        cross(du, dv, n);
        const double away = dot(n, n) > 0 ? fabs(dot(n, off)) / sqrt(dot(n, n)) : is; /* 0: a border's rounded corner */
        CHECK(is < 5e-3 && away < (cone ? 1e-4 : 3e-6), "%s: face %u at %g, %g is off by %g, %g from the surface",
              s->name, m->cage_face[f], m->place[c][0], m->place[c][1], is, away);
    }
}

static void limits_nearby(void **state)
{
    (void)state;
    for (const cage_case *k = cages; k < cages + CAGES; ++k) {
        subject s = new_subject(k, 1, true);
        ref_mesh *m = refined(&s.cage, 1);
        for (unsigned v = 0; v < m->vertex_count; ++v) {
            ref_mesh *part = ref_around(m, v);
            for (int level = 2; level <= 14; ++level) {
                part = ref_zoom(part);
                if (level > 10) check_around(&s, part);
            }
            ref_free(part);
        }
        ref_free(m);
        free_subject(&s);
    }
}

/* All points that patches of a face have at u, v, behind those that are there. */
static unsigned points_at(const scene_geometry *g, uint32_t face, double u, double v, double (*p)[4], unsigned count)
{
    for (size_t i = 0; i < g->chart_count; ++i) {
        const chart *c = &g->charts[i];
        for (size_t k = c->face == face ? c->first : c->first + c->count; k < c->first + c->count; ++k) {
            const double *m = g->places[k], det = m[0] * m[3] - m[1] * m[2], x = u - m[4], y = v - m[5];
            const double a = (m[3] * x - m[2] * y) / det, b = (m[0] * y - m[1] * x) / det;
            const bool triangle = c->kind == PATCH_TRIANGLE;
            net_point pu, pv;
            if (fmin(a, b) < -1e-9 || (triangle ? a + b : fmax(a, b)) > 1 + 1e-9) continue;
            assert_true(count < 64);
            net_evaluate((net_shape){triangle, triangle ? 4 : 3, triangle ? 4 : 3},
                         (const net_point *)g->points + g->patches[k].first, a, b, p[count++], pu, pv);
        }
    }
    return count;
}

static void check_equal(const subject *s, const double (*p)[4], unsigned count)
{
    for (unsigned i = 1; i < count; ++i)
        for (int x = 0; x < 3; ++x)
            CHECK(fabs(p[i][x] - p[0][x]) < 1e-13, "%s: %g from one patch to the next", s->name, p[i][x] - p[0][x]);
}

/* Where along an edge to look: at all ends of patches, and between. */
static const double stations[] = {0,    1e-5, 0.0004, 0x1p-10, 0.0013, 0x1p-8, 0.03, 0.125,
                                  0.25, 0.37, 0.5,    0.75,    0.9375, 0.9999, 1};

/* Between faces: along the edges of the cage and of what polygons are divided into. */
static unsigned check_face_edges(const subject *s)
{
    unsigned met = 0;
    ref_mesh *m = refined(&s->cage, 1);
    for (unsigned e = 0; e < m->edge_count; ++e) {
        const ref_edge *edge = &m->edges[e];
        for (unsigned k = 0; k < EP_ARRAY_LEN(stations); ++k) {
            double p[64][4];
            unsigned count = 0;
            for (unsigned i = 0; i < edge->face_count; ++i) {
                const unsigned c = edge->corner[i], to = ref_next(m, c);
                const double x = m->vertex[c] == edge->vertex[0] ? stations[k] : 1 - stations[k];
                count = points_at(s->patches, m->cage_face[m->face[c]], (1 - x) * m->place[c][0] + x * m->place[to][0],
                                  (1 - x) * m->place[c][1] + x * m->place[to][1], p, count);
            }
            check_equal(s, p, count);
            met += count > 1;
        }
    }
    ref_free(m);
    return met;
}

/* Within a face: along the sides of its patches. */
static unsigned check_patch_edges(const subject *s)
{
    static const double corners[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}},
                        three[4][2] = {{0, 0}, {1, 0}, {0, 1}, {0, 0}};
    unsigned met = 0;
    const scene_geometry *g = s->patches;
    for (size_t i = 0; i < g->chart_count; ++i)
        for (size_t k = g->charts[i].first; k < g->charts[i].first + g->charts[i].count; ++k)
            for (int side = 0; side < (s->cage.loop ? 3 : 4); ++side)
                for (int x = 0; x <= 4; ++x) {
                    const double *a = s->cage.loop ? three[side] : corners[side], *b = a + 2, *m = g->places[k];
                    const double at[2] = {a[0] + (b[0] - a[0]) * x / 4, a[1] + (b[1] - a[1]) * x / 4};
                    double p[64][4];
                    const unsigned count = points_at(g, g->charts[i].face, m[0] * at[0] + m[2] * at[1] + m[4],
                                                     m[1] * at[0] + m[3] * at[1] + m[5], p, 0);
                    check_equal(s, p, count);
                    met += count > 1;
                }
    return met;
}

static void continuity(void **state)
{
    (void)state;
    for (const cage_case *k = cages; k < cages + CAGES; ++k) {
        subject s = new_subject(k, 2, true);
        const unsigned between = check_face_edges(&s), within = check_patch_edges(&s);
        CHECK(between > 10 && (within > 10 || s.patches->patch_count == s.patches->chart_count), "%s: %u, %u", s.name,
              between, within);
        free_subject(&s);
    }
}

/* The same cage seen from behind: first corners stay, and the others come the other way round. */
static ref_cage reversed(const ref_cage *c)
{
    ref_cage r = *c;
    for (unsigned f = 0, first = 0; f < c->face_count; first += c->sizes[f++])
        for (unsigned i = 1; i < c->sizes[f]; ++i) r.corners[first + i] = c->corners[first + c->sizes[f] - i];
    return r;
}

/* Of a chart, the one that is the same part of the cage seen from behind: in a polygon the first stays, too. */
static const chart *chart_behind(const subject *s, const subject *behind, size_t i)
{
    const chart *all = s->patches->charts;
    size_t first = i, end = i + 1;
    while (first && all[first - 1].face == all[i].face) --first;
    while (end < s->patches->chart_count && all[end].face == all[i].face) ++end;
    return &behind->patches->charts[i == first ? i : first + end - i];
}

/* That is the same surface with u and v exchanged, in what is approximated, too. Points are near all corners. */
static void from_behind(void **state)
{
    (void)state;
    for (const cage_case *k = cages; k < cages + CAGES; ++k) {
        subject s = new_subject(k, 2, true);
        const ref_cage turned = reversed(&s.cage);
        subject behind = subject_of(k->name, &turned, CAGE_LEVEL_DEFAULT, true);
        assert_int_equal(s.patches->chart_count, behind.patches->chart_count);
        for (size_t i = 0; i < s.patches->chart_count; ++i) {
            const chart *c = &s.patches->charts[i], *d = chart_behind(&s, &behind, i);
            const bool square = c->kind == PATCH_TENSOR;
            for (unsigned n = 0; n < 40; ++n) {
                rng r = rng_split(3, i, n);
                double p[3], q[3], u, v, x = rng_scale(&r, 1e-5, 0.5), y = x * rng_unit(&r);
                if (rng_below(&r, 2) && square) x = 1 - x;
                if (rng_below(&r, 2)) y = (square ? 1 : 1 - x) - y;
                chart_place(c, x, y, &u, &v);
                assert_int_equal(epEvaluate(s.g, c->face, u, v, p, NULL, NULL, NULL), EP_OK);
                chart_place(d, y, x, &u, &v);
                assert_int_equal(epEvaluate(behind.g, d->face, u, v, q, NULL, NULL, NULL), EP_OK);
                for (int a = 0; a < 3; ++a)
                    CHECK(fabs(p[a] - q[a]) < 1e-13, "%s: face %u at %g, %g of a chart: %g", s.name, c->face, x, y,
                          p[a] - q[a]);
            }
        }
        free_subject(&behind);
        free_subject(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits),
        cmocka_unit_test(limits_nearby),
        cmocka_unit_test(continuity),
        cmocka_unit_test(from_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
