#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Converts a block-structured hexahedral mesh to B-spline volumes; installs and builds what is missing before.
#
#   ./convert.sh                       a generated demonstration mesh
#   ./convert.sh [options] mesh.xyz    your own: PLOT3D (with a neutral map file .nmf beside it, if any) or CGNS
#   ./convert.sh --help                all options
set -eu

root=$(cd "$(dirname "$0")" && pwd)
"$root/CMake/install-packages.sh"
if [ ! -e "$root/build/CMakeCache.txt" ]; then
  cmake -S "$root" -B "$root/build" -G Ninja -DBUILD_TESTING=OFF
fi
cmake --build "$root/build"

exec python3 "$root/Filters/Python/display.py" pvpython "$root/Examples/convert.py" "$@"
