/* methods.h - other ways to test points, to compare with: the region as it stands, without cells.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * All of them give the even-odd answer by the rule of piece.h, and so agree wherever rounding does not decide. */
#ifndef EP_TRIM_METHODS_H
#define EP_TRIM_METHODS_H

#include "trim/trim.h"

typedef enum ep_trim_method {
    EP_TRIM_CELLS,         /* ep_trim_has_point()                                                     */
    EP_TRIM_STRIP_TREES,   /* a tree of parallelograms for each contour (strip_tree.c)                */
    EP_TRIM_CLIPPING,      /* iterative Bézier clipping of every curve, in constant memory (clip.c)   */
    EP_TRIM_CLIPPING_LEFT, /* the same, clipping on the left only                                     */
    EP_TRIM_METHODS
} ep_trim_method;

extern const char *const ep_trim_method_name[EP_TRIM_METHODS];

typedef struct ep_trim_tester ep_trim_tester;

/* The region and the trim of it must outlive the tester. */
EPStatus ep_trim_tester_new(const ep_region *region, const ep_trim *trim, ep_trim_method method,
                            ep_trim_tester **tester, ep_message *m);
void ep_trim_tester_free(ep_trim_tester *t);
bool ep_trim_tester_has_point(const ep_trim_tester *t, double u, double v);
size_t ep_trim_tester_bytes(const ep_trim_tester *t);

/* Does the ray from (u,v) towards +u cross the curve an odd number of times? */
bool ep_clip_crosses(const ep_region_curve *curve, const ep_point2h *points, bool left_only, double u, double v);

/* A strip tree over pieces first to last-1, those of one contour. `curves` are the region's. */
typedef struct ep_strip_tree ep_strip_tree;
EPStatus ep_strip_tree_new(const ep_trim *trim, const ep_region_curve *curves, uint32_t first, uint32_t last,
                           ep_strip_tree **tree, ep_message *m);
void ep_strip_tree_free(ep_strip_tree *tree);
bool ep_strip_tree_crosses(const ep_strip_tree *tree, double u, double v);
size_t ep_strip_tree_bytes(const ep_strip_tree *tree);

#endif
