/* visits.h - how many rays come to a leaf, and whether cutting it would pay.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_VISITS_H
#define EP_VISITS_H

#include "embree_patch/leaf.h"

/* Half the surface of the box with these bounds, as ep_hierarchy.bounds. */
double ep_half_surface(const float bounds[6]);

/* Of the rays that cross a box with this half surface the share that will meet the box of a fitted piece, the part `d`
 * of its patch: more or less, before it is padded. */
double ep_visits(const ep_fit *fit, const ep_domain *d, double half_surface);

/* A piece that is met by a share of `visits`: do so few rays meet it that a pole or a fold in it may cost them dear? */
bool ep_is_seldom_met(double visits);

/* A piece that is a leaf as far as the surface goes, and met by a share of `visits`: would halving it save more visits
 * than it costs? *along: its first side (0) or its second. Never of triangles, which are quartered: quarters of a
 * slender triangle are as slender. */
bool ep_is_askew(const ep_fit *fit, double visits, unsigned *along);

#endif
