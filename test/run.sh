#!/bin/sh
# test/run.sh - installs what is missing, builds, runs every test and ends with a line `N passed, N failed`.
#
# SPDX-License-Identifier: Apache-2.0
#
#   sh test/run.sh                      the release build with the default compiler
#   sh test/run.sh gcc|clang|asan ...   these configurations
#
# Each configuration has a build directory of its own (build, build-clang, build-asan), so running again is quick.
set -u
cd "$(dirname "$0")/.." || exit 1
. tools/setup.sh

[ $# -gt 0 ] || set -- gcc
for configuration; do
    case $configuration in
    gcc | clang | asan) ;;
    *)
        echo "test/run.sh: there is no configuration '$configuration'; there are gcc, clang and asan" >&2
        exit 2
        ;;
    esac
done
case " $* " in
*" clang "*) setup_packages cmake "clang:clang libomp-dev" ;;
*) setup_packages cmake ;;
esac || {
    echo "0 passed, 1 failed"
    exit 1
}

built= # directories
broken=0
for configuration; do
    case $configuration in
    gcc) setup_build build ;;
    clang) CC=clang CXX=clang++ setup_build build-clang ;;
    asan) # at -O2, gcc 12's check of object sizes changes the floats that leaf.c computes; clang's does not
        setup_build build-asan -Db_sanitize=address,undefined -Db_lundef=false -Dbuildtype=debug -Doptimization=1
        ;;
    esac && built="$built $directory" || broken=$((broken + 1))
done
# shellcheck disable=SC2086 # words are wanted
exec python3 test/run_tests.py --broken-builds "$broken" $built
