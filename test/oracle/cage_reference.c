/* cage_reference.c - see cage_reference.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/oracle/cage_reference.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static void *room(size_t count, size_t size)
{
    void *p = calloc(count + 1, size);
    if (p) return p;
    fputs("out of memory\n", stderr);
    abort();
}

static void add(double w, const double x[3], double to[3])
{
    for (int c = 0; c < 3; ++c) to[c] += w * x[c];
}

static void scale(double w, double x[3])
{
    for (int c = 0; c < 3; ++c) x[c] *= w;
}

static ref_mesh *mesh_new(const ref_mesh *like, size_t vertices, size_t faces, size_t corners)
{
    ref_mesh *m = room(1, sizeof *m);
    if (like) m->loop = like->loop, m->chaikin = like->chaikin, m->smooth_triangles = like->smooth_triangles;
    m->vertex_count = (unsigned)vertices;
    m->x = room(vertices, sizeof *m->x);
    m->sharpness = room(vertices, sizeof *m->sharpness);
    m->star_first = room(vertices + 1, sizeof *m->star_first);
    m->rays_first = room(vertices + 1, sizeof *m->rays_first);
    m->first = room(faces + 1, sizeof *m->first);
    m->cage_face = room(faces, sizeof *m->cage_face);
    m->hole = room(faces, sizeof *m->hole);
    m->vertex = room(corners, sizeof *m->vertex);
    m->face = room(corners, sizeof *m->face);
    m->edge = room(corners, sizeof *m->edge);
    m->place = room(corners, sizeof *m->place);
    m->star = room(corners, sizeof *m->star);
    m->edges = room(corners, sizeof *m->edges);
    m->rays = room(2 * corners, sizeof *m->rays);
    return m;
}

void ref_free(ref_mesh *m)
{
    if (!m) return;
    void *all[] = {m->x,      m->sharpness, m->star_first, m->rays_first, m->first, m->cage_face, m->hole,
                   m->vertex, m->face,      m->edge,       m->place,      m->star,  m->edges,     m->rays};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i) free(all[i]);
    free(m);
}

unsigned ref_next(const ref_mesh *m, unsigned corner)
{
    const unsigned f = m->face[corner];
    return corner + 1 < m->first[f + 1] ? corner + 1 : m->first[f];
}

unsigned ref_previous(const ref_mesh *m, unsigned corner)
{
    const unsigned f = m->face[corner];
    return (corner > m->first[f] ? corner : m->first[f + 1]) - 1;
}

static void begin_face(ref_mesh *m, unsigned cage_face, bool hole)
{
    m->cage_face[m->face_count] = cage_face;
    m->hole[m->face_count++] = hole;
    m->first[m->face_count] = m->corner_count;
}

static void add_corner(ref_mesh *m, unsigned vertex, double u, double v)
{
    const unsigned c = m->corner_count++;
    m->face[c] = m->face_count - 1;
    m->vertex[c] = vertex;
    m->place[c][0] = u, m->place[c][1] = v;
    m->first[m->face_count] = m->corner_count;
}

/* A corner, and the edge that begins there with the smaller of its vertices first. */
typedef struct half_edge {
    unsigned low, high, corner;
} half_edge;

static int by_vertices(const void *a, const void *b)
{
    const half_edge *p = a, *q = b;
    if (p->low != q->low) return p->low < q->low ? -1 : 1;
    if (p->high != q->high) return p->high < q->high ? -1 : 1;
    return p->corner < q->corner ? -1 : p->corner > q->corner;
}

static void find_edges(ref_mesh *m)
{
    half_edge *h = room(m->corner_count, sizeof *h);
    for (unsigned c = 0; c < m->corner_count; ++c) {
        const unsigned a = m->vertex[c], b = m->vertex[ref_next(m, c)];
        h[c] = a < b ? (half_edge){a, b, c} : (half_edge){b, a, c};
    }
    qsort(h, m->corner_count, sizeof *h, by_vertices);
    for (unsigned i = 0; i < m->corner_count; ++i) {
        const bool another = !i || h[i].low != h[i - 1].low || h[i].high != h[i - 1].high;
        if (another) m->edges[m->edge_count++] = (ref_edge){.vertex = {h[i].low, h[i].high}};
        ref_edge *e = &m->edges[m->edge_count - 1];
        if (e->face_count == 2) fputs("an edge of three faces\n", stderr), abort();
        e->corner[e->face_count++] = h[i].corner;
        m->edge[h[i].corner] = m->edge_count - 1;
    }
    free(h);
}

/* Lists, for each vertex, the items that have it; `first` has been zeroed. */
static void list(unsigned vertices, unsigned items, unsigned ends, unsigned (*vertex)(const ref_mesh *, unsigned),
                 const ref_mesh *m, unsigned *first, unsigned *to)
{
    for (unsigned i = 0; i < items * ends; ++i) ++first[vertex(m, i) + 1];
    for (unsigned v = 0; v < vertices; ++v) first[v + 1] += first[v];
    unsigned *at = room(vertices, sizeof *at);
    memcpy(at, first, vertices * sizeof *at);
    for (unsigned i = 0; i < items * ends; ++i) to[at[vertex(m, i)]++] = i / ends;
    free(at);
}

static unsigned vertex_of_corner(const ref_mesh *m, unsigned i)
{
    return m->vertex[i];
}

static unsigned vertex_of_end(const ref_mesh *m, unsigned i)
{
    return m->edges[i / 2].vertex[i % 2];
}

/* Once all faces are there. Borders are as sharp as can be. */
static void connect(ref_mesh *m)
{
    find_edges(m);
    list(m->vertex_count, m->corner_count, 1, vertex_of_corner, m, m->star_first, m->star);
    list(m->vertex_count, m->edge_count, 2, vertex_of_end, m, m->rays_first, m->rays);
    for (unsigned e = 0; e < m->edge_count; ++e)
        if (m->edges[e].face_count == 1) m->edges[e].sharpness = INFINITY;
}

static ref_edge *find_edge(const ref_mesh *m, unsigned a, unsigned b)
{
    for (unsigned i = m->rays_first[a]; i < m->rays_first[a + 1]; ++i) {
        ref_edge *e = &m->edges[m->rays[i]];
        if (e->vertex[0] == b || e->vertex[1] == b) return e;
    }
    fprintf(stderr, "no edge from %u to %u\n", a, b);
    abort();
}

unsigned ref_valence(const ref_mesh *m, unsigned vertex)
{
    return m->star_first[vertex + 1] - m->star_first[vertex];
}

/* Without a boundary, the faces at a border are holes, unless it was made sharp. */
static void open_border(ref_mesh *m, const ref_edge *e)
{
    for (int k = 0; k < 2; ++k)
        for (unsigned i = m->star_first[e->vertex[k]]; i < m->star_first[e->vertex[k] + 1]; ++i)
            m->hole[m->face[m->star[i]]] = true;
}

ref_mesh *ref_new(const ref_cage *c)
{
    static const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, triangle[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    ref_mesh *m = mesh_new(NULL, c->vertex_count, c->face_count, c->corner_count);
    m->loop = c->loop, m->chaikin = c->chaikin, m->smooth_triangles = c->smooth_triangles;
    memcpy(m->x, c->vertices, c->vertex_count * sizeof *m->x);
    for (unsigned f = 0, k = 0; f < c->face_count; ++f) {
        begin_face(m, f, false);
        for (unsigned i = 0; i < c->sizes[f]; ++i, ++k) {
            const double *at = c->loop ? triangle[i] : square[i % 4]; /* of another polygon it means nothing */
            add_corner(m, c->corners[k], at[0], at[1]);
        }
    }
    connect(m);
    for (unsigned i = 0; i < c->hole_count; ++i) m->hole[c->holes[i]] = true;
    bool *sharp = room(m->edge_count, sizeof *sharp);
    for (unsigned i = 0; i < c->crease_count; ++i) {
        ref_edge *e = find_edge(m, c->creases[i].vertex[0], c->creases[i].vertex[1]);
        sharp[e - m->edges] = c->creases[i].sharpness >= REF_SHARP;
        if (e->face_count == 2) e->sharpness = (double)c->creases[i].sharpness;
    }
    for (unsigned e = 0; e < m->edge_count; ++e)
        if (c->boundary == REF_NO_BOUNDARY && m->edges[e].face_count == 1 && !sharp[e]) open_border(m, &m->edges[e]);
    free(sharp);
    for (unsigned i = 0; i < c->sharp_count; ++i) m->sharpness[c->sharp[i].vertex[0]] = (double)c->sharp[i].sharpness;
    for (unsigned v = 0; v < m->vertex_count; ++v)
        if (c->boundary == REF_EDGE_AND_CORNER && ref_valence(m, v) == 1) m->sharpness[v] = INFINITY;
    return m;
}

static double lowered(double sharpness)
{
    return sharpness >= REF_SHARP ? sharpness : fmax(sharpness - 1, 0);
}

static bool ends(double sharpness)
{
    return sharpness > 0 && sharpness < REF_SHARP;
}

/* How sharp the half of an edge is that has one of its vertices. Chaikin's rule: a quarter of the mean of the others at
 * that vertex. */
static double half_sharpness(const ref_mesh *m, unsigned edge, unsigned vertex)
{
    const double s = m->edges[edge].sharpness;
    if (!m->chaikin || !ends(s)) return lowered(s);
    double sum = 0, others = 0;
    for (unsigned i = m->rays_first[vertex]; i < m->rays_first[vertex + 1]; ++i) {
        const double other = m->edges[m->rays[i]].sharpness;
        if (m->rays[i] != edge && ends(other)) sum += other, ++others;
    }
    return fmax((others > 0 ? 0.75 * s + 0.25 * sum / others : s) - 1, 0);
}

static void face_point(const ref_mesh *m, unsigned f, double p[3])
{
    const unsigned n = m->first[f + 1] - m->first[f];
    memset(p, 0, 3 * sizeof *p);
    for (unsigned c = m->first[f]; c < m->first[f + 1]; ++c) add(1.0 / n, m->x[m->vertex[c]], p);
}

static void smooth_edge_point(const ref_mesh *m, const ref_edge *e, double p[3])
{
    double triangles = 0, face[3];
    for (int k = 0; k < 2 && m->smooth_triangles; ++k) {
        const unsigned f = m->face[e->corner[k]];
        triangles += m->first[f + 1] - m->first[f] == 3;
    }
    /* 0.47 is OpenSubdiv's CATMARK_SMOOTH_TRI_EDGE_WEIGHT */
    const double faces = m->loop ? 0 : (triangles * 0.47 + (2 - triangles) * 0.25) / 2;
    memset(p, 0, 3 * sizeof *p);
    for (int k = 0; k < 2; ++k) {
        add(m->loop ? 3.0 / 8 : 0.5 - faces, m->x[e->vertex[k]], p);
        if (m->loop) {
            add(1.0 / 8, m->x[m->vertex[ref_previous(m, e->corner[k])]], p);
        } else {
            face_point(m, m->face[e->corner[k]], face);
            add(faces, face, p);
        }
    }
}

static void edge_point(const ref_mesh *m, unsigned edge, double p[3])
{
    const ref_edge *e = &m->edges[edge];
    const bool stays = half_sharpness(m, edge, e->vertex[0]) > 0 && half_sharpness(m, edge, e->vertex[1]) > 0;
    const double w = stays ? 1 : fmin(e->sharpness, 1);
    memset(p, 0, 3 * sizeof *p);
    if (w < 1) smooth_edge_point(m, e, p);
    scale(1 - w, p);
    for (int k = 0; k < 2; ++k) add(w / 2, m->x[e->vertex[k]], p);
}

static unsigned other_end(const ref_edge *e, unsigned vertex)
{
    return e->vertex[e->vertex[0] == vertex];
}

/* With the sharpness of this level, or of the next. */
static ref_rule rule_of(const ref_mesh *m, unsigned v, bool next)
{
    unsigned sharp = 0;
    for (unsigned i = m->rays_first[v]; i < m->rays_first[v + 1]; ++i) {
        const unsigned e = m->rays[i];
        sharp += (next ? half_sharpness(m, e, v) : m->edges[e].sharpness) > 0;
    }
    if (sharp > 2 || (next ? lowered(m->sharpness[v]) : m->sharpness[v]) > 0) return REF_CORNER;
    return sharp == 2 ? REF_CREASE : sharp == 1 ? REF_DART : REF_SMOOTH;
}

ref_rule ref_rule_of(const ref_mesh *m, unsigned vertex)
{
    return rule_of(m, vertex, false);
}

/* Loop's weight of each neighbour. */
static double loop_weight(unsigned n)
{
    const double c = 3.0 / 8 + cos(2 * pi / n) / 4;
    return (5.0 / 8 - c * c) / n;
}

static void smooth_vertex_point(const ref_mesh *m, unsigned v, double p[3])
{
    const unsigned n = ref_valence(m, v);
    const double w = loop_weight(n);
    memset(p, 0, 3 * sizeof *p);
    if (m->loop) {
        add(1 - n * w, m->x[v], p);
        for (unsigned i = m->rays_first[v]; i < m->rays_first[v + 1]; ++i)
            add(w, m->x[other_end(&m->edges[m->rays[i]], v)], p);
        return;
    }
    /* Q/n + 2R/n + (n-3)S/n: of the new points of faces, of the middles of edges, and of the vertex */
    double face[3];
    add((n - 3.0) / n, m->x[v], p);
    for (unsigned i = m->star_first[v]; i < m->star_first[v + 1]; ++i) {
        face_point(m, m->face[m->star[i]], face);
        add(1.0 / n / n, face, p);
    }
    for (unsigned i = m->rays_first[v]; i < m->rays_first[v + 1]; ++i) {
        add(1.0 / n / n, m->x[v], p);
        add(1.0 / n / n, m->x[other_end(&m->edges[m->rays[i]], v)], p);
    }
}

static void crease_point(const ref_mesh *m, unsigned v, bool next, double side, double p[3])
{
    memset(p, 0, 3 * sizeof *p);
    add(1 - 2 * side, m->x[v], p);
    for (unsigned i = m->rays_first[v]; i < m->rays_first[v + 1]; ++i) {
        const unsigned e = m->rays[i];
        if ((next ? half_sharpness(m, e, v) : m->edges[e].sharpness) > 0)
            add(side, m->x[other_end(&m->edges[e], v)], p);
    }
}

static void point_by_rule(const ref_mesh *m, unsigned v, bool next, double p[3])
{
    const ref_rule rule = rule_of(m, v, next);
    if (rule == REF_CORNER) memcpy(p, m->x[v], sizeof m->x[v]);
    else if (rule == REF_CREASE) crease_point(m, v, next, 1.0 / 8, p);
    else smooth_vertex_point(m, v, p);
}

static void vertex_point(const ref_mesh *m, unsigned v, double p[3])
{
    double sum = 0, count = 0, after[3];
    if (m->sharpness[v] > 0 && !(lowered(m->sharpness[v]) > 0)) sum += m->sharpness[v], ++count;
    for (unsigned i = m->rays_first[v]; i < m->rays_first[v + 1]; ++i) {
        const double s = m->edges[m->rays[i]].sharpness;
        if (s > 0 && !(half_sharpness(m, m->rays[i], v) > 0)) sum += s, ++count;
    }
    point_by_rule(m, v, false, p);
    if (rule_of(m, v, false) == rule_of(m, v, true)) return;
    const double w = fmin(sum / count, 1);
    point_by_rule(m, v, true, after);
    scale(w, p);
    add(1 - w, after, p);
}

static void middle(const ref_mesh *m, unsigned a, unsigned b, double p[2])
{
    for (int i = 0; i < 2; ++i) p[i] = (m->place[a][i] + m->place[b][i]) / 2;
}

/* One quadrilateral a corner. Those of a polygon that is none have places of their own. */
static void divide_polygon(const ref_mesh *m, unsigned f, ref_mesh *to)
{
    const unsigned n = m->first[f + 1] - m->first[f], edges = m->vertex_count, faces = edges + m->edge_count;
    for (unsigned k = 0; k < n; ++k) {
        const unsigned c = m->first[f] + k, before = ref_previous(m, c), opposite = ref_next(m, ref_next(m, c));
        double at[4][2];
        if (n == 4) {
            middle(m, c, c, at[0]);
            middle(m, c, ref_next(m, c), at[1]);
            middle(m, c, opposite, at[2]);
            middle(m, c, before, at[3]);
        } else {
            const double u = 2 * (k % 4) + 0.5, v = 2 * floor(k / 4) + 0.5;
            memcpy(at, (double[4][2]){{u, v}, {u + 1, v}, {u + 1, v + 1}, {u, v + 1}}, sizeof at);
        }
        begin_face(to, m->cage_face[f], m->hole[f]);
        add_corner(to, m->vertex[c], at[0][0], at[0][1]);
        add_corner(to, edges + m->edge[c], at[1][0], at[1][1]);
        add_corner(to, faces + f, at[2][0], at[2][1]);
        add_corner(to, edges + m->edge[before], at[3][0], at[3][1]);
    }
}

static void divide_triangle(const ref_mesh *m, unsigned f, ref_mesh *to)
{
    double at[3][2];
    const unsigned c = m->first[f], edges = m->vertex_count;
    for (unsigned k = 0; k < 3; ++k) middle(m, c + k, c + (k + 1) % 3, at[k]);
    for (unsigned k = 0; k < 3; ++k) {
        const unsigned before = (k + 2) % 3;
        begin_face(to, m->cage_face[f], m->hole[f]);
        add_corner(to, m->vertex[c + k], m->place[c + k][0], m->place[c + k][1]);
        add_corner(to, edges + m->edge[c + k], at[k][0], at[k][1]);
        add_corner(to, edges + m->edge[c + before], at[before][0], at[before][1]);
    }
    begin_face(to, m->cage_face[f], m->hole[f]);
    for (unsigned k = 0; k < 3; ++k) add_corner(to, edges + m->edge[c + k], at[k][0], at[k][1]);
}

/* Vertices keep their numbers; those of edges follow, then those of faces. */
ref_mesh *ref_refine(const ref_mesh *m)
{
    const unsigned vertices = m->vertex_count + m->edge_count + (m->loop ? 0 : m->face_count);
    const unsigned faces = m->loop ? 4 * m->face_count : m->corner_count;
    ref_mesh *to = mesh_new(m, vertices, faces, (m->loop ? 3 : 4) * faces);
    for (unsigned v = 0; v < m->vertex_count; ++v) vertex_point(m, v, to->x[v]);
    for (unsigned e = 0; e < m->edge_count; ++e) edge_point(m, e, to->x[m->vertex_count + e]);
    for (unsigned f = 0; f < m->face_count; ++f) {
        if (!m->loop) face_point(m, f, to->x[m->vertex_count + m->edge_count + f]);
        (m->loop ? divide_triangle : divide_polygon)(m, f, to);
    }
    connect(to);
    for (unsigned v = 0; v < m->vertex_count; ++v) to->sharpness[v] = lowered(m->sharpness[v]);
    for (unsigned e = 0; e < m->edge_count; ++e)
        for (int k = 0; k < 2; ++k) {
            const unsigned v = m->edges[e].vertex[k];
            find_edge(to, v, m->vertex_count + e)->sharpness = half_sharpness(m, e, v);
        }
    return to;
}

ref_mesh *ref_around(const ref_mesh *m, unsigned vertex)
{
    unsigned *number = room(m->vertex_count, sizeof *number), count = 0, faces = 0, corners = 0;
    bool *wanted = room(m->face_count, sizeof *wanted);
    for (unsigned i = m->star_first[vertex]; i < m->star_first[vertex + 1]; ++i) {
        const unsigned f = m->face[m->star[i]];
        for (unsigned c = m->first[f]; c < m->first[f + 1]; ++c)
            for (unsigned k = m->star_first[m->vertex[c]]; k < m->star_first[m->vertex[c] + 1]; ++k)
                wanted[m->face[m->star[k]]] = true;
    }
    number[vertex] = ++count;
    for (unsigned c = 0; c < m->corner_count; ++c) {
        if (!wanted[m->face[c]]) continue;
        if (!number[m->vertex[c]]) number[m->vertex[c]] = ++count;
        faces += c == m->first[m->face[c]], ++corners;
    }
    ref_mesh *to = mesh_new(m, count, faces, corners);
    for (unsigned f = 0; f < m->face_count; ++f) {
        if (!wanted[f]) continue;
        begin_face(to, m->cage_face[f], m->hole[f]);
        for (unsigned c = m->first[f]; c < m->first[f + 1]; ++c)
            add_corner(to, number[m->vertex[c]] - 1, m->place[c][0], m->place[c][1]);
    }
    connect(to);
    for (unsigned v = 0; v < m->vertex_count; ++v) {
        if (!number[v]) continue;
        memcpy(to->x[number[v] - 1], m->x[v], sizeof m->x[v]);
        to->sharpness[number[v] - 1] = m->sharpness[v];
    }
    for (unsigned c = 0; c < m->corner_count; ++c)
        if (wanted[m->face[c]]) {
            const ref_edge *e = &m->edges[m->edge[c]];
            ref_edge *copy = find_edge(to, number[e->vertex[0]] - 1, number[e->vertex[1]] - 1);
            if (copy->face_count == 2) copy->sharpness = e->sharpness;
        }
    free(number);
    free(wanted);
    return to;
}

ref_mesh *ref_zoom(ref_mesh *m)
{
    ref_mesh *finer = ref_refine(m), *part = ref_around(finer, 0);
    ref_free(finer);
    ref_free(m);
    return part;
}

/* Where there is no mask in print: by subdividing for as long as doubles tell a difference. */
static void limit_by_levels(const ref_mesh *m, unsigned v, double p[3])
{
    ref_mesh *ring = ref_around(m, v);
    for (int level = 0; level < 56; ++level) ring = ref_zoom(ring);
    memcpy(p, ring->x[0], sizeof ring->x[0]);
    ref_free(ring);
}

/* [Halstead, Kass, DeRose, "Efficient, fair interpolation using Catmull-Clark surfaces", 1993], and Loop's thesis. */
static void smooth_limit(const ref_mesh *m, unsigned v, double p[3])
{
    const unsigned n = ref_valence(m, v);
    const double loop = 1 / (3 / (8 * loop_weight(n)) + n), all = n * (n + 5.0);
    memset(p, 0, 3 * sizeof *p);
    add(m->loop ? 1 - n * loop : n * n / all, m->x[v], p);
    for (unsigned i = m->star_first[v]; i < m->star_first[v + 1]; ++i) {
        const unsigned next = ref_next(m, m->star[i]);
        add(m->loop ? loop : 4 / all, m->x[m->vertex[next]], p);
        if (!m->loop) add(1 / all, m->x[m->vertex[ref_next(m, next)]], p);
    }
}

void ref_limit(const ref_mesh *m, unsigned vertex, double p[3])
{
    switch (ref_rule_of(m, vertex)) {
    case REF_SMOOTH: smooth_limit(m, vertex, p); break;
    case REF_DART: limit_by_levels(m, vertex, p); break;
    case REF_CREASE: crease_point(m, vertex, false, 1.0 / 6, p); break;
    default: memcpy(p, m->x[vertex], sizeof m->x[vertex]);
    }
}

bool ref_tangent(const ref_mesh *m, unsigned corner, double t[3])
{
    const unsigned v = m->vertex[corner], n = ref_valence(m, v);
    if (ref_rule_of(m, v) != REF_SMOOTH) return false;
    const double a = 1 + cos(2 * pi / n) + cos(pi / n) * sqrt(2 * (9 + cos(2 * pi / n)));
    memset(t, 0, 3 * sizeof *t);
    for (unsigned i = 0; i < n; ++i) {
        const double c = cos(2 * pi * i / n), d = cos(2 * pi * (i + 1) / n);
        const unsigned next = ref_next(m, corner), before = ref_previous(m, corner);
        add(m->loop ? c / 3 : a * c / 12, m->x[m->vertex[next]], t);
        if (!m->loop) add((c + d) / 12, m->x[m->vertex[ref_next(m, next)]], t);
        /* the next face around the vertex is beyond the edge that ends here */
        const ref_edge *e = &m->edges[m->edge[before]];
        corner = e->corner[e->corner[0] == before];
    }
    return true;
}
