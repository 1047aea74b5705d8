#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Builds the modules against the VTK of another release, without ParaView, Qt and OpenCASCADE, in a bare Debian, and runs the test of
# such a build and what docs/python.md says of PyVista. Needs root and debootstrap.
#
#   Testing/Platforms/run_vtk.sh RELEASE [FOLDER]
#
# RELEASE, FOLDER and variables are those of run.sh; ParaView's packages exclude VTK's, so the folder is another one (default:
# build/platforms/RELEASE-vtk). All output is in FOLDER/vtk.log, a picture by PyVista in FOLDER/pyvista.png.
set -eu

source=$(cd "$(dirname "$0")/../.." && pwd)
release=${1:?"usage: $0 RELEASE [FOLDER]"}
folder=${2:-$source/build/platforms/$release-vtk}

. "$source/Testing/Platforms/root.sh"
make_root "$release" "$folder"
rm -rf "$folder/BSplineVolume"
mkdir "$folder/BSplineVolume"
git -C "$source" archive HEAD | tar -x -C "$folder/BSplineVolume"

status=0
inside "$folder" /BSplineVolume sh -eux -c '
  CMake/install-packages.sh debian-packages-vtk.txt
  cmake -S . -B build -G Ninja -DBUILD_TESTING=OFF
  cmake --build build
  modules=/BSplineVolume/build/lib/BSplineVolume
  export PYTHONPATH=$modules:/BSplineVolume/Examples
  python3 Testing/Python/TestWithoutParaView.py $modules
  python3 Filters/Python/display.py python3 -c "
import bsplinevolume, make_demo_mesh, pyvista
volume = bsplinevolume.convert(make_demo_mesh.write_demo(\"/tmp\", 4))
blocks = pyvista.wrap(volume.to_multiblock(level=1))
assert isinstance(blocks, pyvista.MultiBlock) and blocks.n_blocks == len(volume.blocks)
plotter = pyvista.Plotter(off_screen=True)
plotter.add_mesh(blocks, show_edges=True)
plotter.screenshot(\"/pyvista.png\")"
' >"$folder/vtk.log" 2>&1 || status=$?

echo "== $release, VTK alone: end"
tail -n 5 "$folder/vtk.log"
echo "compiler warnings: $(grep -c 'warning:' "$folder/vtk.log" || true)"
exit $status
