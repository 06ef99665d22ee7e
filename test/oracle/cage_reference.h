/* cage_reference.h - subdivision surfaces by subdividing: whole meshes, in double, rule by rule.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Catmull and Clark's scheme [1978] and Loop's [1987], with the creases and corners of DeRose, Kass and Truong
 * ["Subdivision surfaces in character animation", 1998]: a sharpness falls by 1 a level, and in the level in which it
 * ends the sharp and the smooth rule are blended by it. What papers leave open is as in OpenSubdiv's sources: at a
 * vertex where several end their mean is taken, and so are Chaikin's rule, weights of smooth triangles and what borders
 * do without a boundary. No code comes from there, or from the library. */
#ifndef ORACLE_CAGE_REFERENCE_H
#define ORACLE_CAGE_REFERENCE_H

#include <stdbool.h>

/* A sharpness of so much or more never ends. */
#define REF_SHARP 10

typedef enum ref_boundary { REF_EDGE_ONLY, REF_EDGE_AND_CORNER, REF_NO_BOUNDARY } ref_boundary;

enum { REF_VERTICES = 128, REF_FACES = 128, REF_CORNERS = 512, REF_TAGS = 64 };

typedef struct ref_tag {
    unsigned vertex[2]; /* of a corner, the first */
    float sharpness;
} ref_tag;

/* A cage, in the terms of tools/cage.h. */
typedef struct ref_cage {
    bool loop, chaikin, smooth_triangles;
    ref_boundary boundary;
    unsigned vertex_count, face_count, corner_count, crease_count, sharp_count, hole_count;
    double vertices[REF_VERTICES][3];
    unsigned sizes[REF_FACES], corners[REF_CORNERS], holes[REF_TAGS];
    ref_tag creases[REF_TAGS], sharp[REF_TAGS];
} ref_cage;

typedef struct ref_edge {
    unsigned vertex[2];
    unsigned face_count; /* 1: a border                       */
    unsigned corner[2];  /* in each face, where the edge begins */
    double sharpness;
} ref_edge;

/* A cage that has been subdivided some times. A corner is a vertex in one of its faces. */
typedef struct ref_mesh {
    bool loop, chaikin, smooth_triangles;
    unsigned vertex_count, edge_count, face_count, corner_count;
    double (*x)[3], *sharpness;     /* of vertices                                                     */
    unsigned *first, *cage_face;    /* of faces, and of one more: the first corner; the face it is in  */
    bool *hole;                     /* of faces                                                        */
    unsigned *vertex, *face, *edge; /* of corners; the edge that begins there                          */
    double (*place)[2];             /* of corners: u, v in the cage's face                             */
    ref_edge *edges;
    unsigned *star_first, *star; /* of vertices: the corners that have them */
    unsigned *rays_first, *rays; /* of vertices: the edges that have them   */
} ref_mesh;

/* The caller's; ends the process without memory. The cage has to be a manifold of consistent orientation. */
ref_mesh *ref_new(const ref_cage *c);
ref_mesh *ref_refine(const ref_mesh *m);
void ref_free(ref_mesh *m);

/* The faces that share a vertex with one of the faces at `vertex`, which becomes the first: all that the levels around
 * it depend on. Rules, limits and tangents of the mesh hold there at the first vertex and its neighbours. */
ref_mesh *ref_around(const ref_mesh *m, unsigned vertex);
/* The next level of such a mesh; frees it. */
ref_mesh *ref_zoom(ref_mesh *m);

/* The corners before and behind one in its face. */
unsigned ref_next(const ref_mesh *m, unsigned corner);
unsigned ref_previous(const ref_mesh *m, unsigned corner);

typedef enum ref_rule { REF_SMOOTH, REF_DART, REF_CREASE, REF_CORNER } ref_rule;

/* By what rule a vertex is subdivided for ever, and how many faces have it. */
ref_rule ref_rule_of(const ref_mesh *m, unsigned vertex);
unsigned ref_valence(const ref_mesh *m, unsigned vertex);

/* Where a vertex goes. All faces of the mesh have to be quadrilaterals, or, with Loop's scheme, triangles, and no
 * sharpness may be left that ends. */
void ref_limit(const ref_mesh *m, unsigned vertex, double p[3]);

/* The limit surface's tangent along the edge that begins at a corner, if its vertex is smooth; where the mesh is
 * regular, the derivative with the edge as the unit. False elsewhere. */
bool ref_tangent(const ref_mesh *m, unsigned corner, double t[3]);

#endif
