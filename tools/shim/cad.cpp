/* cad.cpp - OpenCASCADE behind cad.h; no exception leaves this file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/shim/cad.h"
#include "tools/shim/cad_widen.h"

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <IGESControl_Reader.hxx>
#include <Precision.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <ios>
#include <iterator>
#include <new>
#include <sstream>
#include <string>

namespace
{

using namespace cad;

thread_local char problem[240];

const char *say(const char *text)
{
    std::snprintf(problem, sizeof problem, "%s", text);
    for (char *c = problem; *c; ++c)
        if (*c == '\n') *c = ' ';
    return problem;
}

/* Runs `body`; NULL, or what it has thrown. */
template <class F> const char *guard(F &&body)
{
    try {
        body();
        return nullptr;
    } catch (const std::bad_alloc &) {
        return say("out of memory");
    } catch (const unusable &e) {
        return say(e.what());
    } catch (const Standard_Failure &e) {
        const char *text = e.GetMessageString();
        return say((std::string("OpenCASCADE: ") + (text && *text ? text : e.DynamicType()->Name())).c_str());
    } catch (const std::exception &e) {
        return say(e.what());
    }
}

std::string slurp(const char *path)
{
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
}

/* What is wrong with a text that the reader of `kind` does not take; `mark` stands in all files of that kind. */
unusable refusal(const std::string &text, const char *kind, const char *mark)
{
    if (text.find(mark) != std::string::npos) return unusable("the file is damaged");
    return unusable(std::string("this is no ") + kind + " file");
}

template <class reader> TopoDS_Shape transfer(reader &r)
{
    r.TransferRoots();
    return r.OneShape();
}

TopoDS_Shape read_step(const char *path)
{
    STEPControl_Reader r;
    if (r.ReadFile(path) != IFSelect_RetDone) throw refusal(slurp(path), "STEP", "ISO-10303-21");
    return transfer(r);
}

/* Is there a line of IGES's last section? The reader is content with less. */
bool is_complete_iges(const std::string &text)
{
    for (size_t at = 0, end; at < text.size(); at = end + 1) {
        end = std::min(text.find('\n', at), text.size());
        if (end - at > 72 && text[at + 72] == 'T') return true;
    }
    return false;
}

TopoDS_Shape read_iges(const char *path)
{
    IGESControl_Reader r;
    if (!is_complete_iges(slurp(path))) throw unusable("this is no IGES file, or it ends too early");
    if (r.ReadFile(path) != IFSelect_RetDone) throw unusable("the file is damaged");
    return transfer(r);
}

/* The reader goes on for ever where a file ends too early: the stream has to throw. */
TopoDS_Shape read_brep(const char *path)
{
    const std::string all = slurp(path);
    std::istringstream text(all + "\n\n"); /* whoever reads the last number looks at what is behind it */
    text.exceptions(std::ios::eofbit | std::ios::failbit | std::ios::badbit);
    TopoDS_Shape shape;
    try {
        BRepTools::Read(shape, text, BRep_Builder());
    } catch (const std::ios_base::failure &) {
        throw refusal(all, "BREP", "CASCADE Topology");
    }
    return shape;
}

TopoDS_Shape read_shape(const char *path, cad_format format)
{
    return format == CAD_STEP ? read_step(path) : format == CAD_IGES ? read_iges(path) : read_brep(path);
}

/* A face, and what it points to. */
struct converted {
    surface s;
    std::vector<std::vector<flat_curve>> loops;
    std::vector<point> points;
    std::vector<std::vector<cad_curve>> curves;
    std::vector<cad_loop> lists;
    cad_face face;
};

void move(net &n, const TopLoc_Location &by)
{
    if (by.IsIdentity()) return;
    const gp_Trsf t = by.Transformation();
    double m[12];
    for (int i = 0; i < 12; ++i) m[i] = t.Value(i % 3 + 1, i / 3 + 1);
    transform(n, m);
}

void convert_face(const TopoDS_Face &face, const face_map &faces, converted &c)
{
    TopLoc_Location at;
    const Handle(Geom_Surface) stored = BRep_Tool::Surface(face, at);
    if (stored.IsNull()) throw unusable("it has no surface");
    const Handle(Geom_Surface) base = untrimmed(stored);
    std::vector<loop> loops = take_loops(face, base, faces);
    widen(loops, base);
    range box[2];
    if (loops.empty()) stored->Bounds(box[0].low, box[0].high, box[1].low, box[1].high);
    else bound(loops, box);
    for (const range &r : box)
        if (Precision::IsInfinite(r.low) || Precision::IsInfinite(r.high)) throw unusable("it has no end");
    c.s = convert(base, box);
    move(c.s.patches, at);
    for (const loop &l : loops) {
        c.loops.emplace_back();
        for (const side &part : l) c.loops.back().push_back(convert(part.along, c.s));
    }
    if (c.loops.size() == 1 && is_border(c.loops[0], c.s)) c.loops.clear();
    for (auto &l : c.loops) join(l, c.s);
}

/* The same for C. */
void describe(converted &c)
{
    const net &n = c.s.patches;
    for (const point &p : n.points) c.points.push_back({p[0] / p[3], p[1] / p[3], p[2] / p[3], p[3]});
    for (const auto &l : c.loops) {
        c.curves.emplace_back();
        for (const flat_curve &f : l)
            c.curves.back().push_back({(unsigned)f.degree, f.points.size(), f.knots.size(), f.knots.data(),
                                       reinterpret_cast<const double(*)[3]>(f.points.data())});
    }
    for (const auto &l : c.curves) c.lists.push_back({l.size(), l.data()});
    c.face = {{(unsigned)n.degree[0], (unsigned)n.degree[1]},
              {n.count[0], n.count[1]},
              {n.knots[0].size(), n.knots[1].size()},
              {n.knots[0].data(), n.knots[1].data()},
              reinterpret_cast<const double(*)[4]>(c.points.data()),
              c.lists.size(),
              c.lists.data()};
}

} // namespace

const char *cad_read(const char *path, cad_format format, cad_taker take, void *user)
{
    std::vector<TopoDS_Face> faces;
    face_map of_edges;
    const char *failure = guard([&] {
        const TopoDS_Shape shape = read_shape(path, format);
        if (!shape.IsNull()) {
            TopExp::MapShapesAndAncestors(shape, TopAbs_EDGE, TopAbs_FACE, of_edges);
            for (TopExp_Explorer e(shape, TopAbs_FACE); e.More(); e.Next()) faces.push_back(TopoDS::Face(e.Current()));
        }
        if (faces.empty()) throw unusable("there are no faces in the file");
    });
    if (failure) return failure;
    bool more = true;
    for (size_t i = 0; i < faces.size() && more; ++i) {
        converted c;
        const char *why = guard([&] {
            convert_face(faces[i], of_edges, c);
            describe(c);
        });
        more = take(user, (uint32_t)i, (uint32_t)faces.size(), why ? nullptr : &c.face, why);
    }
    return nullptr;
}
