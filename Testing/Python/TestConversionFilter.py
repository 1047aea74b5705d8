# SPDX-License-Identifier: BSD-3-Clause
"""vtkCatmullClarkToBSplineVolume through its proxy: properties, output data, errors, threads, abort."""
import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (simple, vtk, bits, blocks, client, collection, coordinates, creased_mesh, demo_mesh, dimensions,
                         failure, field, grid, main, names, producer, update, values)

RULES = ["Copied", "Regular", "Boundary", "Symmetry", "PlanarSide", "Body", "BodyExtraordinaryVertex", "Crease",
         "Corner", "ExtraordinaryEdge", "SingularNode", "WallLayer", "FarFieldLayer"]
DEMO = demo_mesh(8)
_CACHE = {}


def conversion(mesh, **properties):
    return simple.CatmullClarkToBSplineVolume(Input=mesh if hasattr(mesh, "SMProxy") else producer(mesh), **properties)


def array(name, numbers):
    data = vtk.vtkDoubleArray()
    data.SetName(name)
    for number in numbers:
        data.InsertNextValue(number)
    return data


def converted_demo():
    if not _CACHE:
        proxy = conversion(DEMO, UseCreaseAngle=1)
        data, warnings = update(proxy)
        proxy.UpdatePropertyInformation()
        _CACHE.update(proxy=proxy, data=data, warnings=warnings)
    return _CACHE["proxy"], _CACHE["data"], _CACHE["warnings"]


def rule_counts(data):
    counts = [0] * len(RULES)
    for block in blocks(data):
        for rule in values(block.GetPointData().GetArray("ControlPointRule")):
            counts[int(rule)] += 1
    return dict(zip(RULES, counts))


def face_points(block, face):
    """Control points of a face as {(s, t): xyz}, and the counts along s and t."""
    dims = dimensions(block)
    normal = face // 2
    u, v = [d for d in range(3) if d != normal]
    ijk = [0, 0, 0]
    ijk[normal] = dims[normal] - 1 if face % 2 else 0
    found = {}
    for t in range(dims[v]):
        for s in range(dims[u]):
            ijk[u], ijk[v] = s, t
            found[s, t] = block.GetPoint(ijk[0] + dims[0] * (ijk[1] + dims[1] * ijk[2]))
    return found, (dims[u], dims[v])


def test_properties():
    proxy = conversion(DEMO)
    assert list(proxy.BodyBoundaries) == ["wall*", "bcwall*", "body*", "no*slip*", "viscous*", "solid*"]
    assert list(proxy.SymmetryBoundaries) == ["sym*", "bcsym*"]
    assert list(proxy.BodyFaces) == []
    assert proxy.PlanarSides == "FarField" and proxy.Twist == "SecondFundamentalForm"
    assert abs(proxy.WallSpacing - 2 / 3) < 1e-15 and proxy.CreaseAngle == 30 and proxy.PlanarTolerance == 1e-6
    assert proxy.WallSpacingMode == "Constant" and list(proxy.BoundaryWallSpacing) == []
    assert proxy.WallSpacingArray == "WallSpacing"
    assert proxy.FarFieldSpacing == "SideAverage" and list(proxy.ExtensionBlocks) == []
    assert proxy.PropagationRange == 8
    assert abs(proxy.MatchTolerance - 0.05) < 1e-15
    assert not proxy.AllowDegenerate and not proxy.UseCreaseAngle
    proxy.BodyBoundaries = ["hull", "*Keel*"]
    proxy.BodyFaces = [0, 4, 1, 5]
    proxy.SMProxy.UpdateVTKObjects()
    assert [client(proxy).GetBodyBoundary(n) for n in range(client(proxy).GetNumberOfBodyBoundaries())] == \
        ["hull", "*Keel*"]
    assert client(proxy).GetNumberOfBodyFaces() == 2
    for name, value in (("PlanarSides", "All"), ("PlanarSides", "None"), ("Twist", "Parallelogram"),
                        ("Twist", "Mask")):
        proxy.SetPropertyWithName(name, value)
        assert proxy.GetPropertyValue(name) == value


def test_linear_data():
    """Control points of linear data are the Greville points: 0, 1/3, 1, .., I-1, I-1/3, I in every direction."""
    cells = (1, 2, 5)

    def place(i, j, k):
        return 2 * i + j + 1, 3 * j - k, 0.5 * i + 4 * k

    data, warnings = update(conversion(grid(cells, place)))
    assert not warnings
    block, = blocks(data)
    assert dimensions(block) == tuple(n + 3 for n in cells)
    assert coordinates(block).IsA("vtkDoubleArray")
    assert field(block, "Degree") == [3, 3, 3]
    assert field(block, "ParentBlock") == [0] and field(block, "ParentOffset") == [0, 0, 0]
    greville = []
    for n, name in zip(cells, ("KnotsU", "KnotsV", "KnotsW")):
        knots = field(block, name)
        assert knots == [0, 0, 0] + list(range(n + 1)) + [n, n, n]
        greville.append([sum(knots[a + 1:a + 4]) / 3 for a in range(n + 3)])
    point = 0
    for c in greville[2]:
        for b in greville[1]:
            for a in greville[0]:
                assert max(abs(x - y) for x, y in zip(block.GetPoint(point), place(a, b, c))) < 1e-13
                point += 1


def test_demo():
    proxy, data, warnings = converted_demo()
    made = blocks(data)
    assert len(made) == proxy.NumberOfBlocks == 16 and proxy.NumberOfInputBlocks == 11
    assert len(set(names(data))) == 16
    assert not warnings and "blocks were split" in proxy.Report
    assert proxy.NumberOfExtraordinaryEdges == 8 and proxy.NumberOfSingularNodes == 0
    assert field(data, "ControlPointRuleNames") == RULES
    counts = rule_counts(data)
    assert list(proxy.ControlPointsPerRule) == list(counts.values())
    assert proxy.NumberOfControlPoints == sum(counts.values()) == sum(b.GetNumberOfPoints() for b in made)
    for rule in RULES:
        assert (counts[rule] > 0) == (rule not in ("SingularNode", "FarFieldLayer")), counts
    # Four extraordinary vertices of valence 3 on the body; their twelve patch corners.
    assert counts["BodyExtraordinaryVertex"] >= 12
    assert "4 extraordinary curves of valence 3" in proxy.Report
    assert "WALL: body" in proxy.Report and "SYMMETRY: symmetry plane" in proxy.Report


def test_repeated_knots():
    """Blocks with creases inside stay those of the input, and join and are valid as their pieces are."""
    mesh = creased_mesh()
    found = []
    for inside in ("Cut", "RepeatedKnots"):
        proxy = conversion(mesh, CreasesInsideBlocks=inside, CheckJoins=1, CheckSpans="All")
        data, warnings = update(proxy)
        assert not warnings
        quality, smoothness = simple.BSplineVolumeQuality(Input=proxy), simple.BSplineVolumeSmoothness(Input=proxy)
        for measured in (proxy, quality, smoothness):
            update(measured)
            measured.UpdatePropertyInformation()
        samples, _ = update(simple.BSplineVolumeSampler(Input=proxy))
        cells, _ = update(simple.BSplineVolumeToBezierCells(Input=proxy, Cells="Volume"))
        found.append({"data": data, "report": proxy.Report, "all": (
            [smoothness.GetProperty("Maximum" + name).GetData() for name in (
                "Gap", "NormalJump", "LayerJump", "Kink", "C1Jump", "C2Jump")],
            smoothness.NumberOfInterfaces, smoothness.NumberOfWallBorders, smoothness.Report.split(" joins: ")[1][:40],
            quality.NumberOfSpans, quality.NumberOfInvalidSpans, quality.NumberOfUndecidedSpans,
            proxy.NumberOfCheckedSpans, proxy.NumberOfInvalidSpans, cells.GetNumberOfCells(),
            len({point for block in blocks(samples) for point in values(coordinates(block))}),
            len(set(values(coordinates(cells)))))})
        assert proxy.NumberOfControlPoints == sum(rule_counts(data).values())
        assert proxy.NumberOfBlocks == len(blocks(data))
    cut, whole = found
    assert cut["all"] == whole["all"], (cut["all"], whole["all"])
    assert len(blocks(cut["data"])) == 6 and len(blocks(whole["data"])) == 2
    assert "split along creases: block 0 \"part 0\" into 4, block 1 \"part 1\" into 2." in cut["report"]
    assert "2 blocks stay whole, with knots of multiplicity 3 where creases would cut: part 0, part 1." \
        in whole["report"] and "split" not in whole["report"]
    first, second = blocks(whole["data"])
    assert field(first, "KnotsU") == [0, 0, 0, 0, 1, 2, 2, 2, 3, 4, 4, 4, 4] == field(first, "KnotsV")
    assert field(second, "KnotsU") == [0, 0, 0, 0, 1, 2, 3, 3, 3, 3]
    assert field(second, "KnotsV") == field(first, "KnotsV") and field(first, "KnotsW") == [0, 0, 0, 0, 1, 2, 2, 2, 2]
    assert names(whole["data"]) == ["part 0", "part 1"]
    assert [tuple(map(int, row[:5])) for row in field(whole["data"], "Interfaces")] == [(0, 1, 1, 0, 0)]
    # Creases count control points, those of the repeated knots included.
    assert [tuple(map(int, row)) for row in field(whole["data"], "CreaseEdges")] == [
        (0, 0, 4, 0, 8, 4, 0), (0, 4, 0, 0, 4, 4, 0), (1, 0, 4, 0, 5, 4, 0)]
    points = {point for block in blocks(cut["data"]) for point in values(coordinates(block))}
    assert points == {point for block in blocks(whole["data"]) for point in values(coordinates(block))}


def test_names_and_assembly():
    _, data, _ = converted_demo()
    assembly = data.GetDataAssembly()
    assert assembly.GetNumberOfChildren(0) == 16
    listed = [assembly.GetDataSetIndices(assembly.GetChild(0, n)) for n in range(16)]
    assert sorted(index for indices in listed for index in indices) == list(range(16))


def test_parents():
    """The pieces of an input block fill it without overlap, and their far-field corners are its mesh points."""
    _, data, _ = converted_demo()
    inputs = blocks(client(DEMO).GetOutputDataObject(0))
    cells = [0] * len(inputs)
    for block in blocks(data):
        parent, = field(block, "ParentBlock")
        size = [n - 3 for n in dimensions(block)]
        whole = [n - 1 for n in dimensions(inputs[int(parent)])]
        offset = field(block, "ParentOffset")
        assert all(o >= 0 and o + s <= w for o, s, w in zip(offset, size, whole))
        cells[int(parent)] += size[0] * size[1] * size[2]
    assert cells == [block.GetNumberOfCells() for block in inputs]


def test_shared_points():
    """Control points of the two sides of every interface are the same bits."""
    _, data, _ = converted_demo()
    made = blocks(data)
    interfaces = field(data, "Interfaces")
    boundaries = field(data, "Boundaries")
    assert 2 * len(interfaces) + len(boundaries) == 6 * len(made)
    for a, face_a, b, face_b, code in (tuple(int(n) for n in row[:5]) for row in interfaces):
        points_a, (ns, nt) = face_points(made[a], face_a)
        points_b, size_b = face_points(made[b], face_b)
        assert size_b == ((nt, ns) if code & 1 else (ns, nt))
        for (s, t), x in points_a.items():
            u, v = (t, s) if code & 1 else (s, t)
            u = size_b[0] - 1 - u if code & 2 else u
            v = size_b[1] - 1 - v if code & 4 else v
            assert points_b[u, v] == x


def test_far_field_and_symmetry_stay_planar():
    _, data, _ = converted_demo()
    made = blocks(data)
    boundary = field(data, "BoundaryNames")
    for row in field(data, "Boundaries"):
        block, face, tag = (int(n) for n in row[:3])
        points, _ = face_points(made[block], face)
        extent = [max(p[d] for p in points.values()) - min(p[d] for p in points.values()) for d in range(3)]
        if boundary[tag] == "SYMMETRY":
            assert max(abs(p[1]) for p in points.values()) == 0.0
        elif boundary[tag] == "FARFIELD":
            assert min(extent) < 1e-12, (extent, block, face)


def test_roles():
    """Names that do not match give no body; selected faces give the same body as names."""
    _, data, _ = converted_demo()
    proxy = conversion(DEMO, UseCreaseAngle=1, BodyBoundaries=["hull"])
    without, _ = update(proxy)
    counts = rule_counts(without)
    assert counts["Body"] == counts["BodyExtraordinaryVertex"] == counts["WallLayer"] == 0
    proxy.UpdatePropertyInformation()
    assert "no body" in proxy.Report

    mesh = client(DEMO).GetOutputDataObject(0)
    wall = field(mesh, "BoundaryNames").index("WALL")
    faces = [int(n) for row in field(mesh, "Boundaries") if row[2] == wall for n in row[:2]]
    proxy.BodyFaces = faces
    selected, _ = update(proxy)
    assert bits(selected) == bits(data)

    proxy.BodyFaces = []
    proxy.BodyBoundaries = ["w?L*"]
    wildcard, _ = update(proxy)
    assert bits(wildcard) == bits(data)


def test_options_matter():
    _, data, _ = converted_demo()
    for properties in (dict(WallSpacing=0.8), dict(PlanarSides="None"), dict(PlanarSides="All"), dict(Twist="Mask"),
                       dict(Twist="Parallelogram"), dict(PropagationRange=0), dict(SymmetryBoundaries=["nothing"])):
        other, _ = update(conversion(DEMO, UseCreaseAngle=1, **properties))
        assert bits(other) != bits(data), properties


def test_far_field_spacing():
    """The extension's first layer follows the last cells before it, 1 long, and not its own, 3 long."""
    mesh = collection([grid((4, 2, 2), lambda i, j, k: (i, j, k)), grid((3, 2, 2), lambda i, j, k: (4 + 3 * i, j, k))])
    for b, name in enumerate(("inner", "Extension 1")):
        mesh.GetMetaData(b).Set(vtk.vtkCompositeDataSet.NAME(), name)

    def first(**properties):
        proxy = conversion(mesh, **properties)
        data, warnings = update(proxy)
        assert not warnings
        proxy.UpdatePropertyInformation()
        return blocks(data)[1].GetPoint(1)[0] - 4, rule_counts(data)["FarFieldLayer"], proxy.Report

    for spacing, distance in (("Off", 1), ("SideAverage", 1 / 3), ("PerVertex", 1 / 3)):
        x, layer, report = first(ExtensionBlocks=["ext*"], FarFieldSpacing=spacing)
        assert abs(x - distance) < 1e-14 and (layer > 0) == (spacing != "Off")
        assert ("planar sides with a far-field extension: 1" in report) == (spacing != "Off")
    # Not recognised, for there is no body; and not planar if no side shall be.
    assert first()[1] == first(ExtensionBlocks=["ext*"], PlanarSides="None")[1] == 0


def test_given_surface():
    """Projection points and normals of the mesh are used at extraordinary body vertices."""
    import make_demo_mesh
    mesh = client(DEMO).GetOutputDataObject(0)
    corners = {make_demo_mesh.mesh_point((a, 4, c, 0), 4, 16) for a in (-4, 4) for c in (-4, 4)}
    moved = {corner: tuple(0.98 * x for x in corner) for corner in corners}
    copy = mesh.NewInstance()
    copy.DeepCopy(mesh)
    marked = 0
    for block in blocks(copy):
        arrays = []
        for name in ("ProjectedPoint", "SurfaceNormal"):
            array = vtk.vtkDoubleArray()
            array.SetName(name)
            array.SetNumberOfComponents(3)
            array.SetNumberOfTuples(block.GetNumberOfPoints())
            array.Fill(float("nan"))
            block.GetPointData().AddArray(array)
            arrays.append(array)
        for n in range(block.GetNumberOfPoints()):
            x = block.GetPoint(n)
            if x in moved:
                length = sum(c * c for c in x) ** 0.5
                arrays[0].SetTuple3(n, *moved[x])
                arrays[1].SetTuple3(n, *(c / length for c in x))
                marked += 1
    assert marked == 4 * 3
    data, _ = update(conversion(copy, UseCreaseAngle=1))
    found = set()
    for block in blocks(data):
        rules = values(block.GetPointData().GetArray("ControlPointRule"))
        found |= {block.GetPoint(n) for n, rule in enumerate(rules) if RULES[int(rule)] == "BodyExtraordinaryVertex"}
    assert set(moved.values()) <= found
    # The inserted points beside them lie in the given tangent planes.
    for corner, point in moved.items():
        length = sum(c * c for c in corner) ** 0.5
        heights = sorted(abs(sum(c / length * (q - p) for c, p, q in zip(corner, point, x))) for x in found
                         if max(abs(p - q) for p, q in zip(point, x)) < 0.2)
        assert len(heights) >= 4 and heights[3] < 1e-13, heights


def test_multiblock_input():
    """Other trees than the reader's, and blocks without any names."""
    tree = vtk.vtkMultiBlockDataSet()
    for b in range(2):
        tree.SetBlock(b, grid((2, 2, 2), lambda i, j, k: (i, j, k), (2 * b, 0, 0)))
    data, _ = update(conversion(tree))
    assert len(blocks(data)) == 2 and len(field(data, "Interfaces")) == 1
    assert data.GetFieldData().GetAbstractArray("Boundaries") is None


def test_threads():
    reference = None
    for threads in (1, 2, 3):
        vtk.vtkSMPTools.SetBackend("STDThread")
        vtk.vtkSMPTools.Initialize(threads)
        data, _ = update(conversion(DEMO, UseCreaseAngle=1))
        reference = reference or bits(data)
        assert bits(data) == reference
    vtk.vtkSMPTools.Initialize()


def test_progress_and_abort():
    seen = []
    proxy = conversion(DEMO, UseCreaseAngle=1)
    client(proxy).AddObserver("ProgressEvent", lambda filter, _: seen.append(filter.GetProgress()))
    update(proxy)
    assert len(seen) > 4 and seen == sorted(seen) and 0 <= seen[0] and seen[-1] == 1.0

    for when in (0.0, 0.5, 0.9):
        proxy = conversion(DEMO, UseCreaseAngle=1)
        client(proxy).AddObserver(
            "ProgressEvent", lambda filter, _: filter.SetAbortExecute(filter.GetProgress() >= when))
        data, warnings = update(proxy)
        assert data.GetNumberOfPartitionedDataSets() == 0 and not warnings


def test_verdict_counts_what_quality_proves():
    """Also where the cells of the mesh are collapsed, which nothing can decide, or inverted, which is proven."""
    def pole(i, j, k):
        angle, radius = 0.25 * math.pi * i, 0.0 if j == 0 else 0.5 * j
        return 0.1 + radius * math.cos(angle), 0.2 + radius * math.sin(angle), k / 3

    def inverted(i, j, k):
        return (-4.0 if (i, j, k) == (2, 2, 2) else float(i)), float(j), float(k)

    for place, decided in ((pole, False), (inverted, True)):
        for continuity in "SingleKnots", "ExactG1":
            mesh = producer(collection([grid((2, 3, 3), place), grid((2, 3, 3), place, (2, 0, 0))]))
            proxy = conversion(mesh, AllowDegenerate=1, CheckSpans="All", Continuity=continuity)
            update(proxy)
            proxy.UpdatePropertyInformation()
            quality = simple.BSplineVolumeQuality(Input=proxy)
            update(quality)
            quality.UpdatePropertyInformation()
            invalid, undecided = quality.NumberOfInvalidSpans, quality.NumberOfUndecidedSpans
            assert (invalid > 0 and undecided == 0) if decided else (invalid == 0 and undecided > 0)
            line = "Spans: %d checked, %d invalid, %d undecided" % (quality.NumberOfSpans, invalid, undecided)
            assert line in proxy.Report, proxy.Report


def test_errors():
    for value in (0, 1, -1):
        assert f"Wall Spacing {value} is not" in failure(conversion(DEMO, WallSpacing=value))
    assert "Wall Spacing: nan is no finite number" in failure(conversion(DEMO, WallSpacing=float("nan")))
    volume = conversion(DEMO)
    for of_meshes in (simple.CatmullClarkToBSplineVolume, simple.MirrorHexBlocks, simple.WallSpacing):
        assert "Input is a B-spline volume already" in failure(of_meshes(Input=volume))
    assert "Planar Tolerance -1 is not" in failure(conversion(DEMO, PlanarTolerance=-1))
    assert "Propagation Range -1 is not" in failure(conversion(DEMO, PropagationRange=-1))
    assert "Match Tolerance 0 is not" in failure(conversion(DEMO, MatchTolerance=0))
    assert "Crease Angle 200 is not" in failure(conversion(DEMO, UseCreaseAngle=1, CreaseAngle=200))
    text = failure(conversion(DEMO, BodyFaces=[11, 0]))
    assert "Body Faces" in text and "11" in text

    wrong = grid((2, 2, 2), lambda i, j, k: (i, j, k))
    normals = vtk.vtkDoubleArray()
    normals.SetName("SurfaceNormal")
    normals.SetNumberOfComponents(2)
    normals.SetNumberOfTuples(27)
    wrong.GetPointData().AddArray(normals)
    assert "SurfaceNormal" in failure(conversion(wrong))


def test_recovers_after_an_error():
    proxy = conversion(DEMO, UseCreaseAngle=1, WallSpacing=-1)
    failure(proxy)
    proxy.WallSpacing = 2 / 3
    data, _ = update(proxy)
    assert bits(data) == bits(converted_demo()[1])


def test_lists_of_a_script_are_complete():
    """What a script, or a state in Python, lists before the mesh is known is on, and nothing else."""
    def roles(source, **properties):
        proxy = conversion(source, **properties)
        data, warnings = update(proxy)
        return dict(zip(field(data, "BoundaryNames"), field(data, "BoundaryRoles"))), warnings
    wing = dict(Resolution=2)
    default, _ = roles(simple.WingFuselageSource(**wing))
    assert default == {"wall_fuselage": 1, "wall_wing": 1, "symmetry": 2, "farfield": 0}, default
    one, warnings = roles(simple.WingFuselageSource(**wing), Walls=["wall_wing"])
    assert one == dict(default, wall_fuselage=0) and not warnings, one
    one, warnings = roles(simple.WingFuselageSource(**wing), SymmetryPlanes=["farfield"])
    assert one == dict(default, symmetry=0, farfield=2) and not warnings, one
    none, warnings = roles(simple.WingFuselageSource(**wing), Walls=["wing"])
    assert none == dict(default, wall_fuselage=0, wall_wing=0), none
    assert len(warnings) == 1 and "Walls: 'wing' is no boundary of the mesh" in warnings[0], warnings
    # The same after the mesh is known, where all boundaries have check boxes.
    proxy = conversion(simple.WingFuselageSource(**wing))
    update(proxy)
    proxy.UpdatePipelineInformation()
    proxy.Walls = ["wall_wing"]
    data, warnings = update(proxy)
    assert field(data, "BoundaryRoles")[:2] == [0, 1] and not warnings, field(data, "BoundaryRoles")


def test_inputs_without_hexahedra():
    surface = vtk.vtkUnstructuredGrid()
    surface.SetPoints(grid((1, 1, 1), lambda *p: p).GetPoints())
    surface.InsertNextCell(vtk.VTK_TRIANGLE, 3, (0, 1, 2))
    for empty in (vtk.vtkPartitionedDataSetCollection(), vtk.vtkMultiBlockDataSet(), collection([]),
                  collection([vtk.vtkStructuredGrid()]), vtk.vtkStructuredGrid(), vtk.vtkUnstructuredGrid(),
                  vtk.vtkImageData(), surface):
        text = failure(conversion(empty))
        assert "the input has no hexahedra" in text, text
        assert ("1 triangles and polygons are left out" in text) == (empty is surface), text


def test_images_and_rectilinear_grids():
    """They are structured grids whose points are given in another way, alone and in trees."""
    image = vtk.vtkImageData()
    image.SetExtent(2, 5, -1, 3, 0, 2)
    image.SetSpacing(0.5, 0.25, 2.0)
    image.SetOrigin(1.0, 2.0, 3.0)
    rectilinear = vtk.vtkRectilinearGrid()
    rectilinear.SetDimensions(4, 3, 5)
    x = ((0.0, 1.0, 3.0, 4.0), (0.0, 2.0, 3.0), (0.0, 1.0, 2.0, 4.0, 8.0))
    for name, places in zip("XYZ", x):
        getattr(rectilinear, "Set%sCoordinates" % name)(array(name, places))
    expected = {
        image: grid((3, 4, 2), lambda i, j, k: (1 + 0.5 * i, 2 + 0.25 * j, 3 + 2.0 * k), (2, -1, 0)),
        rectilinear: grid((3, 2, 4), lambda i, j, k: (x[0][i], x[1][j], x[2][k])),
    }
    for given, same in expected.items():
        sharpness = array("CreaseSharpness", [10.0 * (n % 4 == 0) for n in range(given.GetNumberOfPoints())])
        for data in (given, same):
            data.GetPointData().AddArray(sharpness)
        right, _ = update(conversion(same))
        tree = vtk.vtkMultiBlockDataSet()
        tree.SetBlock(0, given)
        for data in (given, tree, collection([given])):
            found, warnings = update(conversion(data))
            assert bits(found) == bits(right) and not warnings
        assert tree.GetBlock(0) is given
        made, _ = update(simple.HexMeshToBlocks(Input=producer(given)))
        assert len(blocks(made)) == 1 and blocks(made)[0].GetNumberOfCells() == given.GetNumberOfCells()
        faces, _ = update(simple.HexBlockTopology(Input=producer(given)))
        assert blocks(faces)[2].GetNumberOfCells() > 0
    # Half of the cells hidden: as of a structured grid.
    blanked = vtk.vtkUniformGrid()
    blanked.SetDimensions(5, 3, 3)
    blanked.AllocateCellGhostArray()
    for cell in range(blanked.GetNumberOfCells()):
        if cell % 4 < 2:
            blanked.BlankCell(cell)
    data, warnings = update(conversion(blanked))
    assert dimensions(blocks(data)[0]) == (5, 5, 5) and "8 hidden" in warnings[0], warnings


if __name__ == "__main__":
    main(globals())
