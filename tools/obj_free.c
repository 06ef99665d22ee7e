/* obj_free.c - see obj_free.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/obj_free.h"
#include "tools/args.h"
#include "tools/array.h"
#include "tools/model.h"
#include "tools/obj_element.h"
#include "tools/obj_surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool obj_add_numbers(obj_free *f, obj_numbers *to, const double *x, size_t count)
{
    void *at = to->at;
    if (!array_grow(&at, &to->capacity, to->count, count, sizeof *x)) return report_no_memory(f->text->path), false;
    to->at = at;
    memcpy(to->at + to->count, x, count * sizeof *x);
    to->count += count;
    return true;
}

static bool read_finite(obj_free *f, const char *what, double *to)
{
    return obj_read_number(f->text, what, to) && (isfinite(*to) || obj_wrong_word(f->text, what));
}

bool obj_read_parameter(obj_free *f, double *to)
{
    return read_finite(f, "a parameter", to);
}

/* A whole number from 1 on. */
static bool read_count(obj_free *f, const char *what, size_t most, size_t *to)
{
    if (!obj_next_word(f->text, what)) return false;
    const obj_word w = f->text->word;
    if (obj_whole_end(w.at) != w.at + w.length) return obj_wrong_word(f->text, what);
    const long long n = strtoll(w.at, NULL, 10); /* the nearest there is when it is too large */
    if (n >= 1 && (unsigned long long)n <= most) return *to = (size_t)n, true;
    report(obj_place(f->text, w.at), "%s is %.*s, not between 1 and %zu", what, OBJ_SHOWN(w), most);
    return false;
}

bool obj_free_vertex(obj_free *f, const double p[4])
{
    return obj_is_fine(f->text, f->text->statement.at, point_problem((double[4]){p[0], p[1], p[2], 1})) &&
           obj_add_numbers(f, &f->vertices, p, 4);
}

/* v and the weight can be left out. */
static bool vertex2(obj_free *f)
{
    double p[3] = {0, NAN, 1};
    if (!read_finite(f, "a parameter", p)) return false;
    for (int i = 1; i < 3 && !obj_at_end(f->text); ++i)
        if (!read_finite(f, i < 2 ? "a parameter" : "a weight", &p[i])) return false;
    return obj_add_numbers(f, &f->vertices2, p, 3) && obj_skip_statement(f->text);
}

static bool form(obj_free *f)
{
    static const char *const names[] = {[OBJ_BSPLINE] = "bspline",
                                        [OBJ_BEZIER] = "bezier",
                                        [OBJ_CARDINAL] = "cardinal",
                                        [OBJ_TAYLOR] = "taylor",
                                        [OBJ_MATRIX] = "bmatrix"};
    static const char what[] = "a kind of curve or surface";
    if (!obj_next_word(f->text, what)) return false;
    f->rational = obj_is(f->text->word, "rat");
    if (f->rational && !obj_next_word(f->text, what)) return false;
    for (size_t i = 0; i < ARG_COUNT(names); ++i)
        if (obj_is(f->text->word, names[i])) return f->form = (obj_form)i, f->has_form = true;
    return obj_wrong_word(f->text, what);
}

static bool degrees(obj_free *f)
{
    size_t d[2] = {0, 0};
    if (!read_count(f, "a degree", EP_MAX_DEGREE, &d[0])) return false;
    if (!obj_at_end(f->text) && !read_count(f, "a degree", EP_MAX_DEGREE, &d[1])) return false;
    for (int i = 0; i < 2; ++i) f->degree[i] = (unsigned)d[i];
    return true;
}

static bool steps(obj_free *f)
{
    size_t *s = f->step;
    s[1] = 0;
    return read_count(f, "a step", INT32_MAX, &s[0]) &&
           (obj_at_end(f->text) || read_count(f, "a step", INT32_MAX, &s[1]));
}

/* u or v, as 0 or 1. */
bool obj_read_axis(obj_free *f, int *axis)
{
    if (!obj_next_word(f->text, "'u' or 'v'")) return false;
    *axis = obj_is(f->text->word, "v");
    return *axis || obj_is(f->text->word, "u") || obj_wrong_word(f->text, "'u' or 'v'");
}

static bool matrix(obj_free *f)
{
    int axis = 0;
    if (!obj_read_axis(f, &axis)) return false;
    f->matrix[axis].count = 0;
    while (!obj_at_end(f->text)) {
        double x = 0;
        if (!read_finite(f, "a number", &x) || !obj_add_numbers(f, &f->matrix[axis], &x, 1)) return false;
    }
    return true;
}

/* Where a statement may stand. */
typedef enum obj_role { ANYWHERE, OUTSIDE, BODY, SURFACE_BODY } obj_role;

static bool skip(obj_free *f)
{
    return obj_skip_statement(f->text);
}

static const struct obj_free_statement {
    const char *name;
    bool (*read)(obj_free *f);
    obj_role role;
} statements[] = {{"vp", vertex2, ANYWHERE},
                  {"cstype", form, OUTSIDE},
                  {"deg", degrees, OUTSIDE},
                  {"bmat", matrix, OUTSIDE},
                  {"step", steps, OUTSIDE},
                  {"curv", obj_open_curve, OUTSIDE},
                  {"curv2", obj_open_curve2, OUTSIDE},
                  {"surf", obj_open_surface, OUTSIDE},
                  {"parm", obj_parameters, BODY},
                  {"trim", obj_surface_trim, SURFACE_BODY},
                  {"hole", obj_surface_hole, SURFACE_BODY},
                  {"scrv", skip, BODY},
                  {"sp", skip, BODY},
                  {"end", obj_end, BODY}};

const obj_free_statement *obj_find_free(obj_word name)
{
    for (size_t i = 0; i < ARG_COUNT(statements); ++i)
        if (obj_is(name, statements[i].name)) return &statements[i];
    return NULL;
}

static bool stands_right(const obj_free *f, obj_role role)
{
    const obj_word name = f->text->statement;
    const bool inside = f->open != OBJ_NONE, fits = role != SURFACE_BODY || f->open != OBJ_CURVE2;
    if (role == ANYWHERE || (role == OUTSIDE ? !inside : inside && fits)) return true;
    const place at = obj_place(f->text, name.at); /* which takes a walk through the text */
    if (role == OUTSIDE) {
        report(at, "'%.*s' comes before the 'end' of the '%.*s' above", OBJ_SHOWN(name), OBJ_SHOWN(f->opened));
        return false;
    }
    if (!inside) report(at, "'%.*s' stands outside of a curve or surface", OBJ_SHOWN(name));
    else report(at, "'%.*s' stands in a curve, not in a surface", OBJ_SHOWN(name));
    return false;
}

bool obj_read_free(obj_free *f, const obj_free_statement *s)
{
    if (!stands_right(f, s->role)) return false;
    if (f->open == OBJ_CURVE && s->role >= BODY && s->read != obj_end) return skip(f);
    if (!s->read(f)) return false;
    if (obj_at_end(f->text)) return true;
    report(obj_place(f->text, f->text->at), "the line goes on after the last argument of '%s'", s->name);
    return false;
}

bool obj_free_is_complete(const obj_free *f)
{
    if (f->open) report(obj_place(f->text, f->opened.at), "the '%.*s' has no 'end'", OBJ_SHOWN(f->opened));
    return !f->open;
}

void obj_free_release(obj_free *f)
{
    obj_numbers *const all[] = {&f->vertices, &f->vertices2,     &f->matrix[0],    &f->matrix[1],
                                &f->points,   &f->parameters[0], &f->parameters[1]};
    for (size_t i = 0; i < ARG_COUNT(all); ++i) free(all[i]->at);
    obj_curves_free(&f->curves);
    loops_free(&f->trim);
}
