/* on_demand.h - an RTCGeometry whose user primitives are patches, cut into leaves when a ray first enters their box.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_ON_DEMAND_H
#define EP_ON_DEMAND_H

#include "embree_patch/rtc/rtc_geometry.h"

/* The user data is the ep_demand of the geometry and the device. */
extern const ep_callbacks ep_on_demand;

#endif
