/* build.h - from patches to leaves.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_BUILD_H
#define EP_BUILD_H

#include "embree_patch/hierarchy.h"

/* Cuts patches[0..count), whose kind, degrees and points are set, into leaves of what the trims keep. Takes `patches`
 * and `trims` over: on success they belong to *out, on failure to the caller as before. The leaves do not depend on the
 * number of threads. */
EPStatus ep_build(ep_patch *patches, const ep_trim **trims, size_t count, const EPBuildSettings *settings,
                  ep_message *message, ep_hierarchy *out);

/* The same without leaves: measures the patches and makes a box of each. */
EPStatus ep_build_boxes(ep_patch *patches, const ep_trim **trims, size_t count, const EPBuildSettings *settings,
                        ep_message *message, ep_hierarchy *out);

/* Cuts one patch of such a hierarchy into the leaves that ep_build would have made. *out has the patches and trims of
 * `boxes`, but they are not its own. *error is what ep_patch.error would be. */
EPStatus ep_build_one(const ep_hierarchy *boxes, uint32_t index, const EPBuildSettings *settings, ep_hierarchy *out,
                      double *error);

#endif
