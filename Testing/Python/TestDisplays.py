# SPDX-License-Identifier: BSD-3-Clause
"""What ParaView's users meet: what is shown after one Apply, names of blocks, colours, menus, file dialogs, help.

Arguments: the folder of the generated help.
"""
import contextlib
import json
import math
import os
import random
import sqlite3
import subprocess
import sys
import tempfile
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import simple, vtk, blocks, client, creased_mesh, demo_mesh, names, producer, update, values
from bsv_support import main as run_tests
from paraview import servermanager
from vtkmodules.vtkIOImage import vtkPNGReader
import make_body_case
import make_demo_mesh

PLUGIN = os.path.dirname(os.environ["BSV_PLUGIN"])
SOURCES = ("HexBlockMeshReader", "NURBSSurfaceReader", "BSplineVolumeReader", "QuadflowReader", "WingFuselageSource")
FILTERS = ("CatmullClarkToBSplineVolume", "HexBlockTopology", "BodyDeviation", "BSplineVolumeSampler",
           "BSplineVolumeSmoothness", "BSplineVolumeQuality", "BSplineVolumeToBezierCells", "WallSpacing",
           "BSplineVolumeDifference", "BSplineVolumeProbe", "BSplineVolumeIsoparametric", "MirrorHexBlocks",
           "HexMeshToBlocks")
WRITERS = ("QuadflowWriter", "NURBSSurfaceWriter", "BSplineVolumeWriter", "HexBlockMeshWriter")

VIEW = simple.CreateRenderView()
FOLDER = tempfile.TemporaryDirectory()
MESH = simple.HexBlockMeshReader(FileName=make_demo_mesh.write_demo(FOLDER.name, 4))
VOLUME = simple.CatmullClarkToBSplineVolume(Input=MESH, UseCreaseAngle=1)


def shown(source, port=0):
    """Display of an output where ParaView puts it by default, or None."""
    controller = servermanager.vtkSMParaViewPipelineControllerWithRendering()
    view = controller.ShowInPreferredView(source.SMProxy, port, VIEW.SMProxy)
    if view is None:
        return None
    assert view == VIEW.SMProxy, view.GetXMLName()
    return simple.GetDisplayProperties(simple.OutputPort(source, port), VIEW)


def array_of(display):
    return tuple(display.ColorArrayName[:2])


def legend_is_shown(display):
    """After the update of legends that follows each Apply."""
    manager = servermanager.vtkSMTransferFunctionManager()
    manager.UpdateScalarBars(VIEW.SMProxy, manager.SHOW_USED_SCALAR_BARS | manager.HIDE_UNUSED_SCALAR_BARS)
    return servermanager.vtkSMPVRepresentationProxy.IsScalarBarVisible(display.SMProxy, VIEW.SMProxy)


def drawn_surface(display):
    """All polygons that a display gives to its mapper, and the bounds that set the camera."""
    simple.Render(VIEW)
    active = client(display).GetActiveRepresentation()
    data = active.GetRenderedDataObject(0)
    append = vtk.vtkAppendPolyData()
    leaves = data.NewIterator()
    leaves.InitTraversal()
    while not leaves.IsDoneWithTraversal():
        append.AddInputData(leaves.GetCurrentDataObject())
        leaves.GoToNextItem()
    append.Update()
    return append.GetOutput()


def test_first_picture_is_the_wall():
    """Of meshes and volumes only faces of the wall are drawn; the normals are those of the surface."""
    wing = simple.WingFuselageSource(Resolution=2)
    volume = simple.CatmullClarkToBSplineVolume(Input=wing)
    assert shown(wing, 1) is None
    areas = []
    for source in (wing, volume):
        display = shown(source)
        assert display.Representation == "Wall And Curves"
        assert not legend_is_shown(display)
        display.SetScalarColoring(None, 0)
        surface = drawn_surface(display)
        names = update(source)[0].GetFieldData().GetAbstractArray("BoundaryNames")
        tags = surface.GetCellData().GetArray("Boundary")
        drawn = {names.GetValue(int(tags.GetValue(n))) for n in range(tags.GetNumberOfValues())}
        assert drawn and all(name.startswith("wall") for name in drawn), drawn
        # A mesh has facets, a volume is smooth.
        assert surface.GetPointData().HasArray("Normals") == (source is volume)
        mass = vtk.vtkMassProperties()
        triangles = vtk.vtkTriangleFilter()
        triangles.SetInputData(surface)
        mass.SetInputConnection(triangles.GetOutputPort())
        areas.append(mass.GetSurfaceArea())
        # The camera is that of the body, not of the far field.
        assert surface.GetLength() < 0.3 * vtk_length(source)
        simple.Hide(source, VIEW)
    # The same body, drawn once and not from its net, inside which it lies.
    assert 0.7 * areas[0] < areas[1] < areas[0], areas
    # Without the wall nothing is left of the surface.
    display = simple.Show(volume, VIEW)
    display.ShowWall = 0
    assert drawn_surface(display).GetNumberOfCells() == 0
    display.ShowWall = 1
    # Layers lie around the body; deep down they are the outer ends of its blocks.
    lengths = []
    for layer in (0, 1, 1000):
        display.WallLayer = layer
        lengths.append(drawn_surface(display).GetLength())
    assert lengths[0] < lengths[1] < lengths[2], lengths
    display.WallLayer = 0
    # Reflection lines follow the exact normals: finer parts hardly move them.
    display.ReflectionLines, display.NumberOfReflectionLines, display.ShowSymmetryNet = 1, 6, 0
    simple.Render(VIEW)
    simple.ResetCamera(VIEW)
    coarse, fine = [picture_of(display, Subdivision=parts) for parts in (2, 4)]
    flat = picture_of(display, Subdivision=2, ReflectionLines=0)
    assert share_that_differs(coarse, fine) < 0.3 * share_that_differs(coarse, flat)
    # The next frame still shows the wall.
    VIEW.GetActiveCamera().Azimuth(20)
    seen, hidden = picture_of(display, ReflectionLines=0), picture_of(display, ShowWall=0)
    assert share_that_differs(seen, hidden) > 0.02
    display.ShowWall = 1
    display.Subdivision, display.ShowSymmetryNet = 0, 1
    simple.Hide(volume, VIEW)


def picture_of(display, **properties):
    """The colours of the pixels."""
    for name, value in properties.items():
        setattr(display, name, value)
    file = os.path.join(FOLDER.name, "picture.png")
    simple.SaveScreenshot(file, VIEW, ImageResolution=[300, 300])
    reader = vtkPNGReader()
    reader.SetFileName(file)
    reader.Update()
    pixels = reader.GetOutput().GetPointData().GetScalars()
    return [pixels.GetTuple(n) for n in range(pixels.GetNumberOfTuples())]


def share_that_differs(colors, others):
    return sum(max(abs(a - b) for a, b in zip(one, other)) > 64 for one, other in zip(colors, others)) / len(colors)


def drawn_lines(display):
    """Points of all lines that a display draws."""
    simple.Render(VIEW)
    leaves = client(display).GetActiveRepresentation().GetRenderedDataObject(0).NewIterator()
    count = 0
    while not leaves.IsDoneWithTraversal():
        count += leaves.GetCurrentDataObject().GetLines().GetNumberOfConnectivityIds()
        leaves.GoToNextItem()
    return count


def field_strings(data, name):
    array = data.GetFieldData().GetAbstractArray(name)
    return [array.GetValue(n) for n in range(array.GetNumberOfValues())]


def vtk_length(source):
    bounds = source.GetDataInformation(0).GetBounds()
    return sum((bounds[2 * d + 1] - bounds[2 * d]) ** 2 for d in range(3)) ** 0.5


def test_repeated_knots_look_like_cuts():
    """Creases inside blocks are lines, and the surface has the normals of both sides there."""
    found = []
    for inside in ("Cut", "RepeatedKnots"):
        volume = simple.CatmullClarkToBSplineVolume(Input=producer(creased_mesh()), CreasesInsideBlocks=inside)
        display = shown(volume)
        surface = drawn_surface(display)
        normals = values(surface.GetPointData().GetArray("Normals"))
        points = [surface.GetPoint(n) + normals[n] for n in range(len(normals))]
        simple.ResetCamera(VIEW)
        picture, plain = picture_of(display), picture_of(display, ShowCreases=0)
        assert share_that_differs(picture, plain) > 0.001
        found.append((points, surface.GetNumberOfCells(), picture))
        simple.Delete(volume)
    (cut, cells, _), (whole, others, _) = found
    assert cells == others
    for ones, twos in ((cut, whole), (whole, cut)):
        assert all(min(math.dist(one, two) for two in twos) < 1e-6 for one in ones)
    assert share_that_differs(found[0][2], found[1][2]) < 0.001


def test_control_nets():
    for source in (MESH, VOLUME):
        display = shown(source)
        display.Representation = "Control Net"
        assert not legend_is_shown(display)
        simple.Render(VIEW)
        # Lines and points.
        active = client(display).GetActiveRepresentation()
        drawn = active.GetActor().GetProperty()
        assert active.IsA("vtkControlNetRepresentation")
        assert drawn.GetRepresentation() == 1 and drawn.GetVertexVisibility() == 1
        size = drawn.GetPointSize()
        display.PointSize *= 2
        assert drawn.GetPointSize() == 2 * size > display.LineWidth


def test_control_points_by_rule():
    """Near the wall, without those that ordinary rules made; under the mouse they are the volume's points."""
    display = shown(VOLUME)
    display.Representation = "Control Points"
    blocks_of_volume = blocks(update(VOLUME)[0])

    def drawn():
        simple.Render(VIEW)
        leaves = client(display).GetActiveRepresentation().GetRenderedDataObject(0).NewIterator()
        found = []
        while not leaves.IsDoneWithTraversal():
            found.append(leaves.GetCurrentDataObject())
            leaves.GoToNextItem()
        return found
    few = drawn()
    rules = {data.GetPointData().GetArray("ControlPointRule").GetValue(n)
             for data in few for n in range(data.GetNumberOfPoints())}
    names = field_strings(client(VOLUME).GetOutputDataObject(0), "ControlPointRuleNames")
    assert rules and not rules & {names.index("Copied"), names.index("Regular")}
    display.OrdinaryPoints, display.ReachOfPoints = 1, 0.0
    everything = drawn()
    assert sum(data.GetNumberOfPoints() for data in few) < sum(data.GetNumberOfPoints() for data in everything)
    for data, block in zip(everything, blocks_of_volume):
        counts = data.GetNumberOfVerts(), data.GetNumberOfPoints(), block.GetNumberOfPoints()
        assert len(set(counts)) == 1, counts
        ids = data.GetPointData().GetArray("vtkOriginalPointIds")
        assert all(data.GetPoint(n) == block.GetPoint(ids.GetValue(n)) for n in range(data.GetNumberOfPoints()))
    display.Representation = "Wall And Curves"
    simple.Hide(VOLUME, VIEW)


def test_volumes_of_files():
    quadflow = os.path.join(FOLDER.name, "volume.qfmb")
    simple.SaveData(quadflow, proxy=VOLUME)
    assert shown(simple.QuadflowReader(FileName=quadflow)).Representation == "Wall And Curves"


def test_samples():
    assert shown(simple.BSplineVolumeSampler(Input=VOLUME)).Representation == "Wall And Curves"


# Source by source as the arguments say: names of displays are definitions that ParaView merges when each is first made.
IN_ORDER = """
import os, sys
from paraview import simple
simple.LoadPlugin(os.environ["BSV_PLUGIN"], remote=False, ns=simple.__dict__)
mesh = simple.HexBlockMeshReader(FileName=sys.argv[1])
volume = simple.CatmullClarkToBSplineVolume(Input=mesh)
sources = {"mesh": mesh, "volume": volume, "quality": simple.BSplineVolumeQuality(Input=volume),
           "topology": simple.HexBlockTopology(Input=mesh)}
for name in sys.argv[2:]:
    print(name, simple.Show(sources[name], simple.CreateView("RenderView")).Representation)
"""


def test_any_display_may_be_first():
    script = os.path.join(FOLDER.name, "in_order.py")
    with open(script, "w") as file:
        file.write(IN_ORDER)
    for order in ["volume", "mesh", "topology"], ["quality", "topology", "volume", "mesh"]:
        said = subprocess.run(["pvpython", script, str(MESH.FileName), *order], stdout=subprocess.PIPE, text=True, check=True)
        assert said.stdout.splitlines() == [name + " 'Wall And Curves'" for name in order], said.stdout


def test_mirrored():
    wing = simple.WingFuselageSource(Resolution=2)
    assert shown(simple.MirrorHexBlocks(Input=wing)).Representation == "Wall And Curves"


def test_wall_spacing():
    spacing = simple.WallSpacing(Input=simple.WingFuselageSource(Resolution=2))
    assert shown(spacing) is None
    assert array_of(shown(spacing, 1)) == ("POINTS", "YPlus")


def test_smoothness():
    smoothness = simple.BSplineVolumeSmoothness(Input=VOLUME)
    # One picture, one legend, and the verdict.
    assert all(shown(smoothness, port) is None for port in (0, 1, 2, 3))
    lines = shown(smoothness, 4)
    assert array_of(lines) == ("POINTS", "Layer jump (degrees)") and legend_is_shown(lines)
    # Of all lines those of the chosen joins, where they kink and near the wall.
    assert lines.Representation == "Joins That Matter"
    few = drawn_lines(lines)
    lines.JoinClasses = "All"
    more = drawn_lines(lines)
    lines.LeastJump, lines.ReachOfJoins = 0.0, 0.0
    everything = drawn_lines(lines)
    assert few < more < everything == client(smoothness).GetOutputDataObject(4).GetNumberOfPoints()
    assert shown(smoothness, 5) is not None
    interfaces = simple.Show(smoothness, VIEW)
    interfaces.Representation = "Surface"
    assert array_of(interfaces) == ("POINTS", "Layer jump (degrees)")
    assert legend_is_shown(interfaces) and interfaces.LookupTable.UseLogScale == 1
    curves = simple.Show(simple.OutputPort(smoothness, 3), VIEW)
    assert array_of(curves) == ("POINTS", "NormalJump")
    # The list says of every join what it is, defects first.
    simple.ColorBy(lines, ("CELLS", "JoinClass"))
    assert lines.LookupTable.InterpretValuesAsCategories == 1
    data = client(smoothness).GetOutputDataObject(4)
    classes = data.GetCellData().GetArray("JoinClass")
    order = [classes.GetValue(n) for n in range(data.GetNumberOfCells())]
    # Defects, deliberate ones, expected ones, smooth ones.
    assert order == sorted(order, key=(0, 2, 1, 3).index) and len(order) == client(smoothness).GetOutputDataObject(2).GetNumberOfRows()
    smoothness.UpdatePropertyInformation()
    assert len(smoothness.GetProperty("JoinList")) == len(order)
    # Those who show the blocks see their worst joins.
    skins = simple.Show(simple.OutputPort(smoothness, 1), VIEW)
    assert array_of(skins) == ("CELLS", "LayerJump")


def test_quality():
    quality = simple.BSplineVolumeQuality(Input=VOLUME)
    # The wall as a ghost, coloured by the validity of its spans, and in it what was found.
    ghost = shown(quality)
    assert ghost.Representation == "Wall And Curves" and ghost.Opacity < 0.5
    assert array_of(ghost) == ("CELLS", "Validity")
    assert 0 < drawn_surface(ghost).GetNumberOfCells() < client(quality).GetOutputDataObject(0).GetNumberOfCells()
    assert shown(quality, 2).Representation == "Surface With Edges" and shown(quality, 3) is not None
    assert client(quality).GetOutputDataObject(2).GetNumberOfCells() == 0
    assert "spans are valid" in client(quality).GetOutputDataObject(3).GetColumnByName("Text").GetValue(0)
    display = simple.Show(quality, VIEW)
    display.Representation = "Surface With Edges"
    assert array_of(display) == ("CELLS", "Validity")
    table = display.LookupTable
    assert table.InterpretValuesAsCategories == 1
    named = dict(zip(table.Annotations[0::2], table.Annotations[1::2]))
    validity = client(quality).GetOutputDataObject(0).GetFieldData().GetAbstractArray("ValidityNames")
    assert named == {str(code): validity.GetValue(code) for code in range(3)}
    assert legend_is_shown(display)
    assert shown(quality, 1).Representation == "Points"


def test_bezier_cells():
    display = shown(simple.BSplineVolumeToBezierCells(Input=VOLUME))
    assert display.Representation == "Bezier Cells" and display.NonlinearSubdivisionLevel == 2
    few = drawn_surface(display).GetNumberOfCells()
    display.NonlinearSubdivisionLevel = 1
    assert few == 4 * drawn_surface(display).GetNumberOfCells()
    # Many are drawn more coarsely, unless that is not wanted.
    wing = simple.CatmullClarkToBSplineVolume(Input=simple.WingFuselageSource(Resolution=3), CheckJoins=0)
    cells = simple.BSplineVolumeToBezierCells(Input=wing, Cells="All Faces")
    display = shown(cells)
    cells.UpdatePipeline()
    count = cells.GetDataInformation().GetNumberOfCells()
    assert 3000 < count <= 20000, count
    many = drawn_surface(display).GetNumberOfCells()
    display.LevelBySize = 0
    assert drawn_surface(display).GetNumberOfCells() == 4 * many
    # Other grids keep ParaView's default.
    assert simple.Show(simple.UnstructuredCellTypes(), VIEW).NonlinearSubdivisionLevel == 1


def test_bezier_cells_are_drawn_as_they_are():
    """Of degrees 2 and 3, with weights: places and normals are those of VTK's evaluation, arrays follow the shape."""
    rng = random.Random(5)
    degree, level = (2, 3), 2
    grid, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
    points.SetDataTypeToDouble()
    arrays = [vtk.vtkDoubleArray() for _ in range(3)]
    for array, name, components in zip(arrays, ("RationalWeights", "Place", "Degrees"), (1, 3, 3)):
        array.SetName(name)
        array.SetNumberOfComponents(components)
    arrays[2].InsertNextTuple(degree + (0,))
    nodes = {}
    for b in range(degree[1] + 1):
        for a in range(degree[0] + 1):
            nodes[vtk.vtkBezierQuadrilateral.PointIndexFromIJK(a, b, degree + (0,))] = (a, b)
    for n in range(len(nodes)):
        place = [nodes[n][0] + rng.uniform(-.3, .3), nodes[n][1] + rng.uniform(-.3, .3), rng.uniform(0, 1)]
        points.InsertNextPoint(place)
        arrays[0].InsertNextTuple([rng.uniform(0.3, 2)])
        arrays[1].InsertNextTuple(place)
    grid.SetPoints(points)
    grid.InsertNextCell(vtk.VTK_BEZIER_QUADRILATERAL, len(nodes), list(range(len(nodes))))
    grid.GetPointData().SetRationalWeights(arrays[0])
    grid.GetPointData().AddArray(arrays[1])
    grid.GetCellData().SetHigherOrderDegrees(arrays[2])
    display = simple.Show(producer(grid), VIEW, "BezierCellsRepresentation")
    display.Representation, display.NonlinearSubdivisionLevel = "Bezier Cells", level
    drawn = drawn_surface(display)
    parts = max(degree) * 2 ** (level - 1)
    assert drawn.GetNumberOfCells() == parts ** 2 and drawn.GetNumberOfPoints() == 4 * parts ** 2

    def at(s, t):
        x = [0.0] * 3
        grid.GetCell(0).EvaluateLocation(vtk.mutable(0), (s, t, 0), x, [0.0] * len(nodes))
        return x
    data, step = drawn.GetPointData(), 1e-5
    for quad in range(parts ** 2):
        for n, (i, j) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
            point, s, t = 4 * quad + n, (quad % parts + i) / parts, (quad // parts + j) / parts
            assert math.dist(drawn.GetPoint(point), at(s, t)) < 1e-6
            assert math.dist(data.GetArray("Place").GetTuple(point), at(s, t)) < 1e-6
            normal = [0.0] * 3
            vtk.vtkMath.Cross(*([a - b for a, b in zip(at(s + ds, t + dt), at(s - ds, t - dt))]
                                for ds, dt in ((step, 0), (0, step))), normal)
            vtk.vtkMath.Normalize(normal)
            assert math.dist(data.GetArray("Normals").GetTuple(point), normal) < 1e-4
            # The edges of the cell, not those of its parts.
            border = ((n == 0 and t == 0) or (n == 1 and s == 1) or (n == 2 and t == 1) or (n == 3 and s == 0))
            assert data.GetArray("vtkEdgeFlags").GetTuple1(point) == border


def test_topology():
    topology = simple.HexBlockTopology(Input=MESH)
    display = shown(topology)
    assert display.Representation == "Wall And Curves" and not array_of(display)[1]
    assert all(shown(topology, port) is None for port in (1, 2, 3))
    # Of the faces those of the wall.
    faces = client(topology).GetOutputDataObject(0).GetPartition(2, 0)
    wall = field_strings(client(topology).GetOutputDataObject(0), "BoundaryNames").index("WALL")
    tags = faces.GetCellData().GetArray("BoundaryTag")
    expected = sum(tags.GetValue(n) == wall for n in range(faces.GetNumberOfCells()))
    assert drawn_surface(display).GetNumberOfCells() == expected > 0


def test_deviation():
    mesh_file, body_file = make_body_case.write_case(FOLDER.name, 4)
    body = simple.NURBSSurfaceReader(FileName=body_file)
    volume = simple.CatmullClarkToBSplineVolume(Input=simple.HexBlockMeshReader(FileName=mesh_file), Body=body)
    # The body is that of the conversion.
    deviation = simple.BodyDeviation(Input=volume)
    display = shown(deviation)
    hairs = shown(deviation, 2)
    assert hairs.PointSize > 5
    # The lines cross where the distance is the largest.
    place = client(deviation).GetOutputDataObject(2).GetPoint(0)
    wall = client(deviation).GetOutputDataObject(0).GetPartition(0, 0)
    distances = wall.GetPointData().GetArray("Distance")
    largest = max(distances.GetTuple1(n) for n in range(distances.GetNumberOfTuples()))
    near = wall.FindPoint(place)
    assert wall.GetPoint(near) == place and distances.GetTuple1(near) == largest > 0
    assert display.Representation == "Surface" and array_of(display) == ("POINTS", "Distance")
    assert legend_is_shown(display)
    assert names(client(deviation).GetOutputDataObject(0)) == ["Wall", "Body"]
    assert all(names(update(body)[0]))


def test_blocks_have_names():
    """As the Multi-block Inspector shows them."""
    expected = names(update(VOLUME)[0])
    assert len(set(expected)) == len(expected) > 1 and all(expected)
    assert all(names(update(MESH)[0]))
    smoothness, quality = simple.BSplineVolumeSmoothness(Input=VOLUME), simple.BSplineVolumeQuality(Input=VOLUME)
    assert names(update(quality)[0]) == names(update(simple.BSplineVolumeSampler(Input=VOLUME))[0]) == expected
    interfaces, _ = update(smoothness)
    assert all("|" in name for name in names(interfaces)) and len(blocks(interfaces)) == len(names(interfaces))
    assert names(client(smoothness).GetOutputDataObject(1)) == expected
    assert names(update(simple.HexBlockTopology(Input=MESH))[0]) == ["Vertices", "Edges", "Faces"]


def forget(described):
    """ParaView keeps imported presets for the next session."""
    known = servermanager.vtkSMTransferFunctionPresets.GetInstance()
    for n in reversed(range(known.GetNumberOfPresets())):
        if known.GetPresetName(n) in [preset["Name"] for preset in described]:
            assert known.RemovePreset(n)


def test_colour_presets():
    """The presets beside the plugin can be imported, and are what arrays begin with."""
    file = os.path.join(PLUGIN, "BSplineVolumePresets.json")
    with open(file) as text:
        described = json.load(text)
    assert len(described) == 8
    known = servermanager.vtkSMTransferFunctionPresets.GetInstance()
    forget(described)
    simple.ImportPresets(file)
    for preset in described:
        assert known.HasPreset(preset["Name"])
        for array in preset["Arrays"]:
            begins_with = simple.GetColorTransferFunction(array)
            chosen = simple.GetColorTransferFunction("of preset " + preset["Name"])
            assert chosen.ApplyPreset(preset["Name"], True)
            if "Annotations" in preset:
                assert begins_with.InterpretValuesAsCategories == chosen.InterpretValuesAsCategories == 1
                assert list(begins_with.Annotations) == preset["Annotations"]
                assert list(begins_with.IndexedColors) == list(chosen.IndexedColors) == preset["IndexedColors"]
                assert 3 * len(preset["Annotations"]) == 2 * len(preset["IndexedColors"])
            else:
                colors = [[table.RGBPoints[n] for n in range(len(table.RGBPoints)) if n % 4]
                          for table in (begins_with, chosen)]
                assert colors[0] == colors[1] and begins_with.ColorSpace == chosen.ColorSpace == preset["ColorSpace"]
    forget(described)


def hints(group, name):
    element = servermanager.ProxyManager().GetPrototypeProxy(group, name).GetHints()
    return [element.GetNestedElement(n) for n in range(element.GetNumberOfNestedElements())]


def test_menus():
    for group, proxies in (("sources", SOURCES), ("filters", FILTERS)):
        for name in proxies:
            menu, = [hint for hint in hints(group, name) if hint.GetName() == "ShowInMenu"]
            assert menu.GetAttribute("category") == "BSplineVolume", name
            # Icons of ParaView's own: an image of ours would make the plugin depend on Qt, servers too.
            assert group == "sources" or menu.GetAttribute("icon").startswith(":/pqWidgets/Icons/"), name


def properties_of(proxy):
    found = proxy.NewPropertyIterator()
    found.UnRegister(None)
    found.Begin()
    while not found.IsAtEnd():
        yield found.GetKey(), found.GetProperty()
        found.Next()


def test_lists_say_what_they_list():
    """ParaView gives lists no label, unless asked to; a group of one list has its name above."""
    for group, proxies in (("sources", SOURCES), ("filters", FILTERS), ("writers", WRITERS)):
        for name in proxies:
            proxy = servermanager.ProxyManager().GetPrototypeProxy(group, name)
            groups = [proxy.GetPropertyGroup(n) for n in range(proxy.GetNumberOfPropertyGroups())]
            alone = {g.GetPropertyName(0) for g in groups if g.GetNumberOfProperties() == 1}
            for key, prop in properties_of(proxy):
                if prop.IsA("vtkSMVectorProperty") and not prop.IsA("vtkSMProxyProperty") and prop.GetRepeatable() and \
                        not prop.GetInformationOnly() and key not in alone | {"FileName"}:
                    hints_of = prop.GetHints()
                    assert hints_of and hints_of.FindNestedElementByName("ShowLabel"), (name, key)


def test_file_dialogs():
    readers = servermanager.vtkSMProxyManager.GetProxyManager().GetReaderFactory()
    session = servermanager.ActiveConnection.Session
    offered = readers.GetSupportedFileTypes(session)
    for description, extensions in (("NURBS surfaces", "igs iges stp step brep g2"), ("B-spline volumes", "g2 mesh"),
                                    ("Quadflow Topology", "qfmb")):
        assert description in offered
        for extension in extensions.split():
            assert "*." + extension in offered, extension
    assert readers.CanReadFile(MESH.FileName[0], session)
    writers = servermanager.vtkSMProxyManager.GetProxyManager().GetWriterFactory()
    assert "qfmb" in writers.GetSupportedFileTypes(VOLUME.SMProxy, 0)


def test_help():
    """Every proxy has a page in the plugin's help, on which every property says what it is."""
    pages = {}
    if not os.path.exists(os.path.join(HELP, "BSplineVolume.qch")) and (5, 12) <= simple.GetParaViewVersion() < (6, 0):
        print("no help pages: ParaView 5.12 and 5.13 with Qt 6 cannot build those of a plugin; the panel has the texts")
        return
    with contextlib.closing(sqlite3.connect(os.path.join(HELP, "BSplineVolume.qch"))) as archive:
        for name, content in archive.execute("select Name, Data from FileNameTable join FileDataTable on FileId = Id "
                                             "where Name like '%.html'"):
            pages[name] = zlib.decompress(content[4:]).decode()  # Qt puts the length in front
    for group, proxies in (("sources", SOURCES), ("filters", FILTERS), ("writers", WRITERS)):
        for name in proxies:
            proxy = servermanager.ProxyManager().GetPrototypeProxy(group, name)
            page = pages["%s.%s.html" % (group, name)]
            documentation = proxy.GetDocumentation()
            for text in (documentation.GetDescription(), documentation.GetShortHelp(), documentation.GetLongHelp()):
                assert text, name
            for key, prop in properties_of(proxy):
                text = prop.GetDocumentation()
                assert text and text.GetDescription(), (name, key)
                if not prop.GetInformationOnly():
                    assert "<th>%s</th>" % prop.GetXMLLabel() in page, (name, key)


if __name__ == "__main__":
    HELP = sys.argv[1]
    run_tests(globals())
