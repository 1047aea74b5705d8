# SPDX-License-Identifier: BSD-3-Clause
"""What the example scripts share: arguments, the plugin, access to blocks and boundaries, views side by side."""
import argparse
import collections
import contextlib
import fnmatch
import os
import sys
import tempfile

import numpy as np
from paraview import simple as pv
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_ID_TYPE, vtkIdList, vtkPoints, vtkSMPTools
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkExtractCells

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import make_body_case
import make_demo_mesh

WIDTH = 1200  # of a picture, in pixels

# VTK runs on one core unless it is told otherwise.
if "VTK_SMP_BACKEND_IN_USE" not in os.environ:
    vtkSMPTools.SetBackend("STDThread")

Patch = collections.namedtuple("Patch", "name points rules normals")


# ---------------------------------------------------------------------------------------------- arguments
def parser(description, picture=None, mesh=True):
    """Arguments of all examples; `picture` is the name of the file that is written unless --output says another."""
    arguments = argparse.ArgumentParser(description=description)
    if mesh:
        arguments.add_argument("--mesh", metavar="FILE", help="mesh file, PLOT3D or CGNS (default: one is generated)")
        arguments.add_argument("--body", metavar="NAMES",
                               help="boundaries that are the body, comma-separated, * and ? as usual (default: walls)")
        arguments.add_argument("--crease-angle", type=float, metavar="DEGREES",
                               help="boundary edges where the surface turns by more stay sharp")
    if picture:
        arguments.add_argument("--output", default=os.path.join("output", picture), metavar="FILE",
                               help="the picture (default: output/%s)" % picture)
    arguments.add_argument("--plugin", metavar="FILE",
                           default=os.path.join(HERE, "..", "build", "lib", "BSplineVolume", "BSplineVolume.so"),
                           help="the ParaView plugin (default: the one in build/)")
    return arguments


def need_display():
    """Without a display this script starts again, in an X server of its own."""
    if not os.environ.get("DISPLAY"):
        server = os.path.join(HERE, "..", "Filters", "Python", "display.py")
        os.execvp("python3", ["python3", server, "pvpython", *sys.argv])


def load_plugin(path):
    need_display()
    pv.LoadPlugin(os.path.abspath(path), remote=False, ns=pv.__dict__)


def read_mesh(arguments, cells=8):
    """The mesh that was asked for, or the demonstration mesh with so many cells an edge; loads the plugin."""
    load_plugin(arguments.plugin)
    if arguments.mesh:
        mesh = pv.HexBlockMeshReader(FileName=os.path.abspath(arguments.mesh))
        mesh.UpdatePipeline()
        return mesh
    with tempfile.TemporaryDirectory() as folder:
        mesh = pv.HexBlockMeshReader(FileName=make_demo_mesh.write_demo(folder, cells))
        mesh.UpdatePipeline()
    if arguments.crease_angle is None:
        arguments.crease_angle = 30.0
    return mesh


def body_case_arguments(arguments):
    """Arguments of examples that need a body: its file, and where to look from."""
    arguments.add_argument("--cad", metavar="FILE", help="the body: IGES, STEP, BREP or .g2; needed with --mesh")
    arguments.add_argument("--unit", default="As in File", help="length unit of the mesh (default: that of the file)")
    arguments.add_argument("--zoom", type=float, default=1.0, help="larger shows less (default: 1)")
    arguments.add_argument("--towards", type=float, nargs=3, metavar="X", help="direction from the body to the camera")
    arguments.add_argument("--look-at", type=float, nargs=3, metavar="X", help="point in the middle of the pictures")


def read_body_case(arguments):
    """Mesh and body that were asked for, or generated ones; loads the plugin."""
    if arguments.mesh:
        mesh = read_mesh(arguments)
        body = pv.NURBSSurfaceReader(FileName=arguments.cad, LengthUnit=arguments.unit)
        body.UpdatePipeline()
        return mesh, body
    load_plugin(arguments.plugin)
    with tempfile.TemporaryDirectory() as folder:
        mesh_file, body_file = make_body_case.write_case(folder)
        mesh = pv.HexBlockMeshReader(FileName=mesh_file)
        body = pv.NURBSSurfaceReader(FileName=body_file)
        for source in (mesh, body):
            source.UpdatePipeline()
        return mesh, body


def convert(mesh, arguments, **properties):
    """The volume of a mesh, as the arguments want it."""
    volume = pv.CatmullClarkToBSplineVolume(Input=mesh, **properties)
    if arguments.body:
        volume.BodyBoundaries = arguments.body.split(",")
    if arguments.crease_angle is not None:
        volume.UseCreaseAngle = 1
        volume.CreaseAngle = arguments.crease_angle
    if data(volume).GetNumberOfPartitionedDataSets() == 0:
        sys.exit("The mesh was not converted; the reason is above")
    return volume


# ---------------------------------------------------------------------------------------------- data
def data(source, port=0):
    """The data object that a source or filter makes."""
    source.UpdatePipeline()
    return source.GetClientSideObject().GetOutputDataObject(port)


def producer(data_object):
    """Source that gives a data object."""
    source = pv.TrivialProducer()
    source.GetClientSideObject().SetOutput(data_object)
    return source


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


def extract_cells(cells, ids):
    """Source of some cells of an unstructured grid."""
    chosen = vtkIdList()
    for cell in ids:
        chosen.InsertNextId(int(cell))
    extract = vtkExtractCells()
    extract.SetInputData(cells)
    extract.SetCellList(chosen)
    extract.Update()
    return producer(extract.GetOutput())


def matches(name, patterns):
    return any(fnmatch.fnmatchcase(name.lower(), pattern.lower()) for pattern in patterns)


def boundary_faces(collection, patterns):
    """(block, face) of the block faces on boundaries whose names fit."""
    names = strings(collection.GetFieldData(), "BoundaryNames")
    table = collection.GetFieldData().GetArray("Boundaries")
    return {(int(row[0]), int(row[1])) for row in (vtk_to_numpy(table) if table else [])
            if row[2] >= 0 and matches(names[row[2]], patterns)}


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


def body_patches(collection, body):
    patches = [patch for patch in boundary_patches(collection) if matches(patch.name, body)]
    if not patches:
        sys.exit("The mesh has no boundary that fits %s; name one with --body" % ", ".join(body))
    return patches


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
    return producer(mesh)


def wall_angles(volume, light, center=None, radius=np.inf):
    """The wall, or what is near a point of it, finely sampled, with the angle between its normals and a direction in
    degrees. The normals of each patch are its own, so that nothing is smoothed across the borders of patches."""
    light = np.asarray(light) / np.linalg.norm(light)
    patches, values = [], []
    for patch in body_patches(data(pv.BSplineVolumeSampler(Input=volume, Level=4)), list(volume.BodyBoundaries)):
        box = np.s_[:, :]
        if center is not None:
            inside = np.linalg.norm(patch.points - center, axis=-1) < radius
            if not inside.any():
                continue
            near = [np.flatnonzero(inside.any(axis=axis)) for axis in (1, 0)]
            box = tuple(slice(n[0], n[-1] + 1) for n in near)
        normals = np.cross(*(np.gradient(patch.points, axis=axis, edge_order=2) for axis in (1, 0)))
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        # Into the mesh; those of the patch go out of it.
        sense = -np.sign(np.sum(normals[:-1, :-1].reshape(-1, 3) * patch.normals))
        values.append(np.degrees(np.arccos(np.clip(sense * (normals @ light), -1.0, 1.0)))[box].ravel())
        patches.append(Patch(patch.name, patch.points[box], None, patch.normals))
    wall = data(surface(patches))
    array = numpy_to_vtk(np.concatenate(values), deep=True)
    array.SetName("Angle")
    wall.GetPointData().AddArray(array)
    return producer(wall)


# ---------------------------------------------------------------------------------------------- views
def rgb(text):
    return [int(text[i:i + 2], 16) / 255.0 for i in (1, 3, 5)]


def viewpoint(normals):
    """Of eight directions to look from, the one from which most faces are seen from inside the mesh."""
    corners = [np.array([x, y, 0.55]) for a in (1.0, -1.0) for b in (-0.6, 0.6) for x, y in ((b, a), (a, b))]
    return max(corners, key=lambda direction: np.count_nonzero(normals @ direction < 0))


def body_viewpoint(patches):
    return viewpoint(np.concatenate([patch.normals for patch in patches]))


def views(titles, height, rows=1):
    """A layout of views side by side, or in rows, on white, each with its title. Returns layout and views."""
    layout = pv.CreateLayout()
    layout.SetSize(WIDTH, height)
    columns = len(titles) // rows
    # Cell n of the layout has the halves 2 n + 1 and 2 n + 2.
    cells = [0]
    if rows == 2:
        layout.SplitVertical(0, 0.5)
        cells = [1, 2]
    made = []
    for row, cell in enumerate(cells):
        for column in range(columns):
            view = pv.CreateView("RenderView")
            view.UseColorPaletteForBackground = 0
            view.Background = [1.0, 1.0, 1.0]
            view.OrientationAxesVisibility = 0
            if column + 1 < columns:
                layout.SplitHorizontal(cell, 1.0 / (columns - column))
                place, cell = 2 * cell + 1, 2 * cell + 2
            else:
                place = cell
            pv.AssignViewToLayout(view, layout, place)
            title(view, titles[row * columns + column])
            made.append(view)
    return layout, made


def title(view, text):
    display = pv.Show(pv.Text(Text=text), view)
    display.Color = [0.0, 0.0, 0.0]
    display.FontSize = 9
    display.WindowLocation = "Upper Left Corner"


def show(source, view, color=None, array=None, representation="Surface", **properties):
    """Shows a source in one colour (#rrggbb), or coloured by a point or cell array ("POINTS", name)."""
    display = pv.Show(source, view)
    display.Representation = representation
    if array:
        pv.ColorBy(display, array)
        # Colours as in the legend.
        display.Ambient, display.Diffuse = 0.7, 0.35
    elif color:
        display.ColorArrayName = [None, ""]
        display.AmbientColor = display.DiffuseColor = rgb(color)
    for name, value in properties.items():
        setattr(display, name, value)
    return display


def legend(array, view, text, location="Lower Right Corner", **properties):
    """Shows the colours of an array."""
    bar = pv.GetScalarBar(pv.GetColorTransferFunction(array), view)
    bar.Title = text
    bar.ComponentTitle = ""
    bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]
    bar.TitleFontSize = bar.LabelFontSize = 8
    bar.WindowLocation = location
    bar.Orientation = "Horizontal"
    bar.HorizontalTitle = 1
    bar.ScalarBarLength = 0.4
    bar.ScalarBarThickness = 10
    # Since ParaView 6.1 a format of C++20.
    bar.LabelFormat = bar.RangeLabelFormat = "{:.3g}" if pv.GetParaViewVersion() >= (6, 1) else "%.3g"
    for name, value in properties.items():
        setattr(bar, name, value)
    bar.Visibility = 1
    return bar


def stripes(windows, width):
    """Colours "Angle" in stripes of so many degrees, without a legend."""
    colors = pv.GetColorTransferFunction("Angle")
    colors.Discretize = 0
    edge = 0.05 * width
    colors.RGBPoints = [number for n in range(int(180 / width)) for at in (n * width + edge, (n + 1) * width - edge)
                        for number in (at, *3 * [0.95 if n % 2 else 0.1])]
    for view in windows:
        for bar in [r for r in view.Representations if "ScalarBar" in r.GetXMLName()]:
            bar.Visibility = 0


def viridis(array):
    """Colours an array from violet to yellow."""
    # The preset's name in ParaView 5 and 6: one does nothing with the other's, or raises an error.
    for name in ("Viridis (matplotlib)", "Viridis"):
        with contextlib.suppress(RuntimeError):
            pv.GetColorTransferFunction(array).ApplyPreset(name, True)


def smooth_shaded(source):
    """The surface with normals at its points. ParaView 6 has another name for the filter."""
    return (pv.SurfaceNormals if hasattr(pv, "SurfaceNormals") else pv.GenerateSurfaceNormals)(Input=source)


def color_range(array, low, high):
    """Colours from `low` to `high`."""
    pv.GetColorTransferFunction(array).RescaleTransferFunction(low, high)


def look(view, bounds, towards, zoom=1.0, center=None, up=(0.0, 0.0, 1.0)):
    """Camera in the direction `towards` of the centre of the bounds, which fill the view at zoom 1."""
    bounds = np.array(bounds).reshape(3, 2)
    radius = 0.5 * np.linalg.norm(bounds[:, 1] - bounds[:, 0])
    center = bounds.mean(axis=1) if center is None else np.asarray(center)
    center = center - 0.1 / zoom * radius * np.asarray(up)  # room for the legend
    view.CameraFocalPoint = center
    view.CameraPosition = center + 4.0 / zoom * radius * np.asarray(towards) / np.linalg.norm(towards)
    view.CameraViewUp = up


def bounds(source, port=0):
    source.UpdatePipeline()
    return source.GetDataInformation(port).GetBounds()


def save(path, layout, height):
    """Writes the picture and says so."""
    path = os.path.abspath(path)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    pv.SaveScreenshot(path, layout, ImageResolution=[WIDTH, height])
    print("Picture written: " + path, flush=True)
