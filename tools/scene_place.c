/* scene_place.c - transforms applied to control points.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Embree takes a ray into the space of an instance in floats, and what is hit there is hit by another ray: near
 * silhouettes that loses some, and their t is off by more than its rounding. A surface whose control points are moved
 * in double is traced as it is. An affine map of the points is one of the surface; weights, parameters and trims stay,
 * and points that patches share remain equal to the bit.
 *
 * Where nothing needs a geometry as it is, one object takes the geometry itself; every other one takes a copy. So a
 * geometry with a single object costs nothing, and what many objects show is left to instances. */
#include "tools/scene_place.h"
#include "tools/model.h"
#include "tools/report.h"

#include <math.h>
#include <stdlib.h>

/* Patches of all copies in a scene. A bicubic one of the teapot takes 37 KB of leaves and hierarchy, this many 150 MB:
 * on two cores they are built in two seconds. A trimmed one counts as several: its leaves follow the trim's curves, in
 * data/scenes/ up to 1.4 MB of them. */
#define MOST_COPIED_PATCHES 4096
#define TRIMMED_PATCH 32

/* A geometry and its objects. */
typedef struct shown {
    double lower[3], upper[3]; /* corners of a box about the points                   */
    size_t patches;            /* as they count for a copy                            */
    size_t as_it_is;           /* objects that show it where it is, or by an instance */
    size_t placed;             /* objects that are still to be placed                 */
} shown;

static void measure(const scene_geometry *g, shown *of)
{
    for (int x = 0; x < 3; ++x) of->lower[x] = INFINITY, of->upper[x] = -INFINITY;
    for (size_t i = 0; i < 4 * g->point_count; i += 4)
        for (int x = 0; x < 3; ++x) {
            of->lower[x] = fmin(of->lower[x], g->points[i + (size_t)x]);
            of->upper[x] = fmax(of->upper[x], g->points[i + (size_t)x]);
        }
    for (size_t i = 0; i < g->patch_count; ++i) of->patches += g->patches[i].trim ? TRIMMED_PATCH : 1;
}

/* An object that is smaller than the steps between floats where it is would not gain: rays are floats. Farther out, its
 * points are rounded to something that is no smooth surface. */
static bool can_be_placed(const scene_object *o, const shown *of)
{
    const double *m = o->transform;
    double side = 0, farthest = 0;
    for (int x = 0; x < 3 && !o->identity; ++x) {
        double lower = m[9 + x], upper = m[9 + x];
        for (int axis = 0; axis < 3; ++axis) {
            const double a = m[3 * axis + x] * of->lower[axis], b = m[3 * axis + x] * of->upper[axis];
            lower += fmin(a, b), upper += fmax(a, b);
        }
        side = fmax(side, upper - lower);
        farthest = fmax(farthest, fmax(fabs(lower), fabs(upper)));
    }
    return !o->identity && farthest <= 0x1p24 * side;
}

static void count_objects(const scene *s, shown *of)
{
    for (size_t i = 0; i < s->geometry_count; ++i) measure(&s->geometries[i], &of[i]);
    for (size_t i = 0; i < s->object_count; ++i) {
        const scene_object *o = &s->objects[i];
        shown *shows = &of[o->geometry];
        ++*(can_be_placed(o, shows) ? &shows->placed : &shows->as_it_is);
    }
}

/* In the order of the file, geometries get the copies that they need as long as there is room for all of them; the
 * others' objects remain to be instances. Returns the number of copies. */
static size_t plan_copies(const scene *s, shown *of)
{
    size_t room = MOST_COPIED_PATCHES, copies = 0;
    for (size_t i = 0; i < s->geometry_count; ++i) {
        const size_t patches = of[i].patches, more = of[i].placed - (of[i].placed && !of[i].as_it_is);
        if (!patches || more > room / patches) {
            of[i].placed = 0;
        } else {
            room -= more * patches;
            copies += more;
        }
    }
    return copies;
}

/* The next geometry of the scene, which has room for it: what g is, but for its points. NULL: no memory. */
static scene_geometry *new_copy(scene *s, const scene_geometry *g)
{
    scene_geometry *copy = &s->geometries[s->geometry_count];
    *copy = *g;
    copy->original = g;
    copy->points = malloc(4 * g->point_count * sizeof *g->points);
    if (!copy->points) return NULL;
    ++s->geometry_count;
    return copy;
}

/* The points of `from`, transformed, to those of `to`, which may be the same. False when some are out of range. */
static bool move_points(const scene_geometry *from, const double m[12], scene_geometry *to)
{
    for (size_t i = 0; i < 4 * from->point_count; i += 4) {
        const double *p = from->points + i;
        double moved[4] = {[3] = p[3]};
        for (int x = 0; x < 3; ++x) moved[x] = m[x] * p[0] + m[3 + x] * p[1] + m[6 + x] * p[2] + m[9 + x];
        if (point_problem(moved)) return false;
        for (int x = 0; x < 4; ++x) to->points[i + (size_t)x] = moved[x];
    }
    return true;
}

/* `of`: the objects of its geometry. The last one to be placed takes the geometry itself. */
static bool place_object(scene *s, size_t object, shown *of)
{
    scene_object *o = &s->objects[object];
    scene_geometry *from = &s->geometries[o->geometry];
    scene_geometry *to = (--of->placed || of->as_it_is) ? new_copy(s, from) : from;
    if (!to) return report_no_memory(s->path), false;
    if (!move_points(from, o->transform, to))
        return report_file(s->path, "object %zu reaches beyond 1e18", object), false;
    *o = (scene_object){(size_t)(to - s->geometries), {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, true, o->material};
    return true;
}

static bool place_objects(scene *s, shown *of)
{
    const size_t count = s->geometry_count + plan_copies(s, of);
    if (count > s->geometry_count) {
        scene_geometry *more = realloc(s->geometries, count * sizeof *more);
        if (!more) return report_no_memory(s->path), false;
        s->geometries = more;
    }
    for (size_t i = 0; i < s->object_count; ++i) {
        const scene_object *o = &s->objects[i];
        if (o->identity || !of[o->geometry].placed || !can_be_placed(o, &of[o->geometry])) continue;
        if (!place_object(s, i, &of[o->geometry])) return false;
    }
    return true;
}

bool scene_place(scene *s)
{
    shown *of = calloc(s->geometry_count + 1, sizeof *of);
    if (!of) return report_no_memory(s->path), false;
    count_objects(s, of);
    const bool done = place_objects(s, of);
    free(of);
    return done;
}
