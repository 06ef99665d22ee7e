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
setup_packages || exit 1

passed=0
failed=0

# The lines of cmocka say how each test of a program ended; a program that dies says less, and counts as one failure.
run_program() {
    log=$1.log
    "$1" > "$log" 2>&1
    status=$?
    ok=$(grep -c '^\[       OK \]' "$log")
    bad=$(grep '^\[  FAILED  \]' "$log" | sort -u | grep -vc 'test(s)')
    [ "$status" -eq 0 ] || [ "$bad" -gt 0 ] || bad=1
    [ "$bad" -eq 0 ] || cat "$log"
    printf '%-40s %4d passed, %d failed\n' "$1" "$ok" "$bad"
    passed=$((passed + ok))
    failed=$((failed + bad))
}

run_cli() {
    log=$1/test_cli.log
    python3 test/test_cli.py "$1/tools/epatch" > "$log" 2>&1
    set -- "$1" $(sed -n 's/^test_cli: \([0-9]*\) passed, \([0-9]*\) failed$/\1 \2/p' "$log" | tail -n 1)
    [ "${3:-1}" -eq 0 ] || cat "$log"
    printf '%-40s %4d passed, %d failed\n' "$1/test_cli" "${2:-0}" "${3:-1}"
    passed=$((passed + ${2:-0}))
    failed=$((failed + ${3:-1}))
}

run_models() {
    if python3 data/make_models.py --check > "$1/models.log" 2>&1; then passed=$((passed + 1))
    else
        cat "$1/models.log"
        failed=$((failed + 1))
    fi
}

build() {
    setup_build "$@" && return 0
    failed=$((failed + 1))
    return 1
}

for configuration in ${*:-gcc}; do
    case $configuration in
    gcc) directory=build; build build || continue ;;
    clang)
        command -v clang > /dev/null || { echo "no clang: its build is left out"; continue; }
        directory=build-clang
        CC=clang CXX=clang++ build build-clang || continue
        ;;
    asan)
        directory=build-asan
        build build-asan -Db_sanitize=address,undefined -Dbuildtype=debugoptimized -Db_lundef=false || continue
        ;;
    *) echo "test/run.sh: there is no configuration '$configuration'"; exit 2 ;;
    esac
    # OpenImageIO and Embree keep memory of their own until the process ends
    export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1
    for program in "$directory"/test/test_*; do
        [ -f "$program" ] && [ -x "$program" ] && run_program "$program"
    done
    [ "$configuration" = clang ] && continue
    run_cli "$directory"
    [ "$configuration" = gcc ] && run_models "$directory"
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
