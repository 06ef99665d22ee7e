/* trimmed.h - what a trim makes of the parts of a patch's domain: trim/'s view of the hierarchy's domains.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_TRIMMED_H
#define EP_TRIMMED_H

#include "embree_patch/patch.h"
#include "trim/trim.h"

/* A domain as trim/ wants it, with a seam. */
ep_trim_domain ep_trimmed_domain(ep_kind_id kind, const ep_domain *d);

/* Is a crossed domain, of which the trim leaves `part`, to be divided further? `visits`: the share of rays that come to
 * it. */
bool ep_trimmed_wants_split(const ep_trim *trim, const ep_trim_part *part, ep_kind_id kind, const ep_domain *d,
                            EPTrimSplit way, double visits);

/* Divides it into at most EP_TRIMMED_PARTS, which together are the domain. Returns their number. `distortion`: how far
 * the parametrisation over it is from affine, at its own size. */
enum { EP_TRIMMED_PARTS = 8 };
unsigned ep_trimmed_split(const ep_trim *trim, const ep_trim_part *part, ep_kind_id kind, const ep_domain *d,
                          EPTrimSplit way, double distortion, ep_domain parts[EP_TRIMMED_PARTS]);

#endif
