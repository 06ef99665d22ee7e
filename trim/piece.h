/* piece.h - a piece of a trim curve on which x and y are monotone, and on which side of it a point lies.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A contour is counted along the ray from the point towards +x, the way a scan line is: a piece counts when the point's
 * y is in the half-open interval [low.y, high.y) and the piece passes on the right there. Pieces that meet have equal
 * ends, bit for bit, so no ray slips through or counts twice, however near to an end it passes. */
#ifndef EP_TRIM_PIECE_H
#define EP_TRIM_PIECE_H

#include "trim/curve.h"

typedef struct ep_piece {
    ep_point2 low, high; /* the ends, low[1] <= high[1]             */
    uint32_t first;      /* of its degree+1 points, from low to high */
    uint32_t degree;
    uint32_t curve; /* of the region, that it was cut from; UINT32_MAX is never one */
    uint32_t falls; /* 1: x decreases from low to high */
} ep_piece;

/* For low.y <= y < high.y: is the piece on the right of (x, y)? Right whenever the point is further from the curve than
 * evaluating it rounds (curve.h). */
bool ep_piece_is_right(const ep_piece *p, const ep_point2h *points, double x, double y);

/* The same for all points of the square of half side `reach` about (x, y), which is not beside the piece's box; NEAR
 * when it may enter the square. */
typedef enum ep_side { EP_SIDE_LEFT, EP_SIDE_RIGHT, EP_SIDE_NEAR } ep_side;
ep_side ep_piece_side(const ep_piece *p, const ep_point2h *points, double x, double y, double reach);

/* Cuts the curve into pieces. There is room for EP_PIECES pieces of degree+1 points each, from low to high;
 * first, curve are the caller's. Pieces without length are left out. Returns their number. */
enum { EP_PIECES = EP_CURVE_CUTS + 1 };
unsigned ep_piece_cut(const ep_point2h *curve, unsigned degree, const ep_point2 from, const ep_point2 to,
                      ep_piece *pieces, ep_point2h *points);

#endif
