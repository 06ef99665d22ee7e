/* lanes_plain.h - the verbs of the kernel templates in plain C: their specification.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The rounding contract of every lanes_*.h: a verb rounds once, to nearest even; fma(a, b, c) = ab + c and
 * fnma(a, b, c) = c - ab are fused; min and max return the second argument when an argument is NaN; comparisons with
 * NaN are false. Types and verbs come in two families:
 *
 *   w_  EP_LANES lanes, one ray each; w_m is a mask
 *   f4  the coordinates of one point
 *
 * Arithmetic on both is written with operators (vector extensions of gcc and clang). */
#ifndef EP_LANES_PLAIN_H
#define EP_LANES_PLAIN_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#define EP_ISA_NAME "plain"
#define EP_KERNELS ep_kernels_plain
#define EP_LANES 4

typedef float f4 __attribute__((vector_size(16)));
typedef int32_t i4 __attribute__((vector_size(16)));
typedef f4 w_f;
typedef i4 w_m;

static inline w_f w_set(float x)
{
    return (w_f){x, x, x, x};
}
static inline w_f w_load(const float *p, unsigned count)
{
    w_f r;
    (void)count; /* a packet has no fewer lanes than this */
    memcpy(&r, p, sizeof r);
    return r;
}
static inline void w_store(float *p, uint32_t mask, w_f a)
{
    for (unsigned k = 0; k < EP_LANES; ++k)
        if (mask >> k & 1) p[k] = a[k];
}
static inline w_f w_fma(w_f a, w_f b, w_f c)
{
    return (w_f){fmaf(a[0], b[0], c[0]), fmaf(a[1], b[1], c[1]), fmaf(a[2], b[2], c[2]), fmaf(a[3], b[3], c[3])};
}
static inline w_f w_fnma(w_f a, w_f b, w_f c)
{
    return w_fma(-a, b, c);
}
static inline w_m w_lt(w_f a, w_f b)
{
    return a < b;
}
static inline w_m w_le(w_f a, w_f b)
{
    return a <= b;
}
static inline w_m w_and(w_m a, w_m b)
{
    return a & b;
}
static inline w_m w_or(w_m a, w_m b)
{
    return a | b;
}
static inline w_m w_andnot(w_m a, w_m b)
{
    return a & ~b;
}
static inline w_f w_select(w_m m, w_f a, w_f b)
{
    return (w_f)((m & (w_m)a) | (~m & (w_m)b));
}
static inline w_f w_min(w_f a, w_f b)
{
    return w_select(a < b, a, b);
}
static inline w_f w_max(w_f a, w_f b)
{
    return w_select(a > b, a, b);
}
static inline w_f w_abs(w_f a)
{
    return (w_f)((w_m)a & 0x7fffffff);
}
static inline w_f w_sqrt(w_f a)
{
    return (w_f){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])};
}
/* Lane k of what is returned is lane from[k] of a. */
static inline w_f w_permute(w_f a, const int *from)
{
    return (w_f){a[from[0]], a[from[1]], a[from[2]], a[from[3]]};
}
static inline uint32_t w_bits(w_m m)
{
    return (m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8);
}
static inline w_m w_mask(uint32_t bits)
{
    return (w_m){-(int32_t)(bits & 1), -(int32_t)(bits >> 1 & 1), -(int32_t)(bits >> 2 & 1), -(int32_t)(bits >> 3 & 1)};
}

/* Masks as Embree keeps them: ints, -1 or 0. w_store_mask may write up to EP_LANES of them. */
static inline void w_store_mask(int *p, uint32_t bits)
{
    const w_m m = w_mask(bits);
    memcpy(p, &m, sizeof m);
}
static inline uint32_t f4_load_mask(const int *p)
{
    w_m m;
    memcpy(&m, p, sizeof m);
    return w_bits(m);
}
static inline uint32_t w_load_mask(const int *p)
{
    return f4_load_mask(p);
}

static inline f4 f4_set(float x)
{
    return w_set(x);
}
static inline f4 f4_load(const float *p)
{
    return w_load(p, 4);
}
static inline void f4_store(float *p, f4 a)
{
    memcpy(p, &a, sizeof a);
}
static inline f4 f4_fma(f4 a, f4 b, f4 c)
{
    return w_fma(a, b, c);
}
static inline f4 f4_fnma(f4 a, f4 b, f4 c)
{
    return w_fnma(a, b, c);
}
static inline f4 f4_min(f4 a, f4 b)
{
    return w_min(a, b);
}
static inline f4 f4_max(f4 a, f4 b)
{
    return w_max(a, b);
}
static inline f4 f4_abs(f4 a)
{
    return w_abs(a);
}
static inline uint32_t f4_lt(f4 a, f4 b)
{
    return w_bits(a < b);
}
#define f4_lane(a, k) ((f4){(a)[k], (a)[k], (a)[k], (a)[k]})
#define f4_swap(a) ((f4){(a)[1], (a)[0], (a)[2], (a)[3]}) /* the first two               */
#define f4_next(a) ((f4){(a)[1], (a)[2], (a)[0], (a)[3]}) /* of the first three, in turn */
#define f4_high(a) ((f4){(a)[2], (a)[3], (a)[2], (a)[3]})
#define f4_first(a, b) ((f4){(a)[0], (b)[1], (b)[2], (b)[3]}) /* the first of a, else b */
#define f4_third(a, b) ((f4){(a)[0], (a)[1], (b)[2], (a)[3]}) /* the third of b, else a */

#endif
