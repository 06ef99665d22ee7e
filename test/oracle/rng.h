/* rng.h - random numbers that are the same everywhere [Steele, Lea, Flood, "Fast splittable pseudorandom number
 * generators", 2014].
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef ORACLE_RNG_H
#define ORACLE_RNG_H

#include <math.h>
#include <stdint.h>

typedef struct rng {
    uint64_t state;
} rng;

static inline uint64_t rng_bits(rng *r)
{
    uint64_t z = r->state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

/* A generator of its own for item `index` of a series. */
static inline rng rng_split(uint64_t seed, uint64_t series, uint64_t index)
{
    rng r = {seed ^ series * 0xd1342543de82ef95u};
    r.state = rng_bits(&r) + index * 0xda942042e4dd58b5u;
    r.state = rng_bits(&r);
    return r;
}

static inline unsigned rng_below(rng *r, unsigned n)
{
    return (unsigned)((rng_bits(r) >> 32) * n >> 32);
}

static inline double rng_unit(rng *r)
{
    return (double)(rng_bits(r) >> 11) * 0x1p-53;
}

static inline double rng_in(rng *r, double low, double high)
{
    return low + (high - low) * rng_unit(r);
}

/* Between low and high, evenly by order of magnitude. */
static inline double rng_scale(rng *r, double low, double high)
{
    return low * pow(high / low, rng_unit(r));
}

static inline double rng_sign(rng *r)
{
    return rng_bits(r) >> 63 ? 1 : -1;
}

static inline void rng_direction(rng *r, double d[3])
{
    const double z = rng_in(r, -1, 1), a = rng_in(r, 0, 6.283185307179586), s = sqrt(1 - z * z);
    d[0] = s * cos(a), d[1] = s * sin(a), d[2] = z;
}

#endif
