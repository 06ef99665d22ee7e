/* json_trim.h - reads the trims of JSON scenes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_JSON_TRIM_H
#define EPATCH_JSON_TRIM_H

#include "embree_patch/embree_patch.h"
#include "test/oracle/trim_reference.h"
#include "tools/json_walk.h"

/* The complete region that a trim describes, and the same as it is written. False after a message. */
bool json_read_trim(const json_reader *r, const json_node *n, EPRegion *region, trim_shape **shape);

#endif
