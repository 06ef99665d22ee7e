#!/bin/sh
# demo.sh - from a bare Debian to a picture: installs what is missing, builds, renders the teapot. The last line names
# the image.
#
# SPDX-License-Identifier: Apache-2.0
set -eu
cd "$(dirname "$0")/.."
. tools/setup.sh

setup_packages
setup_build build
build/tools/epatch render data/teapot.bpt -o build/teapot.png
echo "$PWD/build/teapot.png"
