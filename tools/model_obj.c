/* model_obj.c - polygons of Wavefront OBJ files as the cage of a subdivision surface.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * What concerns only looks is skipped, and so is, with a word, what nobody knows. A face has vertices that stand above
 * it; OpenSubdiv's tags may stand anywhere, so that they are read when all else is. */
#include "tools/args.h"
#include "tools/files.h"
#include "tools/obj_tags.h"

#include <stdlib.h>
#include <string.h>

typedef struct obj {
    obj_text text;
    const char *first_tag; /* NULL: there are no tags */
    bool polygons_are_cage;
    cage_builder builder;
} obj;

static bool read_vertex(obj *o)
{
    double p[3], more;
    for (int i = 0; i < 3; ++i)
        if (!obj_read_number(&o->text, "a coordinate", &p[i])) return false;
    while (!obj_at_end(&o->text)) /* a weight, colours */
        if (!obj_read_number(&o->text, "a number", &more)) return false;
    return obj_is_fine(&o->text, o->text.statement.at, cage_add_vertex(&o->builder, p));
}

/* vertex[/[texture][/[normal]]], of which the vertex counts from 1, or with a minus sign back from the last one. */
static bool read_corner(obj *o)
{
    if (!obj_next_word(&o->text, "a vertex")) return false;
    const obj_word w = o->text.word;
    const char *vertex_end = obj_whole_end(w.at), *end = vertex_end;
    for (int i = 0; i < 2 && *end == '/'; ++i) end = obj_whole_end(end + 1);
    if (vertex_end == w.at || end != w.at + w.length) return obj_wrong_word(&o->text, "a corner of a face");

    const long long count = (long long)o->builder.cage->vertex_count;
    const long long n = strtoll(w.at, NULL, 10); /* the nearest there is when it is too large */
    if (n && n <= count && n >= -count) {
        const uint32_t vertex = (uint32_t)(n > 0 ? n - 1 : count + n);
        return obj_is_fine(&o->text, w.at, cage_add_face_corner(&o->builder, vertex));
    }
    const obj_word vertex = {w.at, (size_t)(vertex_end - w.at)};
    report(obj_place(&o->text, w.at), "there is no vertex %.*s: %lld are defined above", OBJ_SHOWN(vertex), count);
    return false;
}

static bool read_face(obj *o)
{
    const char *at = o->text.statement.at;
    if (!o->polygons_are_cage) {
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

static bool refuse_free_form(obj *o)
{
    report(obj_place(&o->text, o->text.statement.at), "'%.*s': free-form curves and surfaces are not read yet",
           OBJ_SHOWN(o->text.statement));
    return false;
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
        {skip, {"vn",    "vt",       "vp",       "o",          "g",         "s",      "mg",
                "p",     "l",        "lod",      "usemtl",     "mtllib",    "usemap", "maplib",
                "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "ctech",  "stech"}},
        {refuse_free_form,
         {"cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp", "end", "con",
          "bzp", "bsp", "cdc", "cdp", "res"}},
    };
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
    if (o->builder.cage->face_count) return true;
    report_file(o->text.path, "there are no faces in the file");
    return false;
}

static bool read_cage(obj *o, obj_tags *tags)
{
    if (!read_statements(o)) return false;
    if (!o->first_tag) return true;
    o->text.at = o->first_tag;
    return obj_read_tags(tags);
}

static bool read_text(const char *path, const char *text, const model_options *options, scene_geometry *g)
{
    obj o = {.text = {.path = path, .begin = text, .at = text}, .polygons_are_cage = options->polygons_are_cage};
    obj_tags tags = {.text = &o.text, .builder = &o.builder, .boundary = options->boundary};
    if (!strncmp(text, "\xEF\xBB\xBF", 3)) o.text.at += 3; /* a mark that some editors write before UTF-8 */
    if (!cage_begin(&o.builder, options)) return report_no_memory(path), false;
    const bool done = read_cage(&o, &tags);
    cage *c = cage_end(&o.builder);
    if (!done) return cage_free(c), false;
    if (!cage_to_geometry(path, c, g)) return false;
    obj_report_ignored(&o.text); /* now that nothing worse has to be said */
    return true;
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
