/* vec.h - three floats: directions, positions and colours of the renderer.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_VEC_H
#define EPATCH_VEC_H

#include <math.h>

/* Unlike fminf and fmaxf these are single instructions; with NaN they give b. */
static inline float minf(float a, float b)
{
    return a < b ? a : b;
}

static inline float maxf(float a, float b)
{
    return a > b ? a : b;
}

static inline float clampf(float x, float least, float most)
{
    return minf(maxf(x, least), most);
}

typedef struct vec3 {
    float x, y, z;
} vec3;

static inline vec3 vec(float x, float y, float z)
{
    return (vec3){x, y, z};
}

static inline vec3 vec_grey(float x)
{
    return (vec3){x, x, x};
}

static inline vec3 vec_add(vec3 a, vec3 b)
{
    return (vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline vec3 vec_sub(vec3 a, vec3 b)
{
    return (vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline vec3 vec_mul(vec3 a, vec3 b)
{
    return (vec3){a.x * b.x, a.y * b.y, a.z * b.z};
}

static inline vec3 vec_scale(float s, vec3 a)
{
    return (vec3){s * a.x, s * a.y, s * a.z};
}

/* a + s b */
static inline vec3 vec_madd(vec3 a, float s, vec3 b)
{
    return (vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline vec3 vec_mix(vec3 a, vec3 b, float t)
{
    return vec_madd(a, t, vec_sub(b, a));
}

static inline float vec_dot(vec3 a, vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline vec3 vec_cross(vec3 a, vec3 b)
{
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline float vec_max(vec3 a)
{
    return maxf(a.x, maxf(a.y, a.z));
}

/* Scaled by the largest component first, so that it neither overflows nor vanishes; zero and NaN give zero. */
static inline vec3 vec_unit(vec3 a)
{
    float m = maxf(fabsf(a.x), maxf(fabsf(a.y), fabsf(a.z)));
    if (!(m > 0 && m < INFINITY)) return (vec3){0, 0, 0};
    a = (vec3){a.x / m, a.y / m, a.z / m};
    return vec_scale(1 / sqrtf(vec_dot(a, a)), a);
}

/* Two directions that make a right-handed orthonormal frame with the unit vector n, after Duff et al., "Building an
 * orthonormal basis, revisited" (2017). */
static inline void vec_frame(vec3 n, vec3 *s, vec3 *t)
{
    float sign = copysignf(1.0f, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    *s = vec(1 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    *t = vec(b, sign + n.y * n.y * a, -n.y);
}

/* 0 below a, 1 above b, smooth in between. */
static inline float smoothf(float a, float b, float x)
{
    float t = clampf((x - a) / (b - a), 0, 1);
    return t * t * (3 - 2 * t);
}

#endif
