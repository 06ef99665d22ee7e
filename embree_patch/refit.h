/* refit.h - new leaves where only points have moved.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_REFIT_H
#define EP_REFIT_H

#include "embree_patch/hierarchy.h"

/* Fits the leaves of *h anew to `patches`, which differ from those that it was built of in their points and weights:
 * the same leaves of the same domains in the same order. Takes `patches` over in place of h->patches; on failure they
 * are the caller's, and *h is as it was. The leaves do not depend on the number of threads. */
EPStatus ep_refit(ep_hierarchy *h, ep_patch *patches, const EPBuildSettings *settings, ep_message *message);

#endif
