/* svg.h - a picture of a domain: its leaves, coloured by what the trims make of them, under the trim curves.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * begin, leaves, curves, end, in this order. u goes to the right, v goes up. Errors of writing add up in the stream;
 * ep_svg_end() reports them. */
#ifndef EP_TRIM_SVG_H
#define EP_TRIM_SVG_H

#include "trim/trim.h"

#include <stdio.h>

void ep_svg_begin(FILE *f, const ep_point2 lo, const ep_point2 hi);
void ep_svg_leaf(FILE *f, ep_trim_state state, unsigned count, const ep_point2 *corners);
void ep_svg_curves(FILE *f, const ep_trim *trim);
bool ep_svg_end(FILE *f);

#endif
