/* obj_surface.h - the trims of a free-form surface, and what it becomes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_OBJ_SURFACE_H
#define EPATCH_OBJ_SURFACE_H

#include "tools/obj_free.h"

/* Statements of the open surface. False after a message. */
bool obj_surface_trim(obj_free *f);
bool obj_surface_hole(obj_free *f);
bool obj_surface_end(obj_free *f);

#endif
