#!/usr/bin/env python3
"""The command line, from outside: what it accepts, what it refuses and how, and what a hit means.

SPDX-License-Identifier: Apache-2.0

usage: test_cli.py EPATCH [TEST...]    prints a line for each failed check, then `test_cli: N passed, M failed`

Each test runs in a folder and a process of its own, as many at once as there are processors.
"""
import contextlib
import io
import itertools
import json
import math
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import traceback
import xml.etree.ElementTree

EPATCH = os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else sys.exit(__doc__)
CAD = os.path.join(os.path.dirname(os.path.abspath(__file__)), "cad")
DATA = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "data")
MISS = 0xFFFFFFFF
passed = failed = 0


def check(ok, message):
    global passed, failed
    if ok:
        passed += 1
    else:
        failed += 1
        print("FAIL", message)
    return ok


class Run:
    """One call of the program in the current directory; `limits` is a list of (resource, value)."""

    def __init__(self, *args, stdin=b"", stdout=subprocess.PIPE, limits=()):
        def limit():
            for what, value in limits:
                resource.setrlimit(what, (value, value))

        self.args = [str(a) for a in args]
        before = set(os.listdir("."))
        p = subprocess.run([EPATCH, *self.args], input=stdin, stdout=stdout, stderr=subprocess.PIPE, timeout=120,
                           preexec_fn=limit if limits else None)
        self.status, self.out, self.err = p.returncode, p.stdout, p.stderr.decode(errors="replace")
        self.new_files = sorted(set(os.listdir(".")) - before)

    def __str__(self):
        return f"epatch {' '.join(self.args)} -> {self.status}, {self.err.strip()[:300]!r}"


def refuses(run, status, pattern):
    """The program said no: the right status, one line that matches, nothing left behind."""
    check(run.status == status, f"{run}: status is not {status}")
    line = run.err.rstrip("\n")
    one = run.err.endswith("\n") and "\n" not in line and line.startswith("epatch: ")
    check(one, f"{run}: not exactly one line 'epatch: ...'")
    check(re.search(pattern, line), f"{run}: the message does not match /{pattern}/")
    check(not run.new_files, f"{run}: left behind {run.new_files}")


def works(run):
    return check(run.status == 0 and not run.err, f"{run}: should have worked")


def write(name, data):
    with open(name, "wb" if isinstance(data, bytes) else "w") as f:
        f.write(data)
    return name


def scene(*geometry, **more):
    return json.dumps({"format": "embree_patch scene", "version": 1, "geometry": geometry, **more})


def pack_rays(rays):
    return b"".join(struct.pack("<8f", *r) for r in rays)


def down(x, y, z=10, length=1.0, far=math.inf):
    return (x, y, z, 0, 0, 0, -length, far)


def trace(scene_name, rays, *args):
    """Hits as tuples t, u, v, geomID, primID, Nx, Ny, Nz."""
    write("rays", pack_rays(rays))
    r = Run("trace", scene_name, "--rays", "rays", "--hits", "hits", *args)
    if not works(r):
        return []
    with open("hits", "rb") as f:
        data = f.read()
    size = 1 if "--occluded" in args else 32
    check(len(data) == size * len(rays), f"{r}: {len(data)} bytes of hits for {len(rays)} rays")
    return list(data) if size == 1 else list(struct.iter_unpack("<3f2I3f", data))


def close(a, b, tolerance=1e-4):
    return len(a) == len(b) and all(abs(x - y) <= tolerance * (1 + abs(y)) for x, y in zip(a, b))


def same_hit(hit, t, u, v, geom, prim, normal, what, tolerance=1e-4):
    check(hit and hit[3:5] == (geom, prim) and close(hit[:3], (t, u, v), tolerance) and
          close(hit[5:], normal, tolerance), f"{what}: {hit}")


# The saddle z = x y over the unit square: u = x, v = y, and Ng = (-v, -u, 1) everywhere.
SADDLE = {"name": "saddle", "type": "bezier", "degree": [1, 1],
          "patches": [[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]]]}
# The same as two quadratic triangles over the square's halves, with weights that change nothing.
TRIANGLE = {"name": "half", "type": "bezier_triangles", "degree": 2,
            "patches": [[[0, 0, 0, 3], [.5, 0, 0, 3], [1, 0, 0, 3], [0, .5, 0, 3], [.5, .5, .5, 3], [0, 1, 0, 3]]]}


def crowd(name):
    """Objects out of the way, of which there are too many for copies: all of that geometry are instances."""
    return [{"geometry": name, "transform": [1, 0, 0, 0, 1, 0, 0, 0, 1, 1000 + 2 * i, 0, 0]} for i in range(4097)]


def test_usage():
    for args, pattern in [
        ((), "no command"),
        (("trcae",), "'trcae'.*did you mean 'trace'"),
        (("nonsense-of-some-length",), "no command"),
        (("trace",), "SCENE is missing"),
        (("trace", "s", "t"), "'t' is too much"),
        (("trace", ""), "SCENE is empty"),
        (("trace", "s", "--hits", "h"), "--rays FILE is missing"),
        (("trace", "s", "--rays", "r"), "--hits FILE is missing"),
        (("trace", "s", "--rays"), "--rays needs a value"),
        (("trace", "s", "--rays="), "--rays is empty"),
        (("trace", "s", "--witdh", "4"), "'--witdh'.*did you mean '--width'"),
        (("trace", "s", "--frobnicate"), "unknown option '--frobnicate'"),
        (("trace", "s", "-x"), "unknown option '-x'"),
        (("trace", "s", "--width", "5"), "--width is '5', not one of 1.4.8.16"),
        (("trace", "s", "--coherent=yes"), "--coherent takes no value"),
        (("render", "s", "-o", "i.png", "--on-demand", "--as", "triangles:4"), "--on-demand is for exact patches"),
        (("trace", "s", "--threads", "-1"), "--threads is '-1'"),
        (("trace", "s", "--threads", "2x"), "--threads is '2x'"),
        (("trace", "s", "--threads", "99999999999999999999"), "--threads is"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "triangles:0"), "--as is"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "boxes"), "--as is 'boxes', not patches or triangles:N"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "patche"), "--as is"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "patchess"), "--as is"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "triangles"), "--as is"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "triangles:"), "--as is"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "triangles:-1"), "--as is"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "triangles:8x"), "--as is"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "triangles:8193"), "--as is"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--as", "triangles:99999999999999999999"), "--as is"),
        (("trace", "s", "--isa", "mmx"), "--isa is 'mmx'"),
        (("trace", "-", "--rays", "-", "--hits", "h"), "standard input"),
        (("trace", "s", "--rays", "r", "--hits", "-", "--stats", "-"), "standard output"),
        (("trace", "s", "--rays", "r", "--hits", "h", "--stats", "h"), "cannot both go to h"),
        (("render", "s", "-o", "x.png", "--stats", "x.png"), "cannot both go to x.png"),
        (("info",), "SCENE is missing"),
        (("info", "s", "--jsn"), "did you mean '--json'"),
        (("render",), "SCENE is missing"),
    ]:
        refuses(Run(*args), 2, pattern)


def test_help():
    for args in [("--help",), ("--version",)] + [(c, o) for c in ("render", "trace", "info", "bench")
                                                for o in ("--help", "--version")]:
        r = Run(*args)
        works(r)
        check(len(r.out) > 5, f"{r}: prints nothing")
    text = Run("trace", "--help").out.decode()
    for option in ("--rays", "--hits", "--width", "--coherent", "--occluded", "--as", "--threads", "--stats", "--isa",
                   "--on-demand"):
        check(option in text, f"trace --help does not tell of {option}")


def bad_scenes():
    def patched(old, new):
        text = scene(SADDLE)
        assert text.count(old) >= 1, old
        return text.replace(old, new, 1)

    yield "", r"the file is empty"
    yield "{", r":1:\d+: "
    yield '{\n "geometry": [\n  1,,\n ]\n}', r":3:\d+: "
    yield '{"version": 2\0, "geometry": []}', r":1:14: a zero byte"
    yield "[]", r":1:1: the scene is an array, not an object"
    yield "{}", r":1:1: the scene has no 'geometry'"
    yield '{"geometry": []} x', r":1:\d+: "
    yield '{"geometry": [], "geometry": []}', r":1:\d+: duplicate"
    yield '{"geometry": [],\n  "geometri": []}', r":2:3: a scene has no key 'geometri'; did you mean 'geometry'\?"
    yield '{"geometry": [], "ge\\u006fmetri": []}', r":1:18: a scene has no key 'geometri'"
    yield '{"geometry": [], "\u00fc": 1,\n "x": 2}', r":1:18: "
    yield '{"format": "obj", "geometry": []}', r":1:12: the format"
    yield '{"version": 2, "geometry": []}', r":1:13: .*version 1"
    yield '{"geometry": {}}', r":1:14: 'geometry' is an object, not an array"
    yield '{"geometry": [5]}', r":1:15: a geometry is a number, not an object"
    yield '{"geometry": [{"name": "x"}]}', r":1:15: a geometry has no 'type'"
    yield patched('"bezier"', '"bezzier"'), r":\d+: no type of geometry is called 'bezzier'; did you mean 'bezier'"
    yield patched('"name"', '"nam"'), r":\d+: .*no key 'nam'; did you mean 'name'"
    yield patched('"patches"', '"knots": [], "patches"'), r"no key 'knots'"
    yield patched("[1, 1]", "[1, 1, 1]"), r"'degree' has two numbers"
    yield patched("[1, 1]", "[1, 0]"), r"a degree is 0, not a whole number from 1 to 25"
    yield patched("[1, 1]", "[1, 26]"), r"a degree is 26"
    yield patched("[1, 1]", "[1.5, 1]"), r"a degree is 1.5"
    yield patched("[1, 1]", "[2, 1]"), r"a patch of this degree has 6 points, not 4"
    yield patched("[0, 0, 0], ", ""), r"has 4 points, not 3"
    yield patched("[0, 0, 0]", "[0, 0]"), r"a point has 3 or 4 numbers, not 2"
    yield patched("[0, 0, 0]", "[0, 0, 0, 1, 1]"), r"a point has 3 or 4 numbers, not 5"
    yield patched("[0, 0, 0]", '[0, "0", 0]'), r"a coordinate is a string, not a number"
    yield patched("[0, 0, 0]", "[0, NaN, 0]"), r":1:\d+: "
    yield patched("[0, 0, 0]", "[0, 1e999, 0]"), r":1:\d+: "
    yield patched("[0, 0, 0]", "[0, 1e300, 0]"), r":1:\d+: a coordinate is beyond 1e18"
    yield patched("[0, 0, 0]", "[0, 0, 0, 0]"), r":1:\d+: the weight is not positive"
    yield patched("[0, 0, 0]", "[0, 0, 0, -1]"), r":1:\d+: the weight is not positive"
    yield patched("[0, 0, 0]", "[0, 0, 0, 1e300]"), r":1:\d+: the weight is outside"
    for trim, message in (('{"circle": {"r": 1}}', "a circle has no key 'r'"), ("{}", "a region is nothing"),
                          ('{"circle": {}, "square": {}}', "a region is only one thing"),
                          ('{"union": {}}', "union is an object, not an array"),
                          ('{"difference": [{"circle": {}}]}', "a difference"),
                          ('{"polygon": {"segments": [{"line": [[0, 0]]}]}}', "a line needs at least two points"),
                          ('{"polygon": {"segments": [{"bezier": {"points": [[0, 0], [1, 1, 0]]}}]}}', "weight of point 2"),
                          ('{"polygon": {"segments": [{"bezier": {"points": [[0, 0], [1]]}}]}}', "a point has 2 or 3 numbers, not 1"),
                          ('{"polygon": {"segments": []}}', "a polygon needs at least one segment"),
                          ('{"loops": []}', "loops of nothing"), ('{"union": []}', "a union of nothing"),
                          ('{"loops": [{"circle": {}}]}', "a circle cannot be a part of loops"),
                          ('{"polygon": {"segments": [{"nurbs": {"degree": 1, "knots": [0, 2, 1, 3], "points": [[0, 0], [1, 1]]}}]}}',
                           "knot 3 is 1, below the one before it, 2"),
                          ('{"polygon": {"segments": [{"bspline": {"degree": 2, "knots": [0, 1], "points": [[0, 0], [1, 1]]}}]}}',
                           "a curve of degree 2 needs 3 points, not 2"),
                          ('{"union": [' * 300 + '{"circle": {}}' + "]}" * 300, "regions are nested more than 256 deep"),
                          ('{"circle": {}, "transform": [1, 0, 0]}', "a transform has 3 numbers, not 6")):
        yield patched('"name"', '"trim": %s, "name"' % trim), r":1:\d+: " + message
    yield scene({"type": "bezier", "degree": [1, 1]}), r"needs 'patches'"
    surface = {"type": "nurbs", "degree": [1, 1], "knots": [[0, 0, 1, 1], [0, 0, 2, 3, 3]], "points": [[i % 2, i // 2, 0] for i in range(6)]}
    for change, message in (({"degree": 1}, r"'degree' is .*not a list|'degree' .*"), ({"degree": [1, 26]}, "a degree is 26"),
                            ({"knots": [[0, 0, 1, 1]]}, "'knots' has two lists"),
                            ({"knots": [[0, 0, 1, 1], [0, 0, 3]]}, "a surface of degree 1 has at least 4 knots, not 3"),
                            ({"knots": [[0, 0, 1, 1], [0, 0, 2, 1, 3]]}, "in v: knot 4 is 1, below the one before it, 2"),
                            ({"knots": [[0, 0, 0, 1], [0, 0, 2, 3, 3]]}, "in u: "),
                            ({"points": surface["points"][:-1]}, "these knots go with 2 x 3 points, not 5"),
                            ({"points": surface["points"][:-1] + [[0, 0, 0, 0]]}, "the weight is not positive"),
                            ({"patches": []}, "patches")):
        yield scene({**surface, **change}), message
    for key in ("degree", "knots", "points"):
        yield scene({k: v for k, v in surface.items() if k != key}), f"needs '{key}'"
    yield scene({"type": "bezier", "patches": []}), r"needs 'degree'"
    yield scene({"type": "file"}), r"needs 'path'"
    yield scene({"type": "file", "path": "missing.bpt"}), r"missing\.bpt: cannot open"
    yield scene({"type": "file", "path": "missing.step"}), r"missing\.step: cannot open"
    yield scene({"type": "file", "path": "self.json"}), r"self\.json: "
    yield scene(SADDLE, objects=[{"geometry": "sadle"}]), r":1:\d+: no geometry is called 'sadle'"
    yield scene(SADDLE, SADDLE, objects=[{"geometry": "saddle"}]), r"several geometries are called 'saddle'"
    yield scene(SADDLE, objects=[{}]), r"an object has no 'geometry'"
    yield scene(SADDLE, objects=[{"geometry": "saddle", "colour": 1}]), r"no key 'colour'"
    yield scene(SADDLE, objects=[{"geometry": "saddle", "transform": [1] * 11}]), r"'transform' has 11 numbers, not 12"
    yield scene(SADDLE, objects=[{"geometry": "saddle", "transform": [1] * 12}]), r"cannot be inverted"
    far_away = [1, 0, 0, 0, 1, 0, 0, 0, 1, 1e30, 0, 0]
    yield scene(SADDLE, objects=[{"geometry": "saddle", "transform": far_away}]), r"object 0 reaches beyond 1e18"
    camera = {"eye": [0, 0, 1], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 30}
    yield scene(SADDLE, camera={**camera, "fov": 180}), r"fov"
    yield scene(SADDLE, camera={**camera, "eye": [0, 0, 0]}), r"the camera's eye is its target"
    yield scene(SADDLE, camera={**camera, "up": [0, 0, 2]}), r"up points along"
    yield scene(SADDLE, camera={"eye": [0, 0, 1]}), r"the camera has no 'target'"
    yield '{"geometry": ' + "[" * 100000, r":1:\d+: "
    yield '{"geometry": [], "camera": "\\ud800"}', r":1:\d+: "


def test_bad_scenes():
    for text, pattern in bad_scenes():
        write("bad.json", text)
        refuses(Run("info", "bad.json"), 1, pattern)
    r = Run("info", "bad.json")
    check("bad.json:" in r.err, f"{r}: does not name the file")
    refuses(Run("info", "-", stdin=b"{"), 1, r"<stdin>:1:\d+: ")

    # The place is exact: a point deep inside, after strings full of brackets.
    text = '{"geometry": [\n {"name": "]}\\"[", "type": "bezier", "degree": [1, 1],\n  "patches": [[[0,0,0],\n  [1,0], [0,1,0], [1,1,0]]]}]}'
    refuses(Run("info", write("bad.json", text)), 1, r"bad\.json:4:3: a point has")
    refuses(Run("info", write("line\nbreak.json", "{")), 1, r"line\?break\.json:1")


def bpt(patches, count=None):
    lines = [str(len(patches) if count is None else count)]
    for m, n, points in patches:
        lines.append(f"{m} {n}")
        lines += ["%g %g %g" % tuple(p) for p in points]
    return "\n".join(lines) + "\n"


def test_bad_models():
    good = bpt([(1, 1, SADDLE["patches"][0])])
    works(Run("info", write("good.bpt", good)))
    for length in range(len(good) - 2):
        if length and good[length - 1].isspace() or not length:
            refuses(Run("info", write("cut.bpt", good[:length])), 1, r"cut\.bpt:\d+:\d+: the file ends")
    for text, pattern in [
        (good + "0", r":7:1: the file goes on"),
        (good.replace("1 1", "0 1", 1), r":2:1: 0 is not a degree from 1 to 25"),
        (good.replace("1 1", "26 1", 1), r":2:1: 26 is not a degree"),
        (good.replace("1 1", "1.5 1", 1), r":2:1: 1.5 is not a degree"),
        (good.replace("1 0 0", "1 nan 0"), r":4:1: a coordinate is not finite"),
        (good.replace("1 0 0", "1 1e999 0"), r":4:1: a coordinate is not finite"),
        (good.replace("1 0 0", "1 x 0"), r":4:3: 'x' is not a coordinate"),
        ("-1\n", r":1:1: -1 is not the number of patches"),
        ("1e30\n", r":1:1: 1e\+30 is not the number of patches"),
        ("4000000000\n1 1\n", r":3:1: the file ends"),
        ("\x7fELF\x02\x01", r":1:1: "),
        (good + "\0", r":7:1: "),
    ]:
        refuses(Run("info", write("bad.bpt", text)), 1, r"bad\.bpt" + pattern)
    start = time.time()
    refuses(Run("info", write("bad.bpt", "1000000000\n" + "3 3\n")), 1, "the file ends")
    check(time.time() - start < 5, "a promise of a billion patches takes long")
    os.makedirs("models", exist_ok=True)
    write("models/good.bpt", good)
    works(Run("info", write("models/nested.json", scene({"type": "file", "path": "good.bpt"}))))
    write("models/good.bpt", good + "x")
    refuses(Run("info", "models/nested.json"), 1, r"models/good\.bpt:7:1: ")


# The unit cube, its vertices in the order of binary numbers: bit 0 is x, bit 1 is y, bit 2 is z.
CUBE = {"name": "cube", "type": "subdivision", "vertices": [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)],
        "faces": [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]], "level": 3}
TETRAHEDRON = {"name": "tetrahedron", "type": "subdivision", "scheme": "loop", "level": 3,
               "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
               "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]}


def obj(cage, *lines):
    """An OBJ file with the cage, then more lines."""
    vertices = ["v %g %g %g" % tuple(p) for p in cage["vertices"]]
    faces = ["f " + " ".join(str(v + 1) for v in face) for face in cage["faces"]]
    return "".join(line + "\n" for line in [*vertices, *faces, *lines])


def test_good_cages():
    """A cage in a scene and the same in an OBJ file, however written: the same bits."""
    def same(json_cage, text, what, **more):
        a = trace(write("cage.json", scene(json_cage)), rays)
        write("cage.obj", text)
        file = {"type": "file", "path": "cage.obj", "as": "subdivision", "level": 3, **more}
        b = trace(write("file.json", scene(file)), rays)
        check(a == b and {h[4] for h in a} > {MISS}, f"{what}: {a[:3]}, {b[:3]}")
        return a

    rays = [down(.1 * i + .03, .1 * j + .04) for i in range(-1, 11) for j in range(-1, 11)] + [
        (5, .3, .4, 0, -1, 0, 0, math.inf), (.3, .4, -5, 0, 0, 0, 1, math.inf)]
    plain = same(CUBE, obj(CUBE), "a cube")
    long = dict(CUBE, creases=[{"vertices": [4, 5, 7, 6, 4], "sharpness": 2.5}])
    edges = [[4, 5, 2.5], [5, 7, 2.5], [7, 6, 2.5], [6, 4, 2.5]]
    creased = same(long, obj(CUBE, "t crease 8/1/0 4 5 5 7 7 6 6 4 2.5"), "creases")
    same(dict(CUBE, creases=edges), obj(CUBE, *(f"t crease 2/1/0 {a} {b} {s}" for a, b, s in edges)), "single creases")
    each = [[4, 5, 1], [5, 7, 2], [7, 6, 3], [6, 4, 1e9]]
    same(dict(CUBE, creases=each), "t crease 8/4/0 4 5 5 7 7 6 6 4 1 2 3 inf\n" + obj(CUBE), "a sharpness each")
    cornered = same(dict(CUBE, corners=[[4, 10], [7, 1.5]]), obj(CUBE, "t corner 2/2/0 4 7 12 1.5"), "corners")
    holed = same(dict(CUBE, holes=[1]), obj(CUBE, "t hole 1/0/0 1"), "a hole")
    loop = same(TETRAHEDRON, obj(TETRAHEDRON), "Loop's scheme", scheme="loop")
    check(len({tuple(x) for x in (plain, creased, cornered, holed, loop)}) == 5, "tags change nothing")

    box = dict(CUBE, faces=CUBE["faces"][1:])      # with two faces around each vertex of the border
    roof = dict(CUBE, faces=CUBE["faces"][1::2])   # with one face around some; and nothing is left without the border
    for cage, first in ((box, 0), (roof, 1)):
        borders = [same(dict(cage, boundary=b), obj(cage, f"t interpolateboundary 1/0/0 {i}"), f"boundary {b}")
                   for i, b in enumerate(("none", "edge-and-corner", "edge-only")) if i >= first]
        check(borders[-1] != borders[0], "boundaries change nothing")
    same(box, obj(box), "the usual boundary")
    same(dict(box, boundary="none"), obj(box, "t interpolateboundary 1/0/0 1"), "both", boundary="none")

    odd = ("\ufeff# a cube\nmtllib x.mtl\n\no c # d\ng a b\ns off\nusemtl \\\n  red\nvn 0 0 1\nvt 0 0 \\\n 0\n" +
           obj(CUBE) + "l 1 2\np 3\nlod 2")
    for old, new in (("f 1 3 4 2", "f 1/1 3/1/1 4//1 2 # first"), ("f 5 6 8 7", "f -4 -3 \\\n\t-1/1 +7"),
                     ("v 1 1 1", " v\t1 1. 1e0 1 .5 .5 .5")):
        assert old in odd
        odd = odd.replace(old, new)
    same(CUBE, odd, "odd writing")
    same(CUBE, odd.replace("\n", "\r\n"), "CR LF")
    methods = [obj(CUBE, "t crease 4/2/0 4 5 5 7 1 3", f"t creasemethod 0/0/1 {m}") for m in ("normal", "chaikin")]
    hits = [trace(write("cage.obj", m), rays) for m in methods]
    check(hits[0] != hits[1], "t creasemethod changes nothing")
    triangles = dict(TETRAHEDRON, faces=[[0, 1, 3], [0, 3, 2]])
    tags = ("0/0/1 catmark", "1/0/0 0", "0/0/1 smooth", "1/0/0 1")
    hits = [trace(write("cage.obj", obj(triangles, "t smoothtriangles " + tag)), rays) for tag in tags]
    check(hits[0] == hits[1] != hits[2] == hits[3], "t smoothtriangles")

    write("cage.obj", obj(CUBE, "t vertexedit 1/1/2 0 1 add P", "t vertexedit 0/0/0", "t strange",
                          "t facevaryinginterpolateboundary 1/0/0 1", "$ a remark", "t crease 2/1/0 0 7 5"))
    r = Run("info", "cage.obj")
    check(r.status == 0 and r.err == "epatch: cage.obj: OpenSubdiv: Edge 0 specified to be sharp does not exist "
          "(0, 7); ignored\nepatch: cage.obj:19:1: '$' is not known and ignored\n"
          "epatch: cage.obj:15:3: 'vertexedit' is not known and ignored\n"
          "epatch: cage.obj:17:3: 'strange' is not known and ignored\n", f"{r}: what is ignored")


def test_bad_cages():
    def patched(old, new, cage=CUBE):
        text = scene(cage)
        assert text.count(old) >= 1, old
        return text.replace(old, new, 1)

    def extended(**more):
        return scene(dict(CUBE, **more))

    for text, pattern in [
        (scene({"type": "subdivision"}), r"a subdivision surface needs 'vertices'"),
        (scene({"type": "subdivision", "vertices": [[0, 0, 0]]}), r"a subdivision surface needs 'faces'"),
        (extended(vertices=[]), r"'vertices' is empty"),
        (extended(faces=[]), r"'faces' is empty"),
        (extended(faces=5), r"'faces' is a number, not an array"),
        (patched("[0, 0, 0]", "[0, 0]"), r"a vertex has 2 numbers, not 3"),
        (patched("[0, 0, 0]", "[0, 1e19, 0]"), r"a coordinate is beyond 1e18"),
        (patched("[0, 2, 3, 1]", "5"), r"a face is a number, not an array"),
        (patched("[0, 2, 3, 1]", "[0, 2, 8, 1]"), r"an index into vertices is 8, not a whole number from 0 to 7"),
        (patched("[0, 2, 3, 1]", "[0, 2, -1, 1]"), r"an index into vertices is -1"),
        (patched("[0, 2, 3, 1]", "[0, 2, 0.5, 1]"), r"an index into vertices is 0.5"),
        (patched("[0, 2, 3, 1]", "[0, 2, 0, 1]"), r"a face has the same vertex twice"),
        (patched("[0, 2, 3, 1]", "[0, 2]"), r"a face has less than three corners"),
        (patched("[0, 2, 1]", "[0, 2, 1, 3]", TETRAHEDRON), r"Loop's scheme takes triangles only"),
        (extended(creases=[5]), r"a crease is a number, not an array"),
        (extended(creases=[[0, 1]]), r"a crease is two vertices and a sharpness, not 2 numbers"),
        (extended(creases=[[0, 8, 1]]), r"an index into vertices is 8"),
        (extended(creases=[[1, 1, 1]]), r"an edge has the same vertex twice"),
        (extended(creases=[[0, 1, -1]]), r"a sharpness is negative"),
        (extended(creases=[[0, 1, "x"]]), r"a sharpness is a string, not a number"),
        (extended(creases=[{"vertices": [0, 1]}]), r"a crease has no 'sharpness'"),
        (extended(creases=[{"sharpness": 1}]), r"a crease has no 'vertices'"),
        (extended(creases=[{"vertices": [0], "sharpness": 1}]), r"a crease has at least two vertices, not 1"),
        (extended(creases=[{"vertices": [0, 1], "sharpnes": 1}]), r"a crease has no key 'sharpnes'; did you mean"),
        (extended(corners=[0]), r"a corner is a number, not an array"),
        (extended(corners=[[0, 1, 2]]), r"a corner is a vertex and a sharpness, not 3 numbers"),
        (extended(corners=[[8, 1]]), r"an index into vertices is 8"),
        (extended(corners=[[0, -1]]), r"a sharpness is negative"),
        (extended(holes=[6]), r"an index into faces is 6, not a whole number from 0 to 5"),
        (extended(scheme="lop"), r"'scheme' is 'lop'; did you mean 'loop'\?"),
        (extended(scheme=1), r"'scheme' is a number, not a string"),
        (extended(level=0), r"'level' is 0, not a whole number from 1 to 16"),
        (extended(level=17), r"'level' is 17, not"),
        (extended(level=1.5), r"'level' is 1.5, not"),
        (extended(boundary="sharp"), r"'boundary' is 'sharp', which is not known"),
        (extended(degree=3), r"a geometry of this type has no key 'degree'"),
        (extended(trim={"circle": {}}), r"a subdivision surface cannot be trimmed"),
    ]:
        refuses(Run("info", write("bad.json", text)), 1, r"bad\.json:1:\d+: " + pattern)
    # the place is exact
    text = scene(CUBE).replace("[0, 2, 3, 1]", "\n [0, 2,\n  9, 1]")
    refuses(Run("info", write("bad.json", text)), 1, r"bad\.json:3:3: an index into vertices is 9")

    write("good.obj", obj(CUBE))
    write("good.bpt", bpt([(1, 1, SADDLE["patches"][0])]))
    for geometry, pattern in [
        ({}, r"good\.obj:9:1: polygons are read as a cage only: add \"as\": \"subdivision\" to the geometry"),
        ({"as": "patches"}, r"bad\.json:1:\d+: 'as' is 'patches', which is not known"),
        ({"as": "subdivision", "level": 17}, r"bad\.json:1:\d+: 'level' is 17"),
        ({"as": "subdivision", "scheme": "loop"}, r"good\.obj:9:1: Loop's scheme takes triangles only"),
        ({"as": "subdivision", "trim": {"circle": {}}}, r"bad\.json:1:\d+: a subdivision surface cannot be trimmed"),
        ({"as": "subdivision", "path": "good.bpt"}, r"bad\.json:1:\d+: the file has no polygons"),
        ({"scheme": "loop"}, r"bad\.json:1:\d+: 'scheme' goes with \"as\": \"subdivision\""),
        ({"level": 3, "path": "good.bpt"}, r"bad\.json:1:\d+: 'level' goes with"),
        ({"boundary": "none"}, r"bad\.json:1:\d+: 'boundary' goes with"),
        ({"as": "subdivision", "faces": []}, r"bad\.json:1:\d+: a geometry of this type has no key 'faces'"),
    ]:
        refuses(Run("info", write("bad.json", scene({"type": "file", "path": "good.obj", **geometry}))), 1, pattern)


def test_bad_obj():
    square = {"vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "faces": [[0, 1, 2, 3]]}
    good = obj(square)
    works(Run("info", write("good.obj", good)))
    for text, pattern in [
        ("", r": there are no faces or surfaces in the file"),
        ("v 0 0 0\n", r": there are no faces or surfaces in the file"),
        ("v 0 0\n", r":1:6: the line ends before a coordinate"),
        ("v 0 0 \\\n\n0", r":2:1: the line ends before a coordinate"),
        ("v 0 0 # 0\n", r":1:10: the line ends before a coordinate"),
        ("v 0 0 0\n v 0 0x 0\n", r":2:6: '0x' is not a coordinate"),
        ("v 0 0 0 \u00fc\n", r":1:9: '\u00fc' is not a number"),
        ("# \u00fc\nv 0 \\\n\u00fc", r":3:1: '\u00fc' is not a coordinate"),
        ("v 0 nan 0\n", r":1:1: a coordinate is not finite"),
        ("v 0 1e999 0\n", r":1:1: a coordinate is not finite"),
        ("v 0 0 -2e18\n", r":1:1: a coordinate is beyond 1e18"),
        (good + "f 1 2 5\n", r":6:7: there is no vertex 5: 4 are defined above"),
        (good + "f 1 -5 2\n", r":6:5: there is no vertex -5: 4 are defined above"),
        (good + "f 0 1 2\n", r":6:3: there is no vertex 0: 4 are defined above"),
        ("f 1 2 3\n" + good, r":1:3: there is no vertex 1: 0 are defined above"),
        (good + "f 1 2 99999999999999999999\n", r":6:7: there is no vertex 99999999999999999999: 4"),
        (good + "f 1 2 -99999999999999999999/1\n", r":6:7: there is no vertex -99999999999999999999: 4"),
        (good + "f 1 2 x\n", r":6:7: 'x' is not a corner of a face"),
        (good + "f 1 2 /3\n", r":6:7: '/3' is not a corner of a face"),
        (good + "f 1 2 3/1/1/1\n", r":6:7: '3/1/1/1' is not a corner of a face"),
        (good + "f 1 2 3/x\n", r":6:7: '3/x' is not a corner of a face"),
        (good + "f 1 2 3.5\n", r":6:7: '3.5' is not a corner of a face"),
        (good + "f 1 2 -3\n", r":6:7: a face has the same vertex twice"),
        (good + "f 1 2\n", r":6:1: a face has less than three corners"),
        (good + "f\n", r":6:1: a face has less than three corners"),
        ("\x7fELF\x02\x01", r": there are no faces or surfaces in the file"),
        (good + "t\n", r":6:2: the line ends before the name of a tag"),
        (good + "t crease\n", r":6:9: the line ends before three counts of arguments, as in 2/1/0"),
        (good + "t crease 2/1\n", r":6:10: '2/1' is not three counts of arguments"),
        (good + "t crease 2/1/-1\n", r":6:10: '2/1/-1' is not three counts"),
        (good + "t crease 2/1/0/1\n", r":6:10: '2/1/0/1' is not three counts"),
        (good + "t crease 3/1/0 0 1 2 1\n", r":6:10: a crease has an odd number of vertices, 3"),
        (good + "t crease 4/3/0 0 1 1 2 1 1 1\n", r":6:10: a tag of this kind has 4/1/0 arguments, not 4/3/0"),
        (good + "t crease 2/1/0 0 1\n", r":6:19: the line ends before a sharpness"),
        (good + "t crease 2/1/0 0\n", r":6:17: the line ends before a vertex"),
        (good + "t crease 2/1/0 0 1 2 3\n", r":6:22: the line goes on after the arguments of the tag"),
        (good + "t crease 2/1/0 0 1.5 1\n", r":6:18: '1.5' is not a vertex"),
        (good + "t crease 2/1/0 0 4 1\n", r":6:18: there is no vertex 4; they count from 0 to 3"),
        ("# first\nt crease 2/1/0 0 -1 1\n" + good, r":2:18: there is no vertex -1; they count from 0 to 3"),
        (good + "t crease 2/1/0 2 2 1\n", r":6:18: an edge has the same vertex twice"),
        (good + "t crease 2/1/0 0 1 -1\n", r":6:20: a sharpness is negative"),
        (good + "t crease 2/1/0 0 1 nan\n", r":6:20: a sharpness is not a number"),
        (good + "t crease 2/1/0 0 1 x\n", r":6:20: 'x' is not a sharpness"),
        (good + "t corner 2/1/1 0 1 1 x\n", r":6:10: a tag of this kind has 2/1/0 arguments, not 2/1/1"),
        (good + "t corner 1/1/0 4 1\n", r":6:16: there is no vertex 4"),
        (good + "t corner 2/2/0 0 1 1 -2\n", r":6:22: a sharpness is negative"),
        (good + "t hole 1/0/0 1\n", r":6:14: there is no face 1; they count from 0 to 0"),
        (good + "t hole 1/1/0 0 1\n", r":6:8: a tag of this kind has 1/0/0 arguments, not 1/1/0"),
        (good + "t interpolateboundary 1/0/0 3\n", r":6:29: there is no boundary 3; they count from 0 to 2"),
        (good + "t interpolateboundary 2/0/0 0 0\n", r":6:23: a tag of this kind has 1/0/0 arguments"),
        (good + "t creasemethod 0/0/1 odd\n", r":6:22: 'odd' is not 'normal' or 'chaikin'"),
        (good + "t smoothtriangles 0/0/1 odd\n", r":6:25: 'odd' is not 'catmark' or 'smooth'"),
        (good + "t smoothtriangles 1/0/0 7\n", r":6:25: '7' is not '0' or '1'"),
        (good + "\0", r":6:1: a zero byte in a text file"),
    ]:
        refuses(Run("info", write("bad.obj", text.encode())), 1, r"bad\.obj" + pattern)
    for word in ("bzp", "bsp", "cdc", "cdp", "res"):
        refuses(Run("info", write("bad.obj", f"# x\n {word} 1 2\n" + good)), 1,
                rf"bad\.obj:2:2: '{word}' is of version 2 of the format and not read")
    start = time.time()
    refuses(Run("info", write("bad.obj", good + "t hole 4000000000/0/0 0 0\n")), 1, r":6:26: the line ends")
    check(time.time() - start < 5, "a promise of many holes takes long")
    refuses(Run("info", write("bad.obj", f"{good}f {' '.join(map(str, range(1, 5)))} {'1 ' * 70000}\n")), 1,
            "a face has the same vertex twice")
    many = "".join(f"v {i} 0 0\n" for i in range(65536)) + "f " + " ".join(str(i + 1) for i in range(65536))
    refuses(Run("info", write("bad.obj", many)), 1, r":65537:1: a face has more than 65535 corners")
    refuses(Run("info", "missing.obj"), 1, r"missing\.obj: cannot open")


def basis(form, degree, parameters, x, matrix=None, step=1):
    """The functions of a free-form curve's points at x: one value a point."""
    if form == "bspline":
        spans = range(len(parameters) - 1)
        n = [float(parameters[i] <= x < parameters[i + 1]) for i in spans]
        for d in range(1, degree + 1):
            def part(value, at, low, high):
                return value * (at - low) / (high - low) if value else 0
            n = [part(n[i], x, parameters[i], parameters[i + d]) +
                 part(n[i + 1], -x, -parameters[i + d + 1], -parameters[i + 1]) for i in range(len(n) - 1)]
        return n
    k = max(i for i in range(len(parameters) - 1) if parameters[i] <= x)
    t = (x - parameters[k]) / (parameters[k + 1] - parameters[k])
    if form == "bezier":
        step, n = degree, [math.comb(degree, i) * t**i * (1 - t)**(degree - i) for i in range(degree + 1)]
    elif form == "cardinal":
        n = [(-t + 2 * t**2 - t**3) / 2, (2 - 5 * t**2 + 3 * t**3) / 2, (t + 4 * t**2 - 3 * t**3) / 2,
             (t**3 - t**2) / 2]
    elif form == "taylor":
        step, n = degree + 1, [t**i for i in range(degree + 1)]
    else:
        n = [sum(c * t**j for j, c in enumerate(matrix[i])) for i in range(degree + 1)]
    return [0] * (k * step) + n + [0] * ((len(parameters) - 2 - k) * step)


def free_form(form, degrees, parameters, points, span=None, rational=False, more=()):
    """An OBJ file of one surface; `points` has a weight each, `span` is s0, s1, t0, t1."""
    span = span or [parameters[0][0], parameters[0][-1], parameters[1][0], parameters[1][-1]]

    def numbers(values):
        return " ".join(map(repr, values))
    return "\n".join([*("v " + numbers(p if rational else p[:3]) for p in points),
                      f"cstype {'rat ' * rational}{form}", "deg " + numbers(degrees), *more,
                      "surf " + numbers(span) + " " + numbers(range(1, len(points) + 1)),
                      "parm u " + numbers(parameters[0]), "parm v " + numbers(parameters[1]), "end", ""])


def free_place(bases, points, rational, u, v):
    """A point of the surface; bases: of u and v, without the parameter's value."""
    nu, nv = (basis(*b[:3], x, *b[3:]) for b, x in zip(bases, (u, v)))
    weights = [a * b * (p[3] if rational else 1) for (a, b), p in zip([(a, b) for b in nv for a in nu], points)]
    sums = [sum(w * p[c] for w, p in zip(weights, points)) for c in range(3)]
    return [x / sum(weights) for x in sums] if rational else sums


def across(bases, points, rational, u, v, h=1e-5):
    """A short ray that meets the surface at u, v and t = 0.05, and the surface's normal there."""
    def place(du, dv):
        return free_place(bases, points, rational, u + du, v + dv)
    pu, pv = ([(a - b) / (2 * h) for a, b in zip(place(*d), place(*(-x for x in d)))] for d in ((h, 0), (0, h)))
    n = [pu[i - 2] * pv[i - 1] - pu[i - 1] * pv[i - 2] for i in range(3)]
    d = [x / math.hypot(*n) for x in n]
    return (*(x - .05 * y for x, y in zip(place(0, 0), d)), 0, *d, .1), n


def test_free_form_surfaces():
    """Each kind of surface, against the format's formulas."""
    hermite = [[1, 0, -3, 2], [0, 0, 3, -2], [0, 1, -2, 1], [0, 0, -1, 1]]
    uniform = [[1 / 6, -.5, .5, -1 / 6], [4 / 6, 0, -1, .5], [1 / 6, .5, .5, -.5], [0, 0, 0, 1 / 6]]
    matrices = ["bmat u " + " ".join(repr(x) for row in hermite for x in row),
                "bmat v " + " \\\n ".join(repr(x) for row in uniform for x in row), "step 2 1"]
    one = [0, 1, 2.5]
    knots = [-1, -1, -.5, 0, 1, 1, 2, 3, 3.5]
    surfaces = [  # bases, lines more, u and v that are tested
        ([("bezier", 3, one), ("bezier", 2, [-1, 1])], (), [.3, 1.1, 2.4], [-.7, .6]),
        ([("bspline", 2, knots), ("bspline", 3, [0, 0, 0, 0, 1, 1, 1, 1])], (), [-.2, .5, 1.5], [.2, .9]),
        ([("cardinal", 3, one), ("cardinal", 3, [0, 2, 3, 3.5])], (), [.3, 2.4], [1.5, 2.1, 3.2]),
        ([("taylor", 2, one), ("taylor", 3, [0, .5])], (), [.4, 1.2, 2.4], [.1, .4]),
        ([("bmatrix", 3, one, hermite, 2), ("bmatrix", 3, one, uniform, 1)], matrices, [.3, 1.7], [.4, 2.2]),
        ([("bezier", 25, [0, 1]), ("bezier", 1, [0, 1])], (), [.3, .7], [.4]),
    ]
    for bases, more, us, vs in surfaces:
        counts = [len(basis(*b[:3], x[0], *b[3:])) for b, x in zip(bases, (us, vs))]
        for rational in (False, True):
            points = [(i + .1 * math.sin(3 * i + j), j + .1 * math.cos(i - j), .3 * math.sin(2 * i * j + i),
                       1 + .3 * math.sin(5 * i + 2 * j)) for j in range(counts[1]) for i in range(counts[0])]
            text = free_form(bases[0][0], [b[1] for b in bases], [b[2] for b in bases], points,
                             [us[0] - .05, us[-1] + .05, vs[0] - .05, vs[-1] + .05], rational, more)
            at = [(u, v) for u in us for v in vs]
            rays = [across(bases, points, rational, u, v) for u, v in at]
            hits = trace(write("free.obj", text), [r for r, n in rays])
            for (u, v), (r, n), hit in zip(at, rays, hits):
                same_hit(hit, .05, u, v, 0, 0, n, f"{'rat ' * rational}{bases[0][0]} at {u}, {v}", 1e-3)


def test_free_form_parts():
    """Several surfaces in a file, parts of surfaces, weights, and what stands between the lines."""
    line = [0, 0, 1, 2, 2]
    plane = [(x, y, 0, 1) for y in (0, 1) for x in (0, 1, 2)]
    text = free_form("bspline", [1, 1], [line, [0, 0, 1, 1]], plane, [.25, 1.5, .5, 1])
    hits = trace(write("part.obj", text), [down(x, y) for y in (.2, .45, .55, .9) for x in (.2, .3, .9, 1.45, 1.55)])
    for i, hit in enumerate(hits):
        x, y = (.2, .3, .9, 1.45, 1.55)[i % 5], (.2, .45, .55, .9)[i // 5]
        if .25 < x < 1.5 and y > .5:
            same_hit(hit, 10, x, y, 0, 0, (0, 0, 1), f"a part at {x}, {y}")
        else:
            check(hit[4] == MISS, f"a part has {x}, {y}: {hit}")

    arc = [(1, z, 0, 1) for z in (0, 2)], [(1, z, 1, .5**.5) for z in (0, 2)], [(0, z, 1, 1) for z in (0, 2)]
    quarter = [row[j] for j in range(2) for row in arc]
    text = free_form("bezier", [2, 1], [[0, 1], [0, 1]], quarter, rational=True)
    hits = trace(write("arc.obj", text), [(0, .6, 0, 0, math.cos(a), 0, math.sin(a), math.inf) for a in (.2, .7, 1.3)])
    check(all(close([h[0], h[2]], [1, .3]) for h in hits), f"a quarter of a cylinder: {hits}")
    check("v 1 0 1 0.7071067811865476" in text, "the weight is written otherwise")
    text = text.replace("rat ", "").replace("v 1 0 1 0.7071067811865476", "v 1 0 1 -3")
    works(Run("info", write("arc.obj", text)))  # where they mean nothing, weights may be anything

    square = ("v 0 0 {0}\nv 1 0 {0}\nv 0 1 {0}\nv 1 1 {0}\nsurf 0 1 0 1 -4/1/1 -3//2 -2/7 -1\nparm v 0 1\n"
              "parm u 0 1\nend\n")
    text = ("cstype bezier\ndeg 1 1 # plane\nmg 1 .5\nctech curv 1 2\nstech curv 1 2\nusemtl x\n" + square.format(0) +
            "g b\nvp 3\nvp 1 2\n" + "curv 0 1 1 2 \\\n 77\nparm u x\nend\n" +
            "con 1 0 1 1 2 0 1 1\n" + square.format(1).replace("end", "sp 1 2\nscrv 0 1 7\nend"))
    hits = trace(write("two.obj", text), [down(.3, .6), (.3, .6, -1, 0, 0, 0, 1, 9)])
    for hit, t, prim in zip(hits, (9, 1), (1, 0)):
        same_hit(hit, t, .3, .6, 0, prim, (0, 0, 1), "two surfaces")

    polygons = text.replace("g b", "f 1 2 4 3\nf 1 2 3")
    write("mixed.obj", polygons)
    for command in (["info"], ["trace", "--rays", "rays", "--hits", "hits"]):
        r = Run(command[0], "mixed.obj", *command[1:])
        check(r.status == 0 and r.err == "epatch: mixed.obj:15:1: free-form surfaces are read; the polygons beside "
              "them are ignored\n", f"{r}: surfaces beside polygons")
    with open("hits", "rb") as f:
        check([h[4] for h in struct.iter_unpack("<3f2I3f", f.read())] == [1, 0], "surfaces beside polygons")
    polygons = polygons.replace("f 1 2 3\n", "")
    write("mixed.obj", polygons)
    for geometry, line in (({}, "15:1: free-form surfaces are read; the polygons beside them are ignored"),
                           ({"as": "subdivision"},
                            "11:1: polygons are read; the free-form surfaces beside them are ignored")):
        r = Run("info", write("s.json", scene({"type": "file", "path": "mixed.obj", **geometry})))
        check(r.status == 0 and r.err == f"epatch: mixed.obj:{line}\n", f"{r}: {geometry}")
    r = Run("info", write("s.json", scene({"type": "file", "path": "two.obj", "as": "subdivision"})))
    refuses(r, 1, r"two\.obj: there are no faces in the file")


def test_free_form_trims():
    """Loops of pieces of curves, forwards and backwards, against formulas."""
    circle = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
    lines = ["cstype bezier", "deg 1", "vp -2 -2", "vp 2 -2", "vp 2 2", "vp -2 2", "curv2 1 2 3 4", "parm u 0 1 2 3",
             "end", "curv2 1 4", "parm u 5 6", "end", "cstype rat bspline", "deg 2",
             *(f"vp {1.5 * x} {1.5 * y} {1 if i % 2 == 0 else .5**.5!r}" for i, (x, y) in enumerate(circle)),
             "curv2 5 6 7 8 9 10 11 12 5", "parm u 0 0 0 1 1 2 2 3 3 4 4 4", "end",
             "vp 0 0", "cstype taylor", "deg 2", "vp -.5 -.5", "vp 1 0", "vp 0 1", "curv2 -3 -2 -1", "parm u 0 1",
             "end", *(f"v {x} {y} 0" for y in (-3, 3) for x in (-3, 3)), "cstype bezier", "deg 1 1"]

    def inside_square(x, y):
        return abs(x) < 2 and abs(y) < 2

    def inside_circle(x, y):
        return x * x + y * y < 2.25

    def left(x, y):  # of the chord from parameter 3, at (0, -1.5), to 0.5, at 45 degrees
        a, b = (0, -1.5), (1.5 * .5**.5, 1.5 * .5**.5)
        return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) > 0

    cases = [
        (["trim 0 3 1 6 5 2"], inside_square),
        (["trim 3 0 1 5 6 2"], inside_square),
        (["trim 0 1 1 1 2 1 2 2.5 1 2.5 3 1 6 5 -3"], inside_square),
        (["trim 0 3 1"], inside_square),  # closed by a straight line
        (["hole 4 0 3"], lambda x, y: not inside_circle(x, y)),
        (["trim 0 3 1", "hole 0 4 3"], lambda x, y: inside_square(x, y) and not inside_circle(x, y)),
        (["hole 0 4 3", "trim 0 3 1"], lambda x, y: inside_square(x, y) and not inside_circle(x, y)),
        (["trim 0 2 3"], lambda x, y: inside_circle(x, y) and y > 0),
        (["trim 3 .5 3"], lambda x, y: inside_circle(x, y) and left(x, y)),
        (["trim 0 1 4"], lambda x, y: -.5 < x < .5 and -.5 + (x + .5)**2 < y < x),
        (["hole 1 0 4"], lambda x, y: not (-.5 < x < .5 and -.5 + (x + .5)**2 < y < x)),
    ]

    at = [(-2.9 + .283 * i, -2.8 + .271 * j) for i in range(21) for j in range(21)]
    for loops, inside in cases:
        text = "\n".join([*lines, "surf -3 3 -3 3 1 2 3 4", "parm u -3 3", "parm v -3 3", *loops, "end", ""])
        hits = trace(write("trim.obj", text), [down(x, y) for x, y in at])
        wrong = [(p, h) for p, h in zip(at, hits) if (h[4] == 0) != bool(inside(*p))]
        check(not wrong, f"{loops}: {len(wrong)} points, {wrong[:2]}")
    for i, loops in enumerate((["hole 4 .5 3"], ["trim 0 3 1 6 5 2", "hole 0 4 3", "trim 0 1 4"])):
        text = "\n".join([*lines, "v 3 3 1", "surf -3 3 -3 3 1 2 3 5", "parm u -3 3", "parm v -3 3", *loops, "end", ""])
        works(Run("verify", write("trim.obj", text), "--rays", 2000, stdout=subprocess.DEVNULL))


def test_bad_free_form():
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"
    attributes = corners + "cstype bezier\ndeg 1 1\n"
    surface, ends = "surf 0 1 0 1 1 2 3 4\n", "parm u 0 1\nparm v 0 1\nend\n"
    good = attributes + surface + ends
    works(Run("info", write("good.obj", good)))
    curve = attributes + "vp 0 0\nvp 1 0\nvp 1 1\ncurv2 1 2 3\nparm u 0 1 2\nend\n"  # 12 lines
    works(Run("info", write("good.obj", curve + surface + "trim 0 2 1\n" + ends)))
    cubic = "".join(f"v {i} 0 0\n" for i in range(16)) + "cstype bspline\ndeg 3 3\nsurf 0 1 0 1 " + \
        " ".join(str(i + 1) for i in range(16)) + "\n"
    for text, pattern in [
        (good + "surf 0 1 0 1 1 2 3 4\n", r":11:1: the 'surf' has no 'end'"),
        (attributes + surface + surface + ends, r":8:1: 'surf' comes before the 'end' of the 'surf' above"),
        (attributes + surface + "deg 1 1\n" + ends, r":8:1: 'deg' comes before the 'end' of the 'surf' above"),
        (corners + surface + ends, r":5:1: there is no 'cstype' above"),
        (corners + "cstype bezier\n" + surface + ends, r":6:1: there is no 'deg' above"),
        (corners + "cstype bezier\ndeg 1\n" + surface + ends, r":7:1: there is no 'deg' with two degrees above"),
        (corners + "cstype rat\n" + surface, r":5:11: the line ends before a kind of curve or surface"),
        (corners + "cstype rational bezier\n" + surface, r":5:8: 'rational' is not a kind of curve or surface"),
        (corners + "deg 26 1\n" + surface, r":5:5: a degree is 26, not between 1 and 25"),
        (corners + "deg 1 4000000000000000000000\n" + surface, r":5:7: a degree is 4000000000000000000000, not"),
        (corners + "deg 0\n" + surface, r":5:5: a degree is 0, not between 1 and 25"),
        (corners + "deg 1.5\n" + surface, r":5:5: '1\.5' is not a degree"),
        (good + "deg 1 1 1\n", r":11:9: the line goes on after the last argument of 'deg'"),
        (good + "end\n", r":11:1: 'end' stands outside of a curve or surface"),
        (good + "parm u 0 1\n", r":11:1: 'parm' stands outside of a curve or surface"),
        (good + "trim 0 1 1\n", r":11:1: 'trim' stands outside of a curve or surface"),
        (attributes + "surf 0 1 0 x 1 2 3 4\n" + ends, r":7:12: 'x' is not a parameter"),
        (attributes + "surf 0 1 0 nan 1 2 3 4\n" + ends, r":7:12: 'nan' is not a parameter"),
        (attributes + "surf 0 1 0\n" + ends, r":7:11: the line ends before a parameter"),
        (attributes + "surf 0 1 0 1 1 2 3 5\n" + ends, r":7:20: there is no vertex 5: 4 are defined above"),
        (attributes + "surf 0 1 0 1 1 2 3 -5\n" + ends, r":7:20: there is no vertex -5: 4 are defined above"),
        (attributes + "surf 0 1 0 1 1 2 3 0\n" + ends, r":7:20: there is no vertex 0: 4 are defined above"),
        (attributes + "surf 0 1 0 1 1 2 3 4/x\n" + ends, r":7:20: '4/x' is not a control point"),
        (attributes + "surf 0 1 0 1 1 2 3\n" + ends, r":7:1: these parameters go with 2 x 2 points, not 3"),
        (attributes + "surf 0 1 0 1\n" + ends, r":7:1: these parameters go with 2 x 2 points, not 0"),
        (attributes + "surf 1 0 0 1 1 2 3 4\n" + ends, r":7:1: 1 to 0 is no part of 0 to 1, where it is defined"),
        (attributes + "surf 0 1 0 2 1 2 3 4\n" + ends, r":7:1: 0 to 2 is no part of 0 to 1"),
        (attributes + surface + "parm u 0 1\nend\n", r":7:1: 0 values of 'parm v' are too few"),
        (attributes + surface + "parm u 0\nparm v 0 1\nend\n", r":7:1: 1 values of 'parm u' are too few"),
        (attributes + surface + "parm w 0 1\n" + ends, r":8:6: 'w' is not 'u' or 'v'"),
        (attributes + surface + "parm u 0 1\n" + ends, r":9:1: a second 'parm' in the same direction"),
        (attributes + surface + "parm u 0 inf\n" + ends, r":8:10: 'inf' is not a parameter"),
        (attributes + surface + "parm u 1 1\nparm v 0 1\nend\n",
         r":7:1: parameter 2 is 1, not above the one before it, 1"),
        (cubic + "parm u 0 0 0 0 1 1 1 1\nparm v 0 0 0 0 1 1 .5 1\nend\n",
         r":19:1: knot 7 is 0.5, below the one before it, 1"),
        (cubic + "parm u 0 0 0 0 1 1 1 1\nparm v 0 0 0 0 1 1 1\nend\n", r":19:1: 7 values of 'parm v' are too few"),
        (cubic + "parm u 0 0 0 0 1 1 1 1\nparm v 0 0 0 0 1 1 1 1 1\nend\n", r":19:1: these parameters go with 4 x 5"),
        (cubic + "parm u 0 0 0 0 0 0 0 0\nparm v 0 0 0 0 1 1 1 1\nend\n", r":19:1: knots 4 to 5 are all 0"),
        (good.replace("deg 1 1", "deg 2 2").replace("bezier", "cardinal"), r":7:1: cardinal splines have degree 3"),
        (good.replace("bezier", "bmatrix"), r":7:1: there is no 'step' for a basis matrix above"),
        (good.replace("bezier", "bmatrix\nstep 1 1"), r":8:1: degree 1 needs a 'bmat u' of 4 numbers, not 0"),
        (good.replace("bezier", "bmatrix\nstep 1\nbmat u 1 -1 0 1"), r":9:1: there is no 'step' for a basis matrix"),
        (good.replace("bezier", "bmatrix\nstep 0 1"), r":6:6: a step is 0, not between 1 and"),
        (good.replace("bezier", "bmatrix\nbmat u 1 nan"), r":6:10: 'nan' is not a number"),
        (good.replace("v 0 0 0", "v nan 0 0"), r":1:1: a coordinate is not finite"),
        (good.replace("bezier", "rat bezier").replace("v 0 0 0", "v 0 0 0 0"), r":7:14: the weight is not positive"),
        (good.replace("bezier", "rat bezier").replace("v 0 1 0", "v 0 1 0 nan"), r":7:18: the weight is not finite"),
        (curve + "curv2 1 2 4\n" + surface, r":13:11: there is no parameter vertex 4: 3 are defined above"),
        (curve + "vp 1\ncurv2 1 2 4\n" + surface, r":14:11: the parameter vertex has no v"),
        (curve + "vp\n" + surface, r":13:3: the line ends before a parameter"),
        (curve + "vp 1 inf\n" + surface, r":13:6: 'inf' is not a parameter"),
        (curve + "curv2 1 2\nparm u 0 1 2\nend\n" + surface, r":13:1: these parameters go with 3 points, not 2"),
        (curve + "curv2 1 2\ntrim 0 1 1\nend\n" + surface, r":14:1: 'trim' stands in a curve, not in a surface"),
        (curve + "curv2 1 2\n", r": there are no faces or surfaces in the file"),
        (curve + surface + "trim 0 2 2\n" + ends, r":14:10: there is no curve 2: 1 are defined above"),
        (good.replace("end", "trim 0 2 1\nend"), r":10:10: there is no curve 1: 0 are defined above"),
        (curve + surface + "trim\n" + ends, r":14:5: the line ends before a parameter"),
        (curve + surface + "trim 0 2\n" + ends, r":14:9: the line ends before a curve"),
        (curve + surface + "trim -1 2 1\n" + ends, r":14:6: -1 to 2 is no part of 0 to 2, where it is defined"),
        (curve + surface + "hole 0 2 1 3 0 1\n" + ends, r":14:12: 0 to 3 is no part of 0 to 2"),
        (curve + surface + "trim 1 1 1\n" + ends, r":14:6: 1 to 1 is no part of 0 to 2"),
        (curve + surface + ("trim" + " 0 2 1" * 3 + "\n") * 999 + "trim 0 2\n" + ends, r":1013:9: the line ends"),
    ]:
        refuses(Run("info", write("bad.obj", text)), 1, r"bad\.obj" + pattern)
    many = "vp 0 1\n" + "curv2" + " 1" * 20000 + "\nparm u " + " ".join(map(str, range(20000))) + "\nend\n"
    refuses(Run("info", write("bad.obj", attributes + many + surface + "trim" + " 0 19999 1" * 20000 + "\n" + ends)), 1,
            r"bad\.obj:12:\d+: the trims repeat their curves too often")


def test_files():
    good = write("good.json", scene(SADDLE))
    write("rays", pack_rays([down(.5, .5)]))
    refuses(Run("info", "missing.json"), 1, r"missing\.json: cannot open")
    refuses(Run("info", "missing.bpt"), 1, r"missing\.bpt: cannot open")
    refuses(Run("info", "missing.xyz"), 1, r"missing\.xyz: cannot open")
    refuses(Run("info", write("some.xyz", "x")), 1, r"some\.xyz: ")
    for name in ("folder", "folder.json", "folder.bpt", "folder.step", "folder.dir"):
        os.makedirs(name, exist_ok=True)
        refuses(Run("info", name), 1, rf"{name}: cannot read: Is a directory")
    refuses(Run("trace", good, "--rays", "folder", "--hits", "h"), 1, "Is a directory")
    refuses(Run("trace", good, "--rays", "missing", "--hits", "h"), 1, "missing: cannot open")
    refuses(Run("trace", good, "--rays", write("cut", b"x" * 45), "--hits", "h"), 1, "cut: ray 1 is cut off")
    refuses(Run("trace", good, "--rays", "rays", "--hits", "folder"), 1, "folder: cannot write")
    refuses(Run("trace", good, "--rays", "rays", "--hits", "missing/h"), 1, "missing/h: cannot write")
    refuses(Run("trace", "bad.json", "--rays", "rays", "--hits", "h"), 1, "bad.json")

    # A full disk, and its cousin, a limit on file sizes.
    many = write("many", pack_rays([down(.5, .5)] * 5000))
    refuses(Run("trace", good, "--rays", many, "--hits", "/dev/full"), 1, "/dev/full: cannot write: No space")
    refuses(Run("trace", good, "--rays", "rays", "--hits", "h", "--stats", "/dev/full"), 1, "/dev/full: cannot write")
    refuses(Run("trace", good, "--rays", "rays", "--hits", "/dev/full", "--stats", "s"), 1, "/dev/full: cannot write")
    refuses(Run("trace", good, "--rays", many, "--hits", "h", limits=[(resource.RLIMIT_FSIZE, 20000)]), 1,
            "h: cannot write: File too large")
    with open("/dev/full", "wb") as full:
        for args in (("info", good), ("info", "--json", good), ("--help",), ("--version",), ("trace", "--help"),
                     ("trace", good, "--rays", "rays", "--hits", "-")):
            refuses(Run(*args, stdout=full), 1, "<stdout>: cannot write")

    # A standard stream that is closed does not become the next file that is opened.
    for streams, status, size in ((">&-", 1, 0), ("<&- 2>&-", 0, 32), ("<&- >&- 2>&-", 1, 0)):
        shell = ["sh", "-c", f'exec "$0" "$@" {streams}', EPATCH, "trace", good, "--rays", "rays", "--hits", "closed",
                 "--stats", "-"]
        p = subprocess.run(shell, capture_output=True)
        there = os.path.getsize("closed") if os.path.exists("closed") else 0
        check(p.returncode == status and there == size, f"{streams}: status {p.returncode}, {there} bytes")
        if there:
            os.remove("closed")

    # A file that was there is replaced as a whole or not touched; a link stays a link.
    write("old", "old")
    refuses(Run("trace", good, "--rays", many, "--hits", "old", limits=[(resource.RLIMIT_FSIZE, 20000)]), 1, "old")
    check(open("old").read() == "old", "a failed run has changed its output file")
    if os.geteuid():  # root may write everything
        os.chmod("old", 0o444)
        refuses(Run("trace", good, "--rays", "rays", "--hits", "old"), 1, "old: cannot write: Permission denied")
        os.chmod("old", 0o666)
    os.symlink("old", "link")
    works(Run("trace", good, "--rays", "rays", "--hits", "link"))
    check(os.path.islink("link") and os.path.getsize("old") == 32, "an output through a symbolic link")
    works(Run("trace", good, "--rays", "rays", "--hits", "/dev/null"))
    check(os.path.exists("/dev/null") and not os.path.isfile("/dev/null"), "/dev/null is replaced")

    # Stopped half way: the output is open, the scene still awaited.
    p = subprocess.Popen([EPATCH, "trace", "-", "--rays", "rays", "--hits", "stopped"], stdin=subprocess.PIPE)
    unfinished = []
    for _ in range(200):
        unfinished = [f for f in os.listdir(".") if f.endswith(".stopped")]
        if unfinished:
            break
        time.sleep(0.05)
    p.terminate()
    p.communicate()
    check(unfinished and p.returncode == -signal.SIGTERM, f"SIGTERM: {unfinished}, status {p.returncode}")
    check(not [f for f in os.listdir(".") if "stopped" in f], "SIGTERM leaves an unfinished file behind")

    # No memory (where the program runs under such a limit at all: sanitizers do not).
    limits = [(resource.RLIMIT_AS, 1 << 30)]
    if Run("--version", limits=limits).status == 0:
        with open("huge", "wb") as f:
            f.truncate(4 << 30)
        refuses(Run("trace", good, "--rays", "huge", "--hits", "h", limits=limits), 1, "huge: out of memory")
        os.remove("huge")


def test_pipes():
    good = write("good.json", scene(SADDLE))
    rays = pack_rays([down(.5, .25), down(2, 2)])
    write("rays", rays)
    works(Run("trace", good, "--rays", "rays", "--hits", "hits"))
    expected = open("hits", "rb").read()
    for r in (Run("trace", good, "--rays", "-", "--hits", "-", stdin=rays),
              Run("trace", "-", "--rays", "rays", "--hits", "-", stdin=open(good, "rb").read()),
              Run("trace", "--rays=rays", "--hits=-", "--", good)):
        works(r)
        check(r.out == expected, f"{r}: other bytes through pipes")
    r = Run("trace", good, "--rays", "rays", "--hits", "hits", "--stats", "-")
    works(r)
    check(json.loads(r.out)["rays"] == 2, f"{r}: stats on standard output")
    r = Run("trace", good, "--rays", "-", "--hits", "-", stdin=b"")
    works(r)
    check(r.out == b"", f"{r}: no rays, no hits")
    big = pack_rays([down(.5, .5)] * 300000)
    r = Run("trace", good, "--rays", "-", "--hits", "-", "--occluded", stdin=big)
    check(r.out == b"\1" * 300000, f"{r}: many rays through a pipe")


def test_stats():
    good = write("good.json", scene(SADDLE))
    rays = [down(.5, .5), down(.2, .3), down(3, 3)]
    for args in ((), ("--as", "triangles:4"), ("--occluded",), ("--width", "1", "--coherent", "--threads", "1")):
        trace(good, rays, "--stats", "stats", *args)
        s = json.load(open("stats"))
        for key in ("rays", "hits", "seconds", "rays_per_second", "build_seconds", "bytes_patches", "bytes_embree",
                    "leaves", "newton_iterations_mean", "slow_path_rays", "threads", "width", "isa", "visits", "solves",
                    "cells"):
            check(key in s, f"--stats {args} has no {key}")
        check(s["rays"] == 3 and s["hits"] == 2, f"--stats {args} counts {s['rays']} rays, {s['hits']} hits")
        check(s["seconds"] > 0 and s["bytes_patches"] > 0 and s["bytes_embree"] > 0, f"--stats {args}: {s}")
        if "--as" in args:
            check(s["newton_iterations_mean"] == 0 and s["slow_path_rays"] == 0 and s["leaves"] == 0,
                  f"triangles iterate: {s}")
        else:
            check(s["leaves"] > 0, f"no leaves: {s}")
    r = Run("info", "--json", "--rays", "rays", good)
    works(r)
    s = json.loads(r.out)
    check(s["geometries"][0]["name"] == "saddle" and s["geometries"][0]["patches"] == 1, f"info --json: {s}")
    check(close(s["bounds"], [0, 0, 0, 1, 1, 1], 0.01), f"info --json: bounds {s['bounds']}")
    check("newton_iterations_mean" in s, "info --rays tells no iterations")
    text = Run("info", good, "--rays", "rays").out.decode()
    check("iterations" in text and "1 x 1" in text, f"info: {text}")


def test_hits():
    for as_ in (("--as", "patches"), ("--as", "triangles:64")):
        tolerance = 1e-5 if as_[1] == "patches" else 2e-2
        for geometry in (SADDLE, TRIANGLE):
            name = write("one.json", scene(geometry))
            what = f"{geometry['name']} {as_}"
            h = trace(name, [down(.3, .6), down(.25, .5, 5, 2), down(1.01, .5)], *as_)
            if len(h) != 3:
                continue
            same_hit(h[0], 10 - .18, .3, .6, 0, 0, (-.6, -.3, 1), what, tolerance)
            same_hit(h[1], (5 - .125) / 2, .25, .5, 0, 0, (-.5, -.25, 1), what + ", direction of length 2", tolerance)
            check(h[2][:5] == (math.inf, 0, 0, MISS, MISS), f"{what}: a miss is {h[2]}")
            corner = (1e-3, 1e-3)
            h = trace(name, [down(*corner), down(1 - 2e-3, 1e-3), down(1e-3, 1 - 2e-3)], *as_)
            check(len(h) == 3 and all(x[4] == 0 for x in h), f"{what}: corners {h}")

    # Several patches of mixed kinds: their indices, and the parameters of each.
    two = dict(SADDLE, patches=SADDLE["patches"] + [[[x + 2, y, z] for x, y, z in SADDLE["patches"][0]]])
    name = write("two.json", scene(two, TRIANGLE))
    for as_ in ("patches", "triangles:32"):
        h = trace(name, [down(2.5, .75, 3)], "--as", as_)
        same_hit(h[0] if h else None, 3 - .375, .5, .75, 0, 1, (-.75, -.5, 1), f"second patch, {as_}", 5e-2)


def test_rays():
    name = write("one.json", scene(SADDLE))
    nan, inf = math.nan, math.inf
    miss = [
        (nan, .5, 5, 0, 0, 0, -1, inf), (.5, .5, 5, nan, 0, 0, -1, inf), (.5, .5, 5, 0, 0, nan, -1, inf),
        (.5, .5, 5, 0, 0, 0, -1, nan), (.5, .5, 5, 0, 0, 0, 0, inf), (inf, .5, 5, 0, 0, 0, -1, inf),
        (.5, .5, 5, 0, 0, 0, -inf, inf), (.5, .5, 5, 0, 0, 0, -1, 4), (.5, .5, 5, 5, 0, 0, -1, inf),
        (.5, .5, 5, 3, 0, 0, -1, 2), (.5, .5, 5, 0, 0, 0, -1, -inf), (.5, .5, 5, -3, 0, 0, -1, -1),
        (.5, .5, -5, -inf, 0, 0, -1, 0), (.5, .5, 5, 0, 0, 0, 1, inf),
    ]
    hit = [(.5, .5, 5, -3, 0, 0, -1, inf), (.5, .5, 5, -inf, 0, 0, -1, 1e30), (.5, .5, 5, 4.7, 0, 0, -1, 4.8)]
    rays = [r for pair in zip(miss, hit * 5) for r in pair]
    for width in (1, 4, 8, 16):
        h = trace(name, rays, "--width", width)
        for r, x in zip(rays, h):
            check((x[4] == MISS) == (r in miss or any(map(math.isnan, r))), f"--width {width}: ray {r} gets {x}")
        o = trace(name, rays, "--width", width, "--occluded")
        check(o == [int(x[4] != MISS) for x in h], f"--width {width}: --occluded disagrees")

    # lengths of directions that Embree does not take, and t in units of them
    unit = trace(name, [down(.5, .25, 5)])[0]
    lengths = [1e17, 1e19, 1e30, 1e38, 1e-17, 1e-19, 1e-30, 1e-37]
    rays = [down(.5, .25, 5, length) for length in lengths]
    lost = [down(.5, .25, 5, 1e-38), (1e19, .5, 5, 0, 0, 0, -1, inf), (.5, .25, 5, 1e-28, 0, 0, -1e30, inf)]
    for width in (1, 16):
        h = trace(name, rays + lost, "--width", width)
        for length, x in zip(lengths, h):
            same_hit(x, unit[0] / length, *unit[1:5], unit[5:], f"a direction of {length}", 1e-6)
            check(abs(x[0] * length / unit[0] - 1) < 1e-6, f"a direction of {length}: t {x[0]}, not {unit[0] / length}")
        check(all(x[4] == MISS for x in h[len(rays):]), f"--width {width}: beyond floats, and hit: {h[len(rays):]}")


def test_agreement():
    """Widths, threads, coherence: the same bytes. Occlusion: the same rays."""
    objects = [{"geometry": "saddle"}, {"geometry": "half", "transform": [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, .5]},
               {"geometry": "saddle", "transform": [0, 1, 0, -1, 0, 0, 0, 0, 2, 1, 0, 1]}]
    rays = []
    for i in range(997):
        a = i * 0.6180339887
        o = (3 * math.cos(9 * a), 3 * math.sin(9 * a), 3 * math.sin(5 * a))
        to = (a % 1, (a * 1.7) % 1, (a * 2.3) % 2)
        rays.append((*o, 0, *[q - p for p, q in zip(o, to)], math.inf))
    for kind, more_objects in (("placed", []), ("instances", crowd("saddle"))):
        name = write("mixed.json", scene(SADDLE, TRIANGLE, objects=objects + more_objects))
        base = trace(name, rays, "--width", 16)
        check({h[3] for h in base} == {0, 1, 2, MISS}, "the rays of the test hit every object and nothing")
        for args in (("--width", 1), ("--width", 4), ("--width", 8), ("--threads", 1), ("--threads", 2), ("--coherent",),
                     ("--on-demand",), ("--on-demand", "--width", 1), ("--isa", "plain")):
            check(trace(name, rays, *args) == base, f"{kind}, {args}: other bits than --width 16")
        hit = [int(h[4] != MISS) for h in base]
        for width in (1, 4, 8, 16):
            for more in ((), ("--on-demand",)):
                check(trace(name, rays, "--occluded", "--width", width, *more) == hit,
                      f"{kind}, --occluded --width {width} {more}")


def test_objects():
    m = [0, 2, 0, -3, 0, 0, 0, 0, 5, 7, 8, 9]  # x -> 2 y, y -> -3 x, z -> 5 z, then moved
    mirror = [1, 0, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0]
    geometry = [SADDLE, TRIANGLE, {"type": "bezier", "degree": [1, 1], "patches": []}]
    objects = [{"geometry": "half", "transform": [1, 0, 0, 0, 1, 0, 0, 0, 1, 20, 0, 0]},
               {"geometry": "saddle", "transform": m},
               {"geometry": "saddle", "material": "steel"},
               {"geometry": "saddle", "transform": [*mirror[:9], 10, 0, 0]}]
    write("placed.json", scene(*geometry, objects=objects))
    write("instances.json", scene(*geometry, objects=objects + crowd("saddle")))
    u, v = .25, .5
    at = (7 - 3 * v, 8 + 2 * u, 9 + 5 * u * v)
    # cofactors of M applied to (-v, -u, 1)
    a, b = (0, 2, 5 * v), (-3, 0, 5 * u)
    normal = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    for name, as_ in ((n, a) for n in ("placed.json", "instances.json") for a in ("patches", "triangles:64")):
        tolerance = 1e-5 if as_ == "patches" else 5e-2
        h = trace(name, [down(at[0], at[1], 100), down(u, v), down(10 + u, v), down(20 + u, v)], "--as", as_)
        if len(h) != 4:
            continue
        same_hit(h[0], 100 - at[2], u, v, 1, 0, normal, f"{name}, a transformed object, {as_}", tolerance)
        same_hit(h[1], 10 - u * v, u, v, 2, 0, (-v, -u, 1), f"{name}, an object as it is, {as_}", tolerance)
        same_hit(h[2], 10 + u * v, u, v, 3, 0, (v, u, 1), f"{name}, a mirrored object, {as_}", tolerance)
        same_hit(h[3], 10 - u * v, u, v, 0, 0, (-v, -u, 1), f"{name}, a moved triangle, {as_}", tolerance)
    for text in (scene(), scene(SADDLE, objects=[]), scene({"type": "bezier", "degree": [1, 1], "patches": []})):
        name = write("empty.json", text)
        h = trace(name, [down(.5, .5)])
        check(h and h[0][4] == MISS, f"a hit in an empty scene: {h}")
        works(Run("info", name))
        works(Run("info", "--json", name))
    name = write("alone.json", scene({"type": "bezier", "degree": [1, 1],
                                      "patches": [{"points": SADDLE["patches"][0]}]}))
    h = trace(name, [down(.5, .5)])
    check(h and h[0][4] == 0, f"a patch as an object with points: {h}")


def transformed(geometry, m, name):
    """The geometry that an object with transform m shows."""
    def move(p):
        return [sum(m[3 * axis + x] * p[axis] for axis in range(3)) + m[9 + x] for x in range(3)] + p[3:]
    return dict(geometry, name=name, patches=[[move(p) for p in patch] for patch in geometry["patches"]])


def test_placed_objects():
    """An object answers bit for bit as its patches do when they are written where it is."""
    bent = {"name": "bent", "type": "bezier", "degree": [3, 2], "trim": HOLE, "patches": [
        [[i / 4, j / 2, (3 * i + 5 * j + i * j) % 7 / 8, 1 + (i + 2 * j) % 3 / 2] for j in range(3) for i in range(4)]]}
    half = transformed(TRIANGLE, [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, .25], "half")  # not where the saddle is
    turns = [[1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0],
             [2, 0, 0, 0, .5, 0, 0, 0, 4, 1.25, -3, .5],   # stretched and moved
             [0, 1, 0, -1, 0, 0, 0, 0, 1, -2, 0, 0],       # a quarter turn
             [0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 2, -1],        # about the diagonal
             [-1, 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 1],       # mirrored
             [0, 0, -.5, 0, 2, .25, 1, 0, 0, 0, 0, 2]]     # sheared, scaled and mirrored
    shown = [(g, m) for m in turns for g in (SADDLE, half, bent)] + [
        (dict(bent, name="alone"), [0, .5, 0, 0, 0, .5, .5, 0, 0, 0, 4, 0])]
    given = {g["name"]: g for g, _ in shown}
    placed = write("placed.json", scene(*given.values(), objects=[
        {"geometry": g["name"], **({} if m == turns[0] else {"transform": m})} for g, m in shown]))
    there = write("there.json", scene(*(transformed(g, m, str(i)) for i, (g, m) in enumerate(shown))))
    rays = []
    for i in range(4000):
        a = i * 0.6180339887
        o = (8 * math.cos(9 * a), 8 * math.sin(9 * a), 8 * math.sin(5 * a))
        g, m = shown[i % len(shown)]
        to = transformed(dict(g, patches=[[[a * 1.7 % 1, a * 2.3 % 1, a % 1]]]), m, "")["patches"][0][0]
        rays.append((*o, 0, *[q - p for p, q in zip(o, to)], math.inf))
    for args in ((), ("--as", "triangles:8"), ("--on-demand",)):
        for width in (1, 16):
            h = trace(placed, rays, "--width", width, *args)
            check({x[3] for x in h} == {*range(len(shown)), MISS}, f"{args}: not everything is hit")
            check(h == trace(there, rays, "--width", width, *args),
                  f"--width {width} {args}: other bits than patches there")
            check([int(x[4] != MISS) for x in h] == trace(placed, rays, "--width", width, "--occluded", *args),
                  f"--width {width} {args}: --occluded disagrees")

    # What is shown as it is needs no copy, nor does what one object shows.
    r = Run("info", placed, "--json")
    if works(r):
        i, j = json.loads(r.out), json.loads(Run("info", there, "--json").out)
        copies = {g["name"]: g["copies"] for g in i["geometries"]}
        check(copies == {"saddle": 5, "half": 5, "bent": 5, "alone": 0}, f"info --json: {i}")
        check(i["leaves"] == j["leaves"] and i["bounds"] == j["bounds"], f"info --json: {i} {j}")
        check([g["patches"] for g in i["geometries"]] == [1] * 4 and i["total"]["patches"] == 4, f"info --json: {i}")
    check(b"and 5 copies" in Run("info", placed).out, "info tells nothing of copies")
    refuses(Run("info", placed, "--svg", "domain.svg", "--patch", 4), 1, "there is no patch 4; the scene has 4")
    r = Run("verify", placed, "--rays", "400", "--isa", "plain")
    check(works(r), f"{r}: {r.out.decode()}")


def test_copies_are_limited():
    """4096 patches may be copied; beyond, objects are instances, which take no memory of their own."""
    def patches(count):
        return dict(SADDLE, patches=[[[x + 2 * i, y, z] for x, y, z in SADDLE["patches"][0]] for i in range(count)])

    def lifted(count):
        return [{"geometry": "saddle", "transform": [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, i + 1]} for i in range(count)]

    def info(*args, **more):
        r = Run("info", write("some.json", scene(*args, **more)), "--json")
        return json.loads(r.out) if works(r) else None

    one, as_it_is = info(patches(2048)), [{"geometry": "saddle"}]
    for objects, copies in ((as_it_is + lifted(2), 2), (lifted(3), 2), (as_it_is + lifted(3), 0), (lifted(4), 0)):
        what, top = f"{len(objects)} objects, {copies} copies", len(objects) - 1
        i = info(patches(2048), objects=objects)
        check(i["geometries"][0]["copies"] == copies, f"{what}: {i}")
        check(i["leaves"] == (copies + 1) * one["leaves"], f"{what}: {i['leaves']} leaves of {one['leaves']}")
        check(i["bytes_patches"] < (copies + 1.1) * one["bytes_patches"], f"{what}: {i}")
        for as_ in ("patches", "triangles:2"):
            h = trace("some.json", [down(4094.25, .25)], "--as", as_)
            same_hit(h[0] if h else None, 10 - objects[-1]["transform"][11] - .0625, .25, .25, top, 2047, (-.25, -.25, 1),
                     f"{what}, {as_}", 1e-5 if as_ == "patches" else .3)

    # A single object needs no copy, however many patches it has.
    i = info(patches(4100), objects=lifted(1))
    check(i["geometries"][0]["copies"] == 0 and i["bounds"][2] > .9, f"info: {i['geometries'][0]}")
    check(i["geometries"][0]["bounds"] == i["bounds"], f"a single object is not in its place: {i}")

    for count, copies in ((129, 128), (130, 0)):  # trimmed patches have more leaves
        i = info(dict(SADDLE, trim={"circle": {}}), objects=lifted(count))
        check(i["geometries"][0]["copies"] == copies, f"{count} trimmed objects: {i}")

    # Where doubles are too coarse for a surface, it is not moved.
    one, far = info(SADDLE), {"geometry": "saddle", "transform": [1, 0, 0, 0, 1, 0, 0, 0, 1, 1e15, 1 / 3, 0]}
    i = info(SADDLE, objects=[far, *lifted(1), far])
    check(i["geometries"][0]["copies"] == 1 and i["leaves"] == 2 * one["leaves"], f"far away: {i}")
    h = trace("some.json", [down(.25, .25)])
    same_hit(h[0] if h else None, 9 - .0625, .25, .25, 1, 0, (-.25, -.25, 1), "next to objects far away", 1e-5)


BENCH = ("--runs", "1", "--rays", "256", "--max-tessellation", "16")


# Curved triangles: their formulas as the papers have them, on (x, y, z), weights b of the corners in their order.


def combine(*pairs):
    return tuple(sum(w * p[c] for w, p in pairs) for c in range(3))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(a):
    return combine((1 / math.sqrt(dot(a, a)), a))


def projected(q, p, n):
    """q onto the plane through p that n is normal to."""
    return combine((1, q), (-dot(combine((1, q), (-1, p)), n), n))


def phong_point(p, n, b, alpha):
    flat = combine(*zip(b, p))
    return combine((1 - alpha, flat), *((alpha * b[i], projected(flat, p[i], n[i])) for i in range(3)))


def pn_point(p, n, b, _):
    near = {(i, j): projected(combine((2 / 3, p[i]), (1 / 3, p[j])), p[i], n[i])
            for i in range(3) for j in range(3) if i != j}
    middle = combine(*((1 / 4, q) for q in near.values()), *((-1 / 6, q) for q in p))
    return combine(*((b[i]**3, p[i]) for i in range(3)), *((3 * b[i]**2 * b[j], q) for (i, j), q in near.items()),
                   (6 * b[0] * b[1] * b[2], middle))


def quadratic_point(p, u, v):
    w = 1 - u - v
    p1, p2, p3, p4, p5, p6 = p
    return combine((u * u, p1), (v * v, p2), (w * w, p3), (4 * u * v, p6), (-u * v, p1), (-u * v, p2), (4 * u * w, p5),
                   (-u * w, p1), (-u * w, p3), (4 * v * w, p4), (-v * w, p2), (-v * w, p3))


def normal_at(f, u, v, h=1e-5):
    """f's derivatives, crossed: differences of cubics are off by h * h."""
    du, dv = (combine((.5 / h, f(u + a, v + b)), (-.5 / h, f(u - a, v - b))) for a, b in ((h, 0), (0, h)))
    return tuple(du[(c + 1) % 3] * dv[(c + 2) % 3] - du[(c + 2) % 3] * dv[(c + 1) % 3] for c in range(3))


def hit_surface(f, u, v):
    """A ray that meets f from outside at (u, v), from nearby, at t = 0.5; and the normal there."""
    p, n = f(u, v), normal_at(f, u, v)
    d = combine((-.4, unit(n)), (.1, (n[1], n[2], n[0])))
    return (*combine((1, p), (-.5, d)), 0, *d, 1), n


def ball(noise=0.0, octahedron=False):
    """A closed mesh about the origin: vertices, normals of any length, triangles that run counterclockwise outside."""
    g = (1 + math.sqrt(5)) / 2
    points = [(0, s, t) for s in (1, -1) for t in (g, -g)] + [(s, t, 0) for s in (1, -1) for t in (g, -g)] + [
        (t, 0, s) for s in (1, -1) for t in (g, -g)]
    near = 0.4
    if octahedron:
        points, near = [tuple(s * (c == k) for c in range(3)) for s in (1, -1) for k in range(3)], -0.5
    points = [unit(p) for p in points]
    triangles = []
    for a, b, c in ((a, b, c) for a in range(len(points)) for b in range(a) for c in range(b)):
        p, q, r = points[a], points[b], points[c]
        if min(dot(p, q), dot(q, r), dot(r, p)) > near:
            outwards = sum(p[i] * (q[(i + 1) % 3] * r[(i + 2) % 3] - q[(i + 2) % 3] * r[(i + 1) % 3]) for i in range(3)) > 0
            triangles.append([[a, b, c], [b, c, a], [c, a, b]][a % 3] if outwards else [b, a, c])
    shaken = [combine((1 + noise * math.sin(7 * i), p)) for i, p in enumerate(points)]
    normals = [combine((1 + i, p), (noise * (1 + i), tuple(math.sin(5 * i + c) for c in range(3))))
               for i, p in enumerate(points)]
    return shaken, normals, triangles


def curved(kind, mesh, **more):
    vertices, normals, triangles = mesh
    return {"type": kind, "vertices": vertices, "normals": normals, "triangles": triangles, **more}


WEIGHTS = [(.2, .3), (.6, .1), (.05, .9), (1 / 3, 1 / 3), (.02, .03), (.96, .02)]


def test_curved_triangles():
    vertices, normals, triangles = mesh = ball(.1)
    check(len(triangles) == 20, f"an icosahedron of {len(triangles)} triangles")
    found, rays_of = {}, {}
    for kind, point, more, alpha in (("phong_triangles", phong_point, {}, .75),
                                     *(("phong_triangles", phong_point, {"alpha": a}, a) for a in (0, .75, 1, .3)),
                                     ("pn_triangles", pn_point, {}, None)):
        rays, normals_there, places = [], [], []
        for i, t in enumerate(triangles):
            p, n = [vertices[k] for k in t], [unit(normals[k]) for k in t]
            for u, v in WEIGHTS:
                ray, ng = hit_surface(lambda u, v: point(p, n, (1 - u - v, u, v), alpha), u, v)
                rays.append(ray)
                normals_there.append(ng)
                places.append((u, v, i))
        rays_of[kind] = rays
        h = found[kind, more.get("alpha")] = trace(write("ball.json", scene(curved(kind, mesh, **more))), rays)
        for hit, ng, (u, v, i) in zip(h, normals_there, places):
            same_hit(hit, .5, u, v, 0, i, ng, f"{kind} {more}, triangle {i} at {u}, {v}", 2e-6)
    phong = [found["phong_triangles", a] for a in (None, 0, .75, 1, .3)]
    check(phong[0] == phong[2] and len(set(map(tuple, phong))) == 4, "alpha is 0.75 where nothing is said")

    six = [[.9, .1, 0], [.1, 1, .1], [0, 0, 0], [0, .6, .3], [.5, -.1, .2], [.6, .6, .25]]
    shape = lambda u, v: quadratic_point(six, u, v)
    for (u, v), p in zip(((1, 0), (0, 1), (0, 0), (0, .5), (.5, 0), (.5, .5)), six):
        check(close(shape(u, v), p, 1e-15), f"the formula of quadratic triangles at {u}, {v}")
    there = [hit_surface(shape, u, v) for u, v in WEIGHTS]
    whole = {"type": "quadratic_triangles", "patches": [[[5, 5, 5]] * 6, [p + [1] for p in six]]}
    h = trace(write("six.json", scene(whole)), [ray for ray, _ in there])
    for hit, (u, v), (_, ng) in zip(h, WEIGHTS, there):
        same_hit(hit, .5, u, v, 0, 1, ng, f"a quadratic triangle at {u}, {v}", 2e-6)

    # trims: of one patch, and of all of a mesh, in the parameters of each
    hole = {"difference": [{"square": {}}, {"circle": {}, "transform": [.1, 0, 0, .1, .2, .3]}]}
    whole["patches"][1] = {"points": six, "trim": hole}
    h = trace(write("six.json", scene(whole)), [ray for ray, _ in there])
    check([x[4] for x in h] == [MISS] + [1] * 5, f"a trimmed quadratic triangle: {h}")
    more = {"phong_triangles": {"alpha": .3}, "pn_triangles": {}}  # as found last
    for kind in more:
        h = trace(write("ball.json", scene(curved(kind, mesh, trim=hole, **more[kind]))), rays_of[kind])
        check([x[4] for x in h] == [MISS if u == .2 else i for u, v, i in places], f"trimmed {kind}")


def test_curved_triangles_close():
    """No ray leaves a closed mesh: at its edges and vertices, and where it is all of one plane or less."""
    origins = [(0, 0, 0), (.1, -.2, .05), (-.25, .15, .2)]
    for what, (vertices, normals, triangles) in (("an icosahedron", ball(.1)), ("a regular one", ball()),
                                                 ("an octahedron", ball(0, True))):
        edges = {(min(a, b), max(a, b)) for t in triangles for a, b in zip(t, t[1:] + t[:1])}
        check(len(vertices) - len(edges) + len(triangles) == 2, f"{what} is closed")
        for kind, point in (("phong_triangles", phong_point), ("pn_triangles", pn_point), ("quadratic_triangles", None)):
            middle = lambda a, b: combine((.6, vertices[a]), (.6, vertices[b]))
            along = lambda a, b, s: (
                quadratic_point([vertices[a], vertices[b], (0, 0, 0)] + [(0, 0, 0)] * 2 + [middle(a, b)], 1 - s, s)
                if not point else point([vertices[a], vertices[b], (0, 0, 0)],
                                        [unit(normals[a]), unit(normals[b]), (0, 0, 1)], (1 - s, s, 0), .75))
            targets = vertices + [along(a, b, s / 16) for a, b in edges for s in range(1, 16)]
            rays = [(*o, 0, *combine((1, t), (-1, o)), math.inf) for o in origins for t in targets]
            mesh = curved(kind, (vertices, normals, triangles)) if point else {
                "type": kind, "patches": [[vertices[a], vertices[b], vertices[c], middle(*sorted((b, c))),
                                           middle(*sorted((a, c))), middle(*sorted((a, b)))] for a, b, c in triangles]}
            name = write("closed.json", scene(mesh))
            for width in (1, 16):
                h = trace(name, rays, "--width", width)
                lost = [r for r, x in zip(rays, h) if x[4] == MISS]
                check(not lost, f"{what} of {kind}, width {width}: {len(lost)} of {len(rays)} rays leave, {lost[:2]}")
                check(all(abs(x[0] - 1) < 1e-5 for x in h), f"{what} of {kind}: t is not 1 at all edges")
                check(all(trace(name, rays, "--occluded", "--width", width)), f"{what} of {kind}: --occluded")

    # a vertex twice, one vertex thrice, no area
    line = ([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 0, 1]] * 4, [[0, 1, 1], [2, 2, 2], [0, 1, 2], [0, 1, 3]])
    for kind in ("phong_triangles", "pn_triangles"):
        h = trace(write("line.json", scene(curved(kind, line))), [down(.25, .5), down(1.5, .5), down(.5, -.1)])
        same_hit(h[0], 10, .25, .5, 0, 3, (0, 0, 1), f"{kind}: a triangle beside some without area", 1e-6)
        check([x[4] for x in h[1:]] == [MISS] * 2, f"{kind}: triangles without area: {h}")
        works(Run("info", write("none.json", scene(curved(kind, ([], [], []))))))


def test_bad_curved_triangles():
    def changed(kind="phong_triangles", **more):
        flat = curved(kind, ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 2]] * 3, [[0, 1, 2]]), **more)
        return scene({k: v for k, v in flat.items() if v is not None})

    points = [[0, 0, 0]] * 6
    quadratic = lambda **more: scene({"type": "quadratic_triangles", "patches": [points], **more})
    either = [(changed(kind, **change), message) for kind in ("phong_triangles", "pn_triangles") for change, message in (
        *(({key: None}, f"a mesh of curved triangles needs '{key}'") for key in ("vertices", "normals", "triangles")),
        *(({key: 5}, f"'{key}' is a number, not an array") for key in ("vertices", "normals", "triangles")),
        ({"normals": [[0, 0, 1]] * 2}, "3 vertices have as many normals, not 2"),
        ({"vertices": [], "normals": []}, "there are no vertices"),
        ({"vertices": [[0, 0, 0, 1]] * 3}, "a vertex has 4 numbers, not 3"),
        ({"vertices": [[0, 0, 1e19]] * 3}, "a coordinate is beyond 1e18"),
        ({"vertices": [[1e18, -1e18, 0], [1e18, 1e18, 0], [0, 0, 0]], "normals": [[-1, 1, 0], [-1, -1, 0], [0, 0, 1]]},
         "a control point of the curved triangle: a coordinate is beyond 1e18"),
        ({"normals": [[0, 0, 1]] * 2 + [[0, 0]]}, "a normal has 2 numbers, not 3"),
        ({"normals": [[0, 0, 1]] * 2 + [["0", 0, 0]]}, "a normal is a string, not a number"),
        ({"normals": [[0, 0, 1]] * 2 + [[0, -0.0, 0]]}, "a normal is zero"),
        ({"triangles": [5]}, "a triangle is a number, not an array"),
        ({"triangles": [[0, 1, 2, 0]]}, "a triangle has 3 vertices, not 4"),
        ({"triangles": [[0, 1, 3]]}, "an index into vertices is 3, not a whole number from 0 to 2"),
        ({"triangles": [[0, 1, -1]]}, "an index into vertices is -1"),
        ({"triangles": [[0, 1, 0.5]]}, "an index into vertices is 0.5"),
        ({"degree": 2}, "a geometry of this type has no key 'degree'"))]
    for text, pattern in either + [
        *((changed(alpha=x), f"'alpha' is {x}, not a number from 0 to 1") for x in (-.25, 1.25)),
        (changed(alpha="1"), "'alpha' is a string, not a number"),
        (changed("pn_triangles", alpha=1), "a geometry of this type has no key 'alpha'"),
        (quadratic(patches=5), "'patches' is a number, not an array"),
        (scene({"type": "quadratic_triangles"}), "a geometry of patches needs 'patches'"),
        (quadratic(patches=[points[1:]]), "a patch of this degree has 6 points, not 5"),
        (quadratic(patches=[points[1:] + [[0, 0, 0, 2]]]), "the points of a quadratic triangle have no weights"),
        (quadratic(patches=[points[1:] + [[0, 9e17, 0]]]), "a control point of the curved triangle: a coordinate is beyond"),
        (quadratic(degree=2), "a geometry of this type has no key 'degree'"),
    ]:
        refuses(Run("info", write("bad.json", text)), 1, r"bad\.json:1:\d+: " + pattern)
    # the place is exact
    for old, text, place in (("[0, 0, 2]]", "\n  [0, 0, 0]]", "2:3: a normal is zero"),
                             ("1, 2]]", "1,\n 3]]", "2:2: an index into vertices is 3")):
        assert old in changed()
        refuses(Run("info", write("bad.json", changed().replace(old, text))), 1, r"bad\.json:" + place)


def test_bench():
    """What is measured, not how fast it is."""
    name = write("bench.json", scene(SADDLE, TRIANGLE, objects=[
        {"geometry": "saddle"}, {"geometry": "half", "transform": [1, 0, 0, 0, 2, 0, 0, 0, 1, 3, 0, .5]}]))
    r = Run("bench", name, "--json", *BENCH)
    if works(r):
        b = json.loads(r.out)
        workloads = [k + n for k in ("primary", "random", "bounce", "occluded") for n in ("1", "16")]
        for key in ("cpu", "cores", "isa", "compiler", "embree"):
            check(key in b["machine"], f"bench --json: the machine has no {key}")
        for s in [*b["tessellation"], b["patches"]]:
            check(set(s["mrays"]) == set(workloads) and all(x > 0 for x in s["mrays"].values()), f"bench: mrays of {s}")
            for key in ("n", "triangles", "bytes", "build_seconds", "max_position_error", "max_normal_error_degrees"):
                check(key in s, f"bench --json: {key} is missing in {s}")
        check([s["n"] for s in b["tessellation"]] == [8, 16], f"bench: tessellations {b['tessellation']}")
        check([s["triangles"] for s in b["tessellation"]] == [3 * 64, 3 * 256], "bench: triangles")
        check(set(b["limit"]["mrays"]) == set(workloads), f"bench: limit {b['limit']}")
        coarse, fine = (s["max_position_error"] for s in b["tessellation"])
        check(coarse > 2 * fine > 2 * b["patches"]["max_position_error"], "bench: finer is not more exact")
        m, last = b["matched"], b["tessellation"][-1]
        check(m["n"] == 16 and not m["as_exact"], f"bench: matched {m}")
        for key in workloads:
            check(close([m[key]], [b["patches"]["mrays"][key] / last["mrays"][key]]), f"bench: matched {key}")
            for t in b["tessellation"]: # of one run, the same as that of its figures but for the patches' share
                check(.1 < t["patches_ratio"][key] * t["mrays"][key] / b["patches"]["mrays"][key] < 10, f"bench: {key} of {t}")
        for key in ("bytes", "build_seconds"):
            check(close([m[key]], [b["patches"][key] / last[key]]), f"bench: matched {key}")

    # Planes are matched at once; the table, the file and the other numbers of threads.
    flat = write("flat.json", scene(dict(SADDLE, patches=[[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]])))
    r = Run("bench", flat, "--stats", "bench.stats", "--all-threads", "--workloads", "random1", *BENCH)
    works(r)
    check("\npatches / 8×8 " in r.out.decode() and " / 1 threads" in r.out.decode(), f"bench: {r.out.decode()}")
    b = json.load(open("bench.stats"))
    check(b["matched"]["n"] == 8 and b["matched"]["as_exact"], f"bench: matched {b['matched']}")
    check(list(b["patches"]["mrays_all_threads"]) == ["random1"], "bench --all-threads --workloads")
    r = Run("bench", name, "--table", "--workloads", "primary16", *BENCH)
    check(works(r) and "| --- | ---: |" in r.out.decode(), f"bench --table: {r.out.decode()}")
    r = Run("bench", "--degrees", "--json", "--runs", "1")
    if works(r):
        rows = json.loads(r.out)["degrees"]
        check([d["degree"] for d in rows] == [[n, n] for n in range(2, 7)] and
              all(d["mpixels"] > 0 and d["coverage"] == 1 for d in rows), f"bench --degrees: {rows}")
    for isa in ("plain", "best"):
        r = Run("bench", os.path.join(DATA, "teapot.bpt"), "--newton", "--json", "--runs", "1", "--rays", "65536",
                "--workloads", "primary1,primary16,random1", "--isa", isa)
        if works(r):
            rows = json.loads(r.out)["workloads"]
            check(list(rows) == ["primary1", "primary16", "random1"], f"bench --newton: {list(rows)}")
            for name_of, row in rows.items():
                check(row["mrays"] > 0 and row["mrays_newton"] > 0 and row["hits"] > 1000, f"bench --newton: {row}")
                # it is the same method, and loses hardly anything
                check(row["lost"] + row["extra"] < .001 * row["hits"] and row["other"] < .01 * row["hits"], f"bench --newton: {row}")
    r = Run("bench", name, "--newton", *BENCH)
    check(works(r) and "certified" in r.out.decode(), f"bench --newton: {r.out.decode()}")

    for args, pattern in [
        ((), "SCENE is missing"),
        ((name, "--max-tessellation", "100"), "not a power of two"),
        ((name, "--max-tessellation", "4"), "--max-tessellation is '4'"),
        ((name, "--runs", "0"), "--runs is '0'"),
        ((name, "--workloads", "primary2"), "--workloads has 'primary2'"),
        ((name, "--json", "--table"), "exclude each other"),
        ((name, "--threads", "2", "--all-threads"), "exclude each other"),
        ((name, "--plot", "picture.png"), "not the name of an .svg file"),
        ((name, "--stats", "-"), "--json writes to standard output"),
        ((name, "--degrees"), "is too much"),
        ((name, "--newton", "--trims"), "exclude each other"),
        ((name, "--newton", "--stats", "s"), "goes with none of"),
    ]:
        refuses(Run("bench", *args), 2, pattern)
    refuses(Run("bench", "missing.json", *BENCH), 1, r"missing\.json: cannot open")
    refuses(Run("bench", write("empty.json", scene()), *BENCH), 1, r"empty\.json: there is nothing to measure")
    refuses(Run("bench", name, "--scene-camera", *BENCH), 1, "there is no camera")
    refuses(Run("bench", name, "--stats", "missing/s", "--table", *BENCH, stdout=subprocess.DEVNULL), 1, "missing/s: cannot write")
    if shutil.which("gnuplot"):
        refuses(Run("bench", name, "--plot", "missing/p.svg", *BENCH), 1, r"missing/p\.svg: cannot write")
        works(Run("bench", name, "--plot", "p.svg", *BENCH))
        check("patches" in open("p.svg").read(), "bench --plot: no word of the patches")
    path = os.environ["PATH"]
    os.environ["PATH"] = "."
    refuses(Run("bench", name, "--plot", "q.svg", *BENCH), 1, r"q\.svg: .*gnuplot, which is not installed")
    os.environ["PATH"] = path


HOLE = {"difference": [{"square": {}}, {"circle": {}, "transform": [.3, 0, 0, .3, .5, .5]}]}


def area(points):
    """Of a polygon, "x,y x,y ..."; positive."""
    p = [tuple(map(float, xy.split(","))) for xy in points.split()]
    return abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(p, p[1:] + p[:1]))) / 2


def test_svg():
    """The leaves in the picture: what is kept, and how little of it is crossed."""
    bent = dict(SADDLE, trim=HOLE)
    name = write("hole.json", scene(SADDLE, bent, dict(TRIANGLE, trim={"circle": {}, "transform": [.2, 0, 0, .2, .3, .3]})))
    kept = {0: 1, 1: 1 - math.pi * .09, 2: math.pi * .04}
    for patch, want in kept.items():
        if not works(Run("info", name, "--svg", "domain.svg", "--patch", patch)):
            continue
        nodes = list(xml.etree.ElementTree.parse("domain.svg").iter())
        by_class = {c: [n for n in nodes if n.get("class") == c] for c in "oixc"}
        areas = {c: sum(area(n.get("points")) for n in by_class[c]) for c in "oix"}
        check(close([areas["o"]], [.5 if patch == 2 else 1]), f"svg of patch {patch}: domain {areas}")
        check(areas["i"] <= want + 1e-6 and areas["i"] + areas["x"] >= want - 1e-6, f"svg of patch {patch}: {areas}")
        check(areas["x"] < .02 * areas["o"], f"svg of patch {patch}: crossed {areas}")
        check(bool(by_class["c"]) == (patch > 0), f"svg of patch {patch}: {len(by_class['c'])} curves")
    refuses(Run("info", name, "--svg", "domain2.svg", "--patch", 3), 1, "there is no patch 3; the scene has 3")
    refuses(Run("info", name, "--svg", "missing/d.svg"), 1, "missing/d.svg: cannot write")
    refuses(Run("info", name, "--svg", "/dev/full"), 1, "/dev/full: cannot write")
    refuses(Run("info", name, "--svg", "-"), 2, "--svg needs the name of a file")


def test_verify_trims():
    """The kernels against the reference, where trims decide."""
    spline = {"nurbs": {"degree": 2, "knots": [0, 0, 0, 1, 2, 3, 3, 3],
                        "points": [[.7, .5], [.7, .8, 2], [.3, .8], [.3, .2, .5], [.7, .5]]}}
    trims = [HOLE, {"loops": [{"polygon": {"segments": [{"line": [[.1, .1], [.9, .1], [.5, .9]]}]}},
                              {"segments": [spline]}]},
             {"intersection": [{"polygon": {"segments": [spline], }}, {"square": {}, "transform": [.4, .1, -.1, .4, .3, .3]}]}]
    geometry = [dict(g, name=f"{g['name']}{i}", trim=t) for g in (SADDLE, TRIANGLE) for i, t in enumerate(trims)]
    r = Run("verify", write("trims.json", scene(*geometry)), "--rays", "1200", "--isa", "plain")
    rows = [line.split() for line in r.out.decode().splitlines()[1:]]
    check(works(r) and len(rows) == 20, f"{r}: {r.out.decode()}")
    check(all(int(row[4]) > 100 for row in rows), f"verify: too few hits in {rows}")


def odd_trims():
    """Regions that have a meaning, however odd."""
    def polygon(*segments):
        return {"polygon": {"segments": list(segments)}}

    def bezier(*points):
        return {"bezier": {"points": list(points)}}

    square = {"line": [[.2, .2], [.8, .2], [.8, .8], [.2, .8]]}
    yield polygon({"line": [[.2, .2], [.8, .2]]}, bezier([.8, .5], [.9, .9], [.5, .8]))
    yield polygon({"line": [[.2, .2], [.2, .2], [.8, .2]]}, bezier([.8, .2], [.8, .2], [.8, .2]), {"line": [[.2, .8], [.2, .8]]})
    yield {"loops": [polygon(square)] * 2}
    yield {"loops": [polygon(square)] * 3}
    yield {"difference": [polygon(square), {"square": {}, "transform": [.6, 0, 0, .6, .2, .2]}]}
    yield {"loops": [polygon(square), polygon({"line": [[.5, .2], [.9, .2], [.9, .6], [.5, .6]]})]}
    yield {"loops": [polygon(square), polygon({"line": [[.8, .4], [1, .5], [.8, .6]]})]}
    yield polygon({"line": [[.2, .2], [.8, .8], [.8, .2], [.2, .8]]})
    yield polygon(bezier([.1, .2], [1.2, 1.2], [-.2, 1.2], [.9, .2]))
    yield polygon(bezier([.1, .2], [.9, .8], [.1, .8], [.9, .2]))
    yield polygon(bezier([.2, .2, 1], [.8, .2, 1e-30], [.8, .8, 1e30], [.2, .8, 1]))
    yield polygon({"line": [[-3, -3], [4, -3], [4, 4], [-3, 4]]})
    yield polygon({"line": [[-1e100, -1e100], [1e100, -1e100], [1e100, 1e100], [-1e100, 1e100]]})
    yield polygon({"line": [[0, 0], [.5, 0], [.5, 1], [0, 1]]})
    yield polygon({"line": [[.1 + .002 * i, .1 if i % 2 else .9] for i in range(401)]})
    # and nothing at all
    yield polygon({"line": [[.2, .2], [.8, .8]]})
    yield polygon(bezier([.5, .5], [.5, .5], [.5, .5]))
    yield {"circle": {}, "transform": [0, 0, 0, 0, .5, .5]}
    yield {"circle": {}, "transform": [.1, 0, 0, .1, 5, 5]}


def polygon_from_afar():
    return {"polygon": {"segments": [{"line": [[.2, .2], [1e100, .3], [.2, .8]]}]}}


def test_odd_trims():
    geometry = [dict(g, name=f"{g['name']}{i}", trim=t) for i, t in enumerate(odd_trims()) for g in (SADDLE, TRIANGLE)]
    name = write("odd.json", scene(*geometry))
    r = Run("verify", name, "--rays", "4000", "--isa", "plain", "--width", "16")
    check(works(r), f"{r}: {r.out.decode()}")
    nothing = write("nothing.json", scene(geometry[-1]))
    for args in (("info", nothing), ("render", nothing, "-o", "nothing.png", "--size", "16x16")):
        works(Run(*args))
    check([h[0] for h in trace(nothing, [down(.2, .2)])] == [math.inf], "a patch that is trimmed away is hit")
    # where nothing can be told of a part, the patch is not divided in vain
    for kind in (SADDLE, TRIANGLE):
        r = Run("info", write("far.json", scene(dict(kind, trim=polygon_from_afar()))), "--json")
        if works(r):
            leaves = json.loads(r.out)["geometries"][0]["leaves"]
            check(leaves < 100, f"{leaves} leaves")


def test_bench_cages():
    """Of a cage Embree's grids and its own subdivision are measured, too, and are the same surface."""
    r = Run("bench", write("cage.json", scene(CUBE)), "--json", "--workloads", "primary1,random16", *BENCH)
    if works(r):
        b = json.loads(r.out)
        triangles = b["tessellation"]
        for form in ("grids", "subdivision"):
            check([s["n"] for s in b[form]] == [s["n"] for s in triangles], f"bench: {form} {b[form]}")
            for s, t in zip(b[form], triangles):
                for key in ("max_position_error", "max_normal_error_degrees"):
                    check(.5 < s[key] / t[key] < 2, f"bench: {form} have {key} {s[key]}, triangles {t[key]}")
                check(close([s["hits"][k] for k in s["hits"]], [t["hits"][k] for k in s["hits"]], .01),
                      f"bench: {form} have hits {s['hits']}, triangles {t['hits']}")
        check(triangles[0]["triangles"] == 6 * 2 * 64, f"bench: triangles of a cage {triangles[0]}")
    r = Run("bench", "cage.json", "--workloads", "primary1", *BENCH)
    for row in ("grids 16×16", "subdivision 16×16", "patches / grids 16×16", "patches / subdivision 16×16"):
        check(f"\n{row} " in r.out.decode(), f"bench: no row {row} in {r.out.decode()}")
    r = Run("bench", write("loop.json", scene(TETRAHEDRON)), "--json", "--workloads", "primary1", *BENCH)
    check(works(r) and "grids" not in json.loads(r.out), "bench: Embree knows no Loop subdivision")


def test_bench_trims():
    """Every way to trim is measured, and they agree about what is hit."""
    name = write("hole.json", scene(SADDLE, dict(SADDLE, name="hole", trim=HOLE)))
    ways = ["untrimmed", "filter_cells", "filter_strip_trees", "filter_clipping", "filter_clipping_left", "split_none",
            "split_cost", "split_regular", "split_curves"]
    r = Run("bench", name, "--trims", "--json", "--runs", "1", "--rays", "4096", "--workloads", "primary1,random16")
    if works(r):
        rows = json.loads(r.out)["geometries"]
        check([g["name"] for g in rows] == ["hole"], f"bench --trims: {rows}")
        got = {w["trimming"]: w for w in rows[0]["ways"]}
        check(list(got) == ways and all(x > 0 for w in got.values() for x in w["mrays"].values()), f"bench --trims: {got}")
        hits = {k: w["hits"]["primary1"] for k, w in got.items()}
        check(all(close([hits[k] / hits["untrimmed"]], [1 - math.pi * .09], .03) for k in ways[1:]),
              f"bench --trims: hits {hits}")
        check(max(hits[k] for k in ways[1:]) - min(hits[k] for k in ways[1:]) < .001, f"bench --trims: hits {hits}")
        crossed = {k: w["crossed"] for k, w in got.items()}
        check(crossed["split_curves"] < .02 < crossed["split_none"] < crossed["filter_cells"] == 1, f"crossed {crossed}")
    r = Run("bench", name, "--trims", "--table", "--trim-tests", "strips", *BENCH)
    check(works(r) and "| test all, strip trees |" in re.sub(" +", " ", r.out.decode()) and b"clipping" not in r.out,
          f"bench --trims --table: {r.out.decode()}")
    r = Run("bench", "--trim-costs", "--json", *BENCH)
    if works(r):
        b = json.loads(r.out)
        check(all(b["ns"][k] > 0 for k in ("strip", "straight", "curved")) and len(b["objects"]) == 12 and
              all(x > 0 for o in b["objects"] for x in o["ns"].values()), f"bench --trim-costs: {b}")
    r = Run("bench", "--trim-curves", "--json", "--trim-tests", "cells", *BENCH)
    if works(r):
        b = json.loads(r.out)["trim_curves"]
        check([row["curves"] for row in b["contour"]] == [10, 100, 1000, 10000], f"bench --trim-curves: {b}")
        check(all([w["trimming"] for w in row["ways"]] == ["untrimmed", "filter_cells", "split_curves"]
                  for rows in b.values() for row in rows), f"bench --trim-curves: {b}")
    refuses(Run("bench", write("plain.json", scene(SADDLE)), "--trims", "--json", *BENCH), 1, "nothing in it is trimmed")
    refuses(Run("bench", name, "--trims", "--trim-costs", *BENCH), 2, "hole.json' is too much")
    refuses(Run("bench", "--trim-curves", "--trim-costs", *BENCH), 2, "exclude each other")
    refuses(Run("bench", name, "--trims", "--stats", "s", *BENCH), 2, "go with none of")
    refuses(Run("bench", name, "--trims", "--trim-tests", "guess", *BENCH), 2, "--trim-tests has 'guess'")


def cad_sphere(x, y):
    """The faces that a ray down meets first, as (height, face, normal), in the order of parts.step."""
    r2 = x * x + y * y
    return (5 + math.sqrt(25 - r2), 7, (x, y, math.sqrt(25 - r2))) if r2 < 25 else None


def cad_cone(x, y):
    r = math.hypot(x, y)
    if r > 6:
        return None
    return (10, 9, (0, 0, 1)) if r < 2 else (2.5 * (6 - r), 8, (x / r, y / r, .4))


def cad_torus(x, y):
    r = math.hypot(x, y)
    if not 4 < r < 8:
        return None
    z = math.sqrt(4 - (r - 6) ** 2)
    return 2 + z, 11, ((r - 6) * x / r, (r - 6) * y / r, z)


def cad_plate(x, y):
    return (10, 2, (0, 0, 1)) if abs(x) < 20 and abs(y) < 15 and math.hypot(x, y) > 6 else None


def cad_segment(x, y):
    return (10, 16, (0, 0, 1)) if x > 3 and math.hypot(x, y) < 6 else None


def parallel(a, b, tolerance=1e-5):
    """Up to the sign."""
    dot = sum(x * y for x, y in zip(a, b))
    return dot * dot >= (1 - tolerance ** 2) * sum(x * x for x in a) * sum(x * x for x in b)


def cad_ray_is_right(hit, t, face, normal):
    if t is None:
        return hit[3:5] == (MISS, MISS)
    return hit[3:5] == (0, face) and abs(hit[0] - t) < 1e-4 and parallel(hit[5:], normal, 1e-3)


def test_cad():
    """Faces of a STEP file: where they are, against formulas, their numbers and their trims."""
    parts = os.path.join(CAD, "parts.step")
    rays, expected = [], []
    for centre, part in ((20, cad_plate), (60, cad_sphere), (80, cad_cone), (100, cad_torus), (120, cad_segment)):
        for i in range(61):
            for j in range(61):
                x, y = .7 * (i - 30) + .0123, .7 * (j - 30) + .0321
                if abs(x) < 10 or part == cad_plate and x < 19:
                    rays.append(down(centre + x, 15 + y, 20))
                    expected.append(part(x, y))
    for k in range(64):  # the walls, from inside and from outside
        c, s = math.cos(.1 * k + .05), math.sin(.1 * k + .05)
        rays.append((20, 15, 5, 0, c, s, .1, math.inf))
        expected.append((6, 6, (c, s, 0)))
        if c > .51:
            rays.append((120 + 9 * c, 15 + 9 * s, 5, 0, -c, -s, 0, math.inf))
            expected.append((3, 12 if s < 0 else 13, (c, s, 0)))
    hits, wrong = trace(parts, rays), []
    for ray, hit, e in zip(rays, hits, expected):
        t, face, normal = e or (None, None, None)
        if not cad_ray_is_right(hit, 20 - t if t and ray[2] == 20 else t, face, normal):
            wrong.append((ray, hit, e))
    check(hits and not wrong, f"parts.step: {len(wrong)} rays are wrong: {wrong[:3]}")
    for h in trace(parts, [(20, 15, 5, 0, math.cos(a), math.sin(a), 0, math.inf) for a in (.7, 1.5, 3.9)]):
        check(5 < h[2] + 5 < 15 and h[1] > 0, f"parameters of the wall: {h}")
    r = Run("info", parts, "--json")
    check(works(r) and json.loads(r.out)["geometries"][0]["patches"] == 45, f"{r}: {r.out[:300]}")
    works(Run("verify", parts, "--rays", "2000", "--isa", "plain", "--width", "16"))
    for as_ in ("patches", "triangles:64"):  # a file in a scene
        name = write("scene.json", scene({"type": "file", "path": parts}))
        h = trace(name, [down(60, 15, 20)], "--as", as_)
        check(h and h[0][4] == 7 and abs(h[0][0] - 10) < .01, f"a sphere in a scene, {as_}: {h}")


def test_cad_kinds():
    """A BREP file with one solid in two places and a face that is left out, and a trimmed saddle from an IGES file."""
    twice = os.path.join(CAD, "twice.brep")
    left_out = f"epatch: {twice}: face 0 is left out: it has no end\n"
    write("rays", pack_rays([(3, 3, 1, 0, 1, 1, 0, math.inf), down(1, 1, 9), (1, 1, -9, 0, 0, 0, 1, math.inf),
                             (1, -1, 1, 0, 0, 1, 0, math.inf), (-1, 1, 1, 0, 1, 0, 0, math.inf),
                             (23, -3, 3, 0, 1, 0, 1, math.inf), (21, -9, 1, 0, 0, 1, 0, math.inf),
                             (21, 1, 1, 0, 0, -1, 0, math.inf), (21, -1, -1, 0, 0, 0, 1, math.inf),
                             (19, -1, 1, 0, 1, 0, 0, math.inf)]))
    r = Run("trace", twice, "--rays", "rays", "--hits", "hits")
    check(r.status == 0 and r.err == left_out, f"{r}")
    with open("hits", "rb") as f:
        hits = list(struct.iter_unpack("<3f2I3f", f.read()))
    check([h[4] for h in hits] == list(range(1, 11)), f"twice.brep: faces {[h[4] for h in hits]}")
    wall = math.sqrt(12.5) - 3
    check(close([h[0] for h in hits], [wall, 1, 9, 1, 1, wall, 1, 1, 1, 1]), f"twice.brep: {[h[0] for h in hits]}")

    saddle = os.path.join(CAD, "saddle.iges")
    rays = [down(.3 + .37 * i, .2 + .39 * j, 20) for i in range(27) for j in range(26)]
    hits, wrong = trace(saddle, rays), []
    for (x, y, *_), h in zip(rays, hits):
        kept = x < 10 and math.hypot(x - 5, y - 5) > 3
        if not cad_ray_is_right(h, 20 - x * y / 10 if kept else None, 0, (-y, -x, 10)) or kept and not close(h[1:3], (x, y)):
            wrong.append((x, y, h))
    check(hits and not wrong, f"saddle.iges: {len(wrong)} rays are wrong: {wrong[:3]}")


def test_cad_gaps():
    """Solids whose faces end short of their edges: no ray from inside leaves between them."""
    gaps, spread = os.path.join(CAD, "gaps.brep"), random.Random(71)
    rays = []

    def aim(middle, at):
        start = [m + spread.uniform(-1, 1) for m in middle]
        rays.append((*start, 0, *(a + spread.uniform(-.004, .004) - s for a, s in zip(at, start)), math.inf))

    size = (10, 8, 6)
    for x in (0, 30):
        for axis, high in itertools.product(range(3), itertools.product((0, 1), repeat=3)):
            for _ in range(50):
                at = [s * (spread.random() if k == axis else h) for k, (s, h) in enumerate(zip(size, high))]
                aim((x + 5, 4, 3), (x + at[0], *at[1:]))
    for k in range(1000):
        aim((20, 4, 3), (20 + 3 * math.cos(.1 * k), 4 + 3 * math.sin(.1 * k), 6 * (k & 1)))
    hits = trace(gaps, rays)
    lost = [r for r, h in zip(rays, hits) if not h[0] < 1.1]
    check(hits and not lost, f"gaps.brep: {len(lost)} of {len(rays)} rays leave: {lost[:3]}")
    # a little farther out there is nothing
    outside = [down(-.01, 4, 9), down(5, 8.01, 9), down(40.01, 4, 9), down(35, -.01, 9), down(23.01, 4, 9)]
    check(all(h[3] == MISS for h in trace(gaps, outside)), "gaps.brep: faces reach too far")
    # exactly through the apex, which the twelve digits of the file leave open
    rays = [(x, y, z, 0, -x, -y, 9 - z, math.inf) for x in (-1.5, -.25, .5, 1) for y in (-1, 0, .75) for z in (1, 2.5)]
    lost = [r for r, h in zip(rays, trace(os.path.join(CAD, "cone.step"), rays)) if not abs(h[0] - 1) < 1e-6]
    check(not lost, f"cone.step: {len(lost)} of {len(rays)} rays leave through the apex: {lost[:3]}")


def test_cad_narrow():
    """What is narrower than the gap at its edges does not open; and offset surfaces, of which there is no more than what
    the file has."""
    slit = [(s, s) for s in (2.4, 3.1, 3.7, 4.4)]
    check(all(h[3] == 0 for h in trace(os.path.join(CAD, "slit.brep"), [down(x, y, 3) for x, y in slit])), "the slit is open")
    hits = trace(os.path.join(CAD, "comb.brep"), [down(.001 * i, 1, 3) for i in range(-100, 101)])
    notch = [i for i, h in enumerate(hits, -100) if h[3] == MISS]
    check(notch and max(map(abs, notch)) <= 5, f"the notch goes to {notch}")
    spread = random.Random(72)
    rays = [(0, 0, 3, 0, *(spread.gauss(0, 1) for _ in range(3)), math.inf) for _ in range(1000)]
    check(all(h[3] == 0 for h in trace(os.path.join(CAD, "shell.brep"), rays)), "shell.brep is open")


def test_bad_cad():
    for name in ("empty.step", "empty.iges", "empty.brep", "words.step", "words.igs", "words.brep"):
        refuses(Run("info", write(name, "" if "empty" in name else "some words\n" * 9)), 1,
                rf"{name}: this is no (STEP|IGES|BREP) file")
        refuses(Run("info", "missing" + name), 1, "cannot open: No such file")
    for name in ("parts.step", "twice.brep", "saddle.iges"):
        with open(os.path.join(CAD, name), "rb") as f:
            whole = f.read()
        for part in (.2, .5, .9):
            refuses(Run("info", write(name, whole[:int(part * len(whole))])), 1,
                    "ends too early" if name == "saddle.iges" else "the file is damaged")
        # whatever else is wrong: no crash, and nothing but messages
        for i in range(8):
            at = len(whole) * (i + 1) // 10
            r = Run("info", write(name, whole[:at] + whole[at + 50 + 13 * i:]))
            check(r.status in (0, 1) and all(line.startswith("epatch: ") for line in r.err.splitlines()) and
                  (r.status == 0 or not r.out), f"{name}, damaged at {at}: {r}")


def run_test(name):
    """How many checks passed and failed, and what was printed."""
    global passed, failed
    passed = failed = 0
    printed = io.StringIO()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(printed):
        os.chdir(folder)
        try:
            globals()[name]()
        except Exception:
            check(False, f"{name}: {traceback.format_exc()}")
        leftovers = [f for f in os.listdir(".") if re.match(r"\.\d+\.", f)]
        check(not leftovers, f"{name}: temporary files left: {leftovers}")
        os.chdir("/")
    return passed, failed, printed.getvalue()


def main():
    tests = sys.argv[2:] or [name for name in globals() if name.startswith("test_")]
    passed, failed = 0, 0
    with multiprocessing.get_context("fork").Pool() as pool:
        for p, f, printed in pool.imap(run_test, tests, chunksize=1):
            print(printed, end="", flush=True)
            passed, failed = passed + p, failed + f
    print(f"test_cli: {passed} passed, {failed} failed")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
