/* camera.c - frames, pixels, and the closed form of "as near as possible".
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/camera.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

/* The picture is this much wider than its contents, in each direction. */
#define FRAMING_MARGIN 1.12
#define FRAMING_FOV 35.0
/* The eye is at least so many times its rounding error away from the target. */
#define ROUNDINGS 256

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double r[3])
{
    r[0] = a[1] * b[2] - a[2] * b[1];
    r[1] = a[2] * b[0] - a[0] * b[2];
    r[2] = a[0] * b[1] - a[1] * b[0];
}

static bool normalize(double a[3])
{
    double m = fmax(fabs(a[0]), fmax(fabs(a[1]), fabs(a[2])));
    if (!(m > 0 && m < (double)INFINITY)) return false;
    for (int k = 0; k < 3; ++k) a[k] /= m;
    double length = sqrt(dot(a, a));
    for (int k = 0; k < 3; ++k) a[k] /= length;
    return true;
}

/* right, up, forward from a line of sight; false without one. */
static bool frame(const double sight[3], const double up[3], double r[3], double u[3], double f[3])
{
    memcpy(f, sight, 3 * sizeof *f);
    if (!normalize(f)) return false;
    double hint[3] = {up[0], up[1], up[2]};
    if (!normalize(hint)) hint[0] = hint[1] = 0, hint[2] = 1;
    if (fabs(dot(hint, f)) > 1 - 1e-12) { /* along the line of sight: the axis that is least so */
        int k = fabs(f[0]) < fabs(f[1]) ? 0 : 1;
        if (fabs(f[2]) < fabs(f[k])) k = 2;
        hint[0] = hint[1] = hint[2] = 0;
        hint[k] = 1;
    }
    cross(f, hint, r);
    normalize(r);
    cross(r, f, u);
    return true;
}

static vec3 to_float(const double a[3])
{
    return vec((float)a[0], (float)a[1], (float)a[2]);
}

bool view_of_camera(view *v, const camera *c, unsigned width, unsigned height)
{
    double sight[3], r[3], u[3], f[3];
    v->eye = to_float(c->eye); /* where rays will start: look from there */
    sight[0] = c->target[0] - (double)v->eye.x;
    sight[1] = c->target[1] - (double)v->eye.y;
    sight[2] = c->target[2] - (double)v->eye.z;
    if (!frame(sight, c->up, r, u, f)) return false;

    double step = 2 * tan(c->fov * PI / 360) / height;
    for (int k = 0; k < 3; ++k) {
        v->step_x[k] = step * r[k];
        v->step_y[k] = -step * u[k];
        v->origin[k] = f[k] - 0.5 * width * v->step_x[k] - 0.5 * height * v->step_y[k];
    }
    v->right = to_float(r);
    v->up = to_float(u);
    v->forward = to_float(f);
    v->vertical = vec_unit(to_float(c->up));
    return true;
}

vec3 view_direction(const view *v, double x, double y)
{
    double d[3];
    for (int k = 0; k < 3; ++k) d[k] = v->origin[k] + x * v->step_x[k] + y * v->step_y[k];
    double length = sqrt(dot(d, d));
    return vec((float)(d[0] / length), (float)(d[1] / length), (float)(d[2] / length));
}

/* With the orientation fixed, a point at (x, y, z) in the camera's axes is inside the picture of an eye at
 * (ex, ey, ez) when |x - ex| <= (z - ez) tx, that is
 *
 *     x - z tx + ez tx <= ex <= x + z tx - ez tx,      and the same with y.
 *
 * Some ex satisfies all of them as long as ez <= (min(x + z tx) - max(x - z tx)) / (2 tx). The eye goes to the
 * largest ez that suits both directions, and halfway between its bounds in each. */
camera camera_framing(const double (*points)[3], size_t count, unsigned up, unsigned width, unsigned height)
{
    static const double cube[8][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                      {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    /* Looking from the right, in front and above. The axes that point to the right and away, by the one that is up;
     * models with y up face +z. */
    static const double seen[3][3] = {{-0.36, -0.33, 0.87}, {-0.33, -0.36, -0.87}, {-0.33, 0.87, -0.36}};
    if (!count) points = cube, count = 8;

    camera c = {.fov = FRAMING_FOV};
    double r[3], u[3], f[3];
    c.up[up] = 1;
    frame(seen[up], c.up, r, u, f);

    double t[2], least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY}, near = INFINITY, far = -INFINITY;
    t[1] = tan(c.fov * PI / 360) / FRAMING_MARGIN;
    t[0] = t[1] * width / height;
    for (size_t i = 0; i < count; ++i) {
        double xy[2] = {dot(r, points[i]), dot(u, points[i])}, z = dot(f, points[i]);
        for (int k = 0; k < 2; ++k) {
            least[k] = fmin(least[k], xy[k] + z * t[k]);
            most[k] = fmax(most[k], xy[k] - z * t[k]);
        }
        near = fmin(near, z);
        far = fmax(far, z);
    }
    double ez = fmin((least[0] - most[0]) / (2 * t[0]), (least[1] - most[1]) / (2 * t[1]));
    if (!(ez < near)) ez = near - fmax(1, fabs(near)); /* a single point */
    double e[2] = {0.5 * (least[0] + most[0]), 0.5 * (least[1] + most[1])}, depth = 0.5 * (near + far), largest = 0;
    for (int k = 0; k < 3; ++k) {
        c.target[k] = e[0] * r[k] + e[1] * u[k] + depth * f[k];
        largest = fmax(largest, fabs(c.target[k]));
    }
    /* Rays start at floats. A small thing far from the origin is seen from so far away, through a longer lens, that
     * rounding the eye is no matter. */
    double distance = depth - ez, least_distance = largest * 0x1p-23 * ROUNDINGS;
    if (distance < least_distance) {
        c.fov = atan(tan(c.fov * PI / 360) * distance / least_distance) * 360 / PI;
        distance = least_distance;
    }
    for (int k = 0; k < 3; ++k) c.eye[k] = c.target[k] - distance * f[k];
    return c;
}
