/* camera.h - a pinhole camera, and where to put it when nobody says.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAMERA_H
#define EPATCH_CAMERA_H

#include "tools/scene.h"
#include "tools/vec.h"

/* A camera made ready for pixels of one image. Pixel (0, 0) is the top left one, its centre is at (0.5, 0.5). */
typedef struct view {
    vec3 eye;
    vec3 right, up, forward; /* orthonormal                                            */
    vec3 vertical;           /* the up that was asked for, which the camera may lean from */
    double origin[3];        /* direction = origin + x * step_x + y * step_y, before it is made a unit vector */
    double step_x[3], step_y[3];
} view;

/* False when eye and target coincide or are not finite. An up vector along the line of sight is replaced. */
bool view_of_camera(view *v, const camera *c, unsigned width, unsigned height);

/* The unit direction through (x, y). */
vec3 view_direction(const view *v, double x, double y);

/* A three-quarter view in which the points just fit, with a margin. `up` is one of the axes: 0, 1, 2. Without
 * points, the unit cube is framed. */
camera camera_framing(const double (*points)[3], size_t count, unsigned up, unsigned width, unsigned height);

#endif
