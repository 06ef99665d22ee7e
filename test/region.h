/* region.h - random trims for the library.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef TEST_REGION_H
#define TEST_REGION_H

#include "embree_patch/embree_patch.h"
#include "test/test_trim.h"

/* The region that a shape describes. Fails the test if there is none. */
EPRegion new_region(const trim_shape *s);

#endif
