/* obj_curve2.h - the 2D curves of a file, pieces of which make the loops of trims.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Functions that return a string return NULL, or what is wrong in words that live until the next call. */
#ifndef EPATCH_OBJ_CURVE2_H
#define EPATCH_OBJ_CURVE2_H

#include "tools/loops.h"
#include "tools/obj_net.h"

typedef struct obj_curves {
    obj_net *all; /* Euclidean points u, v, 0 with weights */
    size_t count, capacity;
    size_t points_left; /* that pieces may have: a short line can name a long curve again and again */
} obj_curves;

/* Takes the net over, also on failure. */
const char *obj_curves_add(obj_curves *c, obj_net *n);

/* The loop goes on with a part of a curve, backwards where from > to. */
const char *obj_curves_piece(obj_curves *c, size_t curve, double from, double to, loops *l);

void obj_curves_free(obj_curves *c);

#endif
