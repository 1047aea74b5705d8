# SPDX-License-Identifier: BSD-3-Clause
"""Converts a block-structured hexahedral mesh to smooth tricubic B-spline volumes.

Sample runs (drawing needs a display; without one, put xvfb-run -a in front):
    pvpython Examples/convert.py                                   a generated demonstration mesh
    pvpython Examples/convert.py wing.xyz --body WALL --level 2    your own: PLOT3D (with .nmf beside it) or CGNS
    pvpython Examples/convert.py --help

Steps:
  1. load the plugin, read the mesh, convert it and sample the volumes;
  2. write control nets before and after (.vtpc), samples (.vtpc) and the multi-block topology (.qfmb);
  3. draw the control nets before and after side by side;
  4. say what was done to each block and how to open it all in ParaView.
"""
import os
import sys

import numpy as np
from paraview import simple as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

import before_after
import example_support
import make_demo_mesh
from example_support import data, grids, size, strings


def parse_arguments():
    parser = example_support.parser(__doc__.split("\n")[0], mesh=False)
    parser.add_argument("mesh", nargs="?", help="mesh file; without it, a demonstration mesh is generated")
    parser.add_argument("--output", default="output", metavar="FOLDER", help="where the results go (default: output)")
    parser.add_argument("--level", type=int, default=2, help="samples: every span is cut into 2^LEVEL (default: 2)")
    parser.add_argument("--body", metavar="NAMES",
                        help="boundaries that are the body, comma-separated, * and ? as usual (default: walls)")
    parser.add_argument("--crease-angle", type=float, metavar="DEGREES",
                        help="boundary edges where the surface turns by more stay sharp (default: only tagged ones)")
    return parser.parse_args()


# ---------------------------------------------------------------------------------------------- report
def report(before, after):
    """One line a block: where it comes from, its size and how its control points were made."""
    names = [name for name, _ in grids(before)]
    rule_names = strings(after.GetFieldData(), "ControlPointRuleNames")
    for name, grid in grids(after):
        cells = "x".join(str(n - 3) for n in size(grid))
        net = "x".join(str(n) for n in size(grid))
        parent = grid.GetFieldData().GetArray("ParentBlock").GetValue(0)
        origin = "" if names[parent] == name else " of " + names[parent]
        counts = np.bincount(vtk_to_numpy(grid.GetPointData().GetArray("ControlPointRule")), minlength=len(rule_names))
        rules = ", ".join("%d %s" % (count, rule) for rule, count in zip(rule_names, counts) if count)
        print("  %s%s: %s cells -> %s control points: %s" % (name, origin, cells, net, rules))


# ---------------------------------------------------------------------------------------------- main
def main():
    arguments = parse_arguments()
    folder = os.path.abspath(arguments.output)
    mesh_file = arguments.mesh
    if mesh_file is None:
        mesh_file = make_demo_mesh.write_demo(os.path.join(folder, "demo"))
        if arguments.crease_angle is None:
            arguments.crease_angle = 30.0
    case = os.path.splitext(os.path.basename(mesh_file))[0]
    folder = os.path.join(folder, case)
    os.makedirs(folder, exist_ok=True)

    # 1. read, convert, sample
    example_support.load_plugin(arguments.plugin)
    mesh = pv.HexBlockMeshReader(FileName=os.path.abspath(mesh_file))
    volume = example_support.convert(mesh, arguments)
    samples = pv.BSplineVolumeSampler(Input=volume, Level=arguments.level)

    # 2. write
    files = []
    for name, source in (("control_net_before.vtpc", mesh), ("control_net_after.vtpc", volume),
                         ("samples.vtpc", samples), (case + ".qfmb", volume)):
        files.append(os.path.join(folder, name))
        if os.path.exists(files[-1]):
            os.remove(files[-1])
        pv.SaveData(files[-1], proxy=source)
        if not os.path.exists(files[-1]):
            sys.exit("%s was not written; the reason is above" % files[-1])

    # 3. draw
    files.append(os.path.join(folder, "before_after.png"))
    before_after.picture(mesh, volume, list(volume.BodyBoundaries), list(volume.SymmetryBoundaries), files[-1])

    # 4. report
    print("%s: %d blocks read, %d B-spline volumes made" %
          (mesh_file, data(mesh).GetNumberOfPartitionedDataSets(), data(volume).GetNumberOfPartitionedDataSets()))
    report(data(mesh), data(volume))
    print("Files written:")
    for file in files:
        print("  " + file)
    print("To open them in ParaView:\n"
          "  1. start paraview; Tools > Manage Plugins > Load New:\n     %s\n"
          "  2. File > Open a .vtpc or the .qfmb file, Apply\n"
          "  or File > Open your mesh, Apply, Filters > BSplineVolume > CatmullClark To BSpline Volume, Apply" %
          os.path.abspath(arguments.plugin))


if __name__ == "__main__":
    main()
