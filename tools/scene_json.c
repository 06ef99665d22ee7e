/* scene_json.c - JSON scenes: jansson parses, this file walks the tree and knows what is allowed where.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Unknown keys are errors; nothing is guessed. */
#include "tools/scene_json.h"
#include "tools/args.h"
#include "tools/files.h"
#include "tools/json_cage.h"
#include "tools/json_patches.h"
#include "tools/json_triangles.h"
#include "tools/model.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool read_model(const json_reader *r, const json_node *n, scene_geometry *g)
{
    json_node p = json_member(n, "path"), as = json_member(n, "as");
    model_options o;
    if (!p.json) return json_wrong(r, n, "a geometry of type 'file' needs 'path'");
    if (!json_is(r, &p, JSON_STRING, "'path'")) return false;

    const char *path = json_string_value(p.json), *slash = strrchr(r->path, '/');
    if (!*path) return json_wrong(r, &p, "'path' is empty");
    if (!json_read_model_options(r, n, &o)) return false;
    size_t folder = *path == '/' || !slash ? 0 : (size_t)(slash + 1 - r->path), size = folder + strlen(path) + 1;
    char *whole = malloc(size);
    if (!whole) return json_no_memory(r);
    snprintf(whole, size, "%.*s%s", (int)folder, r->path, path);
    bool done = model_read(whole, &o, g);
    free(whole);
    return done && (!as.json || g->cage || json_wrong(r, &as, "the file has no polygons"));
}

/* What a geometry may be. */
typedef struct geometry_type {
    const char *name;
    bool (*read)(const json_reader *r, const json_node *n, scene_geometry *g);
    const char *keys[8]; /* besides name, type and trim */
} geometry_type;

static const geometry_type types[] = {
    {"bezier_triangles", json_read_bezier_triangles, {"degree", "patches"}},
    {"bezier", json_read_bezier, {"degree", "patches"}},
    {"file", read_model, {"path", "as", "scheme", "level", "boundary"}},
    {"subdivision",
     json_read_cage,
     {"vertices", "faces", "creases", "corners", "holes", "scheme", "level", "boundary"}},
    {"nurbs", json_read_nurbs, {"degree", "knots", "points"}},
    {"quadratic_triangles", json_read_quadratic_triangles, {"patches"}},
    {"phong_triangles", json_read_phong_triangles, {"vertices", "normals", "triangles", "alpha"}},
    {"pn_triangles", json_read_pn_triangles, {"vertices", "normals", "triangles"}},
};

/* NULL after a message. */
static const geometry_type *find_type(const json_reader *r, const json_node *n)
{
    const char *names[ARG_COUNT(types)];
    json_node type = json_member(n, "type");
    if (!type.json) return json_wrong(r, n, "a geometry has no 'type'"), NULL;
    if (!json_is(r, &type, JSON_STRING, "'type'")) return NULL;

    const char *name = json_string_value(type.json);
    for (size_t i = 0; i < ARG_COUNT(types); ++i) {
        names[i] = types[i].name;
        if (!strcmp(name, names[i])) return &types[i];
    }
    const char *nearest = args_nearest(name, names, ARG_COUNT(names));
    if (nearest) json_wrong(r, &type, "no type of geometry is called '%s'; did you mean '%s'?", name, nearest);
    else json_wrong(r, &type, "no type of geometry is called '%s'", name);
    return NULL;
}

static bool read_geometry(const json_reader *r, const json_node *n, scene_geometry *g)
{
    if (!json_is(r, n, JSON_OBJECT, "a geometry")) return false;
    const geometry_type *type = find_type(r, n);
    if (!type) return false;

    const char *keys[3 + ARG_COUNT(type->keys)] = {"name", "type", "trim"};
    size_t count = 3;
    for (size_t i = 0; i < ARG_COUNT(type->keys) && type->keys[i]; ++i) keys[count++] = type->keys[i];
    if (!json_only_keys(r, n, "a geometry of this type", keys, count)) return false;

    json_node name = json_member(n, "name"), trim = json_member(n, "trim");
    if (name.json && !json_read_string(r, &name, "'name'", &g->name)) return false;
    if (!type->read(r, n, g)) return false;
    if (trim.json && g->cage) return json_wrong(r, &trim, "a subdivision surface cannot be trimmed");
    return !trim.json || json_trim_all(r, &trim, g);
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

/* `names`: of the geometries; name -> index, or -1 where several are called so. */
static bool find_geometry(const json_reader *r, const json_node *n, const json_t *names, size_t *found)
{
    if (!json_is(r, n, JSON_STRING, "an object's geometry")) return false;
    const char *name = json_string_value(n->json);
    const json_t *at = json_object_get(names, name);
    if (!at) return json_wrong(r, n, "no geometry is called '%s'", name);
    if (json_integer_value(at) < 0) return json_wrong(r, n, "several geometries are called '%s'", name);
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

static bool read_object(const json_reader *r, const json_node *n, const json_t *names, scene_object *o)
{
    static const char *const keys[] = {"geometry", "transform", "material"};
    static const double identity[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    if (!json_is(r, n, JSON_OBJECT, "an object of the scene")) return false;
    if (!json_only_keys(r, n, "an object", keys, ARG_COUNT(keys))) return false;

    json_node geometry = json_member(n, "geometry"), transform = json_member(n, "transform"),
              material = json_member(n, "material");
    if (!geometry.json) return json_wrong(r, n, "an object has no 'geometry'");
    if (!find_geometry(r, &geometry, names, &o->geometry)) return false;
    if (material.json && !json_read_string(r, &material, "'material'", &o->material)) return false;

    memcpy(o->transform, identity, sizeof identity);
    if (transform.json && !json_read_numbers(r, &transform, "'transform'", 12, o->transform)) return false;
    if (!can_invert(o->transform)) return json_wrong(r, &transform, "the transform cannot be inverted");
    o->identity = true;
    for (int i = 0; i < 12; ++i) o->identity = o->identity && o->transform[i] == identity[i];
    return true;
}

static bool read_objects(const json_reader *r, const json_node *objects, scene *s)
{
    if (!json_is(r, objects, JSON_ARRAY, "'objects'")) return false;
    size_t count = json_array_size(objects->json);
    json_t *names = index_names(s);
    s->objects = calloc(count ? count : 1, sizeof *s->objects);
    bool done = names && s->objects;
    if (!done) json_no_memory(r);
    while (done && s->object_count < count) {
        json_node e = json_element(objects, s->object_count);
        done = read_object(r, &e, names, &s->objects[s->object_count++]);
    }
    json_decref(names);
    return done;
}

static bool read_camera(const json_reader *r, const json_node *n, camera *c)
{
    static const char *const keys[] = {"eye", "target", "up", "fov"};
    if (!json_is(r, n, JSON_OBJECT, "'camera'") || !json_only_keys(r, n, "a camera", keys, ARG_COUNT(keys)))
        return false;
    for (size_t i = 0; i < ARG_COUNT(keys); ++i) {
        json_node value = json_member(n, keys[i]);
        if (!value.json) return json_wrong(r, n, "the camera has no '%s'", keys[i]);
        double *const to[] = {c->eye, c->target, c->up};
        if (i < 3 ? !json_read_numbers(r, &value, keys[i], 3, to[i]) : !json_read_number(r, &value, keys[i], &c->fov))
            return false;
    }
    const char *problem = camera_problem(c);
    return !problem || json_wrong(r, n, "%s", problem);
}

static bool read_scene(const json_reader *r, const json_node *root, scene *s)
{
    static const char *const keys[] = {"format", "version", "camera", "geometry", "objects"};
    if (!json_is(r, root, JSON_OBJECT, "the scene") || !json_only_keys(r, root, "a scene", keys, ARG_COUNT(keys)))
        return false;

    json_node format = json_member(root, "format"), version = json_member(root, "version"),
              camera = json_member(root, "camera");
    json_node geometry = json_member(root, "geometry"), objects = json_member(root, "objects");
    if (format.json && (!json_is_string(format.json) || strcmp(json_string_value(format.json), "embree_patch scene")))
        return json_wrong(r, &format, "the format is not \"embree_patch scene\"");
    if (version.json && json_number_value(version.json) != 1)
        return json_wrong(r, &version, "this program reads version 1 of the format");
    s->has_camera = camera.json != NULL;
    if (camera.json && !read_camera(r, &camera, &s->camera)) return false;

    if (!geometry.json) return json_wrong(r, root, "the scene has no 'geometry'");
    if (!json_is(r, &geometry, JSON_ARRAY, "'geometry'")) return false;
    size_t count = json_array_size(geometry.json);
    s->geometries = calloc(count ? count : 1, sizeof *s->geometries);
    if (!s->geometries) return json_no_memory(r);
    for (s->geometry_count = 0; s->geometry_count < count;) {
        json_node e = json_element(&geometry, s->geometry_count);
        if (!read_geometry(r, &e, &s->geometries[s->geometry_count++])) return false;
    }

    return !objects.json || read_objects(r, &objects, s);
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
    json_node root = {{NULL, NULL, 0},
                      json_loadb(text, size, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &error)};
    bool done = false;
    if (root.json) {
        done = read_scene(&(json_reader){path, text, s->path}, &root, s);
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
