#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Converts a block-structured hexahedral mesh to B-spline volumes; installs and builds what is missing before. The rest is
# the command bsplinevolume, here with the folder output/ for its files.
#
#   ./convert.sh                       a generated demonstration mesh
#   ./convert.sh [options] mesh.xyz    your own: PLOT3D (with a neutral map file .nmf beside it, if any), CGNS, VTK, Exodus
#   ./convert.sh --help                all options
set -eu

root=$(cd "$(dirname "$0")" && pwd)
"$root/CMake/install-packages.sh"
if [ ! -e "$root/build/CMakeCache.txt" ]; then
  cmake -S "$root" -B "$root/build" -G Ninja -DBUILD_TESTING=OFF
fi
cmake --build "$root/build"

if [ $# -eq 0 ]; then
  set -- "$(python3 "$root/Examples/make_demo_mesh.py" output)" --crease-angle 30
fi
exec "$root/build/bin/bsplinevolume" convert --output output/ "$@"
