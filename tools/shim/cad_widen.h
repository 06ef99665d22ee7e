/* cad_widen.h - boundaries that reach their edges.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAD_WIDEN_H
#define EPATCH_CAD_WIDEN_H

#include "tools/shim/cad_trim.h"

namespace cad
{

/* Moves the sides of a face's loops out of it by what they miss their edges by. */
void widen(std::vector<loop> &loops, const Handle(Geom_Surface) & s);

} // namespace cad
#endif
