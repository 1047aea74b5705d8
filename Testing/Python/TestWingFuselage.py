# SPDX-License-Identifier: BSD-3-Clause
"""Wing Fuselage Source through ParaView: the menu's proxy, conversion with its body, writers and readers."""
import collections
import math
import os
import tempfile

from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

from bsv_support import (blocks, client, collection, coordinates, dimensions, failure, field, has_opencascade, main,
                         messages, names, producer, simple, update, values, vtk)


def source(**properties):
    return simple.WingFuselageSource(**properties)


def output(proxy, port):
    proxy.UpdatePipeline()
    return client(proxy).GetOutputDataObject(port)


def body_of(proxy):
    return simple.OutputPort(proxy, 1)


def test_proxy():
    manager = simple.servermanager.ProxyManager()
    prototype = manager.GetPrototypeProxy("sources", "WingFuselageSource")
    assert prototype.GetXMLLabel() == "Wing Fuselage Source"
    assert [prototype.GetOutputPortName(i) for i in range(prototype.GetNumberOfOutputPorts())] == ["Mesh", "Body"]
    hints = prototype.GetHints()
    assert any(hints.GetNestedElement(i).GetName() == "ShowInMenu" for i in range(hints.GetNumberOfNestedElements()))


def test_mesh():
    proxy = source(Resolution=3)
    data, warnings = update(proxy)
    proxy.UpdatePropertyInformation()
    assert not warnings and len(blocks(data)) == 79
    assert proxy.NumberOfMeshPoints == sum(block.GetNumberOfPoints() for block in blocks(data))
    assert 0.1 < proxy.MinimumScaledJacobian < 1
    assert set(field(data, "BoundaryNames")) == {"wall_fuselage", "wall_wing", "symmetry", "farfield"}
    assert len(set(names(data))) == 79
    boundary_names = field(data, "BoundaryNames")
    counts = collections.Counter(boundary_names[int(tag)] for _, _, tag in field(data, "Boundaries"))
    assert counts["wall_fuselage"] == 4 and counts["wall_wing"] == 5, counts
    # In the symmetry plane: 16 blocks around the fuselage, 2 beside them, 5 x 3 - 3 of the extension.
    assert counts["symmetry"] == 30, counts
    # The outer boundary: ends, top and bottom in span 3 each, and the side 5 x 3.
    assert counts["farfield"] == 2 * 3 * 3 + 2 * 5 * 3 + 5 * 3, counts


def test_conversion():
    proxy = source(Resolution=3)
    volume = simple.CatmullClarkToBSplineVolume(Input=proxy, Body=body_of(proxy))
    data, warnings = update(volume)
    assert not warnings, warnings
    assert len(blocks(data)) == 79
    for before, after in zip(blocks(output(proxy, 0)), blocks(data)):
        assert tuple(n + 2 for n in dimensions(before)) == dimensions(after)
    # The mesh is a control net already, whose limit points lie on the body.
    volume.UpdatePropertyInformation()
    assert "input points taken as ControlNet, chosen automatically" in volume.Report
    deviation = simple.BodyDeviation(Input=volume, Body=body_of(proxy), Level=0)
    update(deviation)
    deviation.UpdatePropertyInformation()
    coarse = deviation.MaximumDistance
    fine = source(Resolution=12)
    deviation = simple.BodyDeviation(
        Input=simple.CatmullClarkToBSplineVolume(Input=fine, Body=body_of(fine)), Body=body_of(fine), Level=0)
    update(deviation)
    deviation.UpdatePropertyInformation()
    assert deviation.MaximumDistance < coarse, (deviation.MaximumDistance, coarse)


def test_quadflow():
    proxy = source(Resolution=3)
    volume = simple.CatmullClarkToBSplineVolume(Input=proxy, Body=body_of(proxy))
    data, _ = update(volume)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "wing.qfmb")
        simple.SaveData(path, proxy=volume)
        again, _ = update(simple.QuadflowReader(FileName=path))
        for a, b in zip(blocks(data), blocks(again)):
            assert bytes(memoryview(coordinates(a))) == bytes(memoryview(coordinates(b)))


def test_creases_of_cut_blocks():
    """Crease lines name control points of the pieces that a crease angle cuts the blocks into, made by crease rules."""
    volume = simple.CatmullClarkToBSplineVolume(Input=source(Resolution=3), UseCreaseAngle=1, CreaseAngle=30.0,
                                                CreaseContrast=0.0)
    data, _ = update(volume)
    assert len(blocks(data)) > 79
    creases = field(data, "CreaseEdges")
    # A crease may end inside the wall, at an extraordinary vertex.
    sharp = {field(data, "ControlPointRuleNames").index(name)
             for name in ("Crease", "Corner", "BodyExtraordinaryVertex")}
    for line in creases:
        block, *ends = (int(n) for n in line)
        grid = blocks(data)[block]
        first, last = ends[:3], ends[3:]
        direction, = [d for d in range(3) if first[d] != last[d]]
        rules = values(grid.GetPointData().GetArray("ControlPointRule"))
        n = dimensions(grid)
        for at in range(min(first[direction], last[direction]), max(first[direction], last[direction]) + 1):
            i, j, k = [at if d == direction else first[d] for d in range(3)]
            assert rules[i + n[0] * (j + n[1] * k)] in sharp, (block, first, last)
    update(simple.BSplineVolumeSampler(Input=volume, Level=0))


def test_convergence():
    """Distance to the body and normal jump at the smooth borders of the wall, with the resolution. Points of the mesh lie on
    the body but next to corners of the patches where creases meet, which decide the largest distance."""
    print("| resolution | largest distance | rate | RMS | rate | largest normal jump, degrees | rate |")
    print("|---|---|---|---|---|---|---|")
    rows = []
    for resolution in (6, 12, 24):
        proxy = source(Resolution=resolution)
        volume = simple.CatmullClarkToBSplineVolume(Input=proxy, Body=body_of(proxy))
        deviation = simple.BodyDeviation(Input=volume, Body=body_of(proxy))
        deviation.UpdatePipeline()
        deviation.UpdatePropertyInformation()
        smoothness = simple.BSplineVolumeSmoothness(Input=volume)
        smoothness.UpdatePipeline()
        smoothness.UpdatePropertyInformation()
        assert smoothness.MaximumGap == 0
        table = client(smoothness).GetOutputDataObject(2)
        kind, a, b, jump = (table.GetColumnByName(n) for n in ("Kind", "NameA", "NameB", "MaximumNormalJump"))
        # The rim of the tip is smooth at the leading edge, and sharp from there on: half a crease.
        rim = {("upper_0", "tip_0"), ("lower_0", "tip_0")}
        border = max(jump.GetValue(row) for row in range(table.GetNumberOfRows())
                     if kind.GetValue(row) == "wall border" and (a.GetValue(row), b.GetValue(row)) not in rim)
        # A wall that turns as much as a crease is one.
        of = table.GetColumnByName("Class")
        assert not [row for row in range(table.GetNumberOfRows()) if kind.GetValue(row) == "wall border"
                    and of.GetValue(row) == "defect" and jump.GetValue(row) > 30.0]
        rows.append((deviation.MaximumDistance, deviation.RMSDistance, border))
        rates = [math.log2(a / b) for a, b in zip(rows[-2], rows[-1])] if len(rows) > 1 else [float("nan")] * 3
        print("| %d | %.3g | %.2f | %.3g | %.2f | %.3g | %.2f |" % (
            (resolution,) + tuple(x for pair in zip(rows[-1], rates) for x in pair)), flush=True)
    # At least second order in the distance, first order in the normal.
    assert rows[2][0] < rows[0][0] / 12 and rows[2][1] < rows[0][1] / 12 and rows[2][2] < rows[0][2] / 1.5, rows


def test_samples_are_valid():
    """Sampled cells of all levels have a positive scaled Jacobian."""
    proxy = source(Resolution=3)
    volume = simple.CatmullClarkToBSplineVolume(Input=proxy, Body=body_of(proxy))
    worst = []
    for level in range(4):
        data, _ = update(simple.BSplineVolumeSampler(Input=volume, Level=level))
        worst.append(1.0)
        for block in blocks(data):
            quality = vtkMeshQuality()
            quality.SetInputData(block)
            quality.SetHexQualityMeasureToScaledJacobian()
            quality.Update()
            worst[-1] = min(worst[-1], quality.GetOutput().GetCellData().GetArray("Quality").GetRange()[0])
    print("smallest scaled Jacobian of the samples, levels 0 to 3: " + ", ".join("%.3g" % w for w in worst))
    assert min(worst) > 0, worst


def patches(data):
    return [block for block in blocks(data) if block.IsA("vtkStructuredGrid")]


def written(proxy, path, port=0):
    """The body that a written file holds, or None where CAD files cannot be written."""
    if not path.endswith(".g2") and not has_opencascade():
        return None
    simple.SaveData(path, proxy=simple.OutputPort(proxy, port))
    assert os.path.exists(path)
    reader = simple.NURBSSurfaceReader(FileName=path)
    with messages(reader) as caught:
        reader.UpdatePipeline()
    assert not caught["errors"], caught
    return client(reader).GetOutputDataObject(0)


def test_surface_files():
    proxy = source(Resolution=3)
    original = patches(output(proxy, 1))
    assert len(original) == 9
    with tempfile.TemporaryDirectory() as folder:
        for extension, tolerance in (("g2", 0.0), ("igs", 0.0), ("step", 0.0)):
            data = written(proxy, os.path.join(folder, "body." + extension), 1)
            if data is None:
                print("CAD files skipped: built without OpenCASCADE")
                continue
            read = patches(data)
            assert len(read) == 9
            for a, b in zip(original, read):
                assert dimensions(a) == dimensions(b)
                for n in range(a.GetNumberOfPoints()):
                    assert max(abs(x - y) for x, y in zip(a.GetPoint(n), b.GetPoint(n))) <= tolerance
                for name in ("Degree", "KnotsU", "KnotsV"):
                    assert max(abs(x - y) for x, y in zip(field(a, name), field(b, name))) <= tolerance


def rational_patch():
    """A quarter of a cylinder, rational, with the outward normal of -(x_u x x_v)."""
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    for z in (0.0, 2.0):
        for x, y in ((1, 0), (1, 1), (0, 1)):
            points.InsertNextPoint(x, y, z)
    patch = vtk.vtkStructuredGrid()
    patch.SetDimensions(3, 2, 1)
    patch.SetPoints(points)
    weights = vtk.vtkDoubleArray()
    weights.SetName("Weights")
    for weight in (1, 0.5 ** 0.5, 1) * 2:
        weights.InsertNextValue(weight)
    patch.GetPointData().AddArray(weights)
    for name, kind, numbers in (("Degree", vtk.vtkIntArray, (2, 1)), ("KnotsU", vtk.vtkDoubleArray, (0, 0, 0, 1, 1, 1)),
                                ("KnotsV", vtk.vtkDoubleArray, (0, 0, 1, 1)), ("Reversed", vtk.vtkIntArray, (1,))):
        array = kind()
        array.SetName(name)
        for value in numbers:
            array.InsertNextValue(value)
        patch.GetFieldData().AddArray(array)
    return patch


def test_rational_and_reversed():
    patch = rational_patch()
    with tempfile.TemporaryDirectory() as folder:
        for extension in ("g2", "igs", "step"):
            data = written(producer(collection([patch])), os.path.join(folder, "part." + extension))
            if data is None:
                continue
            read, = patches(data)
            assert dimensions(read) == (3, 2, 1)
            # u runs the other way.
            for j in range(2):
                for i in range(3):
                    x, y = patch.GetPoint(2 - i + 3 * j), read.GetPoint(i + 3 * j)
                    assert max(abs(a - b) for a, b in zip(x, y)) < 1e-12
            assert max(abs(a - b) for a, b in zip(values(read.GetPointData().GetArray("Weights")),
                                                  (1, 0.5 ** 0.5, 1) * 2)) < 1e-12


def test_threads():
    reference = None
    for threads in (1, 2, 3):
        vtk.vtkSMPTools.SetBackend("STDThread")
        vtk.vtkSMPTools.Initialize(threads)
        found = b"".join(bytes(memoryview(coordinates(block))) for block in blocks(output(source(Resolution=5), 0)))
        reference = reference or found
        assert found == reference
    vtk.vtkSMPTools.Initialize()


def test_errors():
    for properties, expected in ((dict(Resolution=1), "Resolution 1 is not between 2 and 96"),
                                 (dict(Resolution=2, Span=6, SweepAngle=45), "too low for Span 6 and Sweep Angle 45"),
                                 (dict(Span=1), "Span 1 is not between 2 and 6"),
                                 (dict(Resolution=64, FirstLayerHeight=0.05), "First Layer Height 0.05 is larger")):
        proxy = source(**properties)
        assert expected in failure(proxy)
        body = client(proxy).GetOutputDataObject(1)
        assert body.GetNumberOfElements(body.POINT) == 0


if __name__ == "__main__":
    main(globals())
