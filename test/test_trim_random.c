/* test_trim_random.c - see test_trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/test_trim.h"

#include <stdlib.h>
#include <string.h>

static double coordinate(rng *r, trim_style style, double lo, double hi)
{
    const double x = rng_in(r, lo, hi);
    return style.grid > 0 ? floor(x / style.grid + 0.5) * style.grid : x;
}

static void random_transform(rng *r, trim_shape *s, trim_style style)
{
    const bool primitive = s->kind >= SHAPE_SQUARE;
    s->transformed = primitive || rng_below(r, 3) == 0;
    if (!s->transformed) return;
    if (style.grid > 0) {
        /* a signed permutation, and a scale that keeps to the grid */
        const double f = primitive ? coordinate(r, style, 0.1, 0.6) : 1;
        const int turned = (int)rng_below(r, 2);
        s->transform[turned ? 1 : 0] = f * rng_sign(r);
        s->transform[turned ? 2 : 3] = f;
    } else {
        const double f = primitive ? rng_in(r, 0.05, 0.7) : rng_in(r, 0.7, 1.2), a = rng_in(r, 0, 6.3);
        const double shear = rng_in(r, -0.5, 0.5), g = f * rng_in(r, 0.3, 1);
        s->transform[0] = f * cos(a), s->transform[1] = f * sin(a);
        s->transform[2] = shear * f * cos(a) - g * sin(a), s->transform[3] = shear * f * sin(a) + g * cos(a);
    }
    if (primitive) s->transform[4] = coordinate(r, style, -0.2, 1.2), s->transform[5] = coordinate(r, style, -0.2, 1.2);
    else s->transform[4] = coordinate(r, style, -0.2, 0.2), s->transform[5] = coordinate(r, style, -0.2, 0.2);
}

static trim_segment *random_segment(rng *r, trim_style style)
{
    const segment_kind kind = (segment_kind)rng_below(r, 3);
    unsigned degree = 1, count = 2 + rng_below(r, style.most_degree);
    if (kind == SEGMENT_NURBS) {
        degree = 1 + rng_below(r, style.most_degree);
        count = degree + 1 + rng_below(r, RANDOM_POINTS - degree - 1);
    }
    trim_segment *g = segment_new(kind, degree, count);
    if (g->kind == SEGMENT_NURBS) {
        const bool clamped = rng_below(r, 3) > 0;
        const unsigned knots = count + degree + 1;
        for (unsigned i = 1; i < knots; ++i) {
            const bool end = i <= g->degree || i > g->count;
            const bool repeat = clamped && end ? true : rng_below(r, 4) == 0;
            g->knots[i] = g->knots[i - 1] + (repeat && i != g->count ? 0 : rng_in(r, 0.2, 1));
        }
        /* not more often than the degree inside */
        for (unsigned i = g->degree + 1; i < g->count; ++i)
            if (g->knots[i] == g->knots[i - g->degree])
                for (unsigned k = i; k < knots; ++k) g->knots[k] += 0.5;
    }
    for (unsigned i = 0; i < g->count; ++i) {
        g->points[i][0] = coordinate(r, style, -0.2, 1.2);
        g->points[i][1] = coordinate(r, style, -0.2, 1.2);
        const bool rational = g->kind != SEGMENT_LINE && style.most_weight > 1 && rng_below(r, 2);
        g->points[i][2] = rational ? rng_scale(r, 1 / style.most_weight, style.most_weight) : 1;
    }
    return g;
}

static trim_shape *random_contour(rng *r, trim_style style, bool only_polygon)
{
    static const shape_kind kinds[] = {SHAPE_SQUARE, SHAPE_CIRCLE, SHAPE_POLYGON, SHAPE_POLYGON, SHAPE_LOOPS};
    trim_shape *s = shape_new(only_polygon ? SHAPE_POLYGON : kinds[rng_below(r, 5)]);
    random_transform(r, s, style);
    if (s->kind == SHAPE_LOOPS) {
        const unsigned count = 1 + rng_below(r, 3);
        for (unsigned i = 0; i < count; ++i) shape_add(s, random_contour(r, style, true));
    } else if (s->kind == SHAPE_POLYGON) {
        const unsigned count = 1 + rng_below(r, 5);
        for (unsigned i = 0; i < count; ++i) {
            shape_add_segment(s, random_segment(r, style));
            if (i && rng_below(r, 4)) { /* mostly no gaps */
                const trim_segment *last = s->segment[i - 1];
                memcpy(s->segment[i]->points[0], last->points[last->count - 1], 2 * sizeof(double));
            }
        }
    }
    return s;
}

trim_shape *random_shape(rng *r, unsigned depth, trim_style style)
{
    if (depth == 0) return random_contour(r, style, false);
    trim_shape *s = shape_new((shape_kind)rng_below(r, 3));
    random_transform(r, s, style);
    const unsigned count = s->kind == SHAPE_DIFFERENCE ? 2 : 1 + rng_below(r, 3);
    for (unsigned i = 0; i < count; ++i) shape_add(s, random_shape(r, i ? rng_below(r, depth) : depth - 1, style));
    return s;
}

static EPStatus build_segment(ep_region *region, const trim_segment *g, ep_message *m)
{
    if (g->kind == SEGMENT_BEZIER) return ep_region_bezier(region, g->count, g->points, m);
    if (g->kind == SEGMENT_NURBS)
        return ep_region_nurbs(region, g->degree, g->count + g->degree + 1, g->knots, g->count, g->points, m);
    double line[RANDOM_POINTS][2];
    for (size_t i = 0; i < g->count; ++i) memcpy(line[i], g->points[i], sizeof line[i]);
    return ep_region_line(region, g->count, line, m);
}

EPStatus build_shape(ep_region *region, const trim_shape *s, ep_message *m)
{
    static const ep_region_kind kinds[] = {EP_REGION_UNION, EP_REGION_INTERSECTION, EP_REGION_DIFFERENCE,
                                           EP_REGION_LOOPS, EP_REGION_POLYGON};
    const double *t = s->transformed ? s->transform : NULL;
    if (s->kind == SHAPE_SQUARE) return ep_region_square(region, t, m);
    if (s->kind == SHAPE_CIRCLE) return ep_region_circle(region, t, m);
    EPStatus status = ep_region_begin(region, kinds[s->kind], t, m);
    for (size_t i = 0; i < s->count && !status; ++i)
        status =
            s->kind == SHAPE_POLYGON ? build_segment(region, s->segment[i], m) : build_shape(region, s->child[i], m);
    return status ? status : ep_region_end(region, m);
}

ep_trim *new_trim(trim_shape *s)
{
    ep_message m;
    ep_region *region = ep_region_new();
    ep_trim *trim = NULL;
    if (build_shape(region, s, &m) || ep_trim_new(region, &trim, &m)) FAIL("%s", m.text);
    ep_region_free(region);
    assert_true(shape_prepare(s));
    return trim;
}
