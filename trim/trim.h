/* trim.h - a region made ready: which points, which parts of a domain are inside?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The curves are cut once into pieces on which both coordinates are monotone (piece.h). A part is what of the region's
 * tree can still decide anything in one convex domain: operators over contours, and for each contour the few pieces
 * that enter the domain. A hierarchy starts at the root, cuts the part again for each of the domains that it divides
 * its own into, drops what is outside, forgets about what is inside, and stores the parts of its crossed leaves in one
 * array of words, where ep_trim_inside() tests points against them:
 *
 *     ep_trim_part part;
 *     ep_trim_cut(trim, &trim->root, &domain, &part, &m);
 *     if (part.state == EP_TRIM_CROSSED) ep_trim_keep(trim, &part, &domain, &store, &node, &m);
 *     ...
 *     mask = ep_trim_inside(trim, store.words, node, 16, u, v, mask);
 *
 * Threads: a trim is constant once it is made. Parts and stores belong to one thread each; a stored node holds no
 * addresses, so stores may be moved and concatenated. */
#ifndef EP_TRIM_TRIM_H
#define EP_TRIM_TRIM_H

#include "trim/domain.h"
#include "trim/region.h"

/* Nodes: 32-bit words in prefix order. The first word of each is
 *   bits 0-2   kind
 *   bit  3     LIST: is a point inside that all of its pieces pass on the left?   STRIP: are points below inside?
 *   bit  4     STRIP: are points above inside?   SPLIT: the axis
 *   bits 5-31  the number of words of the node with all below it
 * and then
 *   EP_NODE_LIST    one contour: a word for each piece, index * 16 + 4 * beyond its low end + beyond its high end
 *   EP_NODE_ANY     union of the nodes that follow
 *   EP_NODE_ALL     their intersection
 *   EP_NODE_SPLIT   float c; the node for coordinate < c, the node for the rest
 *   EP_NODE_STRIP   floats a, b, lo, hi: below is a u + b v < lo, above is > hi; the node between
 *   EP_NODE_BOX     floats u0, v0, u1, v1: beyond them all is outside; the node within
 *   EP_NODE_REGION  nothing: the region's own cells decide
 *   EP_NODE_GRID    doubles u0, v0, cells a unit of u, of v; their numbers nu + nv * 65536; then for each cell, row by
 *                   row in u, 0: outside, 1: inside, or how many words behind the first its node is */
typedef enum ep_node_kind {
    EP_NODE_LIST,
    EP_NODE_ANY,
    EP_NODE_ALL,
    EP_NODE_SPLIT,
    EP_NODE_STRIP,
    EP_NODE_BOX,
    EP_NODE_REGION,
    EP_NODE_GRID
} ep_node_kind;
enum { EP_NODE_KIND = 7, EP_NODE_BIT3 = 8, EP_NODE_BIT4 = 16, EP_NODE_SIZE_SHIFT = 5 };
#define EP_NODE_MOST_WORDS ((size_t)1 << 27)

typedef enum ep_trim_state { EP_TRIM_OUTSIDE, EP_TRIM_INSIDE, EP_TRIM_CROSSED } ep_trim_state;

/* Free it with ep_trim_part_free(), whatever its state; the root is the trim's. */
typedef struct ep_trim_part {
    ep_trim_state state; /* of the whole domain; CROSSED may be wrong, the others never are */
    uint32_t *words;     /* when crossed: LIST, ANY and ALL nodes */
    size_t pieces;       /* in all of its lists */
} ep_trim_part;

/* Stored nodes, one after the other. Start with zeros, free with ep_free(words). */
typedef struct ep_trim_store {
    uint32_t *words;
    size_t count, room;
} ep_trim_store;

/* Two words for each cell of the region's grid, which decide nearly every point (band.h). */
typedef struct ep_bands {
    uint32_t *words;                            /* NULL: the region has no grid */
    float lo[2], per_unit[2], last[2], columns; /* of the grid; `last`: before the end of the last cell */
    double reach; /* what the bands tell holds so far around a point; negative without a grid */
} ep_bands;

typedef struct ep_trim {
    ep_piece *pieces;
    ep_point2h *points;
    size_t piece_count, point_count;
    double scale;        /* the largest coordinate of a point                  */
    double share;        /* the part of what is trimmed that is the unit square: 1, less for a patch of a face */
    ep_point2 lo, hi;    /* the box of all pieces                              */
    ep_trim_part root;   /* the whole plane                                    */
    ep_trim_store cells; /* node 0 decides any point: a box, and a grid if it can be */
    ep_bands bands;      /* of that grid's cells                               */
} ep_trim;

/* EP_INVALID: the region is not finished. EP_BAD_DATA: it has too many curves. The region may be freed. */
EPStatus ep_trim_new(const ep_region *region, ep_trim **trim, ep_message *m);
void ep_trim_free(ep_trim *trim);
size_t ep_trim_bytes(const ep_trim *trim);

/* The part of `parent` in a domain that lies in the parent's. */
EPStatus ep_trim_cut(const ep_trim *trim, const ep_trim_part *parent, const ep_trim_domain *domain, ep_trim_part *part,
                     ep_message *m);
void ep_trim_part_free(ep_trim_part *part);

/* The indices of all pieces of a crossed part, part->pieces of them: pass part->words. Returns their number. */
size_t ep_trim_part_pieces(const uint32_t *words, uint32_t *pieces);
/* About how long they are together; no piece counts for more than `most`. */
double ep_trim_part_length(const ep_trim *trim, const uint32_t *words, double most);

/* Appends the part with what makes testing it fast: a strip that holds all curves in the domain, so that points beside
 * it are decided by two products; and cells, while there are more than a few pieces. `node` is where it begins. */
EPStatus ep_trim_keep(const ep_trim *trim, const ep_trim_part *part, const ep_trim_domain *domain, ep_trim_store *store,
                      uint32_t *node, ep_message *m);
/* The same for the region as a whole, which leaves with many pieces refer to: trim->cells, made once. */
EPStatus ep_trim_keep_cells(ep_trim *trim, ep_message *m);

/* Which of the first `count` <= EP_TRIM_LANES points are inside, of those in `mask`? The points lie in the domain that
 * the node was stored for, or no further from it than its margin or seam. A point is decided rightly when it is further
 * from every border than 2^-44 of the largest coordinate (with a seam, than a few of its widths), and the same way
 * whatever stands beside it. NaN is outside. */
enum { EP_TRIM_LANES = 16 };
uint32_t ep_trim_inside(const ep_trim *trim, const uint32_t *words, uint32_t node, unsigned count, const float *u,
                        const float *v, uint32_t mask);
/* The same for one point, in double. */
bool ep_trim_inside_one(const ep_trim *trim, const uint32_t *words, uint32_t node, double u, double v);

/* The same for the squares of half side `reach` about the points. Those in `open` may have a border in them; the others
 * certainly do not. */
uint32_t ep_trim_sift(const ep_trim *trim, const uint32_t *words, uint32_t node, unsigned count, const float *u,
                      const float *v, uint32_t mask, double reach, uint32_t *open);
/* Is the point or a corner of such a square inside? A border that bends outwards, or not at all within the square, has
 * one of them beyond it as soon as it is nearer than `reach`; so of two regions on either side of a border, whichever
 * bends this way, one at least is reached by any point that rounding has moved by less. */
bool ep_trim_reaches(const ep_trim *trim, const uint32_t *words, uint32_t node, double u, double v, double reach);

/* Any point of the plane: the cells of the whole region. */
static inline bool ep_trim_has_point(const ep_trim *t, double u, double v)
{
    return ep_trim_inside_one(t, t->cells.words, 0, u, v);
}

#endif
