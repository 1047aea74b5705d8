# SPDX-License-Identifier: BSD-3-Clause
"""The wing-fuselage case from mesh to B-spline volumes: source, conversion, files, table of rules, two pictures.

Sample runs (without a display each starts one in memory):
    pvpython Examples/wing_fuselage.py
    pvpython Examples/wing_fuselage.py --resolution 16 --span 5 --sweep 35

Steps:
  1. load the plugin, make mesh and body, write the body as IGES and read it back;
  2. convert the mesh with that body, write the topology (.qfmb) and both control nets (.vtpc);
  3. print how the control points were made, and what the volumes are like;
  4. draw the body with its control net, and all blocks, cut open.
"""
import argparse
import colorsys
import os
import sys

import numpy as np
from paraview import simple as pv
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_ID_TYPE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPartitionedDataSetCollection, vtkPolyData

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
from example_support import boundary_patches, data, grids, matches, points, rgb, smooth_shaded, strings

WALL = ["wall*"]
SIZE = [2000, 1200]
# Where the picture of the blocks is cut: x and z.
CUT = (0.7, 0.12)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--resolution", type=int, default=8, help="cells across the leading edge (default: 8)")
    parser.add_argument("--span", type=float, default=3.5, help="of the half model (default: 3.5)")
    parser.add_argument("--sweep", type=float, default=25.0, metavar="DEGREES", help="of the wing (default: 25)")
    parser.add_argument("--output", default=os.path.join("output", "wing_fuselage"), metavar="FOLDER",
                        help="where the results go (default: output/wing_fuselage)")
    parser.add_argument("--plugin", metavar="FILE",
                        default=os.path.join(HERE, "..", "build", "lib", "BSplineVolume", "BSplineVolume.so"),
                        help="the ParaView plugin (default: the one in build/)")
    return parser.parse_args()


# ---------------------------------------------------------------------------------------------- report
def measured(proxy):
    """The filter after it has run, with its results."""
    proxy.UpdatePipeline()
    proxy.UpdatePropertyInformation()
    return proxy


def report(before, after):
    """Control points per rule, and per kind of block."""
    rule_names = strings(after.GetFieldData(), "ControlPointRuleNames")
    groups = (("around the body", 0, 36), ("rest of the cuboid", 36, 40), ("extension by faces", 40, 59),
              ("extension by edges and corners", 59, 79))
    table = np.zeros((len(rule_names), len(groups)), dtype=int)
    blocks = [grid for _, grid in grids(after)]
    for column, (_, first, last) in enumerate(groups):
        for grid in blocks[first:last]:
            rules = vtk_to_numpy(grid.GetPointData().GetArray("ControlPointRule"))
            table[:, column] += np.bincount(rules, minlength=len(rule_names))
    print("%d blocks in, %d blocks out" % (len(list(grids(before))), len(blocks)))
    print("| rule | %s | all |" % " | ".join(name for name, _, _ in groups))
    print("|---|%s---|" % ("---|" * len(groups)))
    for name, row in zip(rule_names, table):
        if row.sum():
            print("| %s | %s | %d |" % (name, " | ".join(str(count) for count in row), row.sum()))


# ---------------------------------------------------------------------------------------------- pictures
def show(view, xyz, color, lines=(), quads=(), width=1.0):
    """Draws points, lines (lists of point numbers) or quadrilaterals in one colour."""
    mesh = vtkPolyData()
    mesh.SetPoints(vtkPoints())
    mesh.GetPoints().SetData(numpy_to_vtk(np.ascontiguousarray(xyz), deep=True))
    cells = vtkCellArray()
    if len(lines):
        ends = np.cumsum([0] + [len(line) for line in lines])
        cells.SetData(*(numpy_to_vtk(values, deep=True, array_type=VTK_ID_TYPE)
                        for values in (ends, np.concatenate(lines))))
        mesh.SetLines(cells)
    elif len(quads):
        cells.SetData(4, numpy_to_vtk(np.concatenate(quads), deep=True, array_type=VTK_ID_TYPE))
        mesh.SetPolys(cells)
    else:
        cells.SetData(1, numpy_to_vtk(np.arange(len(xyz)), deep=True, array_type=VTK_ID_TYPE))
        mesh.SetVerts(cells)
    source = pv.TrivialProducer()
    source.GetClientSideObject().SetOutput(mesh)
    display = pv.Show(smooth_shaded(source) if len(quads) else source, view)
    display.Representation = "Surface" if len(quads) else "Wireframe" if len(lines) else "Points"
    display.ColorArrayName = [None, ""]
    display.AmbientColor = display.DiffuseColor = rgb(color)
    display.LineWidth = display.PointSize = width
    display.Ambient, display.Diffuse = (0.35, 0.7) if len(quads) else (1.0, 0.0)


def show_lines(view, lines, color, width):
    numbers, first = [], 0
    for line in lines:
        numbers.append(first + np.arange(len(line)))
        first += len(line)
    show(view, np.concatenate(lines), color, lines=numbers, width=width)


def show_surface(view, patch, color):
    number = np.arange(patch[..., 0].size).reshape(patch.shape[:2])
    quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    show(view, patch.reshape(-1, 3), color, quads=quads)


def wall(source):
    """Points [t][s][xyz] of every patch of the wall."""
    return [patch.points for patch in boundary_patches(data(source)) if matches(patch.name, WALL)]


def grid_lines(patch):
    return list(patch) + list(patch.swapaxes(0, 1))


def border(patch):
    return [patch[0], patch[-1], patch[:, 0], patch[:, -1]]


def crease_lines(mesh):
    """The runs of the field array CreaseEdges, as arrays of points."""
    blocks = [grid for _, grid in grids(mesh)]
    for row in vtk_to_numpy(mesh.GetFieldData().GetArray("CreaseEdges")):
        low, high = np.minimum(row[1:4], row[4:7])[::-1], np.maximum(row[1:4], row[4:7])[::-1]
        box = points(blocks[row[0]])[tuple(np.s_[a:b + 1] for a, b in zip(low, high))]
        yield box.reshape(-1, 3)


def new_view(towards, center, height):
    """View along parallel rays from the direction `towards`; `height` is half of what is seen."""
    view = pv.CreateView("RenderView")
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    view.OrientationAxesVisibility = 0
    view.ViewSize = SIZE
    view.CameraFocalPoint = center
    view.CameraPosition = np.asarray(center) + 40.0 * towards
    view.CameraViewUp = [0.0, 0.0, 1.0]
    view.CameraParallelProjection = 1
    view.CameraParallelScale = height
    return view


def draw_body(mesh, volume, samples, path):
    """B-spline body blue, control net green with yellow points, mesh black, creases yellow, borders of patches bold."""
    towards = np.array([-0.5, 0.62, 0.6])
    view = new_view(towards, [0.05, 1.3, 0.65], 2.0)

    def raised(lines, height):
        # Towards the eye, or the surface hides parts of what lies on it.
        return [line + height * towards for line in lines]

    for patch in wall(samples):
        show_surface(view, patch, "#5f8fd6")
    net = wall(volume)
    show_lines(view, raised([line for patch in net for line in grid_lines(patch)], 0.014), "#1c8c3a", 3.0)
    show_lines(view, raised([line for patch in wall(mesh) for line in grid_lines(patch)], 0.016), "#000000", 1.0)
    show_lines(view, raised([line for patch in wall(samples) for line in border(patch)], 0.018), "#000000", 5.0)
    show_lines(view, raised(crease_lines(data(mesh)), 0.020), "#ffc800", 5.0)
    show(view, np.concatenate(raised([patch.reshape(-1, 3) for patch in net], 0.022)), "#ffe94a", width=4.0)
    pv.SaveScreenshot(path, view, ImageResolution=SIZE)


def coloured_blocks(mesh):
    """Source of the mesh's blocks with a colour of its own each, as the cell array Colour."""
    copy = vtkPartitionedDataSetCollection()
    for number, (_, grid) in enumerate(grids(mesh)):
        block = grid.NewInstance()
        block.ShallowCopy(grid)
        # Hues in steps of the golden section are well apart; the body's blocks are stronger than the outer ones.
        colour = colorsys.hsv_to_rgb(number * 0.618034 % 1.0, 0.65 if number < 40 else 0.35, 0.95)
        colour = (255 * np.array(colour)).astype(np.uint8)
        array = numpy_to_vtk(np.tile(colour, (grid.GetNumberOfCells(), 1)), deep=True)
        array.SetName("Colour")
        block.GetCellData().AddArray(array)
        copy.SetPartition(number, 0, block)
    source = pv.TrivialProducer()
    source.GetClientSideObject().SetOutput(copy)
    return source


def show_coloured(view, source, edges):
    display = pv.Show(source, view)
    display.Representation = "Surface With Edges" if edges else "Surface"
    pv.ColorBy(display, ("CELLS", "Colour"))
    display.MapScalars = 0
    display.EdgeColor = [0.2, 0.2, 0.2]
    display.Ambient, display.Diffuse = 0.6, 0.45


def halfspace(source, axis, position, above):
    """The part of a source above or below a plane across an axis, cut exactly."""
    clip = pv.Clip(Input=source)
    clip.ClipType = "Plane"
    clip.ClipType.Origin = [position if d == axis else 0.0 for d in range(3)]
    clip.ClipType.Normal = [1.0 if d == axis else 0.0 for d in range(3)]
    clip.Invert = 0 if above else 1
    return clip


def cut(source, axis, position):
    """Polygons where a plane across an axis cuts the cells."""
    plane = pv.Slice(Input=source, Triangulatetheslice=0)
    plane.SliceType = "Plane"
    plane.SliceType.Origin = [position if d == axis else 0.0 for d in range(3)]
    plane.SliceType.Normal = [1.0 if d == axis else 0.0 for d in range(3)]
    return plane


def draw_blocks(source, path):
    """All blocks in colours of their own; what is above the wing and ahead of its middle is cut away."""
    towards = np.array([-0.6, 0.55, 0.6])
    mesh = data(source)
    blocks = coloured_blocks(mesh)
    bounds = np.array([grid.GetBounds() for _, grid in grids(mesh)])
    low, high = bounds[:, ::2].min(axis=0), bounds[:, 1::2].max(axis=0)
    view = new_view(towards, 0.5 * (low + high), 0.46 * np.linalg.norm(high - low))
    x, z = CUT
    skin = pv.ExtractSurface(Input=pv.MergeBlocks(Input=blocks, MergePoints=1, Tolerance=0.0))
    for part in (halfspace(skin, 2, z, False), halfspace(halfspace(skin, 2, z, True), 0, x, True)):
        show_coloured(view, part, True)
    show_coloured(view, halfspace(cut(blocks, 2, z), 0, x, False), True)
    show_coloured(view, halfspace(cut(blocks, 0, x), 2, z, True), True)
    for patch in wall(source):
        show_surface(view, patch, "#b0b4ba")
    pv.SaveScreenshot(path, view, ImageResolution=SIZE)


# ---------------------------------------------------------------------------------------------- main
def main():
    arguments = parse_arguments()
    folder = os.path.abspath(arguments.output)
    os.makedirs(folder, exist_ok=True)
    pv.LoadPlugin(os.path.abspath(arguments.plugin), remote=False, ns=pv.__dict__)

    def path(name):
        file = os.path.join(folder, name)
        if os.path.exists(file):
            os.remove(file)
        files.append(file)
        return file

    files = []

    # 1. mesh and body; the body through a CAD file, as it would come from elsewhere
    source = pv.WingFuselageSource(Resolution=arguments.resolution, Span=arguments.span, SweepAngle=arguments.sweep)
    if data(source).GetNumberOfPartitionedDataSets() == 0:
        sys.exit("no mesh was made; the reason is above")
    body_file = path("body.igs")
    pv.SaveData(body_file, proxy=pv.OutputPort(source, 1))
    body = pv.NURBSSurfaceReader(FileName=body_file)
    body.UpdatePipeline()
    if body.GetDataInformation().GetNumberOfPoints() == 0:
        print("the IGES file cannot be read here; going on with the body of the source")
        body = pv.OutputPort(source, 1)

    # 2. convert and write
    volume = pv.CatmullClarkToBSplineVolume(Input=source, Body=body)
    samples = pv.BSplineVolumeSampler(Input=volume, Level=2)
    if data(samples).GetNumberOfPartitionedDataSets() == 0:
        sys.exit("the mesh was not converted; the reason is above")
    for name, proxy in (("control_net_before.vtpc", source), ("control_net_after.vtpc", volume),
                        ("wing_fuselage.qfmb", volume)):
        pv.SaveData(path(name), proxy=proxy)

    # 3. report
    measured(source)
    print("mesh: %d points, smallest scaled Jacobian %.3f" % (source.NumberOfMeshPoints, source.MinimumScaledJacobian))
    report(data(source), data(volume))
    quality = measured(pv.BSplineVolumeQuality(Input=volume))
    print("spans: %d, proven valid: %d, smallest scaled Jacobian %.3f" %
          (quality.NumberOfSpans, quality.NumberOfValidSpans, quality.MinimumScaledJacobian))
    smoothness = measured(pv.BSplineVolumeSmoothness(Input=volume))
    joins = smoothness.GetClientSideObject().GetOutputDataObject(2)
    turns = vtk_to_numpy(joins.GetColumnByName("MaximumNormalJump"))[
        [kind == "wall border" for kind in strings(joins.GetRowData(), "Kind")]]
    print("interfaces: %d, largest gap %g; borders of the wall's patches that turn by less than 10 degrees: %d, by at "
          "most %.3g degrees" % (smoothness.NumberOfInterfaces, smoothness.MaximumGap, (turns < 10).sum(),
                                 turns[turns < 10].max()))
    deviation = measured(pv.BodyDeviation(Input=volume, Body=body, Level=2))
    print("distance of the converted body from the NURBS surface: largest %.3g, root mean square %.3g" %
          (deviation.MaximumDistance, deviation.RMSDistance))

    # 4. draw
    draw_body(source, volume, samples, path("body.png"))
    near = pv.WingFuselageSource(Resolution=6, Span=arguments.span, SweepAngle=arguments.sweep, FarFieldDistance=3.0)
    draw_blocks(near, path("blocks.png"))
    print("Files written:")
    for file in files:
        print("  " + file)


if __name__ == "__main__":
    main()
