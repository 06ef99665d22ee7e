/* cage_build.h - puts a cage together, item by item. A reader knows where an item stands in its file and that indices
 * are in range; what is allowed besides is known here.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Functions that return a string return NULL, or what is wrong. */
#ifndef EPATCH_CAGE_BUILD_H
#define EPATCH_CAGE_BUILD_H

#include "tools/model.h"

typedef struct cage_builder {
    cage *cage;
    uint32_t *last_face; /* of each vertex: the number, from 1, of the last face that has it */
    size_t last_capacity;
    size_t face_first; /* the first corner of the face that is being written */
} cage_builder;

/* An empty cage with these options. False without memory. */
bool cage_begin(cage_builder *b, const model_options *o);
/* The cage, which is the caller's; the builder is done. */
cage *cage_end(cage_builder *b);

const char *cage_add_vertex(cage_builder *b, const double p[3]);
/* A face is its corners, then the word that it is complete. */
const char *cage_add_face_corner(cage_builder *b, uint32_t vertex);
const char *cage_add_face(cage_builder *b);
const char *cage_add_crease(cage_builder *b, uint32_t from, uint32_t to, float sharpness);
const char *cage_add_corner(cage_builder *b, uint32_t vertex, float sharpness);
const char *cage_add_hole(cage_builder *b, uint32_t face);

/* A number from a file as a sharpness. */
const char *cage_sharpness(double from, float *to);

#endif
