/* json_triangles.c - see json_triangles.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/json_triangles.h"
#include "tools/json_patches.h"
#include "tools/model.h"
#include "tools/triangles.h"

#include <stdlib.h>
#include <string.h>

/* Finite points can have control points that are too far out. */
static bool check_control_points(const json_reader *r, const json_node *n, const double (*points)[4], size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        const char *problem = point_problem(points[i]);
        if (problem) return json_wrong(r, n, "a control point of the curved triangle: %s", problem);
    }
    return true;
}

/* `to`: the points as they are written, which become control points. */
static bool make_quadratic(const json_reader *r, const json_node *n, double (*to)[4])
{
    double on[6][4];
    memcpy(on, to, sizeof on);
    for (int i = 0; i < 6; ++i)
        if (on[i][3] != 1) return json_wrong(r, n, "the points of a quadratic triangle have no weights");
    quadratic_triangle(on, to);
    return check_control_points(r, n, to, 6);
}

bool json_read_quadratic_triangles(const json_reader *r, const json_node *n, scene_geometry *g)
{
    const json_node patches = json_member(n, "patches");
    if (!json_read_patches(r, n, PATCH_TRIANGLE, (unsigned[2]){2, 2}, g)) return false;
    for (size_t i = 0; i < g->patch_count; ++i) {
        const json_node e = json_element(&patches, i);
        if (!make_quadratic(r, &e, (double(*)[4])g->points + g->patches[i].first)) return false;
    }
    return true;
}

typedef struct mesh {
    mesh_vertex *vertices;
    size_t count;
} mesh;

static bool read_list(const json_reader *r, const json_node *n, const char *key, json_node *list)
{
    char what[40];
    snprintf(what, sizeof what, "'%s'", key);
    *list = json_member(n, key);
    if (!list->json) return json_wrong(r, n, "a mesh of curved triangles needs %s", what);
    return json_is(r, list, JSON_ARRAY, what);
}

static bool read_vertex(const json_reader *r, const json_node *p, const json_node *n, mesh_vertex *to)
{
    if (!json_read_numbers(r, p, "a vertex", 3, to->p)) return false;
    const char *problem = point_problem((double[4]){to->p[0], to->p[1], to->p[2], 1});
    if (problem) return json_wrong(r, p, "%s", problem);
    if (!json_read_numbers(r, n, "a normal", 3, to->n)) return false;
    return normalise(to->n) || json_wrong(r, n, "a normal is zero");
}

/* `m` owns the vertices also on failure. */
static bool read_vertices(const json_reader *r, const json_node *n, mesh *m)
{
    json_node vertices, normals;
    if (!read_list(r, n, "vertices", &vertices) || !read_list(r, n, "normals", &normals)) return false;
    m->count = json_array_size(vertices.json);
    if (json_array_size(normals.json) != m->count)
        return json_wrong(r, &normals, "%zu vertices have as many normals, not %zu", m->count,
                          json_array_size(normals.json));
    m->vertices = malloc((m->count + 1) * sizeof *m->vertices);
    if (!m->vertices) return json_no_memory(r);
    for (size_t i = 0; i < m->count; ++i) {
        const json_node p = json_element(&vertices, i), normal = json_element(&normals, i);
        if (!read_vertex(r, &p, &normal, &m->vertices[i])) return false;
    }
    return true;
}

/* `alpha`: of Phong tessellation; NULL for PN triangles. */
static bool read_triangle(const json_reader *r, const json_node *n, const mesh *m, const double *alpha,
                          scene_geometry *g)
{
    const mesh_vertex *at[3];
    if (!json_is(r, n, JSON_ARRAY, "a triangle")) return false;
    if (json_array_size(n->json) != 3)
        return json_wrong(r, n, "a triangle has 3 vertices, not %zu", json_array_size(n->json));
    for (size_t i = 0; i < 3; ++i) {
        const json_node e = json_element(n, i);
        uint32_t vertex = 0;
        if (!json_read_index(r, &e, "vertices", m->count, &vertex)) return false;
        at[i] = &m->vertices[vertex];
    }
    const unsigned degree = alpha ? 2 : 3;
    double(*to)[4] = (double(*)[4])geometry_add_patch(g, PATCH_TRIANGLE, degree, degree);
    if (!to) return json_no_memory(r);
    if (alpha) phong_triangle(at, *alpha, to);
    else pn_triangle(at, to);
    return check_control_points(r, n, to, patch_point_count(PATCH_TRIANGLE, degree, degree));
}

static bool read_mesh(const json_reader *r, const json_node *n, const double *alpha, scene_geometry *g)
{
    mesh m = {NULL, 0};
    json_node triangles;
    bool done = read_vertices(r, n, &m) && read_list(r, n, "triangles", &triangles);
    for (size_t i = 0; done && i < json_array_size(triangles.json); ++i) {
        const json_node e = json_element(&triangles, i);
        done = read_triangle(r, &e, &m, alpha, g);
    }
    free(m.vertices);
    return done;
}

bool json_read_phong_triangles(const json_reader *r, const json_node *n, scene_geometry *g)
{
    const json_node a = json_member(n, "alpha");
    double alpha = 0.75;
    if (a.json && !json_read_number(r, &a, "'alpha'", &alpha)) return false;
    if (!(alpha >= 0 && alpha <= 1)) return json_wrong(r, &a, "'alpha' is %.10g, not a number from 0 to 1", alpha);
    return read_mesh(r, n, &alpha, g);
}

bool json_read_pn_triangles(const json_reader *r, const json_node *n, scene_geometry *g)
{
    return read_mesh(r, n, NULL, g);
}
