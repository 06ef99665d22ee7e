/* series_tmpl.h - a polynomial and its derivatives, from its coefficients.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Included twice per instruction set: X(series) is w_series, one coordinate of all rays, and f4_series, all coordinates
 * of one point, from the same text and so to the same bits. X(v) is what it computes with. */

/* A polynomial, its derivatives, and half of the second ones: what Horner's scheme leads to. */
typedef struct X(jet) {
    X(v) f, s, t, ss, st, tt; /* ss, tt: halves */
} X(jet);

/* Row by row in s, then in t. */
EP_INLINE X(jet) X(series)(const float *net, int stride, int triangle, unsigned m, unsigned n, X(v) s, X(v) t)
{
    const float *row = net + (size_t)stride * (triangle ? (n + 1) * (n + 2) / 2 : (m + 1) * (n + 1));
    const unsigned top = triangle ? n - 1 : n; /* the first row with a derivative by s */
    const X(v) zero = X(v_zero);
    X(jet) p = {zero, zero, zero, zero, zero, zero};
    for (unsigned j = n + 1; j-- > 0;) {
        const unsigned count = triangle ? n - j : m;
        row -= (size_t)stride * (count + 1);
        X(v) a = X(v_load)(row + (size_t)stride * count), as = a, ass = a;
        if (count > 0) a = X(v_fma)(a, s, X(v_load)(row + (size_t)stride * (count - 1)));
        for (unsigned i = count - 1; count > 1 && i-- > 0;) {
            if (i + 2 < count) ass = X(v_fma)(ass, s, as);
            as = X(v_fma)(as, s, a);
            a = X(v_fma)(a, s, X(v_load)(row + (size_t)stride * i));
        }
        if (j == n) {
            p.f = a;
        } else {
            if (j + 1 < n) p.tt = j + 2 == n ? p.t : X(v_fma)(p.tt, t, p.t);
            p.t = j + 1 == n ? p.f : X(v_fma)(p.t, t, p.f);
            p.f = X(v_fma)(p.f, t, a);
        }
        if (count > 0) {
            if (j < top) p.st = j + 1 == top ? p.s : X(v_fma)(p.st, t, p.s);
            p.s = j == top ? as : X(v_fma)(p.s, t, as);
        }
        if (count > 1) p.ss = j == (triangle ? n - 2 : n) ? ass : X(v_fma)(p.ss, t, ass);
    }
    return p;
}
