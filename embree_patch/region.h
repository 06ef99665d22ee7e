/* region.h - what is behind an EPRegion.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_REGION_H
#define EP_REGION_H

#include "trim/trim.h"

#include <stdatomic.h>

struct EPRegionTy {
    atomic_int references;
    ep_region *region;
    ep_trim *trim; /* once the region is complete, which makes all of this constant */
    ep_message message;
};

/* What a complete region has allocated. */
size_t ep_region_object_bytes(EPRegion region);

#endif
