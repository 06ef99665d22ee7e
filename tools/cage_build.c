/* cage_build.c - see cage_build.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/cage_build.h"
#include "tools/array.h"

#include <math.h>
#include <stdlib.h>

/* OpenSubdiv and Embree count with int. */
#define COUNT_MAX ((size_t)INT32_MAX)

static const char no_memory[] = "out of memory";

/* Room for one item more: where the items are then, or NULL without memory. */
static void *make_room(void *items, size_t *capacity, size_t count, size_t size)
{
    return array_grow(&items, capacity, count, 1, size) ? items : NULL;
}

#define MAKE_ROOM(items, capacity, count)                                                                              \
    ((more = make_room(items, &(capacity), count, sizeof *(items))) ? (items = more, true) : false)

bool cage_begin(cage_builder *b, const model_options *o)
{
    *b = (cage_builder){.cage = calloc(1, sizeof *b->cage)};
    if (!b->cage) return false;
    b->cage->scheme = o->scheme;
    b->cage->level = o->level;
    if (o->boundary) b->cage->boundary = *o->boundary;
    return true;
}

cage *cage_end(cage_builder *b)
{
    cage *c = b->cage;
    free(b->last_face);
    *b = (cage_builder){0};
    return c;
}

const char *cage_add_vertex(cage_builder *b, const double p[3])
{
    cage *c = b->cage;
    void *more;
    const char *problem = point_problem((double[4]){p[0], p[1], p[2], 1});
    if (problem) return problem;
    if (c->vertex_count == COUNT_MAX) return "a cage has more than 2147483647 vertices";
    if (!MAKE_ROOM(c->vertices, c->vertex_capacity, c->vertex_count) ||
        !MAKE_ROOM(b->last_face, b->last_capacity, c->vertex_count))
        return no_memory;
    b->last_face[c->vertex_count] = 0;
    for (int i = 0; i < 3; ++i) c->vertices[c->vertex_count][i] = p[i];
    ++c->vertex_count;
    return NULL;
}

const char *cage_add_face_corner(cage_builder *b, uint32_t vertex)
{
    cage *c = b->cage;
    void *more;
    uint32_t face = (uint32_t)c->face_count + 1; /* fits: there are more corners than faces */
    if (b->last_face[vertex] == face) return "a face has the same vertex twice";
    b->last_face[vertex] = face;
    if (c->corner_count == COUNT_MAX) return "the faces of a cage have more than 2147483647 corners";
    if (!MAKE_ROOM(c->corners, c->corner_capacity, c->corner_count)) return no_memory;
    c->corners[c->corner_count++] = vertex;
    return NULL;
}

static const char *size_problem(cage_scheme scheme, size_t corners)
{
    if (scheme == CAGE_LOOP) return corners == 3 ? NULL : "Loop's scheme takes triangles only";
    /* OpenSubdiv counts the faces around a vertex, and the middle of a face becomes one, in 16 bits */
    if (corners > 65535) return "a face has more than 65535 corners";
    return corners >= 3 ? NULL : "a face has less than three corners";
}

const char *cage_add_face(cage_builder *b)
{
    cage *c = b->cage;
    void *more;
    size_t corners = c->corner_count - b->face_first;
    const char *problem = size_problem(c->scheme, corners);
    if (problem) return problem;
    if (!MAKE_ROOM(c->sizes, c->face_capacity, c->face_count)) return no_memory;
    c->sizes[c->face_count++] = (uint32_t)corners;
    b->face_first = c->corner_count;
    return NULL;
}

const char *cage_add_crease(cage_builder *b, uint32_t from, uint32_t to, float sharpness)
{
    cage *c = b->cage;
    void *more;
    if (from == to) return "an edge has the same vertex twice";
    if (!MAKE_ROOM(c->creases, c->crease_capacity, c->crease_count)) return no_memory;
    c->creases[c->crease_count++] = (cage_crease){{from, to}, sharpness};
    return NULL;
}

const char *cage_add_corner(cage_builder *b, uint32_t vertex, float sharpness)
{
    cage *c = b->cage;
    void *more;
    if (!MAKE_ROOM(c->sharp, c->sharp_capacity, c->sharp_count)) return no_memory;
    c->sharp[c->sharp_count++] = (cage_corner){vertex, sharpness};
    return NULL;
}

const char *cage_add_hole(cage_builder *b, uint32_t face)
{
    cage *c = b->cage;
    void *more;
    if (!MAKE_ROOM(c->holes, c->hole_capacity, c->hole_count)) return no_memory;
    c->holes[c->hole_count++] = face;
    return NULL;
}

const char *cage_sharpness(double from, float *to)
{
    if (isnan(from)) return "a sharpness is not a number";
    if (from < 0) return "a sharpness is negative";
    *to = from < (double)CAGE_SHARP ? (float)from : CAGE_SHARP;
    return NULL;
}
