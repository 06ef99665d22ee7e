/* face.h - patches that are parts of one face: a surface with one primID and parameters of its own.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Everything below knows patches, each over its own unit square or triangle, which is what its numerics are scaled to.
 * A hit is given its face's parameters when it leaves (rtc/offer.h), in double and rounded once. */
#ifndef EP_FACE_H
#define EP_FACE_H

#include "embree_patch/patch.h"

/* Where a patch lies in the parameter plane of its face. */
typedef struct ep_place {
    double map[6]; /* (s, t) to (u, v), see epJoinPatches */
    double scale;  /* S_u x S_v = scale * S_s x S_t: the inverse of its determinant */
    uint32_t face;
} ep_place;

/* The patches of a face begin at `first`. Where they are rectangles in rows, u growing along each row and v from one to
 * the next, as the spans of a NURBS surface do, each row has `columns` of them; else 0. */
typedef struct ep_face {
    size_t first, columns;
} ep_face;

/* Of all patches; without arrays until some are joined, each patch being a face by itself. */
typedef struct ep_faces {
    ep_place *places; /* of each patch           */
    ep_face *faces;
    size_t count, place_count, place_capacity, capacity;
} ep_faces;

/* Are any joined? */
static inline bool ep_faces_exist(const ep_faces *f)
{
    return f->places != NULL;
}

/* Makes room for `count` more patches; with ep_faces_add, which cannot fail then, a face each. */
bool ep_faces_reserve(ep_faces *f, size_t count);
void ep_faces_add(ep_faces *f, size_t count);
/* Gives room for more back. False without memory. */
bool ep_faces_shrink(ep_faces *f);

/* Begins to keep places: `patches` patches are faces by themselves. False without memory; then nothing has changed. */
bool ep_faces_begin(ep_faces *f, size_t patches);

/* NULL when the last `count` of `patches` can be joined, else what is wrong. */
const char *ep_faces_problem(const ep_faces *f, size_t patches, size_t first, size_t count,
                             const double (*transforms)[6]);
/* False without memory; then nothing has changed. */
bool ep_faces_join(ep_faces *f, size_t patches, size_t first, size_t count, const double (*transforms)[6]);

/* The patches of a face that exists: *first up to, not including, *end. */
void ep_faces_patches(const ep_faces *f, uint32_t face, size_t *first, size_t *end);

/* The patch that has (u, v), or the nearest, where they are in rows; SIZE_MAX where they are not. */
size_t ep_faces_at(const ep_faces *f, uint32_t face, double u, double v);

/* The (s, t) of a patch where its face has (u, v), and back. */
void ep_place_inverse(const ep_place *p, double u, double v, double *s, double *t);
static inline void ep_place_apply(const ep_place *p, double s, double t, double *u, double *v)
{
    *u = p->map[0] * s + p->map[2] * t + p->map[4];
    *v = p->map[1] * s + p->map[3] * t + p->map[5];
}

bool ep_place_is_identity(const ep_place *p);
/* The inverse of its map. */
void ep_place_invert(const ep_place *p, double map[6]);

/* Turns derivatives by s, t into those by u, v. */
void ep_place_derivatives(const ep_place *p, ep_frame *f);

size_t ep_faces_bytes(const ep_faces *f);
void ep_faces_free(ep_faces *f);

#endif
