/* bench_newton_kernels.h - kernels that certify nothing, for one instruction set each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_BENCH_NEWTON_KERNELS_H
#define EPATCH_BENCH_NEWTON_KERNELS_H

#include "embree_patch/kernels.h"

typedef struct newton_kernels {
    ep_packet_kernel *packet[EP_SHAPES];
    ep_single_kernel *single[EP_SHAPES];
} newton_kernels;

extern const newton_kernels newton_kernels_plain;
#if EP_HAVE_X86
extern const newton_kernels newton_kernels_avx2, newton_kernels_avx512;
#endif

/* Steps before a ray is taken to miss, and the step in leaf coordinates that ends with a hit: what it leaves is of the
 * third order, 2^-17 of the leaf times its bend. */
#define NEWTON_STEPS 4
#define NEWTON_NEAR 0x1p-5f

/* How far outside the leaf a hit may be. */
#define NEWTON_RIM 0x1p-20f

#endif
