/* scene_place.h - objects put where their transforms say; scene_read() does it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_SCENE_PLACE_H
#define EPATCH_SCENE_PLACE_H

#include "tools/scene.h"

/* Gives transformed objects geometries of their own, whose control points are where the object is, and takes their
 * transforms from them. Objects that would need too many copies, or are too small for floats where they are, keep
 * theirs. False after a message. */
bool scene_place(scene *s);

#endif
