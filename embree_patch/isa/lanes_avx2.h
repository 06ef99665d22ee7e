/* lanes_avx2.h - the verbs for AVX2 and FMA; lanes_plain.h says what each promises.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_LANES_AVX2_H
#define EP_LANES_AVX2_H

#include "embree_patch/isa/lanes_x86.h"

#define EP_ISA_NAME "avx2"
#define EP_KERNELS ep_kernels_avx2
#define EP_LANES 8

typedef float w_f __attribute__((vector_size(32)));
typedef __m256 w_m;

static inline w_f w_set(float x)
{
    return _mm256_set1_ps(x);
}
static inline w_f w_load(const float *p, unsigned count)
{
    return count < 8 ? _mm256_castps128_ps256(_mm_loadu_ps(p)) : _mm256_loadu_ps(p);
}
static inline w_f w_fma(w_f a, w_f b, w_f c)
{
    return _mm256_fmadd_ps(a, b, c);
}
static inline w_f w_fnma(w_f a, w_f b, w_f c)
{
    return _mm256_fnmadd_ps(a, b, c);
}
static inline w_m w_lt(w_f a, w_f b)
{
    return _mm256_cmp_ps(a, b, _CMP_LT_OQ);
}
static inline w_m w_le(w_f a, w_f b)
{
    return _mm256_cmp_ps(a, b, _CMP_LE_OQ);
}
static inline w_m w_and(w_m a, w_m b)
{
    return _mm256_and_ps(a, b);
}
static inline w_m w_or(w_m a, w_m b)
{
    return _mm256_or_ps(a, b);
}
static inline w_m w_andnot(w_m a, w_m b)
{
    return _mm256_andnot_ps(b, a);
}
static inline w_f w_select(w_m m, w_f a, w_f b)
{
    return _mm256_blendv_ps(b, a, m);
}
static inline w_f w_min(w_f a, w_f b)
{
    return _mm256_min_ps(a, b);
}
static inline w_f w_max(w_f a, w_f b)
{
    return _mm256_max_ps(a, b);
}
static inline w_f w_abs(w_f a)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a);
}
static inline w_f w_sqrt(w_f a)
{
    return _mm256_sqrt_ps(a);
}
static inline w_f w_permute(w_f a, const int *from)
{
    return _mm256_permutevar8x32_ps(a, _mm256_loadu_si256((const __m256i *)from));
}
static inline uint32_t w_bits(w_m m)
{
    return (uint32_t)_mm256_movemask_ps(m);
}
static inline w_m w_mask(uint32_t bits)
{
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int)bits), bit), bit));
}
static inline void w_store(float *p, uint32_t mask, w_f a)
{
    _mm256_maskstore_ps(p, _mm256_castps_si256(w_mask(mask)), a);
}

static inline void w_store_mask(int *p, uint32_t bits)
{
    _mm256_storeu_ps((float *)p, w_mask(bits));
}
static inline uint32_t w_load_mask(const int *p)
{
    return w_bits(_mm256_loadu_ps((const float *)p));
}

#endif
