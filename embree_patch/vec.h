/* vec.h - three doubles, by value.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_VEC_H
#define EP_VEC_H

#include <math.h>

typedef struct ep_vec3 {
    double x, y, z;
} ep_vec3;

static inline ep_vec3 ep_v3(double x, double y, double z)
{
    return (ep_vec3){x, y, z};
}
static inline ep_vec3 ep_add(ep_vec3 a, ep_vec3 b)
{
    return ep_v3(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline ep_vec3 ep_sub(ep_vec3 a, ep_vec3 b)
{
    return ep_v3(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline ep_vec3 ep_scale(double s, ep_vec3 a)
{
    return ep_v3(s * a.x, s * a.y, s * a.z);
}
static inline double ep_dot(ep_vec3 a, ep_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline double ep_length(ep_vec3 a)
{
    return sqrt(ep_dot(a, a));
}
static inline double ep_norm1(ep_vec3 a)
{
    return fabs(a.x) + fabs(a.y) + fabs(a.z);
}
static inline ep_vec3 ep_cross(ep_vec3 a, ep_vec3 b)
{
    return ep_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

#endif
