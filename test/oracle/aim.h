/* aim.h - rays that are worth asking about.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef ORACLE_AIM_H
#define ORACLE_AIM_H

#include "test/oracle/oracle.h"
#include "test/oracle/rng.h"

typedef enum aim_kind {
    AIM_AT,      /* from outside, at or close by the surfaces                            */
    AIM_INSIDE,  /* from anywhere in the box, anywhere                                   */
    AIM_GRAZING, /* through, or just past, a point where the surface is nearly edge-on   */
    AIM_BORDER,  /* at points on the patches' borders, a quarter of them corners         */
    AIM_AXIS,    /* along an axis, half of them through a point of a surface             */
    AIM_KINDS
} aim_kind;

extern const char *const aim_names[AIM_KINDS];

/* The ray is the same for the same state of `r`. Origins are within 30 diagonals of the box of everything. */
void aim(const oracle *o, aim_kind kind, rng *r, float org[3], float dir[3]);

/* A point of a patch's domain, evenly; and one on its border. */
void aim_domain(const oracle *o, uint32_t patch, rng *r, double *u, double *v);
void aim_border(const oracle *o, uint32_t patch, rng *r, double *u, double *v);

#endif
