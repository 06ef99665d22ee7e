/* lanes_x86.h - the family f4, and masks of four, in SSE with FMA: the same for every instruction set that has these.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_LANES_X86_H
#define EP_LANES_X86_H

#include <immintrin.h>
#include <stdint.h>

typedef float f4 __attribute__((vector_size(16)));

static inline uint32_t f4_load_mask(const int *p)
{
    return (uint32_t)_mm_movemask_ps(_mm_loadu_ps((const float *)p));
}

static inline f4 f4_set(float x)
{
    return _mm_set1_ps(x);
}
static inline f4 f4_load(const float *p)
{
    return _mm_loadu_ps(p);
}
static inline void f4_store(float *p, f4 a)
{
    _mm_storeu_ps(p, a);
}
static inline f4 f4_fma(f4 a, f4 b, f4 c)
{
    return _mm_fmadd_ps(a, b, c);
}
static inline f4 f4_fnma(f4 a, f4 b, f4 c)
{
    return _mm_fnmadd_ps(a, b, c);
}
static inline f4 f4_min(f4 a, f4 b)
{
    return _mm_min_ps(a, b);
}
static inline f4 f4_max(f4 a, f4 b)
{
    return _mm_max_ps(a, b);
}
static inline f4 f4_abs(f4 a)
{
    return _mm_andnot_ps(_mm_set1_ps(-0.0f), a);
}
static inline uint32_t f4_lt(f4 a, f4 b)
{
    return (uint32_t)_mm_movemask_ps(_mm_cmplt_ps(a, b));
}
#define f4_lane(a, k) _mm_shuffle_ps(a, a, (k)*0x55)
#define f4_swap(a) _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 2, 0, 1))
#define f4_next(a) _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 0, 2, 1))
#define f4_high(a) _mm_movehl_ps(a, a)
#define f4_first(a, b) _mm_blend_ps(b, a, 1)
#define f4_third(a, b) _mm_blend_ps(a, b, 4)

#endif
