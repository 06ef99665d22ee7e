/* scene_json.c - JSON scenes: jansson parses, this file walks the tree and knows what is allowed where.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A node is a value with the way to it from the root, so that a message can name line and column (json_place.h). Each
 * level of the walk keeps its node on the stack. Unknown keys are errors; nothing is guessed. */
#include "tools/scene_json.h"
#include "tools/args.h"
#include "tools/files.h"
#include "tools/json_place.h"
#include "tools/model.h"

#include <float.h>
#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    const char *path, *text;
    scene *s;
    json_t *names; /* of the geometries, once they are read: name -> index, or -1 where several are called so */
} reader;

typedef struct node {
    json_step at; /* first, so that a child's `up` leads here */
    json_t *json; /* NULL: not there */
} node;

static bool vwrong(const reader *r, const node *n, bool at_key, const char *format, va_list list)
{
    char message[400];
    vsnprintf(message, sizeof message, format, list);
    report(json_place(r->s->path, r->text, &n->at, at_key), "%s", message);
    return false;
}

__attribute__((format(printf, 3, 4))) static bool wrong(const reader *r, const node *n, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vwrong(r, n, false, format, list);
    va_end(list);
    return false;
}

__attribute__((format(printf, 3, 4))) static bool wrong_key(const reader *r, const node *n, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vwrong(r, n, true, format, list);
    va_end(list);
    return false;
}

static bool no_memory(const reader *r)
{
    report_no_memory(r->s->path);
    return false;
}

static node member(const node *object, const char *key)
{
    return (node){{&object->at, key, 0}, json_object_get(object->json, key)};
}

static node element(const node *array, size_t i)
{
    return (node){{&array->at, NULL, i}, json_array_get(array->json, i)};
}

static const char *type_name(json_type type)
{
    switch (type) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: return "an array";
    case JSON_STRING: return "a string";
    case JSON_INTEGER:
    case JSON_REAL: return "a number";
    case JSON_TRUE:
    case JSON_FALSE: return "true or false";
    case JSON_NULL: break;
    }
    return "null";
}

/* `what` names the value in messages: "the camera's eye". */
static bool is(const reader *r, const node *n, json_type type, const char *what)
{
    if (json_typeof(n->json) == type) return true;
    return wrong(r, n, "%s is %s, not %s", what, type_name(json_typeof(n->json)), type_name(type));
}

static bool only_keys(const reader *r, const node *object, const char *what, const char *const *keys, size_t count)
{
    const char *key;
    json_t *value;
    json_object_foreach(object->json, key, value)
    {
        size_t i = 0;
        while (i < count && strcmp(key, keys[i])) ++i;
        if (i < count) continue;
        node n = member(object, key);
        const char *nearest = args_nearest(key, keys, count);
        if (nearest) return wrong_key(r, &n, "%s has no key '%s'; did you mean '%s'?", what, key, nearest);
        return wrong_key(r, &n, "%s has no key '%s'", what, key);
    }
    return true;
}

static bool read_number(const reader *r, const node *n, const char *what, double *to)
{
    if (!json_is_number(n->json)) return wrong(r, n, "%s is %s, not a number", what, type_name(json_typeof(n->json)));
    *to = json_number_value(n->json);
    return true;
}

static bool read_numbers(const reader *r, const node *n, const char *what, size_t count, double *to)
{
    if (!is(r, n, JSON_ARRAY, what)) return false;
    if (json_array_size(n->json) != count)
        return wrong(r, n, "%s has %zu numbers, not %zu", what, json_array_size(n->json), count);
    for (size_t i = 0; i < count; ++i) {
        node e = element(n, i);
        if (!read_number(r, &e, what, &to[i])) return false;
    }
    return true;
}

static bool read_string(const reader *r, const node *n, const char *what, char **to)
{
    if (!is(r, n, JSON_STRING, what)) return false;
    *to = strdup(json_string_value(n->json));
    return *to || no_memory(r);
}

static bool read_degree(const reader *r, const node *n, unsigned *to)
{
    double x = 0;
    if (!read_number(r, n, "a degree", &x)) return false;
    if (x != floor(x) || x < 1 || x > EP_MAX_DEGREE)
        return wrong(r, n, "a degree is %g, not a whole number from 1 to %d", x, EP_MAX_DEGREE);
    *to = (unsigned)x;
    return true;
}

static bool read_point(const reader *r, const node *n, double p[4])
{
    if (!is(r, n, JSON_ARRAY, "a point")) return false;
    size_t count = json_array_size(n->json);
    if (count != 3 && count != 4) return wrong(r, n, "a point has 3 or 4 numbers, not %zu", count);
    p[3] = 1;
    for (size_t i = 0; i < count; ++i) {
        node e = element(n, i);
        if (!read_number(r, &e, "a coordinate", &p[i])) return false;
    }
    const char *problem = point_problem(p);
    return !problem || wrong(r, n, "%s", problem);
}

/* A patch is its list of points, or an object with the list and a trim. */
static bool read_patch(const reader *r, const node *n, patch_kind kind, const unsigned degree[2], scene_geometry *g)
{
    node points = *n;
    if (json_is_object(n->json)) {
        static const char *const keys[] = {"points", "trim"};
        node trim = member(n, "trim");
        if (!only_keys(r, n, "a patch", keys, ARG_COUNT(keys))) return false;
        if (trim.json) return wrong_key(r, &trim, "trims are not supported yet");
        points = member(n, "points");
        if (!points.json) return wrong(r, n, "a patch has no points");
    }
    if (!is(r, &points, JSON_ARRAY, "a patch")) return false;

    size_t have = json_array_size(points.json), need = patch_point_count(kind, degree[0], degree[1]);
    if (have != need) return wrong(r, &points, "a patch of this degree has %zu points, not %zu", need, have);
    double *p = geometry_add_patch(g, kind, degree[0], degree[1]);
    if (!p) return no_memory(r);
    for (size_t i = 0; i < need; ++i) {
        node e = element(&points, i);
        if (!read_point(r, &e, p + 4 * i)) return false;
    }
    return true;
}

static bool read_patches(const reader *r, const node *n, patch_kind kind, const unsigned degree[2], scene_geometry *g)
{
    node patches = member(n, "patches");
    if (!patches.json) return wrong(r, n, "a geometry of Bézier patches needs 'patches'");
    if (!is(r, &patches, JSON_ARRAY, "'patches'")) return false;
    for (size_t i = 0; i < json_array_size(patches.json); ++i) {
        node e = element(&patches, i);
        if (!read_patch(r, &e, kind, degree, g)) return false;
    }
    return true;
}

static bool read_bezier_triangles(const reader *r, const node *n, scene_geometry *g)
{
    unsigned degree[2] = {0, 0};
    node d = member(n, "degree");
    if (!d.json) return wrong(r, n, "a geometry of Bézier triangles needs 'degree'");
    if (!read_degree(r, &d, &degree[0])) return false;
    degree[1] = degree[0];
    return read_patches(r, n, PATCH_TRIANGLE, degree, g);
}

static bool read_bezier(const reader *r, const node *n, scene_geometry *g)
{
    unsigned degree[2] = {0, 0};
    node d = member(n, "degree");
    if (!d.json) return wrong(r, n, "a geometry of Bézier patches needs 'degree'");
    if (!is(r, &d, JSON_ARRAY, "'degree'")) return false;
    if (json_array_size(d.json) != 2) return wrong(r, &d, "'degree' has two numbers: in u and in v");
    for (size_t i = 0; i < 2; ++i) {
        node e = element(&d, i);
        if (!read_degree(r, &e, &degree[i])) return false;
    }
    return read_patches(r, n, PATCH_TENSOR, degree, g);
}

static bool read_model(const reader *r, const node *n, scene_geometry *g)
{
    node p = member(n, "path");
    if (!p.json) return wrong(r, n, "a geometry of type 'file' needs 'path'");
    if (!is(r, &p, JSON_STRING, "'path'")) return false;

    const char *path = json_string_value(p.json), *slash = strrchr(r->path, '/');
    if (!*path) return wrong(r, &p, "'path' is empty");
    size_t folder = *path == '/' || !slash ? 0 : (size_t)(slash + 1 - r->path), size = folder + strlen(path) + 1;
    char *whole = malloc(size);
    if (!whole) return no_memory(r);
    snprintf(whole, size, "%.*s%s", (int)folder, r->path, path);
    bool done = model_read(whole, g);
    free(whole);
    return done;
}

/* What a geometry may be. A type without a reader is known to the format and not to this version. */
typedef struct geometry_type {
    const char *name;
    bool (*read)(const reader *r, const node *n, scene_geometry *g);
    const char *keys[2]; /* besides name, type and trim */
} geometry_type;

static const geometry_type types[] = {
    {"bezier_triangles", read_bezier_triangles, {"degree", "patches"}},
    {"bezier", read_bezier, {"degree", "patches"}},
    {"file", read_model, {"path"}},
    {"nurbs", NULL, {NULL}},
    {"quadratic_triangles", NULL, {NULL}},
    {"phong_triangles", NULL, {NULL}},
    {"pn_triangles", NULL, {NULL}},
    {"subdivision", NULL, {NULL}},
};

/* NULL after a message. */
static const geometry_type *find_type(const reader *r, const node *n)
{
    const char *names[ARG_COUNT(types)];
    node type = member(n, "type");
    if (!type.json) return wrong(r, n, "a geometry has no 'type'"), NULL;
    if (!is(r, &type, JSON_STRING, "'type'")) return NULL;

    const char *name = json_string_value(type.json);
    for (size_t i = 0; i < ARG_COUNT(types); ++i) {
        names[i] = types[i].name;
        if (strcmp(name, names[i])) continue;
        if (types[i].read) return &types[i];
        return wrong(r, &type, "geometry of type '%s' is not supported yet", name), NULL;
    }
    const char *nearest = args_nearest(name, names, ARG_COUNT(names));
    if (nearest) wrong(r, &type, "no type of geometry is called '%s'; did you mean '%s'?", name, nearest);
    else wrong(r, &type, "no type of geometry is called '%s'", name);
    return NULL;
}

static bool read_geometry(const reader *r, const node *n, scene_geometry *g)
{
    if (!is(r, n, JSON_OBJECT, "a geometry")) return false;
    const geometry_type *type = find_type(r, n);
    if (!type) return false;

    const char *keys[5] = {"name", "type", "trim"};
    size_t count = 3;
    for (size_t i = 0; i < ARG_COUNT(type->keys) && type->keys[i]; ++i) keys[count++] = type->keys[i];
    if (!only_keys(r, n, "a geometry of this type", keys, count)) return false;

    node name = member(n, "name"), trim = member(n, "trim");
    if (name.json && !read_string(r, &name, "'name'", &g->name)) return false;
    if (trim.json) return wrong_key(r, &trim, "trims are not supported yet");
    return type->read(r, n, g);
}

static json_t *index_names(const scene *s)
{
    json_t *names = json_object();
    for (size_t i = 0; i < s->geometry_count; ++i) {
        const char *name = s->geometries[i].name;
        if (!name) continue;
        json_int_t at = json_object_get(names, name) ? -1 : (json_int_t)i;
        if (!json_object_set_new(names, name, json_integer(at))) continue;
        json_decref(names);
        return NULL;
    }
    return names;
}

static bool find_geometry(const reader *r, const node *n, size_t *found)
{
    if (!is(r, n, JSON_STRING, "an object's geometry")) return false;
    const char *name = json_string_value(n->json);
    const json_t *at = json_object_get(r->names, name);
    if (!at) return wrong(r, n, "no geometry is called '%s'", name);
    if (json_integer_value(at) < 0) return wrong(r, n, "several geometries are called '%s'", name);
    *found = (size_t)json_integer_value(at);
    return true;
}

/* Embree inverts transforms in float, so that is what must be possible. */
static bool can_invert(const double m[12])
{
    double det = 0, lengths = 1;
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        det += m[i] * (m[3 + j] * m[6 + k] - m[3 + k] * m[6 + j]);
        lengths *= sqrt(m[3 * i] * m[3 * i] + m[3 * i + 1] * m[3 * i + 1] + m[3 * i + 2] * m[3 * i + 2]);
    }
    return isnormal((float)det) && isnormal((float)(1 / det)) && fabs(det) > 8 * FLT_EPSILON * lengths;
}

static bool read_object(const reader *r, const node *n, scene_object *o)
{
    static const char *const keys[] = {"geometry", "transform", "material"};
    static const double identity[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    if (!is(r, n, JSON_OBJECT, "an object of the scene")) return false;
    if (!only_keys(r, n, "an object", keys, ARG_COUNT(keys))) return false;

    node geometry = member(n, "geometry"), transform = member(n, "transform"), material = member(n, "material");
    if (!geometry.json) return wrong(r, n, "an object has no 'geometry'");
    if (!find_geometry(r, &geometry, &o->geometry)) return false;
    if (material.json && !read_string(r, &material, "'material'", &o->material)) return false;

    memcpy(o->transform, identity, sizeof identity);
    if (transform.json && !read_numbers(r, &transform, "'transform'", 12, o->transform)) return false;
    if (!can_invert(o->transform)) return wrong(r, &transform, "the transform cannot be inverted");
    o->identity = true;
    for (int i = 0; i < 12; ++i) o->identity = o->identity && o->transform[i] == identity[i];
    return true;
}

static bool read_objects(const reader *r, const node *objects)
{
    scene *s = r->s;
    if (!is(r, objects, JSON_ARRAY, "'objects'")) return false;
    size_t count = json_array_size(objects->json);
    reader named = *r;
    named.names = index_names(s);
    s->objects = calloc(count ? count : 1, sizeof *s->objects);
    bool done = named.names && s->objects;
    if (!done) no_memory(r);
    while (done && s->object_count < count) {
        node e = element(objects, s->object_count);
        done = read_object(&named, &e, &s->objects[s->object_count++]);
    }
    json_decref(named.names);
    return done;
}

static bool read_camera(const reader *r, const node *n, camera *c)
{
    static const char *const keys[] = {"eye", "target", "up", "fov"};
    if (!is(r, n, JSON_OBJECT, "'camera'") || !only_keys(r, n, "a camera", keys, ARG_COUNT(keys))) return false;
    for (size_t i = 0; i < ARG_COUNT(keys); ++i) {
        node value = member(n, keys[i]);
        if (!value.json) return wrong(r, n, "the camera has no '%s'", keys[i]);
        double *const to[] = {c->eye, c->target, c->up};
        if (i < 3 ? !read_numbers(r, &value, keys[i], 3, to[i]) : !read_number(r, &value, keys[i], &c->fov))
            return false;
    }
    const char *problem = camera_problem(c);
    return !problem || wrong(r, n, "%s", problem);
}

static bool read_scene(const reader *r, const node *root)
{
    static const char *const keys[] = {"format", "version", "camera", "geometry", "objects"};
    scene *s = r->s;
    if (!is(r, root, JSON_OBJECT, "the scene") || !only_keys(r, root, "a scene", keys, ARG_COUNT(keys))) return false;

    node format = member(root, "format"), version = member(root, "version"), camera = member(root, "camera");
    node geometry = member(root, "geometry"), objects = member(root, "objects");
    if (format.json && (!json_is_string(format.json) || strcmp(json_string_value(format.json), "embree_patch scene")))
        return wrong(r, &format, "the format is not \"embree_patch scene\"");
    if (version.json && json_number_value(version.json) != 1)
        return wrong(r, &version, "this program reads version 1 of the format");
    s->has_camera = camera.json != NULL;
    if (camera.json && !read_camera(r, &camera, &s->camera)) return false;

    if (!geometry.json) return wrong(r, root, "the scene has no 'geometry'");
    if (!is(r, &geometry, JSON_ARRAY, "'geometry'")) return false;
    size_t count = json_array_size(geometry.json);
    s->geometries = calloc(count ? count : 1, sizeof *s->geometries);
    if (!s->geometries) return no_memory(r);
    for (s->geometry_count = 0; s->geometry_count < count;) {
        node e = element(&geometry, s->geometry_count);
        if (!read_geometry(r, &e, &s->geometries[s->geometry_count++])) return false;
    }

    return !objects.json || read_objects(r, &objects);
}

bool scene_read_json(const char *path, scene *s)
{
    size_t size;
    json_error_t error;
    char *text = input_read(path, &size);
    if (!text) return false;

    const char *end = text + strlen(text);
    if (end != text + size) { /* jansson lets some pass, and nothing could be found behind them */
        report(text_place(s->path, text, end), "a zero byte in a text file");
        free(text);
        return false;
    }
    node root = {{NULL, NULL, 0}, json_loadb(text, size, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &error)};
    bool done = false;
    if (root.json) {
        done = read_scene(&(reader){path, text, s, NULL}, &root);
    } else if (!size) {
        report_file(s->path, "the file is empty");
    } else if (!error.text[0]) { /* jansson always finds words but when an allocation fails */
        report_no_memory(s->path);
    } else {
        size_t column = error.column > 0 ? (size_t)error.column : 1; /* 0: a line that has not begun */
        report((place){s->path, (size_t)error.line, column}, "%s", error.text);
    }
    json_decref(root.json);
    free(text);
    return done;
}
