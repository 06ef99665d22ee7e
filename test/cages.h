/* cages.h - cages of all kinds, for tests: as the reference takes them, and as surfaces that are traced.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef TEST_CAGES_H
#define TEST_CAGES_H

#include "test/oracle/cage_reference.h"
#include "test/support.h"
#include "tools/cage_build.h"
#include "tools/world.h"

typedef struct cage_case {
    const char *name;
    void (*make)(ref_cage *c, unsigned n);
    unsigned n;
    bool loop;
    enum { OPEN, STAR, TUBE } inside; /* what it encloses: seen from the origin, or around a circle of radius 1 */
    ref_boundary boundary;
    bool embree; /* means the same surface, see as_embree */
} cage_case;

enum { CAGES = 30 };
extern const cage_case cages[CAGES];

/* A cage in a world; sizes of cages are about 2. */
typedef struct subject {
    const char *name;
    ref_cage cage;
    scene *scene;
    const scene_geometry *patches;
    world *world;
    EPGeometry g;
} subject;

/* Vertices are moved a little, by chance: what is the same but for one thing must not look the same. */
ref_cage new_cage(const cage_case *k, uint64_t seed);
subject new_subject(const cage_case *k, uint64_t seed, bool demand);
subject subject_of(const char *name, const ref_cage *c, unsigned level, bool demand);
void free_subject(subject *s);

/* The cage after so many levels. */
ref_mesh *refined(const ref_cage *c, int levels);

static inline void cross(const double a[3], const double b[3], double r[3])
{
    for (int c = 0; c < 3; ++c) r[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static inline double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

#endif
