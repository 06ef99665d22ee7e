/* cage_irregular.h - what OpenSubdiv's refined meshes look like around an extraordinary vertex.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAGE_IRREGULAR_H
#define EPATCH_CAGE_IRREGULAR_H

#include "tools/cage_rings.h"

#include <opensubdiv/far/patchParam.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>
#include <vector>

/* Is the surface of a mesh smooth but at borders, and these are regular, and are there no holes? */
bool cage_is_smooth(const OpenSubdiv::Far::TopologyLevel &mesh);

/* The face of a level that a patch is over, and its corner that is extraordinary; -1: there are none or several. */
struct cage_irregular {
    int level;
    OpenSubdiv::Far::Index face, centre;
    int corner;
};

/* Of a patch of the cage's face, or of a quadrilateral of it. */
cage_irregular cage_find_irregular(const OpenSubdiv::Far::TopologyRefiner &refiner, uint32_t face, uint32_t quad,
                                   const OpenSubdiv::Far::PatchParam &param);

/* Is a vertex smooth, and regular all around it? */
bool cage_has_rings(const OpenSubdiv::Far::TopologyLevel &level, OpenSubdiv::Far::Index v);

/* Fills in the vertices around such a corner, from `points` of the level, and returns the sectors' faces; the first is
 * that of the corner. */
std::vector<OpenSubdiv::Far::Index> cage_gather(const OpenSubdiv::Far::TopologyLevel &level, const cage_irregular &of,
                                                const double (*points)[3], cage_rings *r);

#endif
