# setup.sh - sourced by tools/demo.sh and test/run.sh with the repository as working directory: installs what is
# missing on Debian 12 or 13 and builds. Without dpkg nothing is installed, and meson says what it misses.
#
# SPDX-License-Identifier: Apache-2.0

say() { printf '%s\n' "$*" >&2; }

# Prints the packages that this machine lacks; an argument is PROGRAM, or PROGRAM:PACKAGES where the names differ.
setup_missing() {
    for pair in meson:meson ninja:ninja-build gcc:gcc g++:g++ pkg-config:pkg-config python3:python3 "$@"; do
        command -v "${pair%%:*}" > /dev/null || echo "${pair#*:}"
    done
    for package in libembree-dev libopenimageio-dev libjansson-dev libosd-dev libocct-data-exchange-dev libcmocka-dev; do
        dpkg -s "$package" 2> /dev/null | grep -q '^Status: install ok installed' || echo "$package"
    done
}

# setup_packages [PROGRAM[:PACKAGES]...]: installs what is missing of the usual packages and these.
setup_packages() {
    command -v dpkg > /dev/null || return 0
    missing=$(setup_missing "$@" | tr '\n' ' ')
    [ -n "$missing" ] || return 0

    root=
    if [ "$(id -u)" != 0 ]; then
        command -v sudo > /dev/null || {
            say "Missing packages. As root: apt-get install $missing"
            return 1
        }
        root=sudo
    fi
    say "Installing $missing"
    # shellcheck disable=SC2086 # words are wanted
    $root env DEBIAN_FRONTEND=noninteractive sh -c '
        apt-get -q update && apt-get -q -y --no-install-recommends install "$@"' sh $missing >&2
}

# setup_build DIRECTORY [meson option...]: configures once, then builds what has changed. Quiet unless it fails.
setup_build() {
    directory=$1
    shift
    log=$directory/setup.log
    mkdir -p "$directory"
    [ -f "$directory/build.ninja" ] || {
        say "Configuring $directory"
        meson setup "$directory" "$@" > "$log" 2>&1 || { cat "$log" >&2; return 1; }
    }
    ninja -C "$directory" -n | grep -q 'no work to do' || say "Building $directory"
    ninja -C "$directory" > "$log" 2>&1 || { cat "$log" >&2; return 1; }
}
