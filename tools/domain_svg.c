/* domain_svg.c - see domain_svg.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * What is outside makes no leaves: the domain is drawn as outside, and the leaves over it. */
#include "tools/domain_svg.h"
#include "embree_patch/geometry.h"
#include "tools/files.h"
#include "tools/report.h"
#include "trim/svg.h"

static void draw_leaf(FILE *f, patch_kind kind, const float d[6], ep_trim_state state)
{
    const double u = d[0], v = d[1];
    if (kind == PATCH_TENSOR) {
        const double u1 = u + d[2], v1 = v + d[3];
        ep_svg_leaf(f, state, 4, (const ep_point2[]){{u, v}, {u1, v}, {u1, v1}, {u, v1}});
    } else {
        ep_svg_leaf(f, state, 3, (const ep_point2[]){{u, v}, {u + d[2], v + d[5]}, {u + d[4], v + d[3]}});
    }
}

static void draw(FILE *f, EPGeometry surface, const patch *p, uint32_t index)
{
    static const float whole[6] = {0, 0, 1, 1, 0, 0};
    const ep_hierarchy *h = &surface->hierarchy;
    ep_svg_begin(f, (const ep_point2){0, 0}, (const ep_point2){1, 1});
    draw_leaf(f, p->kind, whole, EP_TRIM_OUTSIDE);
    for (size_t i = 0; i < h->leaf_count; ++i)
        if (h->leaves[i].patch == index)
            draw_leaf(f, p->kind, h->leaves[i].domain, h->leaves[i].trim ? EP_TRIM_CROSSED : EP_TRIM_INSIDE);
    if (h->trims[index]) ep_svg_curves(f, h->trims[index]);
    ep_svg_end(f); /* closing the file finds what went wrong */
}

bool domain_svg_write(const world *w, size_t index, const char *path)
{
    const scene *s = w->scene;
    const size_t originals = scene_originals(s);
    size_t i = 0, patches = 0;
    while (i < originals && index - patches >= s->geometries[i].patch_count) patches += s->geometries[i++].patch_count;
    if (i == originals) {
        report_file(s->path, "there is no patch %zu; the scene has %zu", index, patches);
        return false;
    }
    output o;
    if (!output_open(&o, path)) return false;
    draw(o.file, w->geometries[i], &s->geometries[i].patches[index - patches], (uint32_t)(index - patches));
    return output_close(&o);
}
