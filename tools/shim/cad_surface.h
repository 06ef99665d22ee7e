/* cad_surface.h - the surface of a face as a NURBS surface.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAD_SURFACE_H
#define EPATCH_CAD_SURFACE_H

#include "tools/shim/cad_net.h"

#include <Geom_Surface.hxx>

#include <optional>

namespace cad
{

struct surface {
    net patches;
    std::optional<arcs> angles[2]; /* of parameters that were angles */
    range box[2];                  /* in the parameters of the file's surface */

    double parameter(int direction, double x) const { return angles[direction] ? angles[direction]->parameter(x) : x; }
};

/* What is under the trims, whose parameters are the same. */
Handle(Geom_Surface) untrimmed(const Handle(Geom_Surface) & s);

/* The part over `box`, or over what there is of it. Throws `unusable`. */
surface convert(const Handle(Geom_Surface) & s, const range box[2]);

} // namespace cad
#endif
