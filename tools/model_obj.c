/* model_obj.c - Wavefront OBJ files: free-form surfaces, or polygons as the cage of a subdivision surface.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A geometry is one or the other; when both are in a file, what is not read is told of. What concerns only looks is
 * skipped, and so is, with a word, what nobody knows. A face has vertices that stand above it; OpenSubdiv's tags may
 * stand anywhere, so that they are read when all else is. */
#include "tools/args.h"
#include "tools/files.h"
#include "tools/obj_free.h"
#include "tools/obj_tags.h"

#include <stdlib.h>
#include <string.h>

typedef struct obj {
    obj_text text;
    model_polygons polygons;
    bool surfaces;         /* are what is read */
    const char *left_out;  /* the first of the others, or NULL */
    const char *first_tag; /* NULL: there are no tags */
    cage_builder builder;
    obj_free free;
} obj;

/* x y z, then a weight or a colour or both. */
static bool read_vertex(obj *o)
{
    double p[4], more[2] = {1, 1};
    size_t count = 0;
    for (int i = 0; i < 3; ++i)
        if (!obj_read_number(&o->text, "a coordinate", &p[i])) return false;
    for (; !obj_at_end(&o->text); ++count)
        if (!obj_read_number(&o->text, "a number", &more[count ? 1 : 0])) return false;
    p[3] = count == 1 || count == 4 ? more[0] : 1;
    if (o->surfaces) return obj_free_vertex(&o->free, p);
    return obj_is_fine(&o->text, o->text.statement.at, cage_add_vertex(&o->builder, p));
}

static bool leave_out(obj *o)
{
    if (!o->left_out) o->left_out = o->text.statement.at;
    return obj_skip_statement(&o->text);
}

static bool read_corner(obj *o)
{
    size_t vertex;
    return obj_read_reference(&o->text, "a corner of a face", "vertex", o->builder.cage->vertex_count, &vertex) &&
           obj_is_fine(&o->text, o->text.word.at, cage_add_face_corner(&o->builder, (uint32_t)vertex));
}

static bool read_face(obj *o)
{
    const char *at = o->text.statement.at;
    if (o->surfaces) return leave_out(o);
    if (o->polygons == POLYGONS_REFUSED) {
        report(obj_place(&o->text, at),
               "polygons are read as a cage only: add \"as\": \"subdivision\" to the geometry");
        return false;
    }
    while (!obj_at_end(&o->text))
        if (!read_corner(o)) return false;
    return obj_is_fine(&o->text, at, cage_add_face(&o->builder));
}

static bool skip(obj *o)
{
    return obj_skip_statement(&o->text);
}

static bool remember_tag(obj *o)
{
    if (!o->first_tag) o->first_tag = o->text.statement.at;
    return skip(o);
}

static bool refuse(obj *o)
{
    report(obj_place(&o->text, o->text.statement.at), "'%.*s' is of version 2 of the format and not read",
           OBJ_SHOWN(o->text.statement));
    return false;
}

static bool read_free(obj *o, const obj_free_statement *s)
{
    if (o->surfaces) return obj_read_free(&o->free, s);
    return obj_is(o->text.statement, "surf") ? leave_out(o) : skip(o);
}

static bool read_statement(obj *o)
{
    static const struct {
        bool (*read)(obj *o);
        const char *names[24];
    } kinds[] = {
        {read_vertex, {"v"}},
        {read_face, {"f"}},
        {remember_tag, {"t"}},
        {skip, {"vn",    "vt",       "con",      "o",          "g",         "s",      "mg",
                "p",     "l",        "lod",      "usemtl",     "mtllib",    "usemap", "maplib",
                "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "ctech",  "stech"}},
        {refuse, {"bzp", "bsp", "cdc", "cdp", "res"}},
    };
    const obj_free_statement *free_form = obj_find_free(o->text.statement);
    if (free_form) return read_free(o, free_form);
    for (size_t i = 0; i < ARG_COUNT(kinds); ++i)
        for (size_t k = 0; k < ARG_COUNT(kinds[i].names) && kinds[i].names[k]; ++k)
            if (obj_is(o->text.statement, kinds[i].names[k])) return kinds[i].read(o);
    obj_ignore(&o->text, o->text.statement);
    return skip(o);
}

static bool read_statements(obj *o)
{
    while (obj_next_statement(&o->text))
        if (!read_statement(o)) return false;
    return true;
}

/* What is left out, and what is not known: told of when nothing worse has to be said. */
static bool tell(const obj *o)
{
    if (o->left_out)
        report(obj_place(&o->text, o->left_out),
               o->surfaces ? "free-form surfaces are read; the polygons beside them are ignored"
                           : "polygons are read; the free-form surfaces beside them are ignored");
    obj_report_ignored(&o->text);
    return true;
}

static bool read_surfaces(obj *o, scene_geometry *g)
{
    o->free = (obj_free){.text = &o->text, .g = g};
    o->free.curves.points_left = 2 * (strlen(o->text.at) + 1);
    const bool done = read_statements(o) && obj_free_is_complete(&o->free);
    obj_free_release(&o->free);
    return done && tell(o);
}

static bool read_cage(obj *o, obj_tags *tags)
{
    if (!read_statements(o)) return false;
    if (!o->builder.cage->face_count)
        return report_file(o->text.path, o->polygons == POLYGONS_WANTED ? "there are no faces in the file"
                                                                        : "there are no faces or surfaces in the file"),
               false;
    if (!o->first_tag) return true;
    o->text.at = o->first_tag;
    return obj_read_tags(tags);
}

static bool read_polygons(obj *o, const model_options *options, scene_geometry *g)
{
    obj_tags tags = {.text = &o->text, .builder = &o->builder, .boundary = options->boundary};
    if (!cage_begin(&o->builder, options)) return report_no_memory(o->text.path), false;
    const bool done = read_cage(o, &tags);
    cage *c = cage_end(&o->builder);
    if (!done) return cage_free(c), false;
    return cage_to_geometry(o->text.path, c, g) && tell(o);
}

static bool has_surfaces(obj_text text)
{
    while (obj_next_statement(&text)) {
        if (obj_is(text.statement, "surf")) return true;
        obj_skip_statement(&text);
    }
    return false;
}

static bool read_text(const char *path, const char *text, const model_options *options, scene_geometry *g)
{
    obj o = {.text = {.path = path, .begin = text, .at = text}, .polygons = options->polygons};
    if (!strncmp(text, "\xEF\xBB\xBF", 3)) o.text.at += 3; /* a mark that some editors write before UTF-8 */
    o.surfaces = options->polygons != POLYGONS_WANTED && has_surfaces(o.text);
    return o.surfaces ? read_surfaces(&o, g) : read_polygons(&o, options, g);
}

bool model_read_obj(const char *path, const model_options *o, scene_geometry *g)
{
    size_t size;
    char *text = input_read(path, &size);
    if (!text) return false;

    const char *end = text + strlen(text);
    bool done = false;
    if (end != text + size) report(text_place(path, text, end), "a zero byte in a text file");
    else done = read_text(path, text, o, g);
    free(text);
    return done;
}
