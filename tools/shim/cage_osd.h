/* cage_osd.h - the limit surface of a cage as Bézier patches, by OpenSubdiv.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAGE_OSD_H
#define EPATCH_CAGE_OSD_H

#include "tools/cage.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The control points of a patch, and where it is in its face. */
typedef struct cage_patch {
    uint32_t face;        /* of the cage                                                                */
    uint32_t quad;        /* of a polygon: which of its quadrilaterals                                  */
    double place[6];      /* maps the patch's s, t to those of the face or quadrilateral                */
    double points[16][3]; /* bicubic, u fastest; or, with Loop's scheme, the 15 of a quartic triangle */
} cage_patch;

/* Calls `take` for each patch, face by face. Returns NULL, or a sentence that says what OpenSubdiv did not like, or
 * that memory ran out, in a buffer of the thread's own, as is *note: "", or what OpenSubdiv has overlooked, such as a
 * crease where there is no edge. `take` returns false to end early, which is no failure. */
const char *cage_patches(const cage *c, bool (*take)(void *user, const cage_patch *p), void *user, const char **note);

#ifdef __cplusplus
}
#endif
#endif
