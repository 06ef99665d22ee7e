#!/usr/bin/env python3
"""Runs the tests of build directories, as many at once as there are processors, and adds up what passed.

SPDX-License-Identifier: Apache-2.0

usage: run_tests.py [--broken-builds N] DIRECTORY...

A program that counts its own checks says so, in cmocka's words or by a line `... N passed, N failed`; one that does
not counts as one. A program that dies or does not end has failed at least once, whatever it said before. The last line
is `N passed, N failed`; a build that broke counts as one failure.
"""
import argparse
import concurrent.futures
import json
import os
import re
import signal
import subprocess
import sys
import time

# Leaks: OpenImageIO and Embree keep memory of their own until the process ends. What was never written, or is freed,
# is no zero by luck (glibc).
ENVIRONMENT = dict(os.environ, ASAN_OPTIONS="detect_leaks=0", UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1",
                   MALLOC_PERTURB_="85")


def tests_of(directory):
    listed = subprocess.run(["meson", "introspect", "--tests", directory], check=True, capture_output=True)
    return [dict(test, directory=directory) for test in json.loads(listed.stdout)]


def count(output):
    """Checks that passed and failed by the program's own account."""
    passed = len(re.findall(r"^\[       OK \]", output, re.M))
    failed = len(set(re.findall(r"^\[  FAILED  \] (?!\d+ test)(.*)", output, re.M)))
    for match in re.finditer(r"(\d+) passed, (\d+) failed$", output, re.M):
        passed, failed = passed + int(match[1]), failed + int(match[2])
    return passed, failed


def how_it_ended(status):
    return f"ended with status {status}" if status > 0 else f"was killed by {signal.Signals(-status).name}"


def run(test):
    """Passed, failed, and what there is to say."""
    start = time.monotonic()
    try:
        p = subprocess.run(test["cmd"], env=dict(ENVIRONMENT, **test["env"]), cwd=test["workdir"] or test["directory"],
                           text=True, errors="replace", stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                           stderr=subprocess.STDOUT, timeout=test["timeout"])
        output, verdict = p.stdout, p.returncode and how_it_ended(p.returncode)
    except subprocess.TimeoutExpired as e:
        output, verdict = (e.stdout or b"").decode(errors="replace"), f"did not end within {test['timeout']} seconds"
    passed, failed = count(output)
    if verdict and not failed:
        failed = 1
    if not passed and not failed:
        passed = 1
    text = "%-40s %6.1f s %6d passed, %d failed" % (f"{test['directory']}: {test['name']}", time.monotonic() - start,
                                                    passed, failed)
    if failed:
        text = f"{output.rstrip()}\n{test['name']} {verdict or 'has failed'}\n{text}"
    return passed, failed, text


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--broken-builds", type=int, default=0)
    parser.add_argument("directories", nargs="*")
    arguments = parser.parse_args()
    tests = [test for directory in arguments.directories for test in tests_of(directory)]
    tests.sort(key=lambda test: -test["priority"])
    passed, failed = 0, arguments.broken_builds
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for p, f, text in pool.map(run, tests):
            print(text, flush=True)
            passed, failed = passed + p, failed + f
    print(f"{passed} passed, {failed} failed")
    return failed > 0 or passed == 0


if __name__ == "__main__":
    sys.exit(main())
