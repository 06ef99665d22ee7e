/* shapes_tmpl.h - all templates, and how they become a kernel for each shape.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Included once per instruction set, after its lanes_*.h. Everything is static, so that no function compiled for a
 * newer machine can be linked in where an older one runs. */
#include "embree_patch/kernels.h"

#include <math.h>
#include <stddef.h>

#define EP_INLINE static inline __attribute__((always_inline))

typedef w_f w_v;
#define w_v_load(p) w_set(*(p))
#define w_v_fma w_fma
#define w_v_zero w_set(0.0f)
#define X(name) w_##name
#include "embree_patch/isa/series_tmpl.h"
#undef X
typedef f4 f4_v;
#define f4_v_load(p) f4_load(p)
#define f4_v_fma f4_fma
#define f4_v_zero f4_set(0.0f)
#define X(name) f4_##name
#include "embree_patch/isa/series_tmpl.h"
#undef X
#include "embree_patch/isa/newton_tmpl.h"
#include "embree_patch/isa/start_tmpl.h"
#include "embree_patch/isa/rays_tmpl.h"
#include "embree_patch/isa/point_tmpl.h"
#include "embree_patch/isa/leave_tmpl.h"
#include "embree_patch/isa/packet_tmpl.h"
#include "embree_patch/isa/single_tmpl.h"
#include "embree_patch/isa/approach_tmpl.h"
#include "embree_patch/isa/fold_tmpl.h"
#include "embree_patch/isa/tangent_tmpl.h"
#include "embree_patch/isa/cells_tmpl.h"

/* The kernels for degrees 1 to 4 and for any, by EP_SHAPE(name, triangle, m, n, rational); m and n may read the leaf.
 */
#if EP_ANY_DEGREE
#define EP_DEGREES(name, triangle, rational) EP_SHAPE(name##_any, triangle, leaf->degree_s, leaf->degree_t, rational)
#define EP_ROW(p, name) p##_##name##_any, p##_##name##_any, p##_##name##_any, p##_##name##_any, p##_##name##_any
#else
#define EP_DEGREES(name, triangle, rational)                                                                           \
    EP_SHAPE(name##_any, triangle, leaf->degree_s, leaf->degree_t, rational)                                           \
    EP_SHAPE(name##_1, triangle, 1, 1, rational)                                                                       \
    EP_SHAPE(name##_2, triangle, 2, 2, rational)                                                                       \
    EP_SHAPE(name##_3, triangle, 3, 3, rational)                                                                       \
    EP_SHAPE(name##_4, triangle, 4, 4, rational)
#define EP_ROW(p, name) p##_##name##_any, p##_##name##_1, p##_##name##_2, p##_##name##_3, p##_##name##_4
#endif

#define EP_EVERY_SHAPE                                                                                                 \
    EP_DEGREES(tensor, 0, 0)                                                                                           \
    EP_DEGREES(tensor_rational, 0, 1)                                                                                  \
    EP_DEGREES(triangle, 1, 0)                                                                                         \
    EP_DEGREES(triangle_rational, 1, 1)

/* The kernels of a shape for packets and for single rays, from the templates for both. */
#define EP_PACKET_AND_SINGLE(packet, single, name, triangle, m, n, rational)                                           \
    static ep_outcome packet_##name(const ep_leaf *leaf, const float *net, const float *ray, unsigned rays,            \
                                    uint32_t active, float *t, float *hit, EPCounters *counters)                       \
    {                                                                                                                  \
        return packet(leaf, net, ray, rays, active, t, hit, counters, triangle, m, n, rational);                       \
    }                                                                                                                  \
    static ep_outcome single_##name(const ep_leaf *leaf, const float *net, const float *ray, float *t, float *hit,     \
                                    EPCounters *counters)                                                              \
    {                                                                                                                  \
        return single(leaf, net, ray, t, hit, counters, triangle, m, n, rational);                                     \
    }

/* In the order of ep_shape. */
#define EP_ALL(p)                                                                                                      \
    {                                                                                                                  \
        EP_ROW(p, tensor), EP_ROW(p, tensor_rational), EP_ROW(p, triangle), EP_ROW(p, triangle_rational)               \
    }
