/* obj_tags.h - OpenSubdiv's tags in Wavefront OBJ files: what a cage has besides vertices and faces.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_OBJ_TAGS_H
#define EPATCH_OBJ_TAGS_H

#include "tools/cage_build.h"
#include "tools/obj_text.h"

typedef struct obj_tags {
    obj_text *text;
    cage_builder *builder;
    const cage_boundary *boundary; /* NULL: as the file says */
} obj_tags;

/* All tags from here to the end of the text, when the cage has its vertices and faces. False after a message. */
bool obj_read_tags(obj_tags *g);

#endif
