/* cage_irregular.cpp - see cage_irregular.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/shim/cage_irregular.h"

#include <algorithm>

using namespace OpenSubdiv;

namespace
{

bool is_smooth(const Far::TopologyLevel &level, Far::Index v)
{
    return !level.IsVertexBoundary(v) && !level.IsVertexNonManifold(v) && level.GetVertexSharpness(v) == 0 &&
           level.GetVertexRule(v) == Sdc::Crease::RULE_SMOOTH;
}

/* Beyond the edge from a to b, which is looked for among those of a. */
Far::Index other_face(const Far::TopologyLevel &level, Far::Index face, Far::Index a, Far::Index b)
{
    const Far::ConstIndexArray faces = level.GetEdgeFaces(level.FindEdge(a, b));
    return faces[0] == face ? faces[1] : faces[0];
}

/* Corner k of a face, counted from where vertex v is. */
Far::Index corner_of(const Far::TopologyLevel &level, Far::Index face, Far::Index v, int k)
{
    const Far::ConstIndexArray at = level.GetFaceVertices(face);
    return at[(at.FindIndex(v) + k) % 4];
}

bool is_regular(const Far::TopologyLevel &level, Far::Index v)
{
    return is_smooth(level, v) && level.GetVertexFaces(v).size() == 4;
}

} // namespace

bool cage_is_smooth(const Far::TopologyLevel &mesh)
{
    for (Far::Index f = 0; f < mesh.GetNumFaces(); ++f)
        if (mesh.IsFaceHole(f)) return false;
    for (Far::Index v = 0; v < mesh.GetNumVertices(); ++v)
        if (!is_smooth(mesh, v) &&
            !(mesh.IsVertexBoundary(v) && !mesh.IsVertexNonManifold(v) && mesh.GetVertexFaces(v).size() == 2 &&
              mesh.GetVertexSharpness(v) == 0 && mesh.GetVertexRule(v) == Sdc::Crease::RULE_CREASE))
            return false;
    return true;
}

bool cage_has_rings(const Far::TopologyLevel &level, Far::Index v)
{
    if (!is_smooth(level, v)) return false;
    for (const Far::Index face : level.GetVertexFaces(v)) {
        if (level.GetFaceVertices(face).size() != 4) return false;
        for (int k = 1; k <= 3; ++k)
            if (!is_regular(level, corner_of(level, face, v, k))) return false;
    }
    return true;
}

/* Down from the face of the cage to that of a patch. A quadrilateral's parts have the numbers of its corners. */
cage_irregular cage_find_irregular(const Far::TopologyRefiner &refiner, uint32_t face, uint32_t quad,
                                   const Far::PatchParam &param)
{
    cage_irregular at{0, (Far::Index)face, -1, -1};
    if (param.NonQuadRoot()) at.face = refiner.GetLevel(at.level++).GetFaceChildFaces(at.face)[(int)quad];
    for (int bit = param.GetDepth() - at.level - 1; bit >= 0; --bit, ++at.level) {
        const bool x = param.GetU() >> bit & 1, y = param.GetV() >> bit & 1;
        at.face = refiner.GetLevel(at.level).GetFaceChildFaces(at.face)[y ? (x ? 2 : 3) : x];
    }
    const Far::TopologyLevel &level = refiner.GetLevel(at.level);
    const Far::ConstIndexArray vertices = level.GetFaceVertices(at.face);
    for (int k = 0; k < 4; ++k) {
        if (level.GetVertexFaces(vertices[k]).size() == 4) continue;
        if (at.corner >= 0) return at.corner = -1, at;
        at.corner = k;
    }
    if (at.corner >= 0) at.centre = vertices[at.corner];
    return at;
}

std::vector<Far::Index> cage_gather(const Far::TopologyLevel &level, const cage_irregular &of,
                                    const double (*points)[3], cage_rings *r)
{
    std::vector<Far::Index> faces;
    const Far::Index centre = of.centre;
    const auto put = [&](Far::Index v, double to[3]) { std::copy(points[v], points[v] + 3, to); };
    put(centre, *r->centre);
    Far::Index face = of.face;
    for (size_t i = 0; i < r->n; ++i) {
        const Far::Index edge = corner_of(level, face, centre, 1), across = corner_of(level, face, centre, 2),
                         next = corner_of(level, face, centre, 3);
        const Far::Index right = other_face(level, face, edge, across), up = other_face(level, face, across, next);
        const Far::Index low = corner_of(level, right, across, 3); /* two steps along the edge, one across */
        const Far::Index far = other_face(level, right, across, low);
        auto *p = r->point[i];
        put(edge, p[0][0]);
        put(across, p[0][1]);
        put(corner_of(level, up, across, 1), p[0][2]);
        put(corner_of(level, right, across, 2), p[1][0]);
        put(low, p[1][1]);
        put(corner_of(level, far, across, 2), p[1][2]);
        faces.push_back(face);
        face = other_face(level, face, next, centre);
    }
    return faces;
}
