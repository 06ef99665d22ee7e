/* array.c - see array.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/array.h"

#include <stdint.h>
#include <stdlib.h>

bool array_grow(void **items, size_t *capacity, size_t count, size_t more, size_t size)
{
    if (more <= *capacity - count) return true;
    size_t to = *capacity ? *capacity : 16;
    while (to < count + more)
        if (to > SIZE_MAX / 2 / size) return false;
        else to *= 2;
    void *grown = realloc(*items, to * size);
    if (!grown) return false;
    *items = grown;
    *capacity = to;
    return true;
}
