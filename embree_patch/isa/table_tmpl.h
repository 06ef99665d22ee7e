/* table_tmpl.h - the kernels of one instruction set, from the templates.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/isa/shapes_tmpl.h"

/* The four kernels of a shape. */
#define EP_SHAPE(name, triangle, m, n, rational)                                                                       \
    static ep_outcome packet_##name(const ep_leaf *leaf, const float *net, const float *ray, unsigned rays,            \
                                    uint32_t active, float *t, float *hit, EPCounters *counters)                       \
    {                                                                                                                  \
        return w_packet(leaf, net, ray, rays, active, t, hit, counters, triangle, m, n, rational);                     \
    }                                                                                                                  \
    static ep_outcome single_##name(const ep_leaf *leaf, const float *net, const float *ray, float *t, float *hit,     \
                                    EPCounters *counters)                                                              \
    {                                                                                                                  \
        return f4_single(leaf, net, ray, t, hit, counters, triangle, m, n, rational);                                  \
    }                                                                                                                  \
    static void cells_##name(const ep_leaf *leaf, const float *net, const float *ray, unsigned rays,                   \
                             const unsigned *lanes, unsigned count, const float *from, const float *to, ep_cells *out) \
    {                                                                                                                  \
        w_cells(leaf, net, ray, rays, lanes, count, from, to, out, triangle, m, n, rational);                          \
    }                                                                                                                  \
    static void tangent_##name(const ep_leaf *leaf, const float *net, const float *ray, unsigned rays,                 \
                               uint32_t active, ep_roots *out)                                                         \
    {                                                                                                                  \
        w_tangent(leaf, net, ray, rays, active, out, triangle, m, n, rational);                                        \
    }

EP_DEGREES(tensor, 0, 0)
EP_DEGREES(tensor_rational, 0, 1)
EP_DEGREES(triangle, 1, 0)
EP_DEGREES(triangle_rational, 1, 1)

const ep_kernels EP_KERNELS = {
    .isa = EP_ISA_NAME,
    .width = EP_LANES,
    .packet = EP_ALL(packet),
    .single = EP_ALL(single),
    .tangent = EP_ALL(tangent),
    .cells = EP_ALL(cells),
    .offer = w_offer,
    .settle = w_settle,
    .active = w_active,
    .commit = w_commit,
};
