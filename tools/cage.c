/* cage.c - the memory of cages. See cage.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/cage.h"

#include <stdlib.h>

cage *cage_new(void)
{
    cage *c = calloc(1, sizeof *c);
    if (c) c->level = CAGE_LEVEL_DEFAULT;
    return c;
}

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

const char *cage_size_problem(cage_scheme scheme, size_t corners)
{
    if (scheme == CAGE_LOOP) return corners == 3 ? NULL : "Loop's scheme takes triangles only";
    /* OpenSubdiv counts the faces around a vertex, and the middle of a face becomes one, in 16 bits */
    if (corners > 65535) return "a face has more than 65535 corners";
    return corners >= 3 ? NULL : "a face has less than three corners";
}
