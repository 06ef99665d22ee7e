/* build.c - cuts patches into leaves.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A piece is split until its certificate (leaf.h) holds for all but nearly tangent rays and its prism is thin:
 * Stürzlinger's criterion, with the thickness taken relative to the piece, so that it means the same at any scale and
 * bounds how far the surface turns within a leaf. At a pole, cusp or fold the certificate never holds; there splitting
 * ends early, because a fold is a curve and the pieces along it double at each level, and subdivision along the ray
 * takes over. Rectangles are halved along the side that turns more, triangles are quartered. What the surface is
 * content with is cut further where its box is met too often for what is in it (visits.h), and along trim curves. */
#include "embree_patch/build.h"
#include "embree_patch/trimmed.h"
#include "embree_patch/visits.h"

#include <string.h>

/* How far the parametrisation of a leaf may be from affine. Nearly tangent rays stumble over it as they do over the
 * thickness: with 0.77 and a thickness of 0.115, 17 of 262,144 primary rays at the teapot end in subdivision. */
static const double max_distortion = 0.77;

/* Halvings after which a piece that folds or collapses within is left to subdivision along the ray; sooner one that few
 * rays meet; and one that is nothing but a line, all of whose parts are no better: a few make its boxes smaller. */
enum { FOLD_DEPTH = 12, SELDOM_DEPTH = 8, LINE_DEPTH = 4 };

/* Points that doubles keep apart by no more than some thousand units in their last place are no smooth surface: no part
 * of it would be any better. */
static bool is_noise(const ep_patch *p)
{
    const double far = fmax(fmax(fabs(p->centre[0]), fabs(p->centre[1])), fabs(p->centre[2]));
    return p->radius < 0x1p-40 * far;
}

/* What patches are cut by. */
typedef struct build_args {
    const ep_trim *const *trims;
    const EPBuildSettings *settings;
    double half_surface; /* of the box of all patches */
} build_args;

typedef struct piece_args {
    const ep_patch *patch;
    const ep_trim *trim;
    uint32_t index;
    const build_args *build;
    unsigned max_depth;
    ep_fit *fit; /* scratch */
} piece_args;

/* What decides within the leaf. */
static bool keep_part(const piece_args *a, const ep_domain *d, const ep_trim_part *part, uint32_t *trim, ep_list *l)
{
    ep_message unused;
    uint32_t node;
    const ep_trim_domain domain = ep_trimmed_domain(a->patch->kind, d);
    l->status = ep_trim_keep(a->trim, part, &domain, &l->crossed, &node, &unused);
    *trim = node + 1;
    return l->status == EP_OK;
}

/* What is to be done with a piece that the surface is content with: in a slender triangle the thickness, which is
 * relative to its width, says nothing any more. */
typedef enum stage { SURFACE, TRIM } stage;

static void build_piece(const piece_args *a, const ep_domain *d, const ep_trim_part *part, stage stage, unsigned depth,
                        ep_list *l);

/* The parts of a piece that the trim keeps something of. `part`: of the piece, NULL when it is inside. */
static void build_parts(const piece_args *a, const ep_domain *d, unsigned count, const ep_trim_part *part, stage stage,
                        unsigned depth, ep_list *l)
{
    for (unsigned k = 0; k < count && l->status == EP_OK; ++k) {
        if (!part) {
            build_piece(a, &d[k], NULL, stage, depth, l);
            continue;
        }
        ep_message unused;
        ep_trim_part own = {0};
        const ep_trim_domain domain = ep_trimmed_domain(a->patch->kind, &d[k]);
        l->status = ep_trim_cut(a->trim, part, &domain, &own, &unused);
        if (l->status == EP_OK && own.state != EP_TRIM_OUTSIDE)
            build_piece(a, &d[k], own.state == EP_TRIM_CROSSED ? &own : NULL, stage, depth, l);
        ep_trim_part_free(&own);
    }
}

static void build_piece(const piece_args *a, const ep_domain *d, const ep_trim_part *part, stage stage, unsigned depth,
                        ep_list *l)
{
    ep_fit *f = a->fit;
    const ep_kind_id kind = a->patch->kind;
    const EPBuildSettings *settings = a->build->settings;
    ep_leaf_fit(d, f);
    if (depth < a->max_depth) {
        const bool good = (f->thickness <= settings->thickness || stage == TRIM) && f->distortion <= max_distortion;
        const double visits = ep_visits(f, d, a->build->half_surface);
        const unsigned enough = f->line ? LINE_DEPTH : ep_is_seldom_met(visits) ? SELDOM_DEPTH : FOLD_DEPTH;
        const bool hopeless = stage == SURFACE && !(f->distortion < 1) && depth * ep_kinds[kind].halvings >= enough;
        const bool content = good || hopeless; /* the surface is */
        unsigned along = f->turn[1] > f->turn[0];
        ep_domain parts[EP_TRIMMED_PARTS];
        if (!content || ep_is_askew(f, visits, &along)) {
            const unsigned n = ep_kinds[kind].split(d, along, parts);
            build_parts(a, parts, n, part, stage, depth + 1, l);
            return;
        }
        if (part && ep_trimmed_wants_split(a->trim, part, kind, d, settings->trimSplit, visits)) {
            const unsigned n = ep_trimmed_split(a->trim, part, kind, d, settings->trimSplit, f->distortion, parts);
            build_parts(a, parts, n, part, hopeless ? SURFACE : TRIM, depth + 1, l);
            return;
        }
    }
    uint32_t trim = 0;
    if (part && !keep_part(a, d, part, &trim, l)) return;
    ep_leaf_certify(d, f);
    ep_list_add(l, f, d, a->index, trim, depth);
}

static void build_patch(const void *what, const ep_patch *p, uint32_t index, ep_fit *fit, ep_list *l)
{
    static const ep_domain whole = {0, 0, 1, 0, 0, 1};
    const build_args *b = what;
    const ep_trim *trim = b->trims[index];
    const unsigned most = b->settings->maxDepth;
    const piece_args a = {.patch = p,
                          .trim = trim,
                          .index = index,
                          .build = b,
                          .max_depth = is_noise(p) && most > LINE_DEPTH ? LINE_DEPTH : most,
                          .fit = fit};
    ep_leaf_begin(p, fit);
    build_parts(&a, &whole, 1, trim ? &trim->root : NULL, SURFACE, 0, l);
}

/* The surface is in the hull of the control points. */
static void box_of(const ep_patch *p, ep_box *box)
{
    const size_t count = ep_kinds[p->kind].point_count(p->degree_u, p->degree_v);
    ep_range hull[3];
    ep_hull(p->points, count, hull);
    for (int c = 0; c < 3; ++c) {
        box->lower[c] = ep_round_down(hull[c].lo);
        box->upper[c] = ep_round_up(hull[c].hi);
    }
}

/* Half the surface of the box of them all: h->bounds of ep_build_boxes, from before any leaf is made. */
static double half_surface_of(const ep_patch *patches, size_t count)
{
    float bounds[6] = EP_NO_BOUNDS;
    for (size_t i = 0; i < count; ++i) {
        ep_box box;
        box_of(&patches[i], &box);
        ep_include_box(bounds, &box);
    }
    return ep_half_surface(bounds);
}

EPStatus ep_build(ep_patch *patches, const ep_trim **trims, size_t count, const EPBuildSettings *settings,
                  ep_message *message, ep_hierarchy *out)
{
    const build_args what = {trims, settings, half_surface_of(patches, count)};
    const EPStatus status = ep_make_hierarchy(patches, count, settings, build_patch, &what, message, out);
    if (status != EP_OK) return status;
    out->patches = patches;
    out->trims = trims;
    out->patch_count = count;
    return EP_OK;
}

EPStatus ep_build_boxes(ep_patch *patches, const ep_trim **trims, size_t count, const EPBuildSettings *settings,
                        ep_message *message, ep_hierarchy *out)
{
    memset(out, 0, sizeof *out);
    out->boxes = ep_alloc(count, sizeof *out->boxes);
    if (!out->boxes) return ep_fail(message, EP_NO_MEMORY, "no memory for the boxes of %zu patches", count);
    for (size_t i = 0; i < count; ++i) {
        ep_patch_measure(&patches[i]);
        box_of(&patches[i], &out->boxes[i]);
    }
    out->patches = patches;
    out->trims = trims;
    out->patch_count = out->box_count = count;
    ep_finish_boxes(out, settings);
    return EP_OK;
}

EPStatus ep_build_one(const ep_hierarchy *boxes, uint32_t index, const EPBuildSettings *settings, ep_hierarchy *out,
                      double *error)
{
    const build_args what = {boxes->trims, settings, ep_half_surface(boxes->bounds)};
    ep_list list = {.status = EP_OK};
    ep_fit *fit = ep_alloc(1, sizeof *fit);
    memset(out, 0, sizeof *out);
    if (!fit) return EP_NO_MEMORY;
    build_patch(&what, &boxes->patches[index], index, fit, &list);
    ep_free(fit);
    const EPStatus status = ep_join(&list, 1, out);
    *error = list.error;
    ep_list_free(&list);
    if (status != EP_OK) {
        ep_hierarchy_free(out);
        return status;
    }
    out->patches = boxes->patches;
    out->trims = boxes->trims;
    ep_pad(out->boxes, out->box_count, boxes->padding);
    return EP_OK;
}
