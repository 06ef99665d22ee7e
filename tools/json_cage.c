/* json_cage.c - see json_cage.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/json_cage.h"
#include "tools/args.h"
#include "tools/cage_build.h"

#include <string.h>

/* One of `names`. */
static bool read_choice(const json_reader *r, const json_node *n, const char *what, const char *const *names,
                        size_t count, size_t *chosen)
{
    if (!json_is(r, n, JSON_STRING, what)) return false;
    const char *name = json_string_value(n->json);
    for (*chosen = 0; *chosen < count; ++*chosen)
        if (!strcmp(name, names[*chosen])) return true;
    const char *nearest = args_nearest(name, names, count);
    if (nearest) return json_wrong(r, n, "%s is '%s'; did you mean '%s'?", what, name, nearest);
    return json_wrong(r, n, "%s is '%s', which is not known", what, name);
}

static bool read_options(const json_reader *r, const json_node *n, model_options *o)
{
    static const char *const schemes[] = {[CAGE_CATMULL_CLARK] = "catmull-clark", [CAGE_LOOP] = "loop"};
    static const char *const boundaries[] = {
        [CAGE_EDGE_ONLY] = "edge-only", [CAGE_EDGE_AND_CORNER] = "edge-and-corner", [CAGE_NO_BOUNDARY] = "none"};
    static const cage_boundary values[] = {CAGE_EDGE_ONLY, CAGE_EDGE_AND_CORNER, CAGE_NO_BOUNDARY};
    const json_node scheme = json_member(n, "scheme"), level = json_member(n, "level"),
                    boundary = json_member(n, "boundary");
    size_t i = 0;
    double depth = CAGE_LEVEL_DEFAULT;

    *o = (model_options){.polygons = POLYGONS_WANTED};
    if (scheme.json && !read_choice(r, &scheme, "'scheme'", schemes, ARG_COUNT(schemes), &i)) return false;
    o->scheme = (cage_scheme)i;
    if (level.json && !json_read_whole(r, &level, "'level'", 1, CAGE_LEVEL_MAX, &depth)) return false;
    o->level = (unsigned)depth;
    if (!boundary.json) return true;
    if (!read_choice(r, &boundary, "'boundary'", boundaries, ARG_COUNT(boundaries), &i)) return false;
    o->boundary = &values[i];
    return true;
}

bool json_read_model_options(const json_reader *r, const json_node *n, model_options *o)
{
    static const char *const ways[] = {"subdivision"}, *const of_cages[] = {"scheme", "level", "boundary"};
    const json_node as = json_member(n, "as");
    size_t way;
    if (!read_options(r, n, o)) return false;
    if (as.json) return read_choice(r, &as, "'as'", ways, ARG_COUNT(ways), &way);

    o->polygons = POLYGONS_REFUSED;
    for (size_t i = 0; i < ARG_COUNT(of_cages); ++i) {
        const json_node e = json_member(n, of_cages[i]);
        if (e.json) return json_wrong_key(r, &e, "'%s' goes with \"as\": \"subdivision\"", of_cages[i]);
    }
    return true;
}

static bool read_sharpness(const json_reader *r, const json_node *n, float *to)
{
    double x = 0;
    if (!json_read_number(r, n, "a sharpness", &x)) return false;
    const char *problem = cage_sharpness(x, to);
    return !problem || json_wrong(r, n, "%s", problem);
}

static bool read_vertex(const json_reader *r, const json_node *n, cage_builder *b)
{
    double p[3];
    if (!json_read_numbers(r, n, "a vertex", 3, p)) return false;
    const char *problem = cage_add_vertex(b, p);
    return !problem || json_wrong(r, n, "%s", problem);
}

static bool read_face(const json_reader *r, const json_node *n, cage_builder *b)
{
    if (!json_is(r, n, JSON_ARRAY, "a face")) return false;
    const char *problem;
    for (size_t i = 0; i < json_array_size(n->json); ++i) {
        const json_node e = json_element(n, i);
        uint32_t vertex = 0;
        if (!json_read_index(r, &e, "vertices", b->cage->vertex_count, &vertex)) return false;
        problem = cage_add_face_corner(b, vertex);
        if (problem) return json_wrong(r, &e, "%s", problem);
    }
    problem = cage_add_face(b);
    return !problem || json_wrong(r, n, "%s", problem);
}

/* The edges between the first `count` elements of n, each with the next. */
static bool read_chain(const json_reader *r, const json_node *n, size_t count, float sharpness, cage_builder *b)
{
    uint32_t from = 0, to = 0;
    for (size_t i = 0; i < count; ++i, from = to) {
        const json_node e = json_element(n, i);
        if (!json_read_index(r, &e, "vertices", b->cage->vertex_count, &to)) return false;
        const char *problem = i ? cage_add_crease(b, from, to, sharpness) : NULL;
        if (problem) return json_wrong(r, &e, "%s", problem);
    }
    return true;
}

static bool read_long_crease(const json_reader *r, const json_node *n, cage_builder *b)
{
    static const char *const keys[] = {"vertices", "sharpness"};
    const json_node vertices = json_member(n, "vertices"), s = json_member(n, "sharpness");
    float sharpness = 0;
    if (!json_only_keys(r, n, "a crease", keys, ARG_COUNT(keys))) return false;
    if (!vertices.json) return json_wrong(r, n, "a crease has no 'vertices'");
    if (!s.json) return json_wrong(r, n, "a crease has no 'sharpness'");
    if (!json_is(r, &vertices, JSON_ARRAY, "'vertices'")) return false;
    const size_t count = json_array_size(vertices.json);
    if (count < 2) return json_wrong(r, &vertices, "a crease has at least two vertices, not %zu", count);
    return read_sharpness(r, &s, &sharpness) && read_chain(r, &vertices, count, sharpness, b);
}

/* [from, to, sharpness], or an object for a chain of edges. */
static bool read_crease(const json_reader *r, const json_node *n, cage_builder *b)
{
    if (json_is_object(n->json)) return read_long_crease(r, n, b);
    if (!json_is(r, n, JSON_ARRAY, "a crease")) return false;
    if (json_array_size(n->json) != 3)
        return json_wrong(r, n, "a crease is two vertices and a sharpness, not %zu numbers", json_array_size(n->json));
    const json_node s = json_element(n, 2);
    float sharpness = 0;
    return read_sharpness(r, &s, &sharpness) && read_chain(r, n, 2, sharpness, b);
}

static bool read_corner(const json_reader *r, const json_node *n, cage_builder *b)
{
    if (!json_is(r, n, JSON_ARRAY, "a corner")) return false;
    if (json_array_size(n->json) != 2)
        return json_wrong(r, n, "a corner is a vertex and a sharpness, not %zu numbers", json_array_size(n->json));
    const json_node v = json_element(n, 0), s = json_element(n, 1);
    uint32_t vertex = 0;
    float sharpness = 0;
    if (!json_read_index(r, &v, "vertices", b->cage->vertex_count, &vertex) || !read_sharpness(r, &s, &sharpness))
        return false;
    const char *problem = cage_add_corner(b, vertex, sharpness);
    return !problem || json_wrong(r, n, "%s", problem);
}

static bool read_hole(const json_reader *r, const json_node *n, cage_builder *b)
{
    uint32_t face = 0;
    if (!json_read_index(r, n, "faces", b->cage->face_count, &face)) return false;
    const char *problem = cage_add_hole(b, face);
    return !problem || json_wrong(r, n, "%s", problem);
}

static bool read_parts(const json_reader *r, const json_node *n, cage_builder *b)
{
    /* whatever their order in the file: each has indices into those before it */
    static const struct {
        const char *key, *name;
        bool needed;
        bool (*read)(const json_reader *r, const json_node *n, cage_builder *b);
    } parts[] = {
        {"vertices", "'vertices'", true, read_vertex}, {"faces", "'faces'", true, read_face},
        {"creases", "'creases'", false, read_crease},  {"corners", "'corners'", false, read_corner},
        {"holes", "'holes'", false, read_hole},
    };
    for (size_t k = 0; k < ARG_COUNT(parts); ++k) {
        const json_node list = json_member(n, parts[k].key);
        if (!list.json && !parts[k].needed) continue;
        if (!list.json) return json_wrong(r, n, "a subdivision surface needs %s", parts[k].name);
        if (!json_is(r, &list, JSON_ARRAY, parts[k].name)) return false;
        const size_t count = json_array_size(list.json);
        if (!count && parts[k].needed) return json_wrong(r, &list, "%s is empty", parts[k].name);
        for (size_t i = 0; i < count; ++i) {
            const json_node e = json_element(&list, i);
            if (!parts[k].read(r, &e, b)) return false;
        }
    }
    return true;
}

bool json_read_cage(const json_reader *r, const json_node *n, scene_geometry *g)
{
    model_options o;
    cage_builder b;
    if (!read_options(r, n, &o)) return false;
    if (!cage_begin(&b, &o)) return json_no_memory(r);
    const bool done = read_parts(r, n, &b);
    cage *c = cage_end(&b);
    if (done) return cage_to_geometry(r->name, c, g);
    cage_free(c);
    return false;
}
