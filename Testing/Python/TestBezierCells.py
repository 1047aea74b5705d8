# SPDX-License-Identifier: BSD-3-Clause
"""vtkBSplineVolumeToBezier and vtkBSplineVolumeReader through their proxies: cells as VTK evaluates them."""
import math
import os
import random
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (aborted, simple, vtk, blocks, collection, coordinates, demo_mesh, dimensions, failure, field,
                         grid, main, names, producer, update, values)

DEMO = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(8), UseCreaseAngle=1)
LEVEL = 2
UNITY = ("3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n"
         "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n")


def array(name, numbers, integer=False):
    result = vtk.vtkIntArray() if integer else vtk.vtkDoubleArray()
    result.SetName(name)
    for number in numbers:
        result.InsertNextValue(number)
    return result


def random_knots(rng, degree, clamped):
    """Inner knots repeated up to `degree` times."""
    inner = sorted(rng.choice((1.0, 2.5)) for _ in range(rng.randint(0, degree)))
    before, after = (([0.0] * degree, [4.0] * degree) if clamped else
                     ([-0.5 * n for n in range(degree, 0, -1)], [4 + 0.25 * n for n in range(1, degree + 1)]))
    return before + [0.0] + inner + [4.0] + after


def random_volume(rng, degree, rational):
    knots = [random_knots(rng, p, rng.random() < 0.7) for p in degree]
    size = [len(t) - p - 1 for t, p in zip(knots, degree)]
    data = grid([n - 1 for n in size], lambda *_: [rng.uniform(-1, 1) for _ in range(3)])
    data.GetFieldData().AddArray(array("Degree", degree, integer=True))
    for name, numbers in zip(("KnotsU", "KnotsV", "KnotsW"), knots):
        data.GetFieldData().AddArray(array(name, numbers))
    if rational:
        data.GetPointData().AddArray(array("Weights", [rng.uniform(0.3, 2) for _ in range(data.GetNumberOfPoints())]))
    return data


def bezier(data, **properties):
    properties.setdefault("Cells", "Volume")
    return simple.BSplineVolumeToBezierCells(Input=data if hasattr(data, "SMProxy") else producer(data), **properties)


def evaluate(cell, pcoords):
    x, weights = [0.0] * 3, [0.0] * cell.GetNumberOfPoints()
    cell.EvaluateLocation(vtk.mutable(0), pcoords, x, weights)
    return x


def worst_difference(cells, samples, volumes):
    """Largest distance of VTK's evaluation of the cells from the samples of the volumes, at all samples."""
    parts, worst = 2 ** LEVEL, 0.0
    span_ids, block_ids = (values(cells.GetCellData().GetArray(name)) for name in ("SpanId", "BlockId"))
    faces = cells.GetCellData().GetArray("FaceId")
    degrees = values(cells.GetCellData().GetHigherOrderDegrees())
    for n in range(cells.GetNumberOfCells()):
        cell = cells.GetCell(n)
        block = blocks(samples)[int(block_ids[n])]
        dims = dimensions(block)
        free = [0, 1, 2]
        fixed = {}
        if faces:
            face = int(faces.GetTuple1(n))
            free.remove(face // 2)
            fixed[face // 2] = dims[face // 2] - 1 if face % 2 else 0
            # Outward: exchanged against the axes of the face on the sides j=J, i=0 and k=0.
            if face in (0, 3, 4):
                free.reverse()
        block_degree = field(volumes[int(block_ids[n])], "Degree")
        assert list(degrees[n]) == [block_degree[d] for d in free] + [0] * len(fixed)
        steps = [range(parts + 1)] * len(free) + [[0]] * (3 - len(free))
        for a in steps[0]:
            for b in steps[1]:
                for c in steps[2]:
                    ijk = [0, 0, 0]
                    for d, step in zip(free, (a, b, c)):
                        ijk[d] = int(span_ids[n][d]) * parts + step
                    for d, place in fixed.items():
                        ijk[d] = place
                        assert span_ids[n][d] in (0, (dims[d] - 1) // parts - 1)
                    expected = block.GetPoint(ijk[0] + dims[0] * (ijk[1] + dims[1] * ijk[2]))
                    worst = max(worst, math.dist(evaluate(cell, (a / parts, b / parts, c / parts)), expected))
    return worst


def test_properties():
    assert simple.BSplineVolumeToBezierCells(Input=DEMO).Cells == "Wall"


def test_vtk_evaluates_the_volume():
    """All degrees, mixed; repeated knots, open ends, weights; hexahedra and quadrilaterals."""
    rng = random.Random(1)
    for rational in (False, True):
        for cells in ("Volume", "All Faces"):
            degrees = [(p, 1 + (3 * p) % 8, 9 - p) for p in range(1, 9)] if cells != "Volume" else \
                [(1, 3, 2), (2, 1, 4), (5, 1, 1), (3, 3, 3), (1, 8, 1), (2, 1, 7), (6, 2, 1)]
            data = collection([random_volume(rng, p, rational) for p in degrees])
            source = producer(data)
            samples, _ = update(simple.BSplineVolumeSampler(Input=source, Level=LEVEL))
            found, _ = update(bezier(source, Cells=cells))
            assert found.GetCellType(0) == (vtk.VTK_BEZIER_HEXAHEDRON if cells == "Volume"
                                            else vtk.VTK_BEZIER_QUADRILATERAL)
            assert bool(found.GetPointData().GetRationalWeights()) == rational
            assert coordinates(found).GetDataTypeAsString() == "double"
            # Coordinates lie in [-1, 1].
            worst = worst_difference(found, samples, blocks(data))
            assert worst < 1e-14


def entities(samples):
    """Numbers of vertices, edges, faces and cells of the spans, and of faces of one cell only, from coordinates."""
    vertices, edges, faces, cells = set(), set(), {}, 0
    for block in blocks(samples):
        ni, nj, nk = dimensions(block)
        point = [block.GetPoint(n) for n in range(block.GetNumberOfPoints())]
        vertices.update(point)
        for k in range(nk - 1):
            for j in range(nj - 1):
                for i in range(ni - 1):
                    cells += 1
                    c = [point[i + a + ni * (j + b + nj * (k + d))] for d in (0, 1) for b in (0, 1) for a in (0, 1)]
                    for bit in (1, 2, 4):
                        for v in range(8):
                            if not v & bit:
                                edges.add(frozenset((c[v], c[v | bit])))
                        for side in (0, bit):
                            key = frozenset(c[v] for v in range(8) if v & bit == side)
                            faces[key] = faces.get(key, 0) + 1
    return len(vertices), len(edges), len(faces), cells, sum(n == 1 for n in faces.values())


def test_demo_is_welded():
    """V + 2 E + 4 F + 8 C points of degree 3, and only those."""
    samples, _ = update(simple.BSplineVolumeSampler(Input=DEMO, Level=0))
    vertices, edges, faces, cells, outer = entities(samples)
    before, _ = update(DEMO)
    assert len(blocks(before)) > 2
    found, _ = update(bezier(DEMO))
    assert found.GetNumberOfPoints() == vertices + 2 * edges + 4 * faces + 8 * cells
    assert found.GetNumberOfCells() == cells
    assert field(found, "BlockNames") == names(before)
    skin, _ = update(bezier(DEMO, Cells="Outer Faces"))
    assert skin.GetNumberOfCells() == outer
    # A closed surface of quadrilaterals: 2 E = 4 F, and its Euler number is even.
    assert (skin.GetNumberOfPoints() - outer * 4 - 2 * (2 * outer)) - 2 * outer + outer in (0, 2, 4)

    # The wall is that part of the skin, with the points of its cells only; without names it is all of the skin.
    wall, _ = update(bezier(DEMO, Cells="Wall"))
    wall_tag = field(before, "BoundaryNames").index("WALL")
    of_wall = {tuple(map(int, row[:2])) for row in field(before, "Boundaries") if row[2] == wall_tag}
    owners = list(zip(*(values(skin.GetCellData().GetArray(name)) for name in ("BlockId", "FaceId"))))
    kept = [n for n, owner in enumerate(owners) if tuple(map(int, owner)) in of_wall]
    assert 0 < wall.GetNumberOfCells() == len(kept) < outer
    for n, cell in enumerate(kept):
        ids, others = wall.GetCell(n).GetPointIds(), skin.GetCell(cell).GetPointIds()
        assert all(wall.GetPoint(ids.GetId(p)) == skin.GetPoint(others.GetId(p)) for p in range(ids.GetNumberOfIds()))
    used = {skin.GetCell(cell).GetPointIds().GetId(p) for cell in kept for p in range(16)}
    assert wall.GetNumberOfPoints() == len(used)

    # What a viewer draws of the volume is the skin.
    surface = simple.ExtractSurface(Input=bezier(DEMO), NonlinearSubdivisionLevel=2)
    other = simple.ExtractSurface(Input=bezier(DEMO, Cells="Outer Faces"), NonlinearSubdivisionLevel=2)
    assert update(surface)[0].GetNumberOfPolys() == update(other)[0].GetNumberOfPolys()

    # Without declared contacts the same is found.
    bare = vtk.vtkPartitionedDataSetCollection()
    bare.ShallowCopy(before)
    bare.SetFieldData(vtk.vtkFieldData())
    again, _ = update(bezier(bare))
    assert again.GetNumberOfPoints() == found.GetNumberOfPoints()
    assert bytes(memoryview(coordinates(again))) == bytes(memoryview(coordinates(found)))


def test_faces_point_outwards():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "cube.g2")
        with open(path, "w") as file:
            file.write("700 1 0 0\n" + UNITY)
        skin, _ = update(bezier(simple.BSplineVolumeReader(FileName=path), Cells="Outer Faces"))
    assert skin.GetNumberOfCells() == 6 and skin.GetNumberOfPoints() == 8
    for n in range(6):
        cell = skin.GetCell(n)
        o, x, y = (evaluate(cell, p) for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0)))
        a, b = ([p[c] - o[c] for c in range(3)] for p in (x, y))
        normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        face = int(skin.GetCellData().GetArray("FaceId").GetTuple1(n))
        assert normal == [(2 * (face % 2) - 1 if c == face // 2 else 0) for c in range(3)], (face, normal)


def test_rational_display():
    """A quarter of a pipe with radii 1 and 2: what ParaView draws lies on circles."""
    half = math.sqrt(0.5)
    arc = ((1, 0, 1), (1, 1, half), (0, 1, 1))
    lines = [" ".join(repr(w * c) for c in (r * x, r * y, z)) + " " + repr(w)
             for z in (0.0, 1.0) for x, y, w in arc for r in (1.0, 2.0)]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "pipe.g2")
        with open(path, "w") as file:
            file.write("700 1 0 0\n3 1\n2 2\n0 0 1 1\n3 3\n0 0 0 1 1 1\n2 2\n0 0 1 1\n" + "\n".join(lines))
        reader = simple.BSplineVolumeReader(FileName=path)
        for cells in ("Volume", "Outer Faces"):
            surface, _ = update(simple.ExtractSurface(Input=bezier(reader, Cells=cells), NonlinearSubdivisionLevel=3))
            assert surface.GetNumberOfPolys() > 6 * 4 ** 2
            for n in range(surface.GetNumberOfPoints()):
                x, y, z = surface.GetPoint(n)
                radius = math.hypot(x, y)
                # The surface has single precision.
                assert min(abs(radius - 1), abs(radius - 2), abs(x), abs(y), z, 1 - z) < 1e-6, (x, y, z)


def test_threads_do_not_matter():
    found = []
    for threads in (1, 2):
        vtk.vtkSMPTools.Initialize(threads)
        data, _ = update(bezier(DEMO))
        found.append(bytes(memoryview(coordinates(data))) +
                     bytes(memoryview(data.GetCells().GetConnectivityArray())))
    assert found[0] == found[1]


def test_errors_and_nothing():
    assert "it is no B-spline volume" in failure(bezier(grid((2, 2, 2), lambda *p: p)))
    assert "has no B-spline volume" in failure(bezier(vtk.vtkPartitionedDataSetCollection()))
    # 40^3 spans of degree 3, 10,000 times: about 800 GB.
    large = grid((42, 42, 42), lambda *p: p)
    large.GetFieldData().AddArray(array("Degree", (3, 3, 3), integer=True))
    for name in ("KnotsU", "KnotsV", "KnotsW"):
        large.GetFieldData().AddArray(array(name, range(47)))
    assert "the volume needs" in failure(bezier(collection([large] * 10000)))
    wrong = random_volume(random.Random(2), (1, 1, 1), True)
    wrong.GetPointData().GetArray("Weights").SetValue(1, 0.0)
    assert "the weight of control point 1 is 0, not positive" in failure(bezier(wrong))


def test_abort():
    aborted(bezier(DEMO))


def test_reader_is_chosen_by_content():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "two.g2")
        with open(path, "w") as file:
            file.write("700 1 0 0\n" + UNITY + "100 1 0 0\n3 0\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n")
        reader = simple.BSplineVolumeReader(FileName=path)
        data, warnings = update(reader)
        assert names(data) == ["Volume 1"] and len(warnings) == 1 and "1 spline curve" in warnings[0]
        reader.UpdatePipelineInformation()
        assert reader.Format == "GoTools g2" and reader.NumberOfBlocks == 1 and reader.NumberOfRationalBlocks == 0
        assert reader.NotRead == "1 spline curve"
        # The samples of the unit cube are its parameters.
        samples, _ = update(simple.BSplineVolumeSampler(Input=reader, Level=1))
        assert values(coordinates(blocks(samples)[0]))[14] == (1.0, 0.5, 0.5)

        mesh = os.path.join(folder, "refused.mesh")
        with open(mesh, "w") as file:
            file.write("MFEM NURBS mesh v1.2\n")
        assert "line 1: 'MFEM NURBS mesh v1.2' is not supported" in failure(simple.BSplineVolumeReader(FileName=mesh))
        assert simple.OpenDataFile(mesh).GetXMLName() == "BSplineVolumeReader"


if __name__ == "__main__":
    main(globals())
