/* cages.c - see cages.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/cages.h"

#include <stdlib.h>
#include <string.h>

static unsigned vertex(ref_cage *c, double x, double y, double z)
{
    memcpy(c->vertices[c->vertex_count], (double[3]){x, y, z}, sizeof c->vertices[0]);
    return c->vertex_count++;
}

static void face(ref_cage *c, unsigned n, const unsigned *corners)
{
    c->sizes[c->face_count++] = n;
    for (unsigned i = 0; i < n; ++i) c->corners[c->corner_count++] = corners[i];
}

#define FACE(c, ...) face(c, sizeof((unsigned[]){__VA_ARGS__}) / sizeof(unsigned), (unsigned[]){__VA_ARGS__})

static void crease(ref_cage *c, unsigned a, unsigned b, float sharpness)
{
    c->creases[c->crease_count++] = (ref_tag){{a, b}, sharpness};
}

static void sharp(ref_cage *c, unsigned v, float sharpness)
{
    c->sharp[c->sharp_count++] = (ref_tag){{v, v}, sharpness};
}

static void hole(ref_cage *c, unsigned f)
{
    c->holes[c->hole_count++] = f;
}

static void cube(ref_cage *c, unsigned n)
{
    (void)n;
    for (int i = 0; i < 8; ++i) vertex(c, i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    FACE(c, 0, 2, 3, 1);
    FACE(c, 4, 5, 7, 6);
    FACE(c, 0, 1, 5, 4);
    FACE(c, 2, 6, 7, 3);
    FACE(c, 0, 4, 6, 2);
    FACE(c, 1, 3, 7, 5);
}

/* Extraordinary points that are smooth, next to a face that is not there. */
static void cube_with_hole(ref_cage *c, unsigned n)
{
    cube(c, n);
    hole(c, 1);
}

static void open_cube(ref_cage *c, unsigned n)
{
    cube(c, n);
    c->corner_count -= c->sizes[--c->face_count];
}

/* Creases of all kinds that meet, end, and come to an end with different sharpness at a vertex. */
static void creased_cube(ref_cage *c, unsigned n)
{
    cube(c, n);
    crease(c, 0, 1, 1.5f);
    crease(c, 1, 3, 2);
    crease(c, 3, 2, 3.75f);
    crease(c, 2, 0, 0.5f);
    crease(c, 4, 5, REF_SHARP);
    crease(c, 5, 7, REF_SHARP);
    crease(c, 7, 6, 3.7f);
    crease(c, 3, 7, 1.25f);
    sharp(c, 2, 2.5f);
    sharp(c, 6, REF_SHARP);
}

/* OpenSubdiv 3.5 extrapolates in edges of sharpness 1 to 4/3 of which one half ends in that level: there are none. */
static void chaikin_cube(ref_cage *c, unsigned n)
{
    cube(c, n);
    c->chaikin = true;
    crease(c, 0, 1, 1.5f);
    crease(c, 1, 3, 2);
    crease(c, 2, 0, 0.5f);
    crease(c, 3, 7, 1.25f);
    crease(c, 4, 5, REF_SHARP);
    crease(c, 5, 7, REF_SHARP);
    sharp(c, 2, 2.5f);
}

/* A crease that ends where the surface is smooth. */
static void dart(ref_cage *c, unsigned n)
{
    cube(c, n);
    crease(c, 0, 1, REF_SHARP);
    crease(c, 1, 3, REF_SHARP);
}

static void tetrahedron(ref_cage *c, unsigned n)
{
    (void)n;
    for (int i = 0; i < 4; ++i) vertex(c, i & 1 ? 1 : -1, i & 2 ? 1 : -1, (i == 0 || i == 3) ? 1 : -1);
    FACE(c, 0, 1, 3);
    FACE(c, 0, 3, 2);
    FACE(c, 0, 2, 1);
    FACE(c, 1, 2, 3);
}

static void smooth_tetrahedron(ref_cage *c, unsigned n)
{
    tetrahedron(c, n);
    c->smooth_triangles = true;
}

enum { RING = 5 };

static void torus(ref_cage *c, unsigned n)
{
    for (unsigned i = 0; i < n; ++i)
        for (unsigned j = 0; j < RING; ++j) {
            const double a = 6.283185307179586 * i / n, b = 6.283185307179586 * j / RING, r = 1 + 0.5 * cos(b);
            vertex(c, r * cos(a), r * sin(a), 0.5 * sin(b));
        }
    for (unsigned i = 0; i < n; ++i)
        for (unsigned j = 0, k = (i + 1) % n * RING, l; j < RING; ++j)
            l = (j + 1) % RING, FACE(c, RING * i + j, k + j, k + l, RING * i + l);
}

/* Rings and parts of rings, along both directions, that cross. */
static void creased_torus(ref_cage *c, unsigned n)
{
    torus(c, n);
    for (unsigned i = 0; i < n; ++i) crease(c, RING * i, RING * ((i + 1) % n), REF_SHARP);
    for (unsigned i = 1; i < 4; ++i) crease(c, RING * i + 2, RING * (i + 1) + 2, (float)i + 0.25f);
    for (unsigned j = 0; j < RING; ++j) crease(c, j, (j + 1) % RING, 2.5f);
    for (unsigned j = 0; j < 2; ++j) crease(c, 3 * RING + j, 3 * RING + j + 1, 1.5f);
    sharp(c, 5 * RING + 3, 1.5f);
    sharp(c, 4 * RING + 3, REF_SHARP);
}

/* Creases that are as sharp at one end as at the other. */
static void evenly_creased_torus(ref_cage *c, unsigned n)
{
    torus(c, n);
    for (unsigned i = 0; i < n; ++i) crease(c, RING * i, RING * ((i + 1) % n), REF_SHARP);
    for (unsigned i = 0; i < n; ++i) crease(c, RING * i + 1, RING * ((i + 1) % n) + 1, 2.5f);
    for (unsigned i = 1; i < 4; ++i) crease(c, RING * i + 3, RING * (i + 1) + 3, 1.5f);
    sharp(c, 5 * RING + 3, 2);
}

/* A border without corners. */
static void tube(ref_cage *c, unsigned n)
{
    torus(c, n);
    c->face_count -= RING;
    c->corner_count -= 4 * RING;
}

static void torus_with_holes(ref_cage *c, unsigned n)
{
    torus(c, n);
    hole(c, 0);
    hole(c, 7);
    hole(c, 8);
}

/* n x n squares, but for the first and one inside: a border of all valences. */
static void grid(ref_cage *c, unsigned n)
{
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= n; ++i) vertex(c, i, j, 0.2 * ((i * i + 3 * j) % 5));
    for (unsigned j = 0; j < n; ++j)
        for (unsigned i = 0; i < n; ++i) {
            const unsigned v = (n + 1) * j + i, w = v + n + 1;
            if (i + j == 0 || (i == 2 && j == 3)) continue;
            if (c->loop) FACE(c, v, v + 1, w), FACE(c, v + 1, w + 1, w);
            else FACE(c, v, v + 1, w + 1, w);
        }
}

/* With sharp borders that faces are not left out at, and creases that go to the border. */
static void creased_grid(ref_cage *c, unsigned n)
{
    grid(c, n);
    for (unsigned i = 0; i < n; ++i) crease(c, (n + 1) * n + i, (n + 1) * n + i + 1, REF_SHARP);
    for (unsigned j = 1; j < n; ++j) crease(c, (n + 1) * j + n, (n + 1) * (j + 1) + n, REF_SHARP);
    for (unsigned j = 2; j < n; ++j) crease(c, (n + 1) * j + 4, (n + 1) * (j + 1) + 4, j < 4 ? 2.5f : REF_SHARP);
    sharp(c, n, 1.5f);
}

static void prism(ref_cage *c, unsigned n)
{
    unsigned low[16] = {0}, high[16] = {0};
    for (unsigned i = 0; i < n; ++i) {
        const double a = 6.283185307179586 * i / n;
        high[i] = vertex(c, cos(a), sin(a), 0.8);
        low[n - 1 - i] = vertex(c, cos(a), sin(a), -0.8);
    }
    face(c, n, high);
    face(c, n, low);
    for (unsigned i = 0; i < n; ++i) {
        const unsigned j = (i + 1) % n;
        FACE(c, high[i], low[n - 1 - i], low[n - 1 - j], high[j]);
    }
}

/* Two poles of valence n: triangles there, squares between. */
static void poles(ref_cage *c, unsigned n)
{
    const unsigned top = vertex(c, 0, 0, 1), bottom = vertex(c, 0, 0, -1);
    for (unsigned i = 0; i < n; ++i) {
        const double a = 6.283185307179586 * i / n;
        vertex(c, cos(a), sin(a), 0.6);
        vertex(c, cos(a), sin(a), -0.6);
    }
    for (unsigned i = 0; i < n; ++i) {
        const unsigned a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % n);
        FACE(c, top, a, b);
        FACE(c, a, a + 1, b + 1, b);
        FACE(c, bottom, b + 1, a + 1);
    }
}

static void icosahedron(ref_cage *c, unsigned n)
{
    (void)n;
    const unsigned top = vertex(c, 0, 0, 1), bottom = vertex(c, 0, 0, -1);
    for (unsigned i = 0; i < 5; ++i) {
        const double a = 6.283185307179586 * i / 5, b = a + 0.6283185307179586;
        vertex(c, 0.894 * cos(a), 0.894 * sin(a), 0.447);
        vertex(c, 0.894 * cos(b), 0.894 * sin(b), -0.447);
    }
    for (unsigned i = 0; i < 5; ++i) {
        const unsigned a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % 5);
        FACE(c, top, a, b);
        FACE(c, a, a + 1, b);
        FACE(c, b, a + 1, b + 1);
        FACE(c, bottom, b + 1, a + 1);
    }
}

static void creased_icosahedron(ref_cage *c, unsigned n)
{
    icosahedron(c, n);
    for (unsigned i = 0; i < 4; ++i) crease(c, 2 + 2 * i, 4 + 2 * i, REF_SHARP);
    crease(c, 10, 2, 1.5f);
    crease(c, 0, 2, 2);
    crease(c, 0, 4, 3.7f);
    crease(c, 1, 5, 0.5f);
    sharp(c, 1, 2.5f);
    sharp(c, 7, REF_SHARP);
}

const cage_case cages[CAGES] = {
    {"cube", cube, 0, false, STAR, REF_EDGE_ONLY, true},
    {"creased cube", creased_cube, 0, false, STAR, REF_EDGE_ONLY, false},
    {"Chaikin", chaikin_cube, 0, false, STAR, REF_EDGE_ONLY, false},
    {"dart", dart, 0, false, STAR, REF_EDGE_ONLY, true},
    {"tetrahedron", tetrahedron, 0, false, STAR, REF_EDGE_ONLY, true},
    {"smooth triangles", smooth_tetrahedron, 0, false, STAR, REF_EDGE_ONLY, false},
    {"torus", torus, 6, false, TUBE, REF_EDGE_ONLY, true},
    {"creased torus", creased_torus, 7, false, TUBE, REF_EDGE_ONLY, false},
    {"even creases", evenly_creased_torus, 7, false, TUBE, REF_EDGE_ONLY, true},
    {"tube", tube, 7, false, OPEN, REF_EDGE_ONLY, true},
    {"holes", torus_with_holes, 6, false, OPEN, REF_EDGE_ONLY, false},
    {"cube with a hole", cube_with_hole, 0, false, OPEN, REF_EDGE_ONLY, false},
    {"open cube", open_cube, 0, false, OPEN, REF_EDGE_ONLY, true},
    {"open cube, no boundary", open_cube, 0, false, OPEN, REF_NO_BOUNDARY, true},
    {"edges only", grid, 5, false, OPEN, REF_EDGE_ONLY, false},
    {"edges and corners", grid, 5, false, OPEN, REF_EDGE_AND_CORNER, true},
    {"no boundary", grid, 5, false, OPEN, REF_NO_BOUNDARY, true},
    {"creased grid", creased_grid, 6, false, OPEN, REF_EDGE_ONLY, false},
    {"sharp borders", creased_grid, 6, false, OPEN, REF_NO_BOUNDARY, false},
    {"prism of 3", prism, 3, false, STAR, REF_EDGE_ONLY, true},
    {"prism of 5", prism, 5, false, STAR, REF_EDGE_ONLY, true},
    {"prism of 7", prism, 7, false, STAR, REF_EDGE_ONLY, true},
    {"prism of 16", prism, 16, false, STAR, REF_EDGE_ONLY, true},
    {"poles", poles, 16, false, STAR, REF_EDGE_ONLY, true},
    {"Loop, tetrahedron", tetrahedron, 0, true, STAR, REF_EDGE_ONLY, false},
    {"Loop, icosahedron", icosahedron, 0, true, STAR, REF_EDGE_ONLY, false},
    {"Loop, creases", creased_icosahedron, 0, true, STAR, REF_EDGE_ONLY, false},
    {"Loop, edges only", grid, 5, true, OPEN, REF_EDGE_ONLY, false},
    {"Loop, edges and corners", grid, 5, true, OPEN, REF_EDGE_AND_CORNER, false},
    {"Loop, no boundary", grid, 5, true, OPEN, REF_NO_BOUNDARY, false},
};

/* The same in every way but one must not look the same: nothing is symmetric. */
ref_cage new_cage(const cage_case *k, uint64_t seed)
{
    ref_cage c = {.loop = k->loop, .boundary = k->boundary};
    k->make(&c, k->n);
    for (unsigned i = 0; i < c.vertex_count; ++i) {
        rng r = rng_split(seed, 0, i);
        for (int x = 0; x < 3; ++x) c.vertices[i][x] += rng_in(&r, -0.07, 0.07);
    }
    return c;
}

static cage *build_cage(const ref_cage *c, unsigned level)
{
    static const cage_boundary boundary[] = {CAGE_EDGE_ONLY, CAGE_EDGE_AND_CORNER, CAGE_NO_BOUNDARY};
    const model_options o = {true, c->loop ? CAGE_LOOP : CAGE_CATMULL_CLARK, level, &boundary[c->boundary]};
    cage_builder b;
    assert_true(cage_begin(&b, &o));
    for (unsigned i = 0; i < c->vertex_count; ++i) assert_null(cage_add_vertex(&b, c->vertices[i]));
    for (unsigned f = 0, k = 0; f < c->face_count; ++f) {
        for (unsigned end = k + c->sizes[f]; k < end; ++k) assert_null(cage_add_face_corner(&b, c->corners[k]));
        assert_null(cage_add_face(&b));
    }
    for (const ref_tag *t = c->creases; t < c->creases + c->crease_count; ++t)
        assert_null(cage_add_crease(&b, t->vertex[0], t->vertex[1], t->sharpness));
    for (const ref_tag *t = c->sharp; t < c->sharp + c->sharp_count; ++t)
        assert_null(cage_add_corner(&b, t->vertex[0], t->sharpness));
    for (unsigned i = 0; i < c->hole_count; ++i) assert_null(cage_add_hole(&b, c->holes[i]));
    cage *made = cage_end(&b);
    made->chaikin = c->chaikin;
    made->smooth_triangles = c->smooth_triangles;
    return made;
}

subject subject_of(const char *name, const ref_cage *c, unsigned level, bool demand)
{
    subject s = {.name = name, .cage = *c, .scene = calloc(1, sizeof *s.scene)};
    s.scene->path = strdup(name);
    s.scene->geometries = calloc(1, sizeof *s.scene->geometries);
    s.scene->objects = calloc(1, sizeof *s.scene->objects);
    s.scene->geometry_count = s.scene->object_count = 1;
    s.scene->objects[0] = (scene_object){0, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, true, NULL};
    assert_true(cage_to_geometry(name, build_cage(&s.cage, level), s.scene->geometries));
    world_options o = {.threads = 1, .build = epDefaultBuildSettings()};
    o.build.onDemand = demand;
    s.world = world_new(s.scene, &o);
    assert_non_null(s.world);
    s.patches = s.scene->geometries;
    s.g = s.world->geometries[0];
    return s;
}

subject new_subject(const cage_case *k, uint64_t seed, bool demand)
{
    const ref_cage c = new_cage(k, seed);
    return subject_of(k->name, &c, CAGE_LEVEL_DEFAULT, demand);
}

void free_subject(subject *s)
{
    world_free(s->world);
    scene_free(s->scene);
}

ref_mesh *refined(const ref_cage *c, int levels)
{
    ref_mesh *m = ref_new(c);
    while (levels--) {
        ref_mesh *finer = ref_refine(m);
        ref_free(m);
        m = finer;
    }
    return m;
}
