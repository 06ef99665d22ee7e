/* json_patches.h - patches and NURBS surfaces in JSON scenes, and their trims.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_JSON_PATCHES_H
#define EPATCH_JSON_PATCHES_H

#include "tools/json_walk.h"
#include "tools/scene.h"

/* Fill an empty geometry by what `n` says. False after a message. */
bool json_read_bezier_triangles(const json_reader *r, const json_node *n, scene_geometry *g);
bool json_read_bezier(const json_reader *r, const json_node *n, scene_geometry *g);
bool json_read_nurbs(const json_reader *r, const json_node *n, scene_geometry *g);

/* "patches": of one kind and degree, each with its trim. */
bool json_read_patches(const json_reader *r, const json_node *n, patch_kind kind, const unsigned degree[2],
                       scene_geometry *g);

/* Trims the patches that have no trim of their own. */
bool json_trim_all(const json_reader *r, const json_node *n, scene_geometry *g);

#endif
