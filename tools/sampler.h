/* sampler.h - sample points that depend on the pixel and nothing else.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * One Sobol (0,2)-sequence for the whole image, Owen-scrambled by hashing (B. Burley, "Practical hash-based Owen
 * scrambling", JCGT 2020). Pixels take consecutive runs of it in Morton order, so that the samples are stratified
 * within a pixel and also over any 2 x 2, 4 x 4, ... block of pixels: what error remains is fine-grained (A. Ahmed,
 * P. Wonka, "Screen-space blue-noise diffusion of Monte Carlo sampling error via hierarchical ordering of pixels",
 * 2020). Every use of a sample ("dimension") shuffles and scrambles the sequence anew. */
#ifndef EPATCH_SAMPLER_H
#define EPATCH_SAMPLER_H

#include <stdint.h>

typedef struct sampler {
    uint32_t index;     /* of the camera sample in the image */
    uint32_t dimension; /* added to those of the uses        */
} sampler;

static inline uint32_t sampler_hash(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}

static inline uint32_t sampler_reverse_bits(uint32_t x)
{
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    return __builtin_bswap32(x);
}

/* Owen scrambling of a bit-reversed number: each bit is flipped depending on the lower ones and the seed. */
static inline uint32_t sampler_laine_karras(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

static inline uint32_t sampler_spread_bits(uint32_t x)
{
    x &= 0xffffu;
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

static inline sampler sampler_of_pixel(uint32_t x, uint32_t y, uint32_t sample, uint32_t spp)
{
    uint32_t morton = sampler_spread_bits(x) | sampler_spread_bits(y) << 1;
    return (sampler){morton * spp + sample, 0};
}

/* The point for one use of the sample: x, y in [0, 1). */
static inline void sampler_2d(const sampler *s, uint32_t use, float *x, float *y)
{
    uint32_t seed = sampler_hash(s->dimension + use + 1);
    /* Shuffling in Owen's way keeps aligned runs together. */
    uint32_t i = sampler_reverse_bits(s->index);
    i = sampler_reverse_bits(sampler_laine_karras(i, seed));

    uint32_t second = 0; /* the matrix of Sobol's second dimension: column b is column b-1 ^ (column b-1 >> 1) */
    for (uint32_t bits = i, column = 0x80000000u; bits; bits >>= 1, column ^= column >> 1)
        if (bits & 1) second ^= column;

    /* The first dimension is i with its bits reversed, so reversing it again gives i. */
    uint32_t a = sampler_reverse_bits(sampler_laine_karras(i, sampler_hash(seed ^ 0x9e3779b9u)));
    uint32_t b =
        sampler_reverse_bits(sampler_laine_karras(sampler_reverse_bits(second), sampler_hash(seed ^ 0x85ebca6bu)));
    *x = (float)(a >> 8) * 0x1p-24f;
    *y = (float)(b >> 8) * 0x1p-24f;
}

#endif
