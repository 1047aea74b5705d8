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
import argparse
import collections
import fnmatch
import os
import sys

import numpy as np
from paraview import simple as pv
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_ID_TYPE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import make_demo_mesh

# Colours of the control points by rule; the names come with the data.
RULE_COLORS = ["#9a9a9a", "#b8c4d6", "#7f9fbf", "#4e79a7", "#d4c39a", "#59a14f", "#e15759", "#f28e2b", "#000000",
               "#b07aa1", "#ff9da7", "#8cd17d"]


SIZE = [2000, 1000]

Patch = collections.namedtuple("Patch", "name points rules normals")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("mesh", nargs="?", help="mesh file; without it, a demonstration mesh is generated")
    parser.add_argument("--output", default="output", metavar="FOLDER", help="where the results go (default: output)")
    parser.add_argument("--level", type=int, default=2, help="samples: every span is cut into 2^LEVEL (default: 2)")
    parser.add_argument("--body", metavar="NAMES",
                        help="boundaries that are the body, comma-separated, * and ? as usual (default: walls)")
    parser.add_argument("--crease-angle", type=float, metavar="DEGREES",
                        help="boundary edges where the surface turns by more stay sharp (default: only tagged ones)")
    parser.add_argument("--plugin", metavar="FILE",
                        default=os.path.join(HERE, "..", "build", "lib", "BSplineVolume", "BSplineVolume.so"),
                        help="the ParaView plugin (default: the one in build/)")
    return parser.parse_args()


def rgb(text):
    return [int(text[i:i + 2], 16) / 255.0 for i in (1, 3, 5)]


def data(source):
    """The data object that a source or filter makes."""
    source.UpdatePipeline()
    return source.GetClientSideObject().GetOutputDataObject(0)


def grids(collection):
    """Name and grid of every block."""
    for index in range(collection.GetNumberOfPartitionedDataSets()):
        yield collection.GetMetaData(index).Get(collection.NAME()), collection.GetPartition(index, 0)


def size(grid):
    """Points of a structured grid per direction i, j, k."""
    extent = grid.GetExtent()
    return [extent[2 * d + 1] - extent[2 * d] + 1 for d in range(3)]


def points(grid, array=None):
    """Points of a structured grid, or values at them, as an array [k][j][i][component]."""
    return vtk_to_numpy(array or grid.GetPoints().GetData()).reshape(*size(grid)[::-1], -1)


def strings(field_data, name):
    array = field_data.GetAbstractArray(name)
    return [array.GetValue(i) for i in range(array.GetNumberOfValues())] if array else []


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


# ---------------------------------------------------------------------------------------------- picture
def boundary_patches(collection):
    """Name, points [t][s][xyz], rules [t][s] or None and outward normals of every boundary patch of the blocks."""
    field_data = collection.GetFieldData()
    names = strings(field_data, "BoundaryNames")
    table = field_data.GetArray("Boundaries")
    blocks = [grid for _, grid in grids(collection)]
    for row in vtk_to_numpy(table) if table else []:
        block, face, tag = row[:3]
        direction, side = divmod(face, 2)
        box = np.s_[row[5]:row[6] + 1, row[3]:row[4] + 1] if len(row) == 7 else np.s_[:, :]

        def layer(values, depth):
            return np.take(values, -1 - depth if side else depth, axis=2 - direction)[box]

        patch = layer(points(blocks[block]), 0)
        normals = np.cross(patch[1:, 1:] - patch[:-1, :-1], patch[1:, :-1] - patch[:-1, 1:])
        if np.sum(normals * (patch - layer(points(blocks[block]), 1))[:-1, :-1]) < 0:
            normals = -normals
        rules = blocks[block].GetPointData().GetArray("ControlPointRule")
        yield Patch(names[tag] if tag >= 0 else "", patch,
                    layer(points(blocks[block], rules), 0)[..., 0] if rules else None, normals.reshape(-1, 3))


def surface(patches):
    """Source of all quadrilaterals of the given patches."""
    quads, first = [], 0
    for patch in patches:
        number = first + np.arange(patch.points[..., 0].size).reshape(patch.points.shape[:2])
        first += number.size
        quads.append(np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).ravel())
    mesh = vtkPolyData()
    mesh.SetPoints(vtkPoints())
    mesh.GetPoints().SetData(numpy_to_vtk(np.concatenate([p.points.reshape(-1, 3) for p in patches]), deep=True))
    cells = vtkCellArray()
    cells.SetData(4, numpy_to_vtk(np.concatenate(quads), deep=True, array_type=VTK_ID_TYPE))
    mesh.SetPolys(cells)
    if all(patch.rules is not None for patch in patches):
        rules = numpy_to_vtk(np.concatenate([patch.rules.ravel() for patch in patches]), deep=True)
        rules.SetName("ControlPointRule")
        mesh.GetPointData().AddArray(rules)
    source = pv.TrivialProducer()
    source.GetClientSideObject().SetOutput(mesh)
    return source


def skin(source):
    """The outer surface of all blocks together; copies of shared points have the same bits, so no tolerance."""
    return pv.ExtractSurface(Input=pv.MergeBlocks(Input=source, MergePoints=1, Tolerance=0.0))


def skin_normals(surface_data):
    xyz = vtk_to_numpy(surface_data.GetPoints().GetData()).astype(float)
    quads = xyz[vtk_to_numpy(surface_data.GetPolys().GetConnectivityArray()).reshape(-1, 4)]
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    # Left-handed blocks have their faces inside out.
    return normals if np.sum(normals * quads.mean(axis=1)) > 0 else -normals


def viewpoint(normals):
    """Of eight directions to look from, the one from which most faces are seen from inside the mesh."""
    corners = [np.array([x, y, 0.55]) for a in (1.0, -1.0) for b in (-0.6, 0.6) for x, y in ((b, a), (a, b))]
    return max(corners, key=lambda direction: np.count_nonzero(normals @ direction < 0))


def matches(name, patterns):
    return any(fnmatch.fnmatchcase(name.lower(), pattern.lower()) for pattern in patterns)


def draw(view, net, rule_names):
    """Shows faces, edges and points of a control net; the points in the colours of their rules, if they have any."""
    used = set()
    for source, color, backface in net:
        display = pv.Show(source, view)
        display.Representation = "Surface With Edges"
        display.BackfaceRepresentation = backface
        display.ColorArrayName = [None, ""]
        display.AmbientColor = display.DiffuseColor = rgb(color)
        display.Ambient, display.Diffuse = 0.55, 0.5
        display.EdgeColor = rgb("#55617a")
        # A second source, because a source can be shown only once in a view.
        dots = pv.Show(pv.ExtractSurface(Input=source), view)
        dots.Representation = "Points"
        dots.PointSize = 6 if data(source).GetNumberOfPoints() < 5000 else 3
        dots.ColorArrayName = [None, ""]
        dots.AmbientColor = dots.DiffuseColor = rgb("#101820")
        rules = data(source).GetPointData().GetArray("ControlPointRule")
        if rules:
            pv.ColorBy(dots, ("POINTS", "ControlPointRule"))
            used |= set(vtk_to_numpy(rules))
    if used:
        table = pv.GetColorTransferFunction("ControlPointRule")
        table.InterpretValuesAsCategories = 1
        table.Annotations = [text for rule in sorted(used) for text in (str(rule), rule_names[rule])]
        table.IndexedColors = [value for rule in sorted(used) for value in rgb(RULE_COLORS[rule])]
        legend = pv.GetScalarBar(table, view)
        legend.Title = ""
        legend.ComponentTitle = ""
        legend.LabelColor = [0.0, 0.0, 0.0]
        legend.LabelFontSize = 8
        legend.WindowLocation = "Lower Right Corner"
        legend.ScalarBarLength = 0.04 * len(used)
        legend.Visibility = 1


def picture(before, after, body, symmetry, path):
    """Body and symmetry planes before and after; without named boundaries all sides of the mesh that face away."""
    nets = []
    for source in (before, after):
        patches = list(boundary_patches(data(source)))
        bodies = [patch for patch in patches if matches(patch.name, body)]
        planes = [patch for patch in patches if matches(patch.name, symmetry) and not matches(patch.name, body)]
        if bodies:
            normals = np.concatenate([patch.normals for patch in bodies + planes])
            nets.append([(surface(group), color, "Follow Frontface")
                         for group, color in ((bodies, "#f0c896"), (planes, "#e6ebf1")) if group])
        else:
            nets.append([(skin(source), "#e6ebf1", "Cull Frontface")])
            normals = skin_normals(data(nets[-1][0][0]))
    towards = viewpoint(normals)
    nets[0][0][0].UpdatePipeline()
    bounds = np.array(nets[0][0][0].GetDataInformation().GetBounds()).reshape(3, 2)
    center, radius = bounds.mean(axis=1), 0.5 * np.linalg.norm(bounds[:, 1] - bounds[:, 0])

    layout = pv.CreateLayout("Before and after")
    layout.SetSize(*SIZE)
    for cell, net, title in zip((0, 2), nets, ("before: mesh", "after: B-spline control net")):
        view = pv.CreateView("RenderView")
        view.UseColorPaletteForBackground = 0
        view.Background = [1.0, 1.0, 1.0]
        view.OrientationAxesVisibility = 0
        pv.AssignViewToLayout(view, layout, cell)
        if cell == 0:
            layout.SplitHorizontal(0, 0.5)
        draw(view, net, strings(data(after).GetFieldData(), "ControlPointRuleNames"))
        text = pv.Show(pv.Text(Text=title), view)
        text.Color = [0.0, 0.0, 0.0]
        text.FontSize = 9
        text.WindowLocation = "Lower Left Corner"
        view.CameraFocalPoint = center
        view.CameraPosition = center + 4.0 * radius * towards / np.linalg.norm(towards)
        view.CameraViewUp = [0.0, 0.0, 1.0]
    pv.SaveScreenshot(path, layout, ImageResolution=SIZE)


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
    plugin = os.path.abspath(arguments.plugin)
    pv.LoadPlugin(plugin, remote=False, ns=pv.__dict__)
    mesh = pv.HexBlockMeshReader(FileName=os.path.abspath(mesh_file))
    volume = pv.CatmullClarkToBSplineVolume(Input=mesh)
    if arguments.body:
        volume.BodyBoundaries = arguments.body.split(",")
    if arguments.crease_angle is not None:
        volume.UseCreaseAngle = 1
        volume.CreaseAngle = arguments.crease_angle
    samples = pv.BSplineVolumeSampler(Input=volume, Level=arguments.level)
    if data(samples).GetNumberOfPartitionedDataSets() == 0:
        sys.exit("%s was not converted; the reason is above" % mesh_file)

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
    picture(mesh, volume, list(volume.BodyBoundaries), list(volume.SymmetryBoundaries), files[-1])

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
          "  or File > Open your mesh, Apply, Filters > Alphabetical > CatmullClark To BSpline Volume, Apply" % plugin)


if __name__ == "__main__":
    main()
