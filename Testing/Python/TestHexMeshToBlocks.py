# SPDX-License-Identifier: BSD-3-Clause
"""Unstructured hexahedra become blocks: as the structured mesh that they came from, however they are numbered."""
import os
import random
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (simple, vtk, bits, blocks, client, collection, demo_mesh, failure, field, grid, main, messages,
                         producer, update, values)

HEX, QUAD = 12, 9
# The rotations of a hexahedron are made of these two.
TURNS = ((1, 2, 3, 0, 5, 6, 7, 4), (3, 2, 6, 7, 0, 1, 5, 4))


def unstructured(data, seed=0, shared=True):
    """All cells of the structured grids of `data`; points of the same bits are one if `shared`. Other seeds than 0
    number points, cells and corners at random."""
    rng = random.Random(seed)
    points, number, cells = [], {}, []
    for block in blocks(data):
        ids = []
        for p in range(block.GetNumberOfPoints()):
            x = block.GetPoint(p)
            key = x if shared else (x, id(block))
            if key not in number:
                number[key] = len(points)
                points.append(x)
            ids.append(number[key])
        for c in range(block.GetNumberOfCells()):
            cell = block.GetCell(c)
            corners = [ids[cell.GetPointId(n)] for n in range(8)]
            for _ in range(rng.randrange(8) if seed else 0):
                corners = [corners[n] for n in TURNS[rng.randrange(2)]]
            cells.append(corners)
    order = list(range(len(points)))
    if seed:
        rng.shuffle(order)
        rng.shuffle(cells)
    result, places = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
    places.SetDataTypeToDouble()
    places.SetNumberOfPoints(len(points))
    for old, new in enumerate(order):
        places.SetPoint(new, points[old])
    result.SetPoints(places)
    result.Allocate(len(cells))
    for corners in cells:
        result.InsertNextCell(HEX, 8, [order[c] for c in corners])
    return result


def found(mesh, **properties):
    """Output and report of the filter."""
    proxy = mesh if hasattr(mesh, "SMProxy") else producer(mesh)
    hexes = simple.HexMeshToBlocks(Input=proxy, **properties)
    data, warnings = update(hexes)
    hexes.UpdatePropertyInformation()
    return data, str(hexes.Report), warnings


def geometry(data):
    return [bytes(memoryview(block.GetPoints().GetData())) for block in blocks(data)]


def converted(mesh):
    proxy = mesh if hasattr(mesh, "SMProxy") else producer(mesh)
    volume, _ = update(simple.CatmullClarkToBSplineVolume(Input=proxy))
    return volume


def star(sectors, n=3):
    """Wedges around an axis."""
    import math

    def rim(half):
        half %= 2 * sectors
        radius = 1.0 if half % 2 == 0 else 1.3
        return radius * math.cos(math.pi * half / sectors), radius * math.sin(math.pi * half / sectors)

    made = []
    for s in range(sectors):
        a, b, c = rim(2 * s), rim(2 * s + 1), rim(2 * s + 2)
        made.append(grid((n, n, 2), lambda i, j, k: tuple(
            round(i * (n - j) / n / n * a[d] + j * (n - i) / n / n * c[d] + i * j / n / n * b[d], 9) + 0.0
            for d in range(2)) + (float(k),)))
    return collection(made)


def test_blocks_are_those_of_the_structured_mesh():
    for sectors in (3, 5, 7):
        original = star(sectors)
        before = None
        for seed in (0, 1, 2):
            data, report, _ = found(unstructured(original, seed))
            assert len(blocks(data)) == sectors, report
            # Each cell once, with its own corners.
            cells = sorted(int(c) for block in blocks(data) for c in values(block.GetCellData().GetArray("OriginalCellIds")))
            assert cells == list(range(18 * sectors))
            before = before or geometry(data)
            assert geometry(data) == before
        assert sorted(len(g) for g in before) == [3 * 8 * 4 * 4 * 3] * sectors
        assert len(field(data, "Interfaces")) == sectors


def control_points(volume):
    """Control points by place, whatever the blocks' order and directions."""
    return sorted(sorted(block.GetPoint(p) for p in range(block.GetNumberOfPoints())) for block in blocks(volume))


def test_conversion_is_that_of_the_structured_mesh():
    original = star(5)
    expected = control_points(converted(original))
    # Behind the filter, directly, and with the points of every block apart.
    data, _, _ = found(unstructured(original, 3))
    assert control_points(converted(data)) == expected
    assert control_points(converted(unstructured(original, 4))) == expected
    conversion = simple.CatmullClarkToBSplineVolume(Input=producer(unstructured(original, 5, shared=False)))
    volume, _ = update(conversion)
    conversion.UpdatePropertyInformation()
    assert control_points(volume) == expected
    assert "unstructured hexahedra were made to 5 blocks" in str(conversion.Report)
    # A single block comes back as it was.
    box = collection([grid((4, 3, 2), lambda i, j, k: (i, j + 0.1 * i * i, k))])
    assert bits(converted(found(unstructured(box, 6))[0])) == bits(converted(box))


def test_demonstration_mesh():
    mesh = demo_mesh(4)
    update(mesh)
    data, report, _ = found(unstructured(client(mesh).GetOutputDataObject(0), 1))
    again, _, _ = found(unstructured(client(mesh).GetOutputDataObject(0), 2))
    assert geometry(data) == geometry(again) and len(blocks(data)) > 1
    assert field(data, "Boundaries") == field(again, "Boundaries")
    converted(data)


def test_names():
    box = unstructured(collection([grid((4, 2, 2), lambda i, j, k: (i, j, k))]))
    at = {box.GetPoint(p): p for p in range(box.GetNumberOfPoints())}

    def quad(a, u, v):
        return [at[tuple(float(a[d] + s * u[d] + t * v[d]) for d in range(3))] for s, t in ((0, 0), (1, 0), (1, 1), (0, 1))]

    floor = [quad((i, j, 0), (1, 0, 0), (0, 1, 0)) for i in range(4) for j in range(2)]
    inlet = [quad((0, j, k), (0, 1, 0), (0, 0, 1)) for j in range(2) for k in range(2)]
    tags = vtk.vtkIntArray()
    tags.SetName("tag")
    for _ in range(box.GetNumberOfCells()):
        tags.InsertNextValue(0)
    with_quads = vtk.vtkUnstructuredGrid()
    with_quads.DeepCopy(box)
    for value, quads in ((7, floor), (9, inlet)):
        for q in quads:
            with_quads.InsertNextCell(QUAD, 4, q)
            tags.InsertNextValue(value)
    with_quads.InsertNextCell(3, 2, [0, 1])
    tags.InsertNextValue(1)
    with_quads.GetCellData().AddArray(tags)

    data, report, warnings = found(with_quads, BoundaryArray="tag")
    assert field(data, "BoundaryNames") == ["tag 7", "tag 9"]
    assert [tuple(b) for b in field(data, "Boundaries")] == [(0, 0, 1), (0, 4, 0)]
    assert not warnings and "1 vertices and lines" in report
    # The cell array goes with the cells.
    assert set(values(blocks(data)[0].GetCellData().GetArray("tag"))) == {0}
    # Without the name of the array: a question, and boundaries by angle.
    data, report, warnings = found(with_quads)
    assert "12 quadrilaterals without a name" in warnings[0] and "'tag'" in warnings[0]
    assert len(field(data, "BoundaryNames")) == 6
    with messages(simple.HexMeshToBlocks(Input=producer(with_quads), BoundaryArray="tga")):
        pass
    assert "no cell array 'tga'" in failure(simple.HexMeshToBlocks(Input=producer(with_quads), BoundaryArray="tga"))

    # Side sets: leaves of their own with points of their own, in the tree or as a second input.
    def surface(quads):
        data = vtk.vtkPolyData()
        points, polys = vtk.vtkPoints(), vtk.vtkCellArray()
        points.SetDataTypeToDouble()
        for q in quads:
            polys.InsertNextCell(4, [points.InsertNextPoint(box.GetPoint(p)) for p in q])
        data.SetPoints(points)
        data.SetPolys(polys)
        return data

    tree, sides = vtk.vtkMultiBlockDataSet(), vtk.vtkMultiBlockDataSet()
    tree.SetBlock(0, box)
    for n, (name, quads) in enumerate((("floor", floor), ("inlet", inlet))):
        for target, place in ((tree, n + 1), (sides, n)):
            target.SetBlock(place, surface(quads))
            target.GetMetaData(place).Set(vtk.vtkCompositeDataSet.NAME(), name)
    for data, _, warnings in (found(tree), found(box, Boundaries=producer(sides))):
        assert field(data, "BoundaryNames") == ["floor", "inlet"] and not warnings
        assert [tuple(b) for b in field(data, "Boundaries")] == [(0, 0, 1), (0, 4, 0)]


def test_one_name_of_several_types():
    # As readers give boundaries of several zones: the low and the high side of a box have one name.
    def side(k, kind):
        points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
        for j in range(3):
            for i in range(4):
                points.InsertNextPoint(i, j, k)
        for j in range(2):
            for i in range(3):
                cells.InsertNextCell(4, [i + 4 * j, i + 1 + 4 * j, i + 5 + 4 * j, i + 4 + 4 * j])
        surface = vtk.vtkPolyData()
        surface.SetPoints(points)
        surface.SetPolys(cells)
        array = vtk.vtkStringArray()
        array.SetName("BoundaryType")
        array.InsertNextValue(kind)
        surface.GetFieldData().AddArray(array)
        return surface

    box = unstructured(collection([grid((3, 2, 2), lambda i, j, k: (i, j, k))]))
    for first, second, expected in (("BCWall", "BCFarfield", {"patch": "BCWall", "patch (BCFarfield)": "BCFarfield"}),
                                    ("BCTypeUserDefined", "BCWall", {"patch": "BCWall"}),
                                    ("BCWall", "BCTypeUserDefined", {"patch": "BCWall"}),
                                    ("BCWall", "BCWall", {"patch": "BCWall"})):
        mesh = vtk.vtkPartitionedDataSetCollection()
        for n, data in enumerate((box, side(0, first), side(2, second))):
            mesh.SetPartition(n, 0, data)
            mesh.GetMetaData(n).Set(vtk.vtkCompositeDataSet.NAME(), "patch" if n else "box")
        data, _ = update(simple.HexMeshToBlocks(Input=producer(mesh)))
        assert dict(zip(field(data, "BoundaryNames"), field(data, "BoundaryTypes"))) == expected, (first, second)


def test_refusals_and_warnings():
    cells = unstructured(collection([grid((2, 1, 1), lambda i, j, k: (i, j, k))]))
    mixed = vtk.vtkUnstructuredGrid()
    mixed.DeepCopy(cells)
    mixed.InsertNextCell(10, 4, [0, 1, 2, 3])
    error = failure(simple.HexMeshToBlocks(Input=producer(mixed)))
    assert "cell 2" in error and "type 10" in error
    ring = collection([grid((2, 2, 2), lambda i, j, k, a=a, b=b: (2 * a + i, 2 * b + j, k))
                       for a in range(3) for b in range(3) if (a, b) != (1, 1)])
    data, report, warnings = found(unstructured(ring, 1))
    assert len(blocks(data)) == 8 and "8 cells each" in warnings[0]
    assert len(blocks(found(unstructured(ring, 1), MergeBlocks=1)[0])) == 4
    error = failure(simple.HexMeshToBlocks(Input=producer(unstructured(ring, 1)), MaximumNumberOfBlocks=7))
    assert "8 blocks" in error
    assert "the input has no hexahedra" in failure(simple.HexMeshToBlocks(Input=producer(vtk.vtkUnstructuredGrid())))


def test_high_order_cells_by_their_corners():
    data, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
    for p in range(20):
        points.InsertNextPoint([p & 1, p >> 1 & 1, p >> 2 & 1] if p < 8 else [0.5, 0.5, 0.1 * p])
    data.SetPoints(points)
    data.InsertNextCell(25, 20, [0, 1, 3, 2, 4, 5, 7, 6] + list(range(8, 20)))
    made, report, _ = found(data)
    assert "1 hexahedra are of higher order" in report
    assert blocks(made)[0].GetNumberOfPoints() == 8


def test_real_meshes():
    folder = os.path.join(os.environ.get("BSV_SHARED_DATA", ""), "hex")
    for name, count in (("rod_hex_paper_used", 8), ("joint_hex_paper", 39), ("ant_hex_paper", 123)):
        path = os.path.join(folder, name + ".vtk")
        if not os.path.exists(path):
            continue
        reader = simple.LegacyVTKReader(FileNames=[path])
        data, report, _ = found(reader)
        assert len(blocks(data)) == count, report
        update(simple.CatmullClarkToBSplineVolume(Input=producer(data)))


main(globals())
