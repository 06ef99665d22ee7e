/* series_tmpl.h - a polynomial and its derivatives, from its coefficients.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Included twice per instruction set: X(series) is w_series, one coordinate of all rays, and f4_series, all coordinates
 * of one point, from the same text and so to the same bits. X(v) is what it computes with. */

/* Point and derivatives of a polynomial, row by row in s, then in t; derivatives by the same scheme. */
EP_INLINE void X(series)(const float *net, int stride, int triangle, unsigned m, unsigned n, X(v) s, X(v) t, X(v) * f,
                         X(v) * fs, X(v) * ft)
{
    const float *row = net + (size_t)stride * (triangle ? (n + 1) * (n + 2) / 2 : (m + 1) * (n + 1));
    X(v) value = X(v_load)(net), ds = value, dt = value;
    for (unsigned j = n + 1; j-- > 0;) {
        const unsigned count = triangle ? n - j : m;
        row -= (size_t)stride * (count + 1);
        X(v) a = X(v_load)(row + (size_t)stride * count), as = a;
        if (count > 0) a = X(v_fma)(a, s, X(v_load)(row + (size_t)stride * (count - 1)));
        for (unsigned i = count - 1; count > 1 && i-- > 0;) {
            as = X(v_fma)(as, s, a);
            a = X(v_fma)(a, s, X(v_load)(row + (size_t)stride * i));
        }
        if (j == n) {
            value = a;
        } else {
            dt = j == n - 1 ? value : X(v_fma)(dt, t, value);
            value = X(v_fma)(value, t, a);
        }
        if (count > 0) ds = j + (triangle ? 1u : 0u) == n ? as : X(v_fma)(ds, t, as);
    }
    *f = value;
    *fs = ds;
    *ft = dt;
}
