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
static inline f4 f4_fma(f4 a, f4 b, f4 c)
{
    return _mm_fmadd_ps(a, b, c);
}
static inline f4 f4_fnma(f4 a, f4 b, f4 c)
{
    return _mm_fnmadd_ps(a, b, c);
}
static inline f4 f4_abs(f4 a)
{
    return _mm_andnot_ps(_mm_set1_ps(-0.0f), a);
}
#define f4_lane(a, k) _mm_shuffle_ps(a, a, (k)*0x55)

#endif
