/* table_tmpl.h - the kernels of one instruction set, from the templates.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/isa/shapes_tmpl.h"

/* The four kernels of a shape. */
#define EP_SHAPE(name, triangle, m, n, rational)                                                                       \
    EP_PACKET_AND_SINGLE(w_packet, f4_single, name, triangle, m, n, rational)                                          \
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

EP_EVERY_SHAPE

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
