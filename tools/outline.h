/* outline.h - how far a scene reaches: points that frame it, and from where rays may come.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_OUTLINE_H
#define EPATCH_OUTLINE_H

#include "tools/world.h"

/* Points of the surfaces in the world, a grid for every patch, or for fewer when there are very many. malloc'ed; NULL
 * without memory. */
double (*outline_new(const world *w, size_t *count))[3];

/* The farthest |origin| of a ray that starts on a surface, at `c`, or, when c is NULL, at an eye that frames the whole
 * scene. For world_options.ray_distance. */
double outline_reach(const scene *s, const camera *c);

#endif
