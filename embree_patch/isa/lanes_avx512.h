/* lanes_avx512.h - the verbs for AVX-512 F, VL and DQ; lanes_plain.h says what each promises.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_LANES_AVX512_H
#define EP_LANES_AVX512_H

#include "embree_patch/isa/lanes_x86.h"

#define EP_ISA_NAME "avx512"
#define EP_KERNELS ep_kernels_avx512
#define EP_LANES 16

typedef float w_f __attribute__((vector_size(64)));
typedef __mmask16 w_m;

static inline w_f w_set(float x)
{
    return _mm512_set1_ps(x);
}
static inline w_f w_load(const float *p, unsigned count)
{
    return count == 16 ? _mm512_loadu_ps(p) : _mm512_maskz_loadu_ps((__mmask16)((1u << count) - 1), p);
}
static inline void w_store(float *p, uint32_t mask, w_f a)
{
    _mm512_mask_storeu_ps(p, (__mmask16)mask, a);
}
static inline w_f w_fma(w_f a, w_f b, w_f c)
{
    return _mm512_fmadd_ps(a, b, c);
}
static inline w_f w_fnma(w_f a, w_f b, w_f c)
{
    return _mm512_fnmadd_ps(a, b, c);
}
static inline w_m w_lt(w_f a, w_f b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
static inline w_m w_le(w_f a, w_f b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
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
    return a & (w_m)~b;
}
static inline w_f w_select(w_m m, w_f a, w_f b)
{
    return _mm512_mask_blend_ps(m, b, a);
}
static inline w_f w_min(w_f a, w_f b)
{
    return _mm512_min_ps(a, b);
}
static inline w_f w_max(w_f a, w_f b)
{
    return _mm512_max_ps(a, b);
}
static inline w_f w_abs(w_f a)
{
    return _mm512_abs_ps(a);
}
static inline w_f w_sqrt(w_f a)
{
    return _mm512_sqrt_ps(a);
}
static inline w_f w_permute(w_f a, const int *from)
{
    return _mm512_permutexvar_ps(_mm512_loadu_si512(from), a);
}
static inline uint32_t w_bits(w_m m)
{
    return m;
}
static inline w_m w_mask(uint32_t bits)
{
    return (w_m)bits;
}

static inline void w_store_mask(int *p, uint32_t bits)
{
    _mm512_storeu_si512(p, _mm512_movm_epi32((__mmask16)bits));
}
static inline uint32_t w_load_mask(const int *p)
{
    return _mm512_movepi32_mask(_mm512_loadu_si512(p));
}

#endif
