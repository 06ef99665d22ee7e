/* stats.h - the JSON objects that commands write.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_STATS_H
#define EPATCH_STATS_H

#include "tools/world.h"

#include <jansson.h>

/* How a world was built, and what it holds by now: build_seconds, bytes_patches, bytes_embree, leaves, isa. NULL when
 * there is no memory; so are the others. */
json_t *stats_of_world(const world *w);

/* What tracing cost: newton_iterations_mean, slow_path_rays, visits, solves, cells. */
json_t *stats_of_cost(const EPCounters *cost);

/* Mean evaluations of a surface in one iteration; 0 when there was none. */
double stats_mean_iterations(const EPCounters *cost);

/* A file's name, which JSON can hold only when it is UTF-8: else what is not ASCII becomes '?'. */
json_t *stats_name(const char *path);

/* Adds the members of `more` to `object` and releases `more`. False when there is no memory; NULLs are that, too. */
bool stats_add(json_t *object, json_t *more);

/* Writes the object to `path` ("-": standard output) and releases it; NULL means that there was no memory to make it.
 * False after a message. */
bool stats_write(const char *path, json_t *object);

#endif
