/* json_triangles.h - curved triangles in JSON scenes, see triangles.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_JSON_TRIANGLES_H
#define EPATCH_JSON_TRIANGLES_H

#include "tools/json_walk.h"
#include "tools/scene.h"

/* Fill an empty geometry by what `n` says. False after a message. */
bool json_read_quadratic_triangles(const json_reader *r, const json_node *n, scene_geometry *g);
bool json_read_phong_triangles(const json_reader *r, const json_node *n, scene_geometry *g);
bool json_read_pn_triangles(const json_reader *r, const json_node *n, scene_geometry *g);

#endif
