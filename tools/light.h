/* light.h - what surrounds the scene: a photographer's studio, or a panorama from a file.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * It is seen in three ways, none of which has noise of its own: as radiance in a direction, blurred as much as the
 * surface that reflects it; as one key light with soft shadows; and as the irradiance of all the rest, which the
 * shader multiplies by how much of the sky a point sees. */
#ifndef EPATCH_LIGHT_H
#define EPATCH_LIGHT_H

#include "tools/camera.h"

#include <stdbool.h>

typedef struct panorama {
    unsigned width, height;
    float *rgb;
    struct panorama *half; /* the same with half the resolution; NULL at the end */
} panorama;

/* A soft box: a bright rectangle at infinity. */
typedef struct soft_box {
    vec3 n, s, t;        /* towards its centre, and along its width and height */
    float width, height; /* tangents of half the angles it covers              */
    float radiance;
} soft_box;

#define STUDIO_BOXES 3

typedef struct light {
    soft_box boxes[STUDIO_BOXES];
    vec3 up, right, back;   /* the studio stands around the camera: back points from the target to it */
    vec3 key, key_s, key_t; /* towards the key light, and across it                                    */
    vec3 key_irradiance;    /* on a surface that faces it, divided by pi                               */
    float key_spread;       /* tangent of the half angle from which it shines                          */
    vec3 ambient[9];        /* irradiance of the rest over pi, in spherical harmonics up to degree 2   */
    panorama *panorama;     /* NULL: the studio                                                        */
    float exposure;         /* of the panorama, so that it lights as strongly as the studio             */
} light;

/* The studio, with its key light above the viewer's left shoulder. */
void light_studio(light *l, const view *v);

/* A panorama (latitude-longitude, z or the view's up axis up); its brightest spot becomes the key light. False after
 * a message. */
bool light_panorama(light *l, const view *v, const char *path);

void light_free(light *l);

/* Radiance from the unit direction d, averaged over about `blur` radians. */
vec3 light_radiance(const light *l, vec3 d, float blur);

/* A direction towards the key light, from two numbers in [0, 1). */
vec3 light_key_direction(const light *l, float x, float y);

/* Irradiance over pi of all but the key light, on a surface with unit normal n that sees everything. */
vec3 light_ambient(const light *l, vec3 n);

/* What the camera sees behind everything, at (x, y) in [-1, 1] about the centre of the picture. */
vec3 light_background(const light *l, vec3 d, float x, float y);

#endif
