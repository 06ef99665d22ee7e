/* shade.h - the light that comes along a ray.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Every hit is lit by the key light (a shadow ray each), by the sky as far as it is seen (occlusion rays), and by
 * what it mirrors (a reflected ray). The surroundings are known in closed form, so that only the edges of shadows
 * are sampled. Surfaces are open sheets: both sides are shaded alike. */
#ifndef EPATCH_SHADE_H
#define EPATCH_SHADE_H

#include "tools/light.h"
#include "tools/material.h"
#include "tools/sampler.h"
#include "tools/world.h"

typedef struct shade_object {
    EPGeometry geometry;
    material material;
    double to_object[12]; /* the inverse of the object's transform */
    double scale;         /* no vector of the geometry becomes longer than so many times its length */
    bool identity;
} shade_object;

typedef struct shader {
    const world *world;
    const light *light;
    shade_object *objects;
    bool exact; /* patches, not triangles */
    bool ground;
    float ground_height; /* along light->up */
} shader;

/* False without memory. The world and the light must outlive it. */
bool shader_new(shader *s, const world *w, const light *l, bool exact, bool ground);
void shader_free(shader *s);

/* What the points of one camera sample are for, see sampler.h; each depth of reflection has its own. */
enum { USE_PIXEL, USE_KEY, USE_SKY, USE_GLOSS, SAMPLE_USES };

/* Where on the picture a camera ray belongs, and what tells its samples from others. */
typedef struct shade_sample {
    sampler sampler;
    float x, y;    /* in [-1, 1] about the picture's centre, for the background */
    uint64_t rays; /* traced on the way, added up                               */
} shade_sample;

/* Radiance that arrives along a camera ray that hit `hit`. d is a unit vector. */
vec3 shade(const shader *s, vec3 org, vec3 d, const world_hit *hit, shade_sample *at);

#endif
