/* obj_element.c - see obj_element.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/obj_element.h"
#include "tools/model.h"
#include "tools/obj_surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What control points mean must be known before they are read. */
static bool has_attributes(obj_free *f, int axes)
{
    const char *at = f->text->statement.at;
    if (!f->has_form) return obj_is_fine(f->text, at, "there is no 'cstype' above");
    for (int i = 0; i < axes; ++i) {
        const size_t order = f->degree[i] + 1;
        if (!f->degree[i])
            return obj_is_fine(f->text, at, i ? "there is no 'deg' with two degrees above" : "there is no 'deg' above");
        if (f->form == OBJ_CARDINAL && f->degree[i] != 3)
            return obj_is_fine(f->text, at, "cardinal splines have degree 3");
        if (f->form != OBJ_MATRIX) continue;
        if (!f->step[i]) return obj_is_fine(f->text, at, "there is no 'step' for a basis matrix above");
        if (f->matrix[i].count == order * order) continue;
        report(obj_place(f->text, at), "degree %u needs a 'bmat %c' of %zu numbers, not %zu", f->degree[i], "uv"[i],
               order * order, f -> matrix[i].count);
        return false;
    }
    return true;
}

static bool open_element(obj_free *f, obj_element e)
{
    f->open = e;
    f->opened = f->text->statement;
    f->points.count = f->parameters[0].count = f->parameters[1].count = 0;
    f->has_trim = f->has_outer = false;
    return true;
}

static bool add_point(obj_free *f, double p[4])
{
    if (!f->rational) p[3] = 1;
    return obj_is_fine(f->text, f->text->word.at, point_problem(p)) && obj_add_numbers(f, &f->points, p, 4);
}

bool obj_open_curve(obj_free *f)
{
    return open_element(f, OBJ_CURVE) && obj_skip_statement(f->text);
}

static bool curve2(obj_free *f)
{
    if (!has_attributes(f, 1)) return false;
    while (!obj_at_end(f->text)) {
        size_t i = 0;
        if (!obj_read_reference(f->text, "a parameter vertex", "parameter vertex", f->vertices2.count / 3, &i))
            return false;
        const double *p = f->vertices2.at + 3 * i;
        if (isnan(p[1])) return obj_is_fine(f->text, f->text->word.at, "the parameter vertex has no v");
        if (!add_point(f, (double[4]){p[0], p[1], 0, p[2]})) return false;
    }
    return true;
}

static bool surface(obj_free *f)
{
    if (!has_attributes(f, 2)) return false;
    for (int i = 0; i < 4; ++i)
        if (!obj_read_parameter(f, &f->range[i / 2][i % 2])) return false;
    while (!obj_at_end(f->text)) {
        size_t i = 0;
        double p[4];
        if (!obj_read_reference(f->text, "a control point", "vertex", f->vertices.count / 4, &i)) return false;
        memcpy(p, f->vertices.at + 4 * i, sizeof p);
        if (!add_point(f, p)) return false;
    }
    return true;
}

bool obj_open_curve2(obj_free *f)
{
    return open_element(f, OBJ_CURVE2) && curve2(f);
}

bool obj_open_surface(obj_free *f)
{
    return open_element(f, OBJ_SURFACE) && surface(f);
}

bool obj_parameters(obj_free *f)
{
    int axis = 0;
    if (!obj_read_axis(f, &axis)) return false;
    obj_numbers *to = &f->parameters[axis];
    if (to->count) return obj_is_fine(f->text, f->text->statement.at, "a second 'parm' in the same direction");
    while (!obj_at_end(f->text)) {
        double x = 0;
        if (!obj_read_parameter(f, &x) || !obj_add_numbers(f, to, &x, 1)) return false;
    }
    return true;
}

/* Do the points go with the parameters? */
static bool count_points(const obj_free *f, const obj_basis basis[2], obj_net *n)
{
    const int axes = f->open == OBJ_SURFACE ? 2 : 1;
    n->count[1] = 1;
    for (int i = 0; i < axes; ++i) {
        n->count[i] = obj_points_of(&basis[i], f->parameters[i].count);
        if (n->count[i]) continue;
        report(obj_place(f->text, f->opened.at), "%zu values of 'parm %c' are too few", f->parameters[i].count,
               "uv"[i]);
        return false;
    }
    const size_t have = f->points.count / 4;
    if (have / n->count[0] == n->count[1] && !(have % n->count[0])) return true;
    const place at = obj_place(f->text, f->opened.at);
    if (axes == 1) report(at, "these parameters go with %zu points, not %zu", n->count[0], have);
    else report(at, "these parameters go with %zu x %zu points, not %zu", n->count[0], n->count[1], have);
    return false;
}

static const char *fill_net(const obj_free *f, const obj_basis basis[2], obj_net *n)
{
    n->points = malloc(f->points.count * sizeof *f->points.at);
    if (!n->points) return "out of memory";
    memcpy(n->points, f->points.at, f->points.count * sizeof *f->points.at);
    const char *problem = NULL;
    for (int i = 0; i < (f->open == OBJ_SURFACE ? 2 : 1) && !problem; ++i)
        problem = obj_net_convert(n, i, &basis[i], f->parameters[i].at, f->parameters[i].count);
    return problem;
}

bool obj_element_net(obj_free *f, obj_net *n)
{
    obj_basis basis[2];
    *n = (obj_net){.rational = f->rational};
    for (int i = 0; i < 2; ++i) basis[i] = (obj_basis){f->form, f->degree[i], f->step[i], f->matrix[i].at};
    if (!count_points(f, basis, n)) return false;
    const char *problem = fill_net(f, basis, n);
    if (problem) obj_net_free(n);
    return obj_is_fine(f->text, f->opened.at, problem);
}

static bool end_curve2(obj_free *f)
{
    obj_net n;
    return obj_element_net(f, &n) && obj_is_fine(f->text, f->opened.at, obj_curves_add(&f->curves, &n));
}

bool obj_end(obj_free *f)
{
    const obj_element e = f->open;
    const bool done = e == OBJ_CURVE2 ? end_curve2(f) : e == OBJ_SURFACE ? obj_surface_end(f) : true;
    f->open = OBJ_NONE;
    return done;
}
