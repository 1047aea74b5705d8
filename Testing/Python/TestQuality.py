# SPDX-License-Identifier: BSD-3-Clause
"""vtkBSplineVolumeQuality through its proxy: verdicts, bounds and shape measures of known volumes, of the demonstration
conversion, of an inverted and of a left-handed block; growth across interfaces; errors, abort, threads."""
import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (aborted, simple, vtk, blocks, client, collection, demo_mesh, dimensions, failure, field, grid,
                         main, names, producer, update, values)

DEMO = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(8), UseCreaseAngle=1)
ARRAYS = ("Validity", "MinJacobian", "MaxJacobian", "ScaledJacobian", "Skewness", "AspectRatio", "GrowthRatio",
          "FirstCellHeight")


def add_array(data, name, rows, integer=False, components=1):
    array = vtk.vtkIntArray() if integer else vtk.vtkDoubleArray()
    array.SetName(name)
    array.SetNumberOfComponents(components)
    for row in rows:
        array.InsertNextTuple(row if components > 1 else (row,))
    data.AddArray(array)


def volume(knots, place, degree=(3, 3, 3)):
    """B-spline block whose control points are place(Greville abscissae)."""
    greville = [[sum(t[i + 1:i + 1 + p]) / p for i in range(len(t) - p - 1)] for t, p in zip(knots, degree)]
    data = grid([len(g) - 1 for g in greville],
                lambda i, j, k: place(greville[0][i], greville[1][j], greville[2][k]))
    fields = data.GetFieldData()
    add_array(fields, "Degree", degree, integer=True)
    for name, numbers in zip(("KnotsU", "KnotsV", "KnotsW"), knots):
        add_array(fields, name, numbers)
    return data


def clamped(*inner, degree=3):
    return [float(inner[0])] * degree + [float(n) for n in inner] + [float(inner[-1])] * degree


def quality(data, **properties):
    return simple.BSplineVolumeQuality(Input=data if hasattr(data, "SMProxy") else producer(data), **properties)


def measured(data, **properties):
    """Proxy with its information properties, output and warnings."""
    proxy = quality(data, **properties)
    output, warnings = update(proxy)
    proxy.UpdatePropertyInformation()
    return proxy, output, warnings


def cell_array(block, name):
    array = block.GetCellData().GetArray(name)
    assert array is not None, name
    return values(array)


def witnesses(proxy):
    return client(proxy).GetOutputDataObject(1)


def close(found, expected, tolerance=1e-12):
    return all(abs(a - b) <= tolerance for a, b in zip(found, expected)) and len(found) == len(expected)


def sheared(x, y, z):
    return x + 0.5 * y, math.sqrt(0.75) * y, 2 * z


def test_properties():
    proxy = quality(DEMO)
    assert proxy.MaximumDepth == 24
    assert list(proxy.BodyBoundaries) == ["wall*", "bcwall*", "body*", "no*slip*", "viscous*", "solid*"]


def test_known_block():
    """A sheared block: u and v meet at 60 degrees. Unequal spans in w; the wall is w = 0."""
    data = collection([volume([clamped(0, 1, 2), clamped(0, 1), clamped(0, 1, 3, 3.5)], sheared)])
    add_array(data.GetFieldData(), "Boundaries", [(0, 4, 0)], integer=True, components=3)
    label = vtk.vtkStringArray()
    label.SetName("BoundaryNames")
    label.InsertNextValue("WALL")
    data.GetFieldData().AddArray(label)
    proxy, output, warnings = measured(data)
    assert not warnings and names(output) == ["block 0"]
    block = blocks(output)[0]
    assert dimensions(block) == (3, 2, 4)
    assert cell_array(block, "Validity") == [0] * 6
    determinant = [math.sqrt(3) * length for length in (1, 1, 2, 2, 0.5, 0.5)]
    for name in ("MinJacobian", "MaxJacobian"):  # bounds of the rounding errors leave some 1e-12
        assert close(cell_array(block, name), determinant, 1e-11)
    assert all(low <= d <= high for low, d, high in
               zip(cell_array(block, "MinJacobian"), determinant, cell_array(block, "MaxJacobian")))
    assert close(cell_array(block, "ScaledJacobian"), [math.sqrt(0.75)] * 6)
    assert close(cell_array(block, "Skewness"), [1 / 3] * 6)
    assert close(cell_array(block, "AspectRatio"), [2, 2, 4, 4, 1, 1])
    growth = cell_array(block, "GrowthRatio")
    assert close([g[2] for g in growth], [2, 2, 4, 4, 4, 4]) and close([g[0] for g in growth], [1] * 6)
    assert close(cell_array(block, "FirstCellHeight"), [2, 2, 0, 0, 0, 0])
    assert field(output, "ValidityNames") == ["valid", "invalid", "undecided"]
    assert [field(output, name) for name in ("ValidSpans", "InvalidSpans", "UndecidedSpans")] == [[6], [0], [0]]
    assert (proxy.NumberOfSpans, proxy.NumberOfValidSpans, proxy.NumberOfInvalidSpans, proxy.NumberOfUndecidedSpans,
            proxy.WorstBlock) == (6, 6, 0, 0, 0)
    assert abs(proxy.MinimumJacobian - math.sqrt(0.75)) < 1e-11
    assert abs(proxy.MinimumScaledJacobian - math.sqrt(0.75)) < 1e-12
    assert witnesses(proxy).GetNumberOfPoints() == 0
    assert set(cell_array(blocks(update(quality(data, BodyBoundaries=["nothing"]))[0])[0], "FirstCellHeight")) == {0.0}


def test_growth_across_an_interface():
    """Sizes double from block to block; the second one runs backwards and has its directions exchanged."""
    first = volume([clamped(0, 1), clamped(0, 1, 2), clamped(0, 1)], lambda x, y, z: (x, y, z))
    # u -> -y, v -> -x + 3, w -> -z: still right-handed? (-y, -x, -z) has determinant +1.
    second = volume([clamped(0, 1, 2), clamped(0, 2), clamped(0, 1)], lambda u, v, w: (3 - v, 2 - u, 1 - w))
    data = collection([first, second])
    # Face 1 (u = max) of the first meets face 3 (v = max) of the second: (s, t) = (y, z) -> (2 - y, 1 - z).
    add_array(data.GetFieldData(), "Interfaces", [(0, 1, 1, 3, 6, 0, 0, 0, 0, 0, 0, 0)], integer=True, components=12)
    output, warnings = update(quality(data))
    assert not warnings
    a, b = (cell_array(block, "GrowthRatio") for block in blocks(output))
    assert [tuple(round(x, 12) for x in g) for g in a] == [(2, 1, 1)] * 2
    assert [tuple(round(x, 12) for x in g) for g in b] == [(1, 2, 1)] * 2
    assert field(output, "ValidSpans") == [2, 2]
    # The same without being told.
    data.GetFieldData().RemoveArray("Interfaces")
    again, warnings = update(quality(data))
    assert not warnings
    for old, new in zip(blocks(output), blocks(again)):
        assert cell_array(old, "GrowthRatio") == cell_array(new, "GrowthRatio")


def test_inverted_span():
    """Control points that change places fold some spans; the others keep their verdict."""
    knots = [clamped(*range(7))] * 3
    data = volume(knots, lambda x, y, z: (x, y, z))
    points = data.GetPoints()
    n, m = (i + 9 * (4 + 9 * 4) for i in (4, 5))
    x, y = points.GetPoint(n), points.GetPoint(m)
    points.SetPoint(n, [y[0] + 2, y[1], y[2]])
    points.SetPoint(m, [x[0] - 2, x[1], x[2]])
    proxy, output, warnings = measured(data)
    block = blocks(output)[0]
    codes = cell_array(block, "Validity")
    assert 0 < codes.count(1) < 64 and codes.count(0) == 216 - codes.count(1)
    assert proxy.NumberOfInvalidSpans == codes.count(1) and proxy.MinimumJacobian < 0 and not warnings
    found = witnesses(proxy)
    assert found.GetNumberOfPoints() == codes.count(1) == found.GetNumberOfCells()
    point_data = found.GetPointData()
    for p in range(found.GetNumberOfPoints()):
        span = [int(n) for n in point_data.GetArray("Span").GetTuple(p)]
        assert codes[span[0] + 6 * (span[1] + 6 * span[2])] == 1
        assert all(s <= u <= s + 1 for s, u in zip(span, point_data.GetArray("UVW").GetTuple(p)))
        assert point_data.GetArray("Jacobian").GetTuple1(p) <= 0
        assert point_data.GetArray("BlockId").GetTuple1(p) == 0
    # The same determinant from the sampler's derivatives.
    samples, _ = update(simple.BSplineVolumeSampler(Input=producer(data), Level=2, ComputeDerivatives=1))
    sample = blocks(samples)[0]
    negative = set()
    for s in range(sample.GetNumberOfPoints()):
        a, b, c = (sample.GetPointData().GetArray(name).GetTuple(s) for name in ("dXdU", "dXdV", "dXdW"))
        if vtk.vtkMath.Determinant3x3(a, b, c) < -1e-9:
            ijk = s % 25, s // 25 % 25, s // 625
            if all(i % 4 for i in ijk):
                negative.add(ijk[0] // 4 + 6 * (ijk[1] // 4 + 6 * (ijk[2] // 4)))
    assert negative and all(codes[s] == 1 for s in negative)


def test_left_handed_block():
    knots = [clamped(0, 1, 2)] * 3
    right = volume(knots, lambda x, y, z: (x, y, z))
    left = volume(knots, lambda x, y, z: (x + 5, -y, z))
    proxy, output, warnings = measured(collection([right, left]))
    assert len(warnings) == 1 and "1 of 2 blocks, block 1 'block 1'" in warnings[0]
    assert field(output, "InvalidSpans") == [0, 0] and proxy.NumberOfLeftHandedBlocks == 1
    assert abs(proxy.MinimumScaledJacobian - 1) < 1e-12 and witnesses(proxy).GetNumberOfPoints() == 0
    # Folded beyond x = 2.5: only there it is invalid, in the last of three spans along x.
    folded = volume([clamped(0, 1, 2, 3)] * 3, lambda x, y, z: (x, -y * (2.5 - x), z))
    proxy, output, _ = measured(collection([folded]))
    assert proxy.NumberOfLeftHandedBlocks == 1 and field(output, "InvalidSpans") == [9]


def test_rational_and_other_degrees():
    """A quarter of a tube of radii 1 and 2 and height 1: lines at right angles everywhere, det J > 0."""
    ends = ((1, 0), (1, 1), (0, 1))

    def tube(r, v, w):
        x, y = ends[round(2 * v)]
        return (1 + r) * x, (1 + r) * y, w
    knots = [clamped(0, 1, degree=1), clamped(0, 1, degree=2), clamped(0, 1, degree=1)]
    data = volume(knots, tube, degree=(1, 2, 1))
    add_array(data.GetPointData(), "Weights", [math.sqrt(0.5) if n // 2 % 3 == 1 else 1.0 for n in range(12)])
    block = blocks(update(quality(data))[0])[0]
    assert dimensions(block) == (2, 2, 2) and cell_array(block, "Validity") == [0]
    assert close(cell_array(block, "ScaledJacobian"), [1]) and close(cell_array(block, "Skewness"), [0], 1e-7)
    # The mean of det J is the volume, 3 pi / 4.
    assert cell_array(block, "MinJacobian")[0] < 0.75 * math.pi < cell_array(block, "MaxJacobian")[0]


def test_demo():
    before, _ = update(DEMO)
    proxy, output, warnings = measured(DEMO)
    assert names(output) == names(before) and not warnings
    for name in ("Interfaces", "Boundaries", "BoundaryNames"):
        assert field(output, name) == field(before, name)
    spans = sum(block.GetNumberOfCells() for block in blocks(output))
    assert proxy.NumberOfSpans == spans == proxy.NumberOfValidSpans and proxy.MinimumJacobian > 0
    tags = field(output, "BoundaryNames")
    walls = {(int(b), int(f)) for b, f, tag in field(output, "Boundaries") if tags[int(tag)] == "WALL"}
    assert walls
    for b, block in enumerate(blocks(output)):
        size = [n - 1 for n in dimensions(block)]
        assert all(a <= c for a, c in zip(cell_array(block, "MinJacobian"), cell_array(block, "MaxJacobian")))
        assert all(0 < s <= 1 for s in cell_array(block, "ScaledJacobian"))
        assert all(0 <= s < 1 for s in cell_array(block, "Skewness"))
        assert all(a >= 1 for a in cell_array(block, "AspectRatio"))
        assert all(min(g) >= 1 for g in cell_array(block, "GrowthRatio"))
        for n, height in enumerate(cell_array(block, "FirstCellHeight")):
            ijk = n % size[0], n // size[0] % size[1], n // (size[0] * size[1])
            at_wall = any((b, 2 * d + side) in walls and ijk[d] == (size[d] - 1) * side
                          for d in range(3) for side in (0, 1))
            assert (height > 0) == at_wall
    print("demo: %d spans valid, smallest scaled Jacobian %.3g" % (spans, proxy.MinimumScaledJacobian))


def test_threads_do_not_matter():
    found = []
    for threads in (1, 2):
        vtk.vtkSMPTools.Initialize(threads)
        data, _ = update(quality(DEMO))
        found.append(b"".join(bytes(memoryview(block.GetCellData().GetArray(name)))
                              for block in blocks(data) for name in ARRAYS))
    assert found[0] == found[1]


def test_inputs_and_errors():
    assert "has no B-spline volume" in failure(quality(vtk.vtkPartitionedDataSetCollection()))
    knots = [clamped(0, 1)] * 3
    single = volume(knots, sheared)
    assert cell_array(blocks(update(quality(single))[0])[0], "Validity") == [0]
    broken = volume(knots, sheared)
    broken.GetPoints().SetPoint(5, [0, float("nan"), 0])
    assert "block 0 'block 0': control point (1, 1, 0) is not finite" in failure(quality(broken))
    plain = grid((2, 2, 2), sheared)
    assert "it is no B-spline volume" in failure(quality(plain))


def test_abort():
    aborted(quality(DEMO))


if __name__ == "__main__":
    main(globals())
