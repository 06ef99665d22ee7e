/* array.h - arrays that grow.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_TRIM_ARRAY_H
#define EP_TRIM_ARRAY_H

#include "embree_patch/base.h"

#include <string.h>

/* Makes room for `more` further items of `size` bytes behind the `count` that are there, doubling. False and
 * unchanged when there is no memory. */
static inline bool ep_array_reserve(void **items, size_t *capacity, size_t count, size_t more, size_t size)
{
    if (more <= *capacity - count) return true;
    if (more > SIZE_MAX / 4 - count) return false;
    const size_t room = 2 * (count + more);
    void *p = ep_alloc(room, size);
    if (!p) return false;
    if (count) memcpy(p, *items, count * size);
    ep_free(*items);
    *items = p;
    *capacity = room;
    return true;
}

#endif
