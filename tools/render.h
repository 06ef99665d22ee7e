/* render.h - a picture of a world: tiles over threads, packets over tiles.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_RENDER_H
#define EPATCH_RENDER_H

#include "tools/film.h"
#include "tools/shade.h"

typedef struct render_result {
    uint64_t camera_rays; /* of the picture                                     */
    uint64_t rays;        /* all, with those of shadows, sky, mirrors and layers */
    double seconds;
    EPCounters cost;
} render_result;

/* Fills the film. The picture does not depend on the number of threads (0: all). */
void render(const shader *s, const view *v, unsigned spp, unsigned threads, film *f, render_result *result);

#endif
