/* cage_osd.cpp - see cage_osd.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * OpenSubdiv refines the cage around extraordinary points and creases until what is left there is as small as the level
 * says. Everywhere else the limit surface is a bicubic B-spline, or, with Loop's scheme, a quartic box spline, patch by
 * patch; its Bézier points follow from its values at as many parameters. What is left is a Gregory patch with the
 * limit's points and tangents at its corners; a pair of its inner points is replaced by their mean, which keeps its
 * border. Inside a smooth surface of Catmull and Clark's, OpenSubdiv only isolates points from one another, and
 * cage_rings.h goes on. All of it is done in double, so that patches meet to the rounding of doubles. */
#include "tools/shim/cage_osd.h"
#include "tools/shim/cage_irregular.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/patchTable.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <utility>
#include <vector>

using namespace OpenSubdiv;

namespace
{

thread_local char problem[240], warning[240];

/* The first one, on a line. */
void keep(const char *message, char (&to)[240])
{
    if (to[0]) return;
    std::snprintf(to, sizeof to, "OpenSubdiv: %s", message);
    for (char *c = to; *c; ++c)
        if (*c == '\n') *c = ' ';
    for (size_t n = std::char_traits<char>::length(to); n && to[n - 1] == ' '; --n) to[n - 1] = 0;
}

void keep_error(Far::ErrorType, const char *message)
{
    keep(message, problem);
}

void keep_warning(const char *message)
{
    keep(message, warning);
}

/* A vertex, as OpenSubdiv's templates add it up. */
struct vertex {
    double x[3];
    void Clear(void * = nullptr) { x[0] = x[1] = x[2] = 0; }
    void AddWithWeight(const vertex &v, double w)
    {
        for (int c = 0; c < 3; ++c) x[c] += w * v.x[c];
    }
};

using refiner_ptr = std::unique_ptr<Far::TopologyRefiner>;
using table_ptr = std::unique_ptr<const Far::PatchTable>;

refiner_ptr make_refiner(const cage &c)
{
    std::vector<int> sizes(c.sizes, c.sizes + c.face_count), corners(c.corners, c.corners + c.corner_count);
    std::vector<int> edges, sharp, holes(c.holes, c.holes + c.hole_count);
    std::vector<float> edge_weights, sharp_weights;
    for (size_t i = 0; i < c.crease_count; ++i) {
        edges.push_back((int)c.creases[i].vertex[0]);
        edges.push_back((int)c.creases[i].vertex[1]);
        edge_weights.push_back(c.creases[i].sharpness);
    }
    for (size_t i = 0; i < c.sharp_count; ++i) {
        sharp.push_back((int)c.sharp[i].vertex);
        sharp_weights.push_back(c.sharp[i].sharpness);
    }
    Far::TopologyDescriptor d;
    d.numVertices = (int)c.vertex_count;
    d.numFaces = (int)c.face_count;
    d.numVertsPerFace = sizes.data();
    d.vertIndicesPerFace = corners.data();
    d.numCreases = (int)c.crease_count;
    d.creaseVertexIndexPairs = edges.data();
    d.creaseWeights = edge_weights.data();
    d.numCorners = (int)c.sharp_count;
    d.cornerVertexIndices = sharp.data();
    d.cornerWeights = sharp_weights.data();
    d.numHoles = (int)c.hole_count;
    d.holeIndices = holes.data();

    using factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    static const Sdc::Options::VtxBoundaryInterpolation boundary[] = {Sdc::Options::VTX_BOUNDARY_EDGE_ONLY,
                                                                      Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER,
                                                                      Sdc::Options::VTX_BOUNDARY_NONE};
    Sdc::Options o;
    o.SetVtxBoundaryInterpolation(boundary[c.boundary]);
    o.SetCreasingMethod(c.chaikin ? Sdc::Options::CREASE_CHAIKIN : Sdc::Options::CREASE_UNIFORM);
    o.SetTriangleSubdivision(c.smooth_triangles ? Sdc::Options::TRI_SUB_SMOOTH : Sdc::Options::TRI_SUB_CATMARK);
    factory::Options options(c.scheme == CAGE_LOOP ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK, o);
    options.validateFullTopology = true;
    return refiner_ptr(factory::Create(d, options));
}

/* What OpenSubdiv's numbering of parts has room for. */
constexpr int most_levels = 10;
/* After two levels every quadrilateral has one extraordinary corner at most. */
constexpr int apart = 2;

/* What is not smooth is for OpenSubdiv to isolate, and so is everything with Loop's scheme. Where all of it is smooth,
 * rings replace its irregular patches: bilinear ones cost least, for their points are those of vertices, and each point
 * of a Gregory patch takes a weight for every face around. */
table_ptr make_table(Far::TopologyRefiner &refiner, const cage &c)
{
    const int asked = c.level ? std::clamp((int)c.level, apart, most_levels) : most_levels;
    Far::PatchTableFactory::Options o(most_levels);
    o.useInfSharpPatch = true;
    o.generateLegacySharpCornerPatches = false;
    o.generateVaryingTables = false;
    o.generateVaryingLocalPoints = false;
    const bool rings = c.scheme == CAGE_CATMULL_CLARK && cage_is_smooth(refiner.GetLevel(0));
    o.SetEndCapType(rings ? Far::PatchTableFactory::Options::ENDCAP_BILINEAR_BASIS
                          : Far::PatchTableFactory::Options::ENDCAP_GREGORY_BASIS);
    o.SetPatchPrecision<double>();
    Far::TopologyRefiner::AdaptiveOptions adaptive = o.GetRefineAdaptiveOptions();
    adaptive.SetSecondaryLevel(rings ? apart : asked);
    refiner.RefineAdaptive(adaptive);
    return table_ptr(Far::PatchTableFactory::Create(refiner, o));
}

/* The vertices of all levels, and then the points that only Gregory patches have. */
std::vector<vertex> make_points(const cage &c, const Far::TopologyRefiner &refiner, const Far::PatchTable &table)
{
    const size_t refined = (size_t)refiner.GetNumVerticesTotal();
    std::vector<vertex> points(refined + (size_t)table.GetNumLocalPoints());
    for (size_t i = 0; i < c.vertex_count; ++i)
        for (int k = 0; k < 3; ++k) points[i].x[k] = c.vertices[i][k];
    Far::PrimvarRefinerReal<double> primvars(refiner);
    vertex *from = points.data();
    for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
        vertex *to = from + refiner.GetLevel(level - 1).GetNumVertices();
        primvars.Interpolate(level, from, to);
        from = to;
    }
    if (table.GetNumLocalPoints() > 0)
        table.GetLocalPointStencilTable<double>()->UpdateValues(points.data(), points.data() + refined);
    return points;
}

enum { MOST = 16 }; /* points of a patch, here and there */
using matrix = std::array<std::array<double, MOST>, MOST>;

/* The Bernstein polynomials of a bicubic patch (order of embree_patch.h), or a quartic triangle, at s, t. */
void bernstein(bool triangle, double s, double t, double b[MOST])
{
    static const double cubic[4] = {1, 3, 3, 1}, factorial[5] = {1, 1, 2, 6, 24};
    const double r = 1 - s - t;
    for (int j = 0, k = 0; j <= (triangle ? 4 : 3); ++j)
        for (int i = 0; i <= (triangle ? 4 - j : 3); ++i, ++k)
            b[k] = triangle ? 24 / (factorial[i] * factorial[j] * factorial[4 - i - j]) * std::pow(s, i) *
                                  std::pow(t, j) * std::pow(r, 4 - i - j)
                            : cubic[i] * std::pow(s, i) * std::pow(1 - s, 3 - i) * cubic[j] * std::pow(t, j) *
                                  std::pow(1 - t, 3 - j);
}

/* Solves a x = b for all columns of b, which become those of x. */
void solve(matrix &a, matrix &b, int n)
{
    for (int k = 0; k < n; ++k) {
        int best = k;
        for (int i = k + 1; i < n; ++i)
            if (std::fabs(a[i][k]) > std::fabs(a[best][k])) best = i;
        std::swap(a[k], a[best]);
        std::swap(b[k], b[best]);
        for (int i = 0; i < n; ++i) {
            if (i == k) continue;
            const double f = a[i][k] / a[k][k];
            for (int j = 0; j < MOST; ++j) a[i][j] -= f * a[k][j], b[i][j] -= f * b[k][j];
        }
    }
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < MOST; ++j) b[k][j] /= a[k][k];
}

/* From the points of a regular patch to its Bézier points; depends on which of its sides are borders. */
matrix bezier_weights(const Far::PatchTable &table, const Far::PatchTable::PatchHandle &handle,
                      const Far::PatchParam &param, bool triangle)
{
    matrix values{}, weights{};
    const int degree = triangle ? 4 : 3;
    int count = 0;
    for (int j = 0; j <= degree; ++j)
        for (int i = 0; i <= (triangle ? degree - j : degree); ++i, ++count) {
            double u = (double)i / degree, v = (double)j / degree;
            bernstein(triangle, u, v, values[count].data());
            if (triangle) param.UnnormalizeTriangle(u, v);
            else param.Unnormalize(u, v);
            table.EvaluateBasis(handle, u, v, weights[count].data());
        }
    solve(values, weights, count);
    return weights;
}

/* Where a Gregory patch's points are among the Bézier points; two mean their mean. */
const int gregory_quad[20] = {0, 1, 4, 5, 5, 3, 7, 2, 6, 6, 15, 14, 11, 10, 10, 12, 8, 13, 9, 9};
const int gregory_triangle[18] = {0, 1, 5, 6, 6, 4, 8, 3, 7, 7, 14, 12, 13, 10, 10, 2, 11, 9};

void take_gregory(const std::vector<vertex> &points, const Far::ConstIndexArray &at, cage_patch *p)
{
    const bool quad = at.size() == 20;
    int count[MOST] = {0};
    for (int k = 0; k < at.size(); ++k) {
        const int to = quad ? gregory_quad[k] : gregory_triangle[k];
        for (int c = 0; c < 3; ++c) {
            double &x = p->points[to][c];
            x = count[to] ? 0.5 * (x + points[(size_t)at[k]].x[c]) : points[(size_t)at[k]].x[c];
        }
        ++count[to];
    }
}

void take_regular(const std::vector<vertex> &points, const Far::ConstIndexArray &at, const matrix &weights, int count,
                  cage_patch *p)
{
    for (int k = 0; k < count; ++k)
        for (int c = 0; c < 3; ++c) {
            double sum = 0;
            for (int i = 0; i < at.size(); ++i) sum += weights[k][i] * points[(size_t)at[i]].x[c];
            p->points[k][c] = sum;
        }
}

void set_place(const Far::PatchParam &param, bool triangle, double place[6])
{
    double origin[2] = {0, 0}, s[2] = {1, 0}, t[2] = {0, 1};
    for (double *at : {origin, s, t}) {
        if (triangle) param.UnnormalizeTriangle(at[0], at[1]);
        else param.Unnormalize(at[0], at[1]);
    }
    const double m[6] = {s[0] - origin[0], s[1] - origin[1], t[0] - origin[0], t[1] - origin[1], origin[0], origin[1]};
    std::copy(m, m + 6, place);
}

using taker = bool (*)(void *, const cage_patch *);

/* A sector's patches on their way to a face. */
struct turning {
    const cage_patch *face; /* its place and numbers */
    int corner;             /* where the sector begins */
    taker take;
    void *user;
    bool *more; /* what `take` has returned last */
};

/* A sector begins at a corner of the face and goes counter-clockwise. */
bool turn(void *user, const cage_ring_patch *p)
{
    const turning *t = (const turning *)user;
    cage_patch to = *t->face;
    const double far_x = 1 - p->x - p->size, far_y = 1 - p->y - p->size;
    const double begin[4][2] = {{p->x, p->y}, {far_y, p->x}, {far_x, far_y}, {p->y, far_x}};
    for (int b = 0; b < 4; ++b)
        for (int a = 0; a < 4; ++a) {
            const int index[4][2] = {{a, b}, {3 - b, a}, {3 - a, 3 - b}, {b, 3 - a}};
            const int *at = index[t->corner];
            std::copy(p->points[4 * b + a], p->points[4 * b + a] + 3, to.points[4 * at[1] + at[0]]);
        }
    const double *m = t->face->place, *at = begin[t->corner];
    to.place[4] = m[4] + m[0] * at[0];
    to.place[5] = m[5] + m[3] * at[1];
    to.place[0] = m[0] * p->size;
    to.place[3] = m[3] * p->size;
    return *t->more = t->take(t->user, &to);
}

/* One patch of the table: `index` counts them all, `patch` those of its array. */
struct listed {
    int ptex, index, array, patch;
};

std::vector<listed> list(const Far::PatchTable &table)
{
    std::vector<listed> all;
    for (int a = 0; a < table.GetNumPatchArrays(); ++a)
        for (int p = 0; p < table.GetNumPatches(a); ++p)
            all.push_back({table.GetPatchParam(a, p).GetFaceId(), (int)all.size(), a, p});
    std::stable_sort(all.begin(), all.end(), [](const listed &x, const listed &y) { return x.ptex < y.ptex; });
    return all;
}

/* What is left in the middle is off the surface by an eighth of what it is off its tangent plane, or less (measured,
 * for valences of 3 to 64): with this, relative to the cage, by 1e-7, which is what floats tell apart. */
constexpr double flat = 0x1p-20;

/* Patches that are smaller than this, relative to coordinates, would be told apart by rounding: points that they share
 * are equal to doubles, which is to be nothing to their size. Floats have no closer points either. */
constexpr double tiny = 0x1p-21;

/* The cage's diagonal, and its largest coordinate. */
struct extent {
    double size = 0, far = 0;
};

extent extent_of(const cage &c)
{
    extent e;
    for (int k = 0; k < 3; ++k) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (size_t i = 0; i < c.vertex_count; ++i) {
            low = std::min(low, c.vertices[i][k]);
            high = std::max(high, c.vertices[i][k]);
        }
        e.size = std::hypot(e.size, high - low);
        e.far = std::max({e.far, std::fabs(low), std::fabs(high)});
    }
    return e;
}

/* A face at an extraordinary vertex; without rings, OpenSubdiv's patch is all there is. */
struct sector {
    std::shared_ptr<const cage_rings> rings;
    size_t index = 0;
};

/* The surface of a cage, patch by patch. */
class surface
{
  public:
    surface(const cage &c, const Far::TopologyRefiner &refiner, const Far::PatchTable &table)
        : c(c), refiner(refiner), table(table), points(make_points(c, refiner, table)), whole(extent_of(c))
    {
        for (int level = 0, first = 0; level <= refiner.GetMaxLevel(); ++level) {
            first_of_level.push_back(first);
            first += refiner.GetLevel(level).GetNumVertices();
        }
    }

    void give(taker take, void *user)
    {
        uint32_t face = 0, ptex = 0; /* the first quadrilateral of the face */
        for (const listed &l : list(table)) {
            const auto quads = [&](uint32_t f) { return triangle || c.sizes[f] == 4 ? 1u : c.sizes[f]; };
            while ((uint32_t)l.ptex >= ptex + quads(face)) ptex += quads(face++);
            cage_patch p{};
            p.face = face;
            p.quad = (uint32_t)l.ptex - ptex;
            set_place(table.GetPatchParam(l.array, l.patch), triangle, p.place);
            if (!give_patch(l, &p, take, user)) return;
        }
    }

  private:
    bool give_patch(const listed &l, cage_patch *p, taker take, void *user)
    {
        const Far::PatchParam param = table.GetPatchParam(l.array, l.patch);
        const Far::ConstIndexArray at = table.GetPatchVertices(l.array, l.patch);
        const Far::PatchDescriptor type = table.GetPatchArrayDescriptor(l.array);
        if (type.GetType() == Far::PatchDescriptor::GREGORY_BASIS || type.GetType() == Far::PatchDescriptor::QUADS) {
            const cage_irregular of = cage_find_irregular(refiner, p->face, p->quad, param);
            if (of.corner >= 0) {
                const sector s = take_sector(of, param.GetDepth());
                if (s.rings) return give_sector(s, of.corner, p, take, user);
            }
        }
        if (type.GetType() == Far::PatchDescriptor::GREGORY_BASIS ||
            type.GetType() == Far::PatchDescriptor::GREGORY_TRIANGLE) {
            take_gregory(points, at, p);
        } else {
            std::unique_ptr<matrix> &w = weights[param.GetBoundary() & 31];
            if (!w) {
                Far::PatchTable::PatchHandle handle;
                handle.arrayIndex = l.array;
                handle.patchIndex = l.index;
                handle.vertIndex = l.patch * type.GetNumControlVertices();
                w = std::make_unique<matrix>(bezier_weights(table, handle, param, triangle));
            }
            take_regular(points, at, *w, triangle ? 15 : 16, p);
        }
        return take(user, p);
    }

    /* The first face around a vertex makes the rings for all of them, and the last one leaves nothing of them. */
    sector take_sector(const cage_irregular &of, int depth)
    {
        const std::pair<int, Far::Index> at{of.level, of.face};
        if (!sectors.count(at)) make_sectors(of, depth);
        return sectors.extract(at).mapped();
    }

    void make_sectors(const cage_irregular &of, int depth)
    {
        const Far::TopologyLevel &level = refiner.GetLevel(of.level);
        const Far::ConstIndexArray around = level.GetVertexFaces(of.centre);
        if (!cage_has_rings(level, of.centre)) {
            for (const Far::Index face : around) sectors[{of.level, face}] = {};
            return;
        }
        const std::shared_ptr<cage_rings> r(new cage_rings{}, [](cage_rings *old) {
            cage_rings_free(old);
            delete old;
        });
        if (!cage_rings_begin(r.get(), (size_t)around.size())) throw std::bad_alloc();
        const vertex *first = &points[(size_t)first_of_level[(size_t)of.level]];
        const std::vector<Far::Index> faces = cage_gather(level, of, &first->x, r.get());
        if (!(c.level == CAGE_LEVEL_DEFAULT ? cage_rings_flatten(r.get(), flat * whole.size, tiny * whole.far)
                                            : cage_rings_subdivide(r.get(), std::max((int)c.level - depth, 0))))
            throw std::bad_alloc();
        for (size_t i = 0; i < faces.size(); ++i) sectors[{of.level, faces[i]}] = {r, i};
    }

    bool give_sector(const sector &s, int corner, const cage_patch *p, taker take, void *user)
    {
        bool more = true;
        turning to{p, corner, take, user, &more};
        cage_rings_cut(s.rings.get(), s.index, turn, &to);
        return more;
    }

    const cage &c;
    const Far::TopologyRefiner &refiner;
    const Far::PatchTable &table;
    const bool triangle = c.scheme == CAGE_LOOP;
    std::vector<vertex> points;
    std::vector<int> first_of_level;
    std::map<std::pair<int, Far::Index>, sector> sectors; /* by level and face: of vertices that are begun */
    std::array<std::unique_ptr<matrix>, 32> weights;      /* by the sides that are borders */
    const extent whole;
};

} // namespace

const char *cage_patches(const cage *c, bool (*take)(void *user, const cage_patch *p), void *user, const char **note)
{
    problem[0] = warning[0] = 0;
    *note = warning;
    Far::SetErrorCallback(keep_error);
    Far::SetWarningCallback(keep_warning);
    try {
        const refiner_ptr refiner = make_refiner(*c);
        if (!refiner) return problem[0] ? problem : "OpenSubdiv does not take this cage";
        const table_ptr table = make_table(*refiner, *c);
        if (!table) return problem[0] ? problem : "OpenSubdiv makes no patches of this cage";
        surface(*c, *refiner, *table).give(take, user);
    } catch (const std::bad_alloc &) {
        return "out of memory";
    } catch (const std::exception &e) {
        std::snprintf(problem, sizeof problem, "OpenSubdiv: %s", e.what());
        return problem;
    }
    return NULL;
}
