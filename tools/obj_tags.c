/* obj_tags.c - see obj_tags.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A tag is `t NAME A/B/C`, then A whole numbers, B numbers and C words. Memory grows with what is read, never with what
 * these counts promise. */
#include "tools/obj_tags.h"
#include "tools/args.h"

#include <stdlib.h>
#include <string.h>

/* How many whole numbers, numbers and words a tag says it has. */
typedef struct tag_counts {
    const char *at;
    unsigned long long whole, numbers, words;
} tag_counts;

static bool read_counts(obj_tags *g, tag_counts *n)
{
    static const char what[] = "three counts of arguments, as in 2/1/0";
    unsigned long long *const to[] = {&n->whole, &n->numbers, &n->words};
    if (!obj_next_word(g->text, what)) return false;
    const obj_word w = g->text->word;
    const char *at = n->at = w.at;
    for (size_t i = 0; i < ARG_COUNT(to); ++i) {
        const char *end = obj_whole_end(at);
        if (end == at || *at == '-' || (i < 2 ? *end != '/' : end != w.at + w.length))
            return obj_wrong_word(g->text, what);
        *to[i] = strtoull(at, NULL, 10); /* the largest there is when it is too large */
        at = end + 1;
    }
    return true;
}

static bool expect(const obj_tags *g, const tag_counts *n, unsigned long long whole, unsigned long long numbers,
                   unsigned long long words)
{
    if (n->whole == whole && n->numbers == numbers && n->words == words) return true;
    report(obj_place(g->text, n->at), "a tag of this kind has %llu/%llu/%llu arguments, not %llu/%llu/%llu", whole,
           numbers, words, n->whole, n->numbers, n->words);
    return false;
}

/* A whole number below `count`. */
static bool read_index(obj_tags *g, const char *what, size_t count, uint32_t *to)
{
    if (!obj_next_word(g->text, what)) return false;
    const obj_word w = g->text->word;
    if (obj_whole_end(w.at) != w.at + w.length) return obj_wrong_word(g->text, what);
    const long long n = strtoll(w.at, NULL, 10);
    if (n >= 0 && (unsigned long long)n < count) return *to = (uint32_t)n, true;
    report(obj_place(g->text, w.at), "there is no %s %.*s; they count from 0 to %lld", strchr(what, ' ') + 1,
           OBJ_SHOWN(w), (long long)count - 1);
    return false;
}

static bool read_vertex_index(obj_tags *g, uint32_t *to)
{
    return read_index(g, "a vertex", g->builder->cage->vertex_count, to);
}

static bool read_sharpness(obj_tags *g, float *to)
{
    double x = 0;
    return obj_read_number(g->text, "a sharpness", &x) && obj_is_fine(g->text, g->text->word.at, cage_sharpness(x, to));
}

/* Of item i, given the one before: there is one for all, or one each. */
static bool read_next_sharpness(obj_tags *g, const tag_counts *n, size_t i, float *s)
{
    return (i && n->numbers == 1) || read_sharpness(g, s);
}

static bool read_crease_edge(obj_tags *g)
{
    uint32_t from = 0, to = 0;
    return read_vertex_index(g, &from) && read_vertex_index(g, &to) &&
           obj_is_fine(g->text, g->text->word.at, cage_add_crease(g->builder, from, to, 0));
}

static bool tag_crease(obj_tags *g, const tag_counts *n)
{
    const cage *c = g->builder->cage;
    const size_t first = c->crease_count;
    float sharpness = 0;
    if (n->whole % 2)
        return report(obj_place(g->text, n->at), "a crease has an odd number of vertices, %llu", n->whole), false;
    if (!expect(g, n, n->whole, n->numbers == n->whole / 2 ? n->numbers : 1, 0)) return false;
    for (unsigned long long i = 0; i < n->whole; i += 2)
        if (!read_crease_edge(g)) return false;
    for (size_t i = first; i < c->crease_count; ++i) {
        if (!read_next_sharpness(g, n, i - first, &sharpness)) return false;
        c->creases[i].sharpness = sharpness;
    }
    return true;
}

static bool tag_corner(obj_tags *g, const tag_counts *n)
{
    const cage *c = g->builder->cage;
    const size_t first = c->sharp_count;
    float sharpness = 0;
    if (!expect(g, n, n->whole, n->numbers == n->whole ? n->numbers : 1, 0)) return false;
    for (unsigned long long i = 0; i < n->whole; ++i) {
        uint32_t vertex = 0;
        if (!read_vertex_index(g, &vertex)) return false;
        if (!obj_is_fine(g->text, g->text->word.at, cage_add_corner(g->builder, vertex, 0))) return false;
    }
    for (size_t i = first; i < c->sharp_count; ++i) {
        if (!read_next_sharpness(g, n, i - first, &sharpness)) return false;
        c->sharp[i].sharpness = sharpness;
    }
    return true;
}

static bool tag_hole(obj_tags *g, const tag_counts *n)
{
    if (!expect(g, n, n->whole, 0, 0)) return false;
    for (unsigned long long i = 0; i < n->whole; ++i) {
        uint32_t face = 0;
        if (!read_index(g, "a face", g->builder->cage->face_count, &face)) return false;
        if (!obj_is_fine(g->text, g->text->word.at, cage_add_hole(g->builder, face))) return false;
    }
    return true;
}

static bool tag_boundary(obj_tags *g, const tag_counts *n)
{
    static const cage_boundary values[] = {CAGE_NO_BOUNDARY, CAGE_EDGE_AND_CORNER, CAGE_EDGE_ONLY};
    uint32_t value = 0;
    if (!expect(g, n, 1, 0, 0) || !read_index(g, "a boundary", ARG_COUNT(values), &value)) return false;
    if (!g->boundary) g->builder->cage->boundary = values[value];
    return true;
}

/* One of two words, the second of which is true. */
static bool read_choice(obj_tags *g, const char *no, const char *yes, bool *to)
{
    if (!obj_next_word(g->text, "a word")) return false;
    const obj_word w = g->text->word;
    *to = obj_is(w, yes);
    if (*to || obj_is(w, no)) return true;
    report(obj_place(g->text, w.at), "'%.*s' is not '%s' or '%s'", OBJ_SHOWN(w), no, yes);
    return false;
}

static bool tag_crease_method(obj_tags *g, const tag_counts *n)
{
    return expect(g, n, 0, 0, 1) && read_choice(g, "normal", "chaikin", &g->builder->cage->chaikin);
}

static bool tag_smooth_triangles(obj_tags *g, const tag_counts *n)
{
    bool *to = &g->builder->cage->smooth_triangles;
    if (n->words) return expect(g, n, 0, 0, 1) && read_choice(g, "catmark", "smooth", to);
    return expect(g, n, 1, 0, 0) && read_choice(g, "0", "1", to);
}

/* Texture coordinates are not traced, and nobody misses what tags say of them. */
static bool ignore_tag(obj_tags *g)
{
    static const char textures[] = "facevarying";
    const obj_word name = g->text->word;
    if (name.length < strlen(textures) || memcmp(name.at, textures, strlen(textures))) obj_ignore(g->text, name);
    return obj_skip_statement(g->text);
}

static bool read_tag(obj_tags *g)
{
    static const struct {
        const char *name;
        bool (*read)(obj_tags *g, const tag_counts *n);
    } kinds[] = {{"crease", tag_crease},
                 {"corner", tag_corner},
                 {"hole", tag_hole},
                 {"interpolateboundary", tag_boundary},
                 {"creasemethod", tag_crease_method},
                 {"smoothtriangles", tag_smooth_triangles}};
    tag_counts n;
    size_t i = 0;
    if (!obj_next_word(g->text, "the name of a tag")) return false;
    while (i < ARG_COUNT(kinds) && !obj_is(g->text->word, kinds[i].name)) ++i;
    if (i == ARG_COUNT(kinds)) return ignore_tag(g);
    if (!read_counts(g, &n) || !kinds[i].read(g, &n)) return false;
    if (obj_at_end(g->text)) return true;
    report(obj_place(g->text, g->text->at), "the line goes on after the arguments of the tag");
    return false;
}

bool obj_read_tags(obj_tags *g)
{
    while (obj_next_statement(g->text))
        if (obj_is(g->text->statement, "t") ? !read_tag(g) : !obj_skip_statement(g->text)) return false;
    return true;
}
