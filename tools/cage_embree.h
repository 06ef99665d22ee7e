/* cage_embree.h - a cage as Embree's own subdivision geometry, to compare with.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAGE_EMBREE_H
#define EPATCH_CAGE_EMBREE_H

#include "embree_patch/rtc/rtc_compat.h"
#include "tools/scene.h"

/* Has every geometry of the scene that has patches a cage that Embree takes for the same surface? It knows Catmull and
 * Clark's scheme, and neither Chaikin's rule nor weights for triangles; holes shape nothing there. Around corners of a
 * single face that are not sharp, and where sharpness changes along a crease, its surface is another all the same:
 * errors tell. */
bool cage_embree_possible(const scene *s);

/* An uncommitted RTCGeometry of the cage of g that is cut into `rate` segments an edge. Its primID, u and v are those
 * of cage.h. NULL when Embree fails. */
RTCGeometry cage_embree_geometry(const scene_geometry *g, RTCDevice device, unsigned rate);

#endif
