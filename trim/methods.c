/* methods.c - see methods.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/methods.h"

#include <string.h>

const char *const ep_trim_method_name[EP_TRIM_METHODS] = {"cells", "strip trees", "clipping", "clipping left"};

struct ep_trim_tester {
    const ep_trim *trim;
    ep_region_view region;
    ep_trim_method method;
    ep_strip_tree **trees; /* of the contour at each node, or NULL */
};

static EPStatus make_trees(ep_trim_tester *t, ep_message *m)
{
    const size_t count = t->region.node_count;
    t->trees = ep_alloc(count, sizeof *t->trees);
    if (!t->trees) return ep_fail(m, EP_NO_MEMORY, "no memory for strip trees");
    memset(t->trees, 0, count * sizeof *t->trees);
    uint32_t first = 0;
    for (size_t i = 0; i < count; ++i) {
        const ep_region_node *n = &t->region.nodes[i];
        if (n->kind < EP_REGION_LOOPS) continue;
        uint32_t last = first;
        while (last < t->trim->piece_count && t->trim->pieces[last].curve < n->curves + n->curve_count) ++last;
        const EPStatus s = ep_strip_tree_new(t->trim, t->region.curves, first, last, &t->trees[i], m);
        if (s) return s;
        first = last;
    }
    return EP_OK;
}

EPStatus ep_trim_tester_new(const ep_region *region, const ep_trim *trim, ep_trim_method method,
                            ep_trim_tester **tester, ep_message *m)
{
    *tester = NULL;
    ep_trim_tester *t = ep_alloc(1, sizeof *t);
    if (!t) return ep_fail(m, EP_NO_MEMORY, "no memory for a trim tester");
    *t = (ep_trim_tester){.trim = trim, .method = method};
    EPStatus s = ep_region_look(region, &t->region, m);
    if (!s && method == EP_TRIM_STRIP_TREES) s = make_trees(t, m);
    if (s) ep_trim_tester_free(t);
    else *tester = t;
    return s;
}

void ep_trim_tester_free(ep_trim_tester *t)
{
    if (!t) return;
    for (size_t i = 0; t->trees && i < t->region.node_count; ++i) ep_strip_tree_free(t->trees[i]);
    ep_free(t->trees);
    ep_free(t);
}

static bool contour_has(const ep_trim_tester *t, uint32_t node, double u, double v)
{
    if (t->method == EP_TRIM_STRIP_TREES) return ep_strip_tree_crosses(t->trees[node], u, v);
    const ep_region_node *n = &t->region.nodes[node];
    const bool left_only = t->method == EP_TRIM_CLIPPING_LEFT;
    bool odd = false;
    for (uint32_t i = n->curves; i < n->curves + n->curve_count; ++i)
        odd ^= ep_clip_crosses(&t->region.curves[i], t->region.points + t->region.curves[i].first, left_only, u, v);
    return odd;
}

/* As the tree of operators says; what a child has decided is not asked of the others. */
static bool node_has(const ep_trim_tester *t, uint32_t node, double u, double v)
{
    const ep_region_node *n = &t->region.nodes[node];
    if (n->kind >= EP_REGION_LOOPS) return contour_has(t, node, u, v);
    const uint32_t first = node + 1;
    if (n->kind == EP_REGION_DIFFERENCE)
        return node_has(t, first, u, v) && !node_has(t, t->region.nodes[first].next, u, v);
    const bool settles = n->kind == EP_REGION_UNION;
    for (uint32_t child = first; child < n->next; child = t->region.nodes[child].next)
        if (node_has(t, child, u, v) == settles) return settles;
    return !settles;
}

bool ep_trim_tester_has_point(const ep_trim_tester *t, double u, double v)
{
    return t->method == EP_TRIM_CELLS ? ep_trim_has_point(t->trim, u, v) : node_has(t, 0, u, v);
}

size_t ep_trim_tester_bytes(const ep_trim_tester *t)
{
    size_t bytes = sizeof *t;
    if (t->method == EP_TRIM_CELLS) bytes += ep_trim_bytes(t->trim);
    for (size_t i = 0; t->trees && i < t->region.node_count; ++i)
        if (t->trees[i]) bytes += ep_strip_tree_bytes(t->trees[i]);
    return bytes;
}
