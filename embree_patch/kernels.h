/* kernels.h - what an instruction set provides: rays against one leaf.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The templates in isa/ are compiled once per instruction set and export one constant table each. All tables give the
 * same bits: a verb rounds once, fused multiply-adds are written out, the compiler may not form its own. The packet
 * kernel has one ray a lane; the single-ray kernel has one coordinate a lane and performs, for its ray, the very same
 * operations in the same order. */
#ifndef EP_KERNELS_H
#define EP_KERNELS_H

#include "embree_patch/leaf.h"

/* Rays come as Embree lays them out, field f of lane i at ray[f * n + i], n = 1, 4, 8 or 16. */
enum { EP_RAY_ORG = 0, EP_RAY_TNEAR = 3, EP_RAY_DIR = 4, EP_RAY_TFAR = 8, EP_RAY_FIELDS = 12 };

/* So do hits: Ng at hit[c * n + i], u and v after it. */
enum { EP_HIT_NG = 0, EP_HIT_U = 3, EP_HIT_V = 4 };

#define EP_PACKET 16

/* One bit a lane; all of it fits into a register. A lane in no set is certified to miss the leaf within (tnear, tfar).
 * t[] and hit[] hold a root for `hit` and for `vague`: the leaf's only one in (tnear, tfar], certainly, where hit is
 * set; ep_polish has to find it again where vague is, and where only that is, also to say whether it is in there. */
typedef struct ep_outcome {
    uint16_t hit;
    uint16_t tie; /* those of hit at tfar itself: in front of the ray's hit or behind it? */
    uint16_t vague;
    uint16_t slow; /* undecided: look closer                                              */
} ep_outcome;

/* `net` is the leaf's own. */
typedef ep_outcome ep_packet_kernel(const ep_leaf *leaf, const float *net, const float *ray, unsigned n,
                                    uint32_t active, float *t, float *hit, EPCounters *counters);

/* The same for a packet of one. */
typedef ep_outcome ep_single_kernel(const ep_leaf *leaf, const float *net, const float *ray, float *t, float *hit,
                                    EPCounters *counters);

/* What became of a packet's nearly tangent rays: up to two roots each, in no order, perhaps the same one twice. */
typedef struct ep_roots {
    float *t[2], *hits[2];      /* where they go; lanes and fields as in a packet             */
    float radius[2][EP_PACKET]; /* how accurate they are, in leaf coordinates                 */
    uint32_t hit[2], vague[2];  /* as above, but also roots beyond tfar and just before tnear */
    uint32_t open;              /* undecided: look closer, whatever was found                 */
} ep_roots;

/* For lanes that the other two have left undecided; n may be 1. */
typedef void ep_tangent_kernel(const ep_leaf *leaf, const float *net, const float *ray, unsigned n, uint32_t active,
                               ep_roots *out);

/* An undecided ray's way through a leaf is cut into so many cells; up to EP_PACKET / EP_CELLS rays at a time. */
#define EP_CELLS 4

/* What became of cell c of ray r: element r EP_CELLS + c; cells in order of t. */
typedef struct ep_cells {
    alignas(64) float t[EP_PACKET]; /* the root's                                              */
    float middle[EP_PACKET];        /* the cell's middle ...                                   */
    float reach[EP_PACKET];         /* ... and half its length, in t                           */
    float radius[EP_PACKET];        /* how accurate it is, in leaf coordinates                 */
    float fields[5 * EP_PACKET];    /* Ng, u, v as in a hit packet of 16                       */
    uint32_t hit, vague;            /* has a root near this cell, the first of it              */
    uint32_t more;                  /* those that may have another root, farther on            */
    uint32_t open;                  /* undecided                                               */
    uint32_t hopeless;              /* of a ray that no cells would decide                     */
} ep_cells;

/* Rays lanes[0] to lanes[count - 1] of a packet of n. The cells of the r-th divide the part from[r] to to[r] of its way
 * through the leaf's prism, all of which is -1 to 1. Cells outside (tnear, tfar) are left out. */
typedef void ep_cells_kernel(const ep_leaf *leaf, const float *net, const float *ray, unsigned n, const unsigned *lanes,
                             unsigned count, const float *from, const float *to, ep_cells *out);

typedef struct ep_kernels {
    const char *isa;
    unsigned width;                      /* lanes a step */
    ep_packet_kernel *packet[EP_SHAPES]; /* n = 4, 8, 16 */
    ep_single_kernel *single[EP_SHAPES]; /* n = 1        */
    ep_tangent_kernel *tangent[EP_SHAPES];
    ep_cells_kernel *cells[EP_SHAPES];
    /* What a filter needs around it, for packets of n = 4, 8, 16. `before` and `valid` have room for 16 and are
     * aligned. offer: valid = -1 in `mask` and 0 elsewhere; the rays' tfar becomes t there, and all of it is kept in
     * before. settle: gives tfar back to lanes of `mask` that are no longer valid, and returns those that are. active:
     * the lanes where valid is -1. commit: writes the first `fields` rows of hit to the lanes in `mask`. */
    void (*offer)(float *ray, unsigned n, uint32_t mask, const float *t, float *before, int *valid);
    uint32_t (*settle)(float *ray, unsigned n, uint32_t mask, const float *before, const int *valid);
    uint32_t (*active)(const int *valid, unsigned n);
    void (*commit)(float *rayhit, unsigned n, uint32_t mask, const float *hit, unsigned fields);
} ep_kernels;

extern const ep_kernels ep_kernels_plain; /* runs everywhere; what the others are compared with */

/* The kernels by name; the best for NULL; NULL if this machine or build has no such. */
const ep_kernels *ep_find_kernels(const char *isa);

#endif
