/* obj_element.h - curves and surfaces of the free-form part of an OBJ file: control points and parameters.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Curves in space bound nothing and are skipped. Functions return false after a message. */
#ifndef EPATCH_OBJ_ELEMENT_H
#define EPATCH_OBJ_ELEMENT_H

#include "tools/obj_free.h"

/* Statements. */
bool obj_open_curve(obj_free *f);
bool obj_open_curve2(obj_free *f);
bool obj_open_surface(obj_free *f);
bool obj_parameters(obj_free *f);
bool obj_end(obj_free *f);

/* The control net of the open element, complete and as B-splines; the caller's. */
bool obj_element_net(obj_free *f, obj_net *n);

#endif
