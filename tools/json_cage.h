/* json_cage.h - reads subdivision cages in JSON scenes, and how model files are to be taken as cages.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_JSON_CAGE_H
#define EPATCH_JSON_CAGE_H

#include "tools/json_walk.h"
#include "tools/model.h"

/* Fills an empty geometry with the surface of a geometry of type "subdivision". False after a message. */
bool json_read_cage(const json_reader *r, const json_node *n, scene_geometry *g);

/* "as", "scheme", "level" and "boundary" of a geometry of type "file". False after a message. */
bool json_read_model_options(const json_reader *r, const json_node *n, model_options *o);

#endif
