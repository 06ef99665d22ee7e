/* knots.c - see knots.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/knots.h"

#include <string.h>

EPStatus ep_knots_check(unsigned degree, size_t knot_count, const double *knots, size_t count, unsigned most,
                        ep_message *m)
{
    if (degree < 1 || degree > EP_MAX_DEGREE)
        return ep_fail(m, EP_BAD_DATA, "degree %u is not between 1 and %d", degree, EP_MAX_DEGREE);
    if (count < degree + 1)
        return ep_fail(m, EP_BAD_DATA, "a curve of degree %u needs %u points, not %zu", degree, degree + 1, count);
    if (count > SIZE_MAX / 2 || knot_count != count + degree + 1)
        return ep_fail(m, EP_BAD_DATA, "%zu points of degree %u go with %zu knots, not %zu", count, degree,
                       count + degree + 1, knot_count);
    for (size_t i = 0; i < knot_count; ++i) {
        if (!(fabs(knots[i]) < 0x1p1000))
            return ep_fail(m, EP_BAD_DATA, "knot %zu is %g, not a number below 1e301", i + 1, knots[i]);
        if (i && knots[i] < knots[i - 1])
            return ep_fail(m, EP_BAD_DATA, "knot %zu is %g, below the one before it, %g", i + 1, knots[i],
                           knots[i - 1]);
        if (i >= most && knots[i] == knots[i - most] && knots[degree] < knots[i] && knots[i] < knots[count])
            return ep_fail(m, EP_BAD_DATA, "knot %g repeats more than %u times, the degree%s", knots[i], most,
                           most > degree ? " and one" : "");
    }
    if (!(knots[degree] < knots[count]))
        return ep_fail(m, EP_BAD_DATA, "knots %u to %zu are all %g: the curve has no extent", degree + 1, count + 1,
                       knots[degree]);
    return EP_OK;
}

size_t ep_knots_next_span(const double *knots, size_t count, size_t i)
{
    while (i < count && !(knots[i] < knots[i + 1])) ++i;
    return i;
}

/* Point j of the Bézier curve is the spline's blossom at knots[i], p-j times, and knots[i+1], j times [Ramshaw 1989].
 * Both lie in every interval that de Boor's algorithm interpolates over, so the combinations are convex. */
void ep_knots_bezier(const double *points, unsigned numbers, size_t stride, unsigned p, const double *knots, size_t i,
                     double *out, size_t out_stride)
{
    for (unsigned j = 0; j <= p; ++j) {
        double d[EP_MAX_DEGREE + 1][EP_KNOTS_NUMBERS];
        for (unsigned k = 0; k <= p; ++k) memcpy(d[k], points + (i - p + k) * stride, numbers * sizeof(double));
        for (unsigned r = 1; r <= p; ++r) {
            const double at = r <= p - j ? knots[i] : knots[i + 1];
            for (unsigned k = p; k >= r; --k) {
                const double lo = knots[i - p + k], hi = knots[i + 1 + k - r], t = (at - lo) / (hi - lo);
                for (unsigned c = 0; c < numbers; ++c) d[k][c] = (1 - t) * d[k - 1][c] + t * d[k][c];
            }
        }
        memcpy(out + j * out_stride, d[p], numbers * sizeof(double));
    }
}
