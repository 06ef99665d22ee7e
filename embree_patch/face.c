/* face.c - see face.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/face.h"

#include <float.h>
#include <string.h>

static double determinant(const double m[6])
{
    return m[0] * m[3] - m[1] * m[2];
}

bool ep_faces_reserve(ep_faces *f, size_t count)
{
    return ep_reserve((void **)&f->places, &f->place_capacity, f->place_count, count, sizeof *f->places) &&
           ep_reserve((void **)&f->faces, &f->capacity, f->count, count, sizeof *f->faces);
}

void ep_faces_add(ep_faces *f, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        f->faces[f->count] = (ep_face){f->place_count, 1};
        f->places[f->place_count++] = (ep_place){{1, 0, 0, 1, 0, 0}, 1, (uint32_t)f->count++};
    }
}

bool ep_faces_shrink(ep_faces *f)
{
    return ep_shrink((void **)&f->places, &f->place_capacity, f->place_count, sizeof *f->places) &&
           ep_shrink((void **)&f->faces, &f->capacity, f->count, sizeof *f->faces);
}

bool ep_faces_begin(ep_faces *f, size_t patches)
{
    if (ep_faces_exist(f)) return true;
    if (ep_faces_reserve(f, patches + 1)) {
        ep_faces_add(f, patches);
        return true;
    }
    ep_faces_free(f);
    return false;
}

static bool is_possible(const double map[6])
{
    const double det = determinant(map);
    bool finite = isfinite(1 / det) && isfinite(det);
    for (int k = 0; k < 6; ++k) finite = finite && fabs(map[k]) <= FLT_MAX;
    return finite;
}

const char *ep_faces_problem(const ep_faces *f, size_t patches, size_t first, size_t count,
                             const double (*transforms)[6])
{
    if (first > patches || count != patches - first) return "only the last patches can be joined";
    bool single = !ep_faces_exist(f) || count <= f->count;
    for (size_t i = 0; ep_faces_exist(f) && single && i < count; ++i)
        single = f->faces[f->count - count + i].first == first + i;
    if (!single) return "one of them belongs to another face";
    if (count && !transforms) return "no transforms";
    for (size_t i = 0; i < count; ++i)
        if (!is_possible(transforms[i])) return "a patch's transform is not finite or has no inverse";
    return NULL;
}

/* Rows as ep_face has them, or 0. */
static size_t find_columns(const ep_place *p, size_t count)
{
    size_t columns = 1;
    while (columns < count && p[columns].map[5] == p[0].map[5]) ++columns;
    if (count % columns) return 0;
    for (size_t i = 0; i < count; ++i) {
        const double *m = p[i].map, *left = i % columns ? p[i - 1].map : NULL,
                     *below = i < columns ? NULL : p[i - columns].map;
        if (m[1] != 0 || m[2] != 0 || !(m[0] > 0) || !(m[3] > 0)) return 0;
        if (left && !(left[4] < m[4] && left[5] == m[5] && left[3] == m[3])) return 0;
        if (below && !(below[5] < m[5] && below[4] == m[4] && below[0] == m[0])) return 0;
    }
    return columns;
}

bool ep_faces_join(ep_faces *f, size_t patches, size_t first, size_t count, const double (*transforms)[6])
{
    if (!ep_faces_begin(f, patches)) return false;
    if (!count) {
        if (!ep_faces_reserve(f, 1)) return false;
        f->faces[f->count++] = (ep_face){f->place_count, 0};
        return true;
    }
    f->count -= count - 1;
    for (size_t i = 0; i < count; ++i) {
        ep_place *p = &f->places[first + i];
        memcpy(p->map, transforms[i], sizeof p->map);
        p->scale = 1 / determinant(p->map);
        p->face = (uint32_t)f->count - 1;
    }
    f->faces[f->count - 1].columns = find_columns(&f->places[first], count);
    return true;
}

void ep_faces_patches(const ep_faces *f, uint32_t face, size_t *first, size_t *end)
{
    *first = face;
    *end = (size_t)face + 1;
    if (!ep_faces_exist(f)) return;
    *first = f->faces[face].first;
    *end = *end < f->count ? f->faces[face + 1].first : f->place_count;
}

/* The last of `count` places, `stride` apart, that begins no later than x; the first if none does. `axis`: 4 for u, 5
 * for v. */
static size_t last_before(const ep_place *p, size_t count, size_t stride, int axis, double x)
{
    size_t low = 0;
    for (size_t high = count; high - low > 1;) {
        const size_t middle = low + (high - low) / 2;
        if (p[middle * stride].map[axis] <= x) low = middle;
        else high = middle;
    }
    return low;
}

size_t ep_faces_at(const ep_faces *f, uint32_t face, double u, double v)
{
    size_t first, end;
    ep_faces_patches(f, face, &first, &end);
    const size_t columns = f->faces[face].columns;
    if (!columns) return SIZE_MAX;
    const size_t row = last_before(&f->places[first], (end - first) / columns, columns, 5, v);
    return first + row * columns + last_before(&f->places[first], columns, 1, 4, u);
}

void ep_place_inverse(const ep_place *p, double u, double v, double *s, double *t)
{
    const double *m = p->map, x = u - m[4], y = v - m[5];
    *s = (m[3] * x - m[2] * y) * p->scale;
    *t = (m[0] * y - m[1] * x) * p->scale;
}

bool ep_place_is_identity(const ep_place *p)
{
    static const double identity[6] = {1, 0, 0, 1, 0, 0};
    for (int k = 0; k < 6; ++k)
        if (p->map[k] != identity[k]) return false;
    return true;
}

void ep_place_invert(const ep_place *p, double map[6])
{
    const double *m = p->map;
    map[0] = m[3] * p->scale;
    map[1] = -m[1] * p->scale;
    map[2] = -m[2] * p->scale;
    map[3] = m[0] * p->scale;
    ep_place_inverse(p, 0, 0, &map[4], &map[5]);
}

static ep_vec3 sum(double a, ep_vec3 x, double b, ep_vec3 y)
{
    return ep_add(ep_scale(a, x), ep_scale(b, y));
}

/* The chain rule with s, t linear in u, v. */
void ep_place_derivatives(const ep_place *p, ep_frame *f)
{
    const double *m = p->map, su = m[3] * p->scale, sv = -m[2] * p->scale, tu = -m[1] * p->scale, tv = m[0] * p->scale;
    const ep_frame g = *f;
    const ep_vec3 us = sum(su, g.puu, tu, g.puv), ut = sum(su, g.puv, tu, g.pvv); /* of P_u by s and t */
    const ep_vec3 vs = sum(sv, g.puu, tv, g.puv), vt = sum(sv, g.puv, tv, g.pvv);
    f->pu = sum(su, g.pu, tu, g.pv);
    f->pv = sum(sv, g.pu, tv, g.pv);
    f->puu = sum(su, us, tu, ut);
    f->puv = sum(sv, us, tv, ut);
    f->pvv = sum(sv, vs, tv, vt);
}

size_t ep_faces_bytes(const ep_faces *f)
{
    return f->place_capacity * sizeof *f->places + f->capacity * sizeof *f->faces;
}

void ep_faces_free(ep_faces *f)
{
    ep_free(f->places);
    ep_free(f->faces);
    *f = (ep_faces){0};
}
