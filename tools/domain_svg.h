/* domain_svg.h - a picture of a patch's parameter domain, its leaves and its trim curves.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_DOMAIN_SVG_H
#define EPATCH_DOMAIN_SVG_H

#include "tools/world.h"

/* Patch `index`, counted through all geometries, but for copies, of a world of exact patches. False after a message. */
bool domain_svg_write(const world *w, size_t index, const char *path);

#endif
