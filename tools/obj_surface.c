/* obj_surface.c - see obj_surface.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/obj_surface.h"
#include "tools/nurbs.h"
#include "tools/obj_element.h"

static bool piece(obj_free *f)
{
    double from = 0, to = 0;
    size_t curve = 0;
    if (!obj_read_parameter(f, &from)) return false;
    const char *at = f->text->word.at;
    return obj_read_parameter(f, &to) && obj_read_reference(f->text, "a curve", "curve", f->curves.count, &curve) &&
           obj_is_fine(f->text, at, obj_curves_piece(&f->curves, curve, from, to, &f->trim));
}

static bool begin_trim(obj_free *f)
{
    if (f->has_trim) return true;
    f->has_trim = true;
    return obj_is_fine(f->text, f->text->statement.at, loops_begin(&f->trim));
}

static bool loop(obj_free *f)
{
    const char *at = f->text->statement.at;
    if (!begin_trim(f) || !obj_is_fine(f->text, at, loops_begin_loop(&f->trim))) return false;
    do
        if (!piece(f)) return false;
    while (!obj_at_end(f->text));
    return obj_is_fine(f->text, at, loops_end_loop(&f->trim));
}

bool obj_surface_trim(obj_free *f)
{
    f->has_outer = true;
    return loop(f);
}

bool obj_surface_hole(obj_free *f)
{
    return loop(f);
}

/* Holes without an outer loop are in the whole surface. The loop around it keeps away from its border. */
static const char *add_outer(obj_free *f)
{
    double lo[2], hi[2];
    for (int i = 0; i < 2; ++i) {
        const double size = f->range[i][1] - f->range[i][0];
        lo[i] = f->range[i][0] - size, hi[i] = f->range[i][1] + size;
    }
    const double corners[4][2] = {{lo[0], lo[1]}, {hi[0], lo[1]}, {hi[0], hi[1]}, {lo[0], hi[1]}};
    const char *problem = loops_begin_loop(&f->trim);
    if (!problem) problem = loops_add_lines(&f->trim, 4, corners);
    return problem ? problem : loops_end_loop(&f->trim);
}

static const char *add(obj_free *f, const obj_net *n)
{
    EPRegion region = NULL;
    struct trim_shape *shape = NULL;
    const nurbs s = {{n->degree[0], n->degree[1]},
                     {n->count[0], n->count[1]},
                     {n->count[0] + n->degree[0] + 1, n->count[1] + n->degree[1] + 1},
                     {n->knots[0], n->knots[1]},
                     (const double(*)[4])n->points};
    const char *problem = f->has_trim && !f->has_outer ? add_outer(f) : NULL;
    if (!problem && f->has_trim) problem = loops_end(&f->trim, f->g, &region, &shape);
    if (!problem) problem = geometry_add_nurbs(f->g, f->surfaces, &s, region, shape);
    epReleaseRegion(region);
    return problem;
}

bool obj_surface_end(obj_free *f)
{
    obj_net n;
    if (!obj_element_net(f, &n)) return false;
    const char *problem = NULL;
    for (int i = 0; i < 2 && !problem; ++i) problem = obj_net_cut(&n, i, f->range[i][0], f->range[i][1]);
    if (!problem) problem = add(f, &n);
    obj_net_free(&n);
    ++f->surfaces;
    return obj_is_fine(f->text, f->opened.at, problem);
}
