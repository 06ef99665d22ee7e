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
