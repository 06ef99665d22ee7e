/* scene_json.h - the reader of JSON scenes; scene_read() in scene.h is the way in.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_SCENE_JSON_H
#define EPATCH_SCENE_JSON_H

#include "tools/scene.h"

/* Fills an empty scene. Leaves `objects` NULL when the file has none. False after a message. */
bool scene_read_json(const char *path, scene *s);

#endif
