/* curve.c - see curve.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/curve.h"

#include <string.h>

static void lerp(ep_point2h out, const ep_point2h a, const ep_point2h b, double t)
{
    for (int c = 0; c < 3; ++c) out[c] = (1 - t) * a[c] + t * b[c];
}

/* Horner's scheme in the Bernstein basis: sum C(n,i) t^i s^(n-i) p_i, every factor positive. */
void ep_curve_eval(const ep_point2h *p, unsigned n, double t, ep_point2 out)
{
    const double s = 1 - t;
    double x = s * p[0][0], y = s * p[0][1], w = s * p[0][2], power = t, choose = 1;
    for (unsigned i = 1; i < n; ++i) {
        choose *= (double)(n - i + 1) / i;
        const double b = choose * power;
        x = s * (x + b * p[i][0]);
        y = s * (y + b * p[i][1]);
        w = s * (w + b * p[i][2]);
        power *= t;
    }
    w += power * p[n][2];
    out[0] = (x + power * p[n][0]) / w;
    out[1] = (y + power * p[n][1]) / w;
}

void ep_curve_halve(const ep_point2h *p, unsigned n, ep_point2h *left, ep_point2h *right)
{
    ep_point2h q[EP_CURVE_POINTS];
    memcpy(q, p, (n + 1) * sizeof q[0]);
    for (unsigned k = n;; --k) {
        memcpy(left[n - k], q[0], sizeof q[0]);
        memcpy(right[k], q[k], sizeof q[0]);
        if (k == 0) break;
        for (unsigned i = 0; i < k; ++i)
            for (int c = 0; c < 3; ++c) q[i][c] = 0.5 * (q[i][c] + q[i + 1][c]);
    }
}

/* Cut at t1 and keep the left; the part that begins at t0 is then the right one of a cut at t0/t1. */
void ep_curve_restrict(const ep_point2h *p, unsigned n, double t0, double t1, ep_point2h *out)
{
    if (out != p) memcpy(out, p, (n + 1) * sizeof out[0]);
    if (t1 != 1)
        for (unsigned k = 1; k <= n; ++k)
            for (unsigned i = n; i >= k; --i) lerp(out[i], out[i - 1], out[i], t1);
    if (t0 != 0)
        for (unsigned k = n; k > 0; --k)
            for (unsigned i = 0; i < k; ++i) lerp(out[i], out[i], out[i + 1], t0 / t1);
}

/* A polynomial in the Bernstein basis, each coefficient with the error it carries. */
enum { SPEED_DEGREE = 2 * EP_MAX_DEGREE - 2 };
typedef struct speed {
    double d[SPEED_DEGREE + 1], error[SPEED_DEGREE + 1];
    unsigned degree;
} speed;

/* The numerator of dx/dt for x = sum w_i x_i B_i / sum w_i B_i [Floater 1992]:
 *
 *     sum over i < j of w_i w_j (x_j - x_i) (B_i B_j' - B_i' B_j),
 *
 * and B_j'/B_j = j/t - (n-j)/(1-t), so that the bracket is (j-i) C(n,i) C(n,j) t^(i+j-1) (1-t)^(2n-i-j-1): a term of
 * coefficient i+j-1 in the basis of degree 2n-2. Each term rounds at most n+8 times. */
static void find_speed(const ep_point2w *p, unsigned n, int axis, speed *s)
{
    double chose[2 * EP_MAX_DEGREE], chosen[EP_CURVE_POINTS];
    const unsigned m = s->degree = 2 * n - 2;
    chose[0] = chosen[0] = 1;
    for (unsigned k = 1; k <= m; ++k) chose[k] = chose[k - 1] * (m - k + 1) / k;
    for (unsigned k = 1; k <= n; ++k) chosen[k] = chosen[k - 1] * (n - k + 1) / k;
    memset(s->d, 0, sizeof s->d);
    memset(s->error, 0, sizeof s->error);
    for (unsigned i = 0; i <= n; ++i)
        for (unsigned j = i + 1; j <= n; ++j) {
            const unsigned k = i + j - 1;
            const double f = p[i][2] * p[j][2] * (j - i) * (chosen[i] * chosen[j] / chose[k]);
            s->d[k] += f * (p[j][axis] - p[i][axis]);
            s->error[k] += f * fmax(fabs(p[j][axis]), fabs(p[i][axis]));
        }
    for (unsigned k = 0; k <= m; ++k) s->error[k] *= 4 * (n + 8) * EP_EPS_D;
}

static int sign_of(const speed *s, unsigned k)
{
    return s->d[k] > s->error[k] ? 1 : s->d[k] < -s->error[k] ? -1 : 0;
}

static void halve_speed(const speed *s, speed *left, speed *right)
{
    speed q = *s;
    left->degree = right->degree = s->degree;
    for (unsigned k = s->degree;; --k) {
        left->d[s->degree - k] = q.d[0], left->error[s->degree - k] = q.error[0];
        right->d[k] = q.d[k], right->error[k] = q.error[k];
        if (k == 0) break;
        for (unsigned i = 0; i < k; ++i) {
            q.d[i] = 0.5 * (q.d[i] + q.d[i + 1]);
            q.error[i] = 0.5 * (q.error[i] + q.error[i + 1]) + fabs(q.d[i]) * EP_EPS_D;
        }
    }
}

typedef struct turns {
    double *cuts;
    unsigned count;
    int sign; /* of the last interval that has one */
} turns;

/* Where the sign of s changes, from left to right. At most one change of sign in the coefficients is at most one root
 * (Descartes); otherwise halve. Below 2^-52 of the curve the point no longer moves. */
static void find_turns(const speed *s, double t0, double t1, int depth, turns *out)
{
    int changes = 0, last = 0;
    for (unsigned k = 0; k <= s->degree; ++k) {
        const int sign = sign_of(s, k);
        if (!sign) continue;
        changes += last && sign != last;
        last = sign;
    }
    if (changes == 0) {
        if (!last) return;
        if (out->sign && last != out->sign && t0 > 0) out->cuts[out->count++] = t0;
        out->sign = last;
        return;
    }
    if (depth == 52) return;
    speed left, right;
    halve_speed(s, &left, &right);
    const double tm = 0.5 * (t0 + t1);
    find_turns(&left, t0, tm, depth + 1, out);
    find_turns(&right, tm, t1, depth + 1, out);
}

unsigned ep_curve_turns(const ep_point2w *p, unsigned n, double *cuts)
{
    if (n < 2) return 0;
    turns out = {cuts, 0, 0};
    for (int axis = 0; axis < 2; ++axis) {
        speed s;
        find_speed(p, n, axis, &s);
        out.sign = 0;
        find_turns(&s, 0, 1, 0, &out);
    }
    /* few: insertion sort, dropping repetitions */
    unsigned count = 0;
    for (unsigned i = 0; i < out.count; ++i) {
        const double t = cuts[i];
        unsigned k = count;
        while (k > 0 && cuts[k - 1] > t) --k;
        if (k > 0 && cuts[k - 1] == t) continue;
        memmove(cuts + k + 1, cuts + k, (count - k) * sizeof *cuts);
        cuts[k] = t;
        ++count;
    }
    return count;
}
