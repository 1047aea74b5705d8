# SPDX-License-Identifier: BSD-3-Clause
"""vtkWallSpacing through its proxy; the pipeline mesh, wall spacing, conversion, sampler with y+ measured at its end."""
import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (simple, vtk, bits, blocks, client, collection, demo_mesh, dimensions, failure, field, grid,
                         main, messages, names, producer, update, values)

CELLS, LAYERS, LENGTH = 8, 12, 4.0
ARRAYS = ["WallSpacing", "BoundaryLayerThickness", "FirstCellHeight", "YPlus", "CellsInBoundaryLayer"]


def plate(first, growth=1.1):
    """Two blocks side by side over the plate z = 0, 0 <= x <= 4; layers of geometric growth. Boundary `wall plate`."""
    heights = [0.0]
    for k in range(LAYERS):
        heights.append(heights[-1] + first * growth ** k)
    grids = [grid((CELLS, CELLS, LAYERS),
                  lambda i, j, k: (LENGTH * i / (2 * CELLS), 2.0 * j / CELLS, heights[k]), (b * CELLS, 0, 0))
             for b in range(2)]
    for block in grids:  # z starts at 0 in both
        assert block.GetBounds()[4] == 0
    mesh = collection(grids)
    names_array = vtk.vtkStringArray()
    names_array.SetName("BoundaryNames")
    names_array.InsertNextValue("wall plate")
    boundaries = vtk.vtkIntArray()
    boundaries.SetName("Boundaries")
    boundaries.SetNumberOfComponents(3)
    for b in range(2):
        boundaries.InsertNextTuple3(b, 4, 0)
    mesh.GetFieldData().AddArray(names_array)
    mesh.GetFieldData().AddArray(boundaries)
    return mesh


def friction(reynolds, x):
    """Turbulent skin friction of a flat plate of length LENGTH."""
    return 0.0592 / (reynolds * x / LENGTH) ** 0.2


def height(reynolds, x, y_plus):
    return y_plus * LENGTH / (reynolds * math.sqrt(friction(reynolds, x) / 2))


REYNOLDS = 1e6
MESH = plate(4 * height(REYNOLDS, 2.0, 1.0))


def wall_spacing(mesh, **properties):
    options = dict(ReynoldsNumber=REYNOLDS, ReferenceLength=LENGTH, MinimumDistance=0.2, Level=2)
    options.update(properties)
    return simple.WallSpacing(Input=mesh if hasattr(mesh, "SMProxy") else producer(mesh), **options)


def test_pipeline():
    """The first sampled cell of the converted mesh has the target y+ at every wall vertex."""
    proxy = wall_spacing(MESH)
    data, warnings = update(proxy)
    assert not warnings, warnings
    proxy.UpdatePropertyInformation()
    assert proxy.NumberOfWallPoints == proxy.NumberOfPointsOnTarget == (2 * CELLS + 1) * (CELLS + 1)
    assert 0.99 < proxy.YPlusRange[0] <= proxy.YPlusRange[1] < 1.01
    for b, block in enumerate(blocks(data)):
        for name in ARRAYS:
            array = values(block.GetPointData().GetArray(name))
            wall = (CELLS + 1) ** 2
            assert all(math.isfinite(x) for x in array[:wall]) and all(math.isnan(x) for x in array[wall:]), name
    volume = simple.CatmullClarkToBSplineVolume(Input=proxy)
    converted, warnings = update(volume)
    assert not warnings
    samples, _ = update(simple.BSplineVolumeSampler(Input=volume, Level=2))
    worst = 0.0
    for block in blocks(samples):
        ni, nj, _ = dimensions(block)
        for j in range(0, nj, 4):
            for i in range(0, ni, 4):
                below, above = block.GetPoint(i + ni * j), block.GetPoint(i + ni * j + ni * nj)
                x = max(below[0], 0.2 * LENGTH)
                worst = max(worst, abs(math.dist(below, above) / height(REYNOLDS, x, 1.0) - 1))
    print("y+ off by at most %.1e" % worst)
    assert worst < 0.01
    # The array made the difference.
    plain, _ = update(simple.CatmullClarkToBSplineVolume(Input=proxy, WallSpacingArray=""))
    assert bits(plain) != bits(converted)
    assert bits(plain) == bits(update(simple.CatmullClarkToBSplineVolume(Input=producer(MESH)))[0])


def test_surface():
    proxy = wall_spacing(MESH)
    update(proxy)
    wall = client(proxy).GetOutputDataObject(1)
    assert wall.GetNumberOfPoints() == (2 * CELLS + 1) * (CELLS + 1) and wall.GetNumberOfCells() == 2 * CELLS * CELLS
    arrays = {name: values(wall.GetPointData().GetArray(name)) for name in ARRAYS + [
        "StreamwiseDistance", "SkinFriction", "CellGrowth", "ReachingLevel", "TargetAllowed"]}
    for n in range(wall.GetNumberOfPoints()):
        x = max(wall.GetPoint(n)[0], 0.2 * LENGTH)
        assert abs(arrays["StreamwiseDistance"][n] - x) < 1e-12
        assert abs(arrays["SkinFriction"][n] / friction(REYNOLDS, x) - 1) < 1e-12
        assert abs(arrays["BoundaryLayerThickness"][n] / (0.37 * x / (REYNOLDS * x / LENGTH) ** 0.2) - 1) < 1e-12
        y_plus = arrays["FirstCellHeight"][n] / height(REYNOLDS, x, 1.0)
        assert abs(arrays["YPlus"][n] / y_plus - 1) < 1e-12
        assert arrays["TargetAllowed"][n] == 1 and 0 <= arrays["ReachingLevel"][n] <= 2
        assert arrays["CellGrowth"][n] <= 1.21 and arrays["CellsInBoundaryLayer"][n] > 4
    # The quadrilaterals cover the plate.
    area = 0.0
    for n in range(wall.GetNumberOfCells()):
        a, b, c, d = (wall.GetPoint(wall.GetCell(n).GetPointId(m)) for m in range(4))
        area += abs((c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0])) / 2
    assert abs(area - 2 * LENGTH) < 1e-12 and wall.GetBounds() == (0, LENGTH, 0, 2, 0, 0)


def test_reference_state():
    """Sea level of the standard atmosphere at M = 0.5 and 1 m."""
    proxy = wall_spacing(MESH, ReynoldsNumber=1.225 * 0.5 * 340.294 / 1.7894e-5, MachNumber=0.5, ReferenceLength=1000,
                         LengthUnit=0.001, TargetYPlus=1e-3)
    with messages(proxy):
        proxy.UpdatePipeline()
    for port in (0, 1):
        data = client(proxy).GetOutputDataObject(port)
        assert abs(field(data, "ReferenceDensity")[0] - 1.225) < 1e-4
        assert abs(field(data, "ReferenceVelocity")[0] - 170.147) < 1e-3
        assert abs(field(data, "ReferencePressure")[0] - 101325) < 10
        assert abs(field(data, "PressureCoefficient")[0] - 1 / (1.4 * 0.25)) < 1e-12
    proxy.UpdatePropertyInformation()
    assert f"density {field(data, 'ReferenceDensity')[0]:.6g} kg/m^3" in proxy.Report


def test_out_of_reach():
    """A mesh twice as coarse needs one level more, and the report says so."""
    proxy = wall_spacing(plate(8 * height(REYNOLDS, 2.0, 1.0)))
    update(proxy)
    proxy.UpdatePropertyInformation()
    assert "Level 3 would reach it everywhere" in proxy.Report
    text = client(proxy).GetOutputDataObject(2).GetColumnByName("Text").GetValue(0)
    assert "reached within 1 % at 0 of" in text and "see the report" in text, text
    proxy.Level = 3
    assert not update(proxy)[1]


def test_mesh_passes():
    """Blocks, names and connectivity are those of the input."""
    demo = demo_mesh(8)
    proxy = wall_spacing(demo, ReferenceLength=1, UseCreaseAngle=1, TargetYPlus=100)
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert not caught["errors"], caught
    data = client(proxy).GetOutputDataObject(0)
    source = client(demo).GetOutputDataObject(0)
    assert [n.upper() for n in names(data)] == [n.upper() for n in names(source)]
    assert [b.GetNumberOfPoints() for b in blocks(data)] == [b.GetNumberOfPoints() for b in blocks(source)]
    for name in ("Boundaries", "BoundaryNames"):
        assert field(data, name) == field(source, name), name
    converted, _ = update(simple.CatmullClarkToBSplineVolume(Input=proxy, UseCreaseAngle=1))
    assert len(blocks(converted)) == 16


def test_conversion_options():
    """c by boundary and by growth."""
    def first(**properties):
        converted, _ = update(simple.CatmullClarkToBSplineVolume(Input=producer(MESH), **properties))
        block = blocks(converted)[0]
        ni, nj, _ = dimensions(block)
        return block.GetPoint(ni * nj)[2] / blocks(MESH)[0].GetPoint((CELLS + 1) ** 2)[2]

    assert abs(first() - 1 / 3) < 1e-12
    assert abs(first(WallSpacingMode="Automatic") - 1 / (3 + math.log(1.1))) < 1e-12
    assert abs(first(BoundaryWallSpacing=["WALL*", "0.8"]) - 0.2) < 1e-12
    assert abs(first(BoundaryWallSpacing=["other", "0.8", "wall?plate", "0.9"]) - 0.1) < 1e-12
    text = failure(simple.CatmullClarkToBSplineVolume(Input=producer(MESH), BoundaryWallSpacing=["wall*", "1.5"]))
    assert "Wall Spacing 1.5 of boundary 'wall plate'" in text
    text = failure(simple.CatmullClarkToBSplineVolume(Input=producer(MESH), ExtensionBlocks=["far*"]))
    assert "Extension Blocks are 'far*'" in text


def test_errors():
    assert "no boundary of the mesh is a wall" in failure(wall_spacing(MESH, BodyBoundaries=["hull"]))
    for name, value, text in (("ReynoldsNumber", -1, "Reynolds Number -1"), ("MachNumber", 0, "Mach Number 0"),
                              ("TargetYPlus", 0, "Target Y Plus 0"), ("MaximumGrowth", 1, "Maximum Growth 1"),
                              ("FlowDirection", [0, 0, 0], "Flow Direction"), ("Viscosity", -1, "Viscosity -1"),
                              ("TransitionLocation", -1, "Transition Location -1")):
        assert text in failure(wall_spacing(MESH, **{name: value})), name


def test_empty():
    assert "has no hexahedra" in failure(wall_spacing(vtk.vtkPartitionedDataSetCollection()))


if __name__ == "__main__":
    main(globals())
