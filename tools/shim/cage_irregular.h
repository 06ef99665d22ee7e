/* cage_irregular.h - what OpenSubdiv's refined meshes look like around an extraordinary vertex.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAGE_IRREGULAR_H
#define EPATCH_CAGE_IRREGULAR_H

#include "tools/cage_rings.h"

#include <opensubdiv/far/patchParam.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>

/* Is the surface of a mesh smooth but at borders, and these are regular, and are there no holes? */
bool cage_is_smooth(const OpenSubdiv::Far::TopologyLevel &mesh);

/* The face of a level that a patch is over, and its corner that is extraordinary; -1: there are none or several, or it
 * is not smooth, or not regular around it. */
struct cage_irregular {
    int level;
    OpenSubdiv::Far::Index face, centre;
    int corner;
    size_t valence;
};

/* Of a patch of the cage's face, or of a quadrilateral of it. */
cage_irregular cage_find_irregular(const OpenSubdiv::Far::TopologyRefiner &refiner, uint32_t face, uint32_t quad,
                                   const OpenSubdiv::Far::PatchParam &param);

/* The vertices around its corner; sector 0 is the face. `points`: those of the level. */
void cage_gather(const OpenSubdiv::Far::TopologyLevel &level, const cage_irregular &of, const double (*points)[3],
                 cage_rings *r);

#endif
