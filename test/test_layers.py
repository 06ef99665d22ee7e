#!/usr/bin/env python3
"""A file includes only its own layer and lower ones. The layers are the rows of the table in embree_patch/README.md,
lowest first.

SPDX-License-Identifier: Apache-2.0
"""
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def read(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as f:
        return f.read()


def stem(name):
    """`bezier`, `bezier.c` and `bezier.h` are one thing."""
    return os.path.splitext(name)[0]


def layers():
    """File or folder in embree_patch/ -> its row."""
    rows = re.findall(r"^\| (?!layer|---)[^|]*\|([^|]*)\|", read("embree_patch", "README.md"), re.M)
    return {stem(name): row for row, names in enumerate(rows) for name in re.findall(r"`([^`]*)`", names)}


def layer_of(path, rows):
    """The row of a path in embree_patch/, or None."""
    name = path.split("/", 1)[1]
    return rows.get(name.split("/")[0] + "/", rows.get(stem(name)))


def sources(folder):
    for where, _, names in os.walk(os.path.join(ROOT, folder)):
        for name in sorted(names):
            if name.endswith((".c", ".h", ".cpp")):
                yield os.path.relpath(os.path.join(where, name), ROOT)


def problems(path, rows):
    """What is wrong with the includes of one file."""
    own = path.split("/")[0]
    for name in re.findall(r'^[ \t]*#[ \t]*include[ \t]+["<]([^">]+)[">]', read(path), re.M):
        folder = name.split("/")[0]
        if folder in ("embree3", "embree4"):
            if path != "embree_patch/rtc/rtc_compat.h":
                yield f"includes {name}: only rtc_compat.h knows which Embree there is"
        elif own in ("embree_patch", "trim") and folder in ("tools", "test", "jansson.h", "OpenImageIO"):
            yield f"includes {name}, which is of the rim"
        elif own == "embree_patch" and folder == "trim" and layer_of(path, rows) <= rows["patch"]:
            yield f"includes {name}: surfaces know no trims"
        elif own == "trim" and folder == "embree_patch" and layer_of(name, rows) > rows["base"]:
            yield f"includes {name}: trims know the base and nothing else"
        elif own == folder == "embree_patch":
            if layer_of(name, rows) is None:
                yield f"includes {name}, which is in no layer"
            elif layer_of(name, rows) > layer_of(path, rows):
                yield f"includes {name}, which is of a higher layer"


def main():
    rows = layers()
    wrong = []
    for folder in ("embree_patch", "trim", "tools"):
        for path in sources(folder):
            if folder == "embree_patch" and layer_of(path, rows) is None:
                wrong.append(f"{path} is in no layer of embree_patch/README.md")
            else:
                wrong += [f"{path} {problem}" for problem in problems(path, rows)]
    for line in wrong:
        print(line)
    return len(wrong) > 0


if __name__ == "__main__":
    sys.exit(main())
