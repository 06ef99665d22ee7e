/* test_trim_split.c - hierarchies that follow the curves: nothing lost, nothing wrong, little left to test.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/test_trim.h"
#include "trim/split.h"

#include <stdlib.h>
#include <string.h>

/* A seam of a few roundings of float: curves along a leaf's border do not cross it. */
static const double seam = -0x1p-22;

typedef struct walk {
    const trim_shape *shape;
    const ep_trim *trim;
    unsigned number;
    double smallest; /* crossed domains of this area are leaves */
    rng r;
    ep_trim_store store;
    double area[3]; /* of leaves in each state */
    size_t leaves[3];
} walk;

static double area_of(const ep_trim_domain *d)
{
    double sum = 0;
    for (unsigned i = 1; i + 1 < d->count; ++i)
        sum += (d->corner[i][0] - d->corner[0][0]) * (d->corner[i + 1][1] - d->corner[0][1]) -
               (d->corner[i][1] - d->corner[0][1]) * (d->corner[i + 1][0] - d->corner[0][0]);
    return 0.5 * sum;
}

static void check_leaf(walk *w, const ep_trim_domain *d, const ep_trim_part *part)
{
    ep_message m;
    uint32_t node = 0;
    if (part->state == EP_TRIM_CROSSED && ep_trim_keep(w->trim, part, d, &w->store, &node, &m)) FAIL("%s", m.text);
    for (int k = 0; k < 4; ++k) {
        double x = 0, y = 0, sum = 0;
        for (unsigned i = 0; i < d->count; ++i) {
            const double f = k ? rng_unit(&w->r) : i == w->leaves[0] % d->count;
            sum += f, x += f * d->corner[i][0], y += f * d->corner[i][1];
        }
        /* hits may lie a little outside of their leaf */
        const float u = (float)(x / sum + rng_in(&w->r, seam, -seam)),
                    v = (float)(y / sum + rng_in(&w->r, seam, -seam));
        const bool got = part->state == EP_TRIM_CROSSED ? ep_trim_inside(w->trim, w->store.words, node, 1, &u, &v, 1)
                                                        : part->state == EP_TRIM_INSIDE;
        if (got != ep_trim_has_point(w->trim, u, v) && shape_at(w->shape, u, v, 2e-5) != SHAPE_NEAR)
            FAIL("case %u: (%.9g, %.9g) is %d in a leaf of state %d", w->number, u, v, got, part->state);
    }
    w->area[part->state] += area_of(d);
    ++w->leaves[part->state];
}

static void walk_triangle(walk *w, const ep_point2 t[3], const ep_trim_part *parent, int depth)
{
    ep_message m;
    ep_trim_part part;
    const ep_trim_domain d = ep_domain_polygon(3, t, seam);
    if (ep_trim_cut(w->trim, parent, &d, &part, &m)) FAIL("%s", m.text);
    if (part.state != EP_TRIM_CROSSED || area_of(&d) <= w->smallest) {
        check_leaf(w, &d, &part);
    } else {
        CHECK(depth < 40, "case %u", w->number);
        ep_trim_triangles s;
        ep_trim_split_triangle(w->trim, &part, t, 0.04, &s);
        double sum = 0;
        for (unsigned i = 0; i < s.count; ++i) {
            const ep_trim_domain k = ep_domain_polygon(3, s.corner[i], 0);
            sum += area_of(&k);
            walk_triangle(w, s.corner[i], &part, depth + 1);
        }
        CHECK(fabs(sum - area_of(&d)) <= 1e-12, "case %u: %g of %g", w->number, sum, area_of(&d));
    }
    ep_trim_part_free(&part);
}

static void walk_rectangle(walk *w, const ep_point2 lo, const ep_point2 hi, const ep_trim_part *parent, int depth)
{
    ep_message m;
    ep_trim_part part;
    const ep_trim_domain d = ep_domain_rectangle(lo[0], hi[0], lo[1], hi[1], seam);
    if (ep_trim_cut(w->trim, parent, &d, &part, &m)) FAIL("%s", m.text);
    if (part.state != EP_TRIM_CROSSED || area_of(&d) <= w->smallest) {
        check_leaf(w, &d, &part);
    } else {
        CHECK(depth < 60, "case %u", w->number);
        int axis;
        double at;
        ep_trim_split_rectangle(w->trim, &part, lo, hi, 0.04, &axis, &at);
        CHECK(at > lo[axis] && at < hi[axis], "case %u", w->number);
        const ep_point2 left = {axis ? hi[0] : at, axis ? at : hi[1]}, right = {axis ? lo[0] : at, axis ? at : lo[1]};
        walk_rectangle(w, lo, left, &part, depth + 1);
        walk_rectangle(w, right, hi, &part, depth + 1);
    }
    ep_trim_part_free(&part);
}

static walk walk_shape(trim_shape *s, unsigned number, bool triangle, double smallest)
{
    ep_trim *trim = new_trim(s);
    walk w = {.shape = s, .trim = trim, .number = number, .smallest = smallest, .r = rng_split(7, 1, number)};
    static const ep_point2 corner[3] = {{0, 0}, {1, 0}, {0, 1}}, end = {1, 1};
    if (triangle) walk_triangle(&w, corner, &trim->root, 0);
    else walk_rectangle(&w, corner[0], end, &trim->root, 0);
    const double all = w.area[0] + w.area[1] + w.area[2];
    CHECK(fabs(all - (triangle ? 0.5 : 1)) < 1e-9, "case %u: %.17g", number, all);
    ep_free(w.store.words);
    ep_trim_free(trim);
    shape_free(s);
    return w;
}

static void random_regions(void **state)
{
    (void)state;
    static const trim_style styles[] = {{0, 1, 3}, {0.125, 4, 3}};
    for (unsigned k = 0; k < 250; ++k) {
        rng r = rng_split(7, 0, k);
        walk_shape(random_shape(&r, k % 5, styles[k / 2 % 2]), k, k & 1, 0x1p-12);
    }
}

static trim_shape *square_without(shape_kind kind, const double transform[6])
{
    trim_shape *s = shape_new(SHAPE_DIFFERENCE), *hole = shape_new(kind);
    hole->transformed = true;
    memcpy(hole->transform, transform, sizeof hole->transform);
    assert_true(shape_add(s, shape_new(SHAPE_SQUARE)) && shape_add(s, hole));
    return s;
}

/* Straight edges become edges of leaves, and the border of the domain is not in it. */
static void straight_edges(void **state)
{
    (void)state;
    const double turned[6] = {0.3, 0.1, -0.15, 0.2, 0.3, 0.2};
    trim_shape *s = square_without(SHAPE_SQUARE, turned);
    const walk w = walk_shape(s, 0, true, 0x1p-13);
    print_message("square hole: %zu inside, %zu outside, %zu crossed of %.2g %%\n", w.leaves[EP_TRIM_INSIDE],
                  w.leaves[EP_TRIM_OUTSIDE], w.leaves[EP_TRIM_CROSSED], 200 * w.area[EP_TRIM_CROSSED]);
    CHECK(w.leaves[EP_TRIM_CROSSED] <= 16 && w.area[EP_TRIM_CROSSED] < 0.0005, "%zu", w.leaves[EP_TRIM_CROSSED]);
}

static trim_shape *polygon_of(unsigned count, const double (*corners)[2])
{
    trim_shape *s = shape_new(SHAPE_POLYGON);
    trim_segment *g = segment_new(SEGMENT_LINE, 1, count);
    assert_true(shape_add_segment(s, g));
    for (unsigned i = 0; i < count; ++i) g->points[i][0] = corners[i][0], g->points[i][1] = corners[i][1];
    return s;
}

/* An edge through a corner: two leaves. */
static void through_a_corner(void **state)
{
    (void)state;
    const double corners[3][2] = {{0, 0}, {1, 1}, {-1, 2}};
    const walk w = walk_shape(polygon_of(3, corners), 0, true, 0x1p-13);
    assert_int_equal(w.leaves[EP_TRIM_INSIDE], 1);
    assert_int_equal(w.leaves[EP_TRIM_OUTSIDE], 1);
    assert_int_equal(w.leaves[EP_TRIM_CROSSED], 0);
}

/* A domain no wider than the seam is still crossed by what goes across it. */
static void narrow_domains(void **state)
{
    (void)state;
    const double corners[4][2] = {{-1, -1}, {0.5, -1}, {0.5, 2}, {-1, 2}};
    trim_shape *s = polygon_of(4, corners);
    ep_trim *trim = new_trim(s);
    ep_message m;
    for (double height = 1; height > 1e-12; height *= 0.1) {
        const ep_trim_domain d = ep_domain_rectangle(0, 1, 0, height, seam);
        ep_trim_part part;
        assert_int_equal(ep_trim_cut(trim, &trim->root, &d, &part, &m), EP_OK);
        assert_int_equal(part.state, EP_TRIM_CROSSED);
        ep_trim_part_free(&part);
    }
    ep_trim_free(trim);
    shape_free(s);
}

static void curved_edges(void **state)
{
    (void)state;
    for (int triangle = 0; triangle < 2; ++triangle) {
        const double placed[6] = {0.2, 0, 0, 0.2, 0.35, 0.3};
        trim_shape *s = square_without(SHAPE_CIRCLE, placed);
        const walk w = walk_shape(s, 0, triangle, 0x1p-13);
        const double crossed = w.area[EP_TRIM_CROSSED] / (triangle ? 0.5 : 1);
        print_message("round hole: %zu inside, %zu outside, %zu crossed of %.2g %%\n", w.leaves[EP_TRIM_INSIDE],
                      w.leaves[EP_TRIM_OUTSIDE], w.leaves[EP_TRIM_CROSSED], 100 * crossed);
        CHECK(crossed < 0.02, "%g", crossed);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_regions), cmocka_unit_test(straight_edges), cmocka_unit_test(through_a_corner),
        cmocka_unit_test(narrow_domains), cmocka_unit_test(curved_edges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
