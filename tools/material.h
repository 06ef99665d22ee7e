/* material.h - what a name such as "steel" or "red plastic" looks like.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_MATERIAL_H
#define EPATCH_MATERIAL_H

#include "tools/vec.h"

typedef struct material {
    vec3 albedo;     /* diffuse; black for metals                          */
    vec3 reflection; /* specular reflectance at normal incidence           */
    float roughness; /* how far reflections are blurred, in radians, about */
} material;

/* Words in any order and case: colours ("red"), finishes ("plastic", "porcelain"), metals ("steel"). A name without
 * a known word gets a colour of its own, always the same. NULL: the neutral default. */
material material_named(const char *name);

#endif
