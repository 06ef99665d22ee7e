#!/usr/bin/env python3
"""Installs a build into an empty folder and builds test/consumer/ against it, as other programs would: by pkg-config
and by CMake.

SPDX-License-Identifier: Apache-2.0

usage: test_install.py BUILD PREFIX
"""
import os
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
CONSUMER = os.path.join(ROOT, "test", "consumer")
SAYS = {"dome": r"^t 1\.75 at u 0\.5 v 0\.5$", "probe": r"^version (\S+) radius2 0\.562500$"}
passed = failed = 0


def check(ok, message):
    global passed, failed
    if ok:
        passed += 1
    else:
        failed += 1
        print("FAIL", message, flush=True)
    return ok


def run(*command, **more):
    """What a program prints; None after a message when it fails."""
    p = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                       env=dict(os.environ, **more))
    if not check(p.returncode == 0, f"{shlex.join(command)}: status {p.returncode}\n{p.stdout}"):
        return None
    return p.stdout


def find(folder, name):
    for where, folders, files in os.walk(folder):
        if name in folders or name in files:
            return os.path.join(where, name)
    check(False, f"{name} is not installed")
    return None


def check_example():
    """The program of the README is the one that is built here."""
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as f:
        shown = re.search(r"^```c\n(.*?)^```", f.read(), re.M | re.S)
    with open(os.path.join(CONSUMER, "dome.c"), encoding="utf-8") as f:
        check(shown and shown[1] == f.read(), "the C program of README.md is not test/consumer/dome.c")


def check_symbols(library):
    listed = run("nm", "-D", "--defined-only", "--format=posix", library)
    names = [line.split()[0].split("@")[0] for line in (listed or "").splitlines()]
    check("epNewGeometry" in names, f"{library} has no epNewGeometry")
    strangers = [name for name in names if not re.match(r"ep[A-Z]", name)]
    check(not strangers, f"{library} shows {strangers}")


def check_programs(folder, libraries, version):
    for name, pattern in SAYS.items():
        said = run(os.path.join(folder, name), LD_LIBRARY_PATH=libraries)
        match = re.search(pattern, (said or "").strip())
        check(match, f"{name} says {said!r}")
        if match and match.groups():
            check(match[1] == version, f"the header is of version {match[1]}, embree_patch.pc of {version}")


def main():
    build, prefix = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        if run("meson", "install", "-C", build, "--no-rebuild", "--quiet", "--destdir", folder) is None:
            return 1
        prefix = folder + prefix
        library, pc = find(prefix, "libembree_patch.so"), find(prefix, "embree_patch.pc")
        find(os.path.join(prefix, "include", "embree_patch"), "embree_patch.h")
        if not library or not pc:
            return 1
        libraries = os.path.dirname(library)
        check_example()
        check_symbols(library)
        picture = os.path.join(folder, "teapot.png")
        if run(os.path.join(prefix, "bin", "epatch"), "render", os.path.join(ROOT, "data", "teapot.bpt"), "-o", picture,
               "--size", "32x18", "--spp", "1") is not None:
            check(os.path.getsize(picture) > 100, "the installed epatch renders nothing")

        os.environ["PKG_CONFIG_PATH"] = os.path.dirname(pc)
        flags = shlex.split(run("pkg-config", f"--define-variable=prefix={prefix}", "--cflags", "--libs",
                                "embree_patch") or "")
        version = (run("pkg-config", "--modversion", "embree_patch") or "").strip()
        strict = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]
        run("cc", "-std=c17", *strict, os.path.join(CONSUMER, "dome.c"), "-o", os.path.join(folder, "dome"), *flags)
        run("c++", "-std=c++17", *strict, os.path.join(CONSUMER, "probe.cpp"), "-o", os.path.join(folder, "probe"),
            *flags)
        check_programs(folder, libraries, version)

        made = os.path.join(folder, "cmake")
        if run("cmake", "-S", CONSUMER, "-B", made, f"-DCMAKE_PREFIX_PATH={prefix}") is not None:
            run("cmake", "--build", made)
            check_programs(made, libraries, version)
    print(f"test_install: {passed} passed, {failed} failed")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
