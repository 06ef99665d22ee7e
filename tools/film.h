/* film.h - the image while it is made: colour and layers, floats proportional to light.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_FILM_H
#define EPATCH_FILM_H

#include "tools/files.h"

/* The layers on offer, in the order of their bits in film.layers. */
#define FILM_LAYER_WORDS "depth,normal,uv,prim,object,iterations,slow"

typedef enum film_layer {
    LAYER_DEPTH,      /* distance from the eye; +inf where there is nothing                 */
    LAYER_NORMAL,     /* unit normal, on the side of dP/du x dP/dv                           */
    LAYER_UV,         /* the patch's parameters                                              */
    LAYER_PRIM,       /* index of the patch in its geometry; -1 where there is nothing       */
    LAYER_OBJECT,     /* index of the object; -1 where there is nothing                      */
    LAYER_ITERATIONS, /* evaluations of a surface that the ray through the centre has cost   */
    LAYER_SLOW,       /* leaf visits of that ray that were decided by subdivision            */
    LAYER_COUNT
} film_layer;

#define FILM_MAX_CHANNELS 16

typedef struct film {
    unsigned width, height, channels;
    unsigned layers; /* sum of 1 << film_layer */
    const char *names[FILM_MAX_CHANNELS];
    unsigned first[LAYER_COUNT]; /* channel where a layer begins */
    float *pixels;               /* channels floats a pixel: R, G, B, then the layers; top row first */
} film;

/* How many channels a layer has. */
unsigned film_layer_size(film_layer layer);

/* False without memory. */
bool film_new(film *f, unsigned width, unsigned height, unsigned layers);
void film_free(film *f);

static inline float *film_pixel(const film *f, unsigned x, unsigned y)
{
    return f->pixels + ((size_t)y * f->width + x) * f->channels;
}

/* Can `path` be written with these layers? A sentence in `why` when not. */
bool film_suits(const char *path, unsigned layers, char *why, size_t size);

/* Encodes the image into `o` and closes it; the film's colours are changed by that. False after a message. */
bool film_write(film *f, output *o);

#endif
