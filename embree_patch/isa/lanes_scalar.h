/* lanes_scalar.h - the family s_: one lane, in an ordinary float; lanes_plain.h says what each verb promises.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_LANES_SCALAR_H
#define EP_LANES_SCALAR_H

#include <math.h>
#include <stdint.h>

typedef float s_f;
typedef uint32_t s_m; /* 0 or 1 */

static inline s_f s_set(float x)
{
    return x;
}
static inline s_f s_fma(s_f a, s_f b, s_f c)
{
    return __builtin_fmaf(a, b, c);
}
static inline s_f s_fnma(s_f a, s_f b, s_f c)
{
    return __builtin_fmaf(-a, b, c);
}
static inline s_m s_lt(s_f a, s_f b)
{
    return a < b;
}
static inline s_m s_le(s_f a, s_f b)
{
    return a <= b;
}
static inline s_m s_and(s_m a, s_m b)
{
    return a & b;
}
static inline s_m s_or(s_m a, s_m b)
{
    return a | b;
}
static inline s_m s_andnot(s_m a, s_m b)
{
    return a & (b ^ 1);
}
static inline s_f s_select(s_m m, s_f a, s_f b)
{
    return m ? a : b;
}
static inline s_f s_min(s_f a, s_f b)
{
    return a < b ? a : b;
}
static inline s_f s_max(s_f a, s_f b)
{
    return a > b ? a : b;
}
static inline s_f s_abs(s_f a)
{
    return __builtin_fabsf(a);
}
static inline uint32_t s_bits(s_m m)
{
    return m;
}

#endif
