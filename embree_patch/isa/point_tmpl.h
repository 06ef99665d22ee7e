/* point_tmpl.h - one ray, the lanes across the coordinates of a point.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A vector has s, t, h in its first three lanes, a quantity of the leaf's plane in the first two; what is in the others
 * does not matter. A number that multiplies vectors is in all lanes, any other is a float. */

/* F's Jacobian: J^-1 (s, t) = (m_0 s - n_0 t, m_1 t - n_1 s) inverse. */
typedef struct f4_linear {
    f4 m, n, inverse;
    f4 c, d; /* the Newton point less y; that times the determinant */
} f4_linear;

#define EP_SELDOM(x) __builtin_expect(x, 0)

EP_INLINE float f1_fma(float a, float b, float c)
{
    return __builtin_fmaf(a, b, c);
}

EP_INLINE float f1_abs(float a)
{
    return __builtin_fabsf(a);
}

EP_INLINE float f1_sqrt(float a)
{
    return __builtin_sqrtf(a);
}

EP_INLINE float f1_max(float a, float b)
{
    return a > b ? a : b;
}

EP_INLINE float f1_min(float a, float b)
{
    return a < b ? a : b;
}

EP_INLINE f4 f4_to_leaf(const f4 *frame, f4 x)
{
    return f4_fma(frame[2], f4_lane(x, 2), f4_fma(frame[1], f4_lane(x, 1), frame[0] * f4_lane(x, 0)));
}

EP_INLINE f4 f4_cross(f4 a, f4 b)
{
    return f4_next(f4_fnma(f4_next(a), b, a * f4_next(b)));
}

EP_INLINE f4 f4_clamp(int triangle, f4 x)
{
    const f4 low = f4_set(triangle ? -EP_THIRD : -EP_HALF), high = f4_set(triangle ? 2 * EP_THIRD : EP_HALF);
    x = f4_max(x, low);
    if (!triangle) return f4_min(x, high);
    const f4 third = f4_set(EP_THIRD);
    const f4 excess = f4_max((x + f4_swap(x)) - third, f4_set(0.0f)) * f4_set(0.5f);
    x = f4_max(x - excess, low);
    const f4 s = f4_min(x, high);
    return f4_first(s, f4_min(x, third - f4_lane(s, 0)));
}

EP_INLINE float f4_outside(int triangle, f4 x)
{
    if (!triangle) return f1_max(f4_abs(x)[0], f4_abs(x)[1]) - EP_HALF;
    return f1_max(f1_max(-x[0], -x[1]), x[0] + x[1]) - EP_THIRD;
}

/* The larger of the first two. */
EP_INLINE float f4_norm(f4 x)
{
    x = f4_abs(x);
    return f1_max(x[0], x[1]);
}

/* `at`: S - o; `ds`, `dt`: the tangents. */
EP_INLINE f4_linear f4_solve(f4 p, f4 at, f4 ds, f4 dt)
{
    const f4 f = f4_fnma(p, f4_lane(at, 2), at);
    const f4 by_s = f4_fnma(p, f4_lane(ds, 2), ds), by_t = f4_fnma(p, f4_lane(dt, 2), dt);
    const f4 s_by = f4_swap(by_s), t_by = f4_swap(by_t);
    f4_linear l = {.m = f4_first(t_by, s_by), .n = f4_first(by_t, by_s)};
    const f4 det = f4_fnma(l.n, f4_first(s_by, t_by), l.m * f4_first(by_s, by_t));
    l.inverse = f4_set(1.0f) / det;
    l.d = f4_fnma(l.m, f, l.n * f4_swap(f));
    l.c = l.d * l.inverse;
    return l;
}

/* w_surface_at: S - o and its derivatives at x. */
EP_INLINE f4_jet f4_surface_at(const float *net, f4 x, f4 o, int triangle, unsigned m, unsigned n, int rational)
{
    /* x + -0 is x, to the sign of a zero */
    const f4 one_s = {1, -0.0f, -0.0f, -0.0f}, one_t = {-0.0f, 1, -0.0f, -0.0f};
    f4_jet j = f4_series(net, rational ? 4 : 3, triangle, m, n, f4_lane(x, 0), f4_lane(x, 1));
    if (rational) {
        const f4 inverse = f4_set(1.0f) / f4_lane(j.f, 3), w_s = f4_lane(j.s, 3), w_t = f4_lane(j.t, 3);
        j.f = j.f * inverse;
        j.s = f4_fnma(j.f, w_s, j.s) * inverse;
        j.t = f4_fnma(j.f, w_t, j.t) * inverse;
        j.ss = f4_fnma(j.f, f4_lane(j.ss, 3), f4_fnma(j.s, w_s, j.ss)) * inverse;
        j.tt = f4_fnma(j.f, f4_lane(j.tt, 3), f4_fnma(j.t, w_t, j.tt)) * inverse;
        j.st = f4_fnma(j.f, f4_lane(j.st, 3), f4_fnma(j.t, w_s, f4_fnma(j.s, w_t, j.st))) * inverse;
        j.f = j.f - o;
    } else {
        j.f = f4_third((x - o) + j.f, j.f - o);
        j.s = j.s + one_s;
        j.t = j.t + one_t;
    }
    return j;
}
