/* piece.c - see piece.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/piece.h"

#include <string.h>

/* Where the curve has passed the point in one coordinate and not in the other, it is on a known side of it for good,
 * because both are monotone. So the search need not find the curve's x at the given y: any such parameter will do.
 * The best place to look for one is where the curve meets the line through the point across the piece's box, that is
 * at the root of f(t) = (x(t)-x)/width + (y(t)-y)/height, which is monotone too: regula falsi [Illinois, Dowell and
 * Jarratt 1971], with a bisection whenever three steps have not halved the interval. The side is known as soon as the
 * root is nearer than the point. The loop ends: an interval of doubles cannot be halved for ever.
 *
 * With a reach, passing by more than that settles the side of a whole square; what passes by less may enter it. */
static ep_side search(const ep_piece *p, const ep_point2h *points, double x, double y, double reach)
{
    static const ep_side side[2] = {EP_SIDE_LEFT, EP_SIDE_RIGHT};
    const double mirror = p->falls ? -1 : 1, width = fabs(p->high[0] - p->low[0]), height = p->high[1] - p->low[1];
    double ta = 0, tb = 1;
    double fa = mirror * (p->low[0] - x) / width + (p->low[1] - y) / height;
    double fb = mirror * (p->high[0] - x) / width + (p->high[1] - y) / height;
    double before = 1;
    int last = 0;
    for (int step = 1;; ++step) {
        double t = ta + (tb - ta) * (fa / (fa - fb));
        if (step % 3 == 0) {
            if (!(tb - ta < 0.5 * before)) t = ta + 0.5 * (tb - ta);
            before = tb - ta;
        }
        if (!(t > ta && t < tb)) {
            t = ta + 0.5 * (tb - ta);
            if (!(t > ta && t < tb)) return reach > 0 ? EP_SIDE_NEAR : side[!p->falls]; /* the point is on the curve */
        }
        ep_point2 c;
        ep_curve_eval(points, p->degree, t, c);
        const double dx = mirror * (c[0] - x), dy = c[1] - y;
        if (dx > 0 && dy <= 0) return dx > reach && dy <= -reach ? side[!p->falls] : EP_SIDE_NEAR;
        if (dx <= 0 && dy > 0) return dx <= -reach && dy > reach ? side[p->falls] : EP_SIDE_NEAR;
        const double f = dx / width + dy / height;
        if (dx <= 0) {
            ta = t, fa = f;
            if (last < 0) fb *= 0.5;
            last = -1;
        } else {
            tb = t, fb = f;
            if (last > 0) fa *= 0.5;
            last = 1;
        }
    }
}

bool ep_piece_is_right(const ep_piece *p, const ep_point2h *points, double x, double y)
{
    if (x < p->low[0] && x < p->high[0]) return true;
    if (x >= p->low[0] && x >= p->high[0]) return false;
    if (p->degree > 1) return search(p, points, x, y, 0) == EP_SIDE_RIGHT;
    return (p->high[0] - p->low[0]) * (y - p->low[1]) > (x - p->low[0]) * (p->high[1] - p->low[1]);
}

ep_side ep_piece_side(const ep_piece *p, const ep_point2h *points, double x, double y, double reach)
{
    if (y - reach < p->low[1] || y + reach >= p->high[1]) return EP_SIDE_NEAR;
    if (p->degree > 1) return search(p, points, x, y, reach);
    const double across = p->falls ? -reach : reach;
    const bool right = ep_piece_is_right(p, points, x - across, y + reach);
    if (right != ep_piece_is_right(p, points, x + across, y - reach)) return EP_SIDE_NEAR;
    return right ? EP_SIDE_RIGHT : EP_SIDE_LEFT;
}

/* Curves are always cut in the same direction, so that two regions that share a curve share its pieces, whichever way
 * round each of them goes. */
static bool is_turned(const ep_point2h *p, unsigned n)
{
    static const int order[3] = {1, 0, 2};
    for (unsigned i = 0; i < n - i; ++i)
        for (int k = 0; k < 3; ++k) {
            const int c = order[k];
            if (p[i][c] != p[n - i][c]) return p[i][c] > p[n - i][c];
        }
    return false;
}

unsigned ep_piece_cut(const ep_point2h *curve, unsigned degree, const ep_point2 from, const ep_point2 to,
                      ep_piece *pieces, ep_point2h *points)
{
    const bool turned = is_turned(curve, degree);
    ep_point2h h[EP_CURVE_POINTS];
    ep_point2w p[EP_CURVE_POINTS];
    for (unsigned i = 0; i <= degree; ++i) {
        memcpy(h[i], curve[turned ? degree - i : i], sizeof h[i]);
        p[i][0] = h[i][0] / h[i][2], p[i][1] = h[i][1] / h[i][2], p[i][2] = h[i][2];
    }
    double cuts[EP_CURVE_CUTS + 1];
    const unsigned n = ep_curve_turns(p, degree, cuts);
    cuts[n] = 1;
    unsigned count = 0;
    ep_point2 at;
    memcpy(at, turned ? to : from, sizeof at);
    for (unsigned k = 0; k <= n; ++k) {
        ep_point2 end;
        if (k == n) memcpy(end, turned ? from : to, sizeof end);
        else ep_curve_eval(h, degree, cuts[k], end);
        if (end[0] != at[0] || end[1] != at[1]) {
            ep_piece *piece = &pieces[count];
            ep_point2h *out = points + count * (degree + 1);
            ep_curve_restrict(h, degree, k ? cuts[k - 1] : 0, cuts[k], out);
            const bool down = at[1] > end[1] || (at[1] == end[1] && at[0] > end[0]);
            if (down)
                for (unsigned i = 0; i < degree - i; ++i) {
                    ep_point2h swap;
                    memcpy(swap, out[i], sizeof swap);
                    memcpy(out[i], out[degree - i], sizeof swap);
                    memcpy(out[degree - i], swap, sizeof swap);
                }
            memcpy(piece->low, down ? end : at, sizeof at);
            memcpy(piece->high, down ? at : end, sizeof at);
            piece->degree = degree;
            piece->falls = piece->high[0] < piece->low[0];
            ++count;
        }
        memcpy(at, end, sizeof at);
    }
    return count;
}
