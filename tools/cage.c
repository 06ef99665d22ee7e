/* cage.c - the memory of cages. See cage.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/cage.h"

#include <stdlib.h>

void cage_free(cage *c)
{
    if (!c) return;
    free(c->vertices);
    free(c->sizes);
    free(c->corners);
    free(c->creases);
    free(c->sharp);
    free(c->holes);
    free(c);
}

bool cage_grow(void **items, size_t *capacity, size_t count, size_t more, size_t size)
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
