/* cage_merge.h - bicubic patches side by side that are one polynomial become one patch.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAGE_MERGE_H
#define EPATCH_CAGE_MERGE_H

#include "tools/shim/cage_osd.h"

#include <stddef.h>

/* Merges what can be merged of the patches of one face or quadrilateral, rectangles of its parameter plane, in place,
 * and returns how many are left, in another order. */
size_t cage_merge(cage_patch *patches, size_t count);

#endif
