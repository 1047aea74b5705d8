# SPDX-License-Identifier: BSD-3-Clause
"""vtkBSplineVolumeSampler through its proxy: output data, watertight faces, nested levels, derivatives, errors."""
import os
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (aborted, simple, vtk, blocks, collection, coordinates, demo_mesh, dimensions, failure, field,
                         grid, main, names, producer, update, values)

DEMO = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(8), UseCreaseAngle=1)


def add_field(data, name, numbers, integer=False):
    array = vtk.vtkIntArray() if integer else vtk.vtkDoubleArray()
    array.SetName(name)
    for number in numbers:
        array.InsertNextValue(number)
    data.GetFieldData().AddArray(array)


def clamped(cells):
    return [0.0] * 4 + [float(n) for n in range(1, cells)] + [float(cells)] * 4


def volume(cells, place):
    """B-spline block whose control points are place(Greville abscissae)."""
    knots = [clamped(n) for n in cells]
    greville = [[sum(t[i + 1:i + 4]) / 3 for i in range(len(t) - 4)] for t in knots]
    data = grid([n + 2 for n in cells], lambda i, j, k: place(greville[0][i], greville[1][j], greville[2][k]))
    add_field(data, "Degree", [3, 3, 3], integer=True)
    for name, numbers in zip(("KnotsU", "KnotsV", "KnotsW"), knots):
        add_field(data, name, numbers)
    return data


def sampler(data, **properties):
    return simple.BSplineVolumeSampler(Input=data if hasattr(data, "SMProxy") else producer(data), **properties)


def sheared(x, y, z):
    return x + 2 * y, y - z, 0.5 * z + 3


def test_properties():
    proxy = sampler(DEMO)
    assert proxy.Level == 1 and not proxy.ComputeDerivatives


def test_linear_volume():
    proxy = sampler(collection([volume((2, 1, 3), sheared)]), Level=2, ComputeDerivatives=1)
    data, _ = update(proxy)
    block = blocks(data)[0]
    assert dimensions(block) == (9, 5, 13)
    assert coordinates(block).GetDataTypeAsString() == "double"
    expected = {"dXdU": (1, 0, 0), "dXdV": (2, 1, 0), "dXdW": (0, -1, 0.5)}
    for n in range(block.GetNumberOfPoints()):
        uvw = n % 9 / 4, n // 9 % 5 / 4, n // 45 / 4
        assert all(abs(a - b) < 1e-14 for a, b in zip(block.GetPoint(n), sheared(*uvw)))
        for name, vector in expected.items():
            found = block.GetPointData().GetArray(name).GetTuple(n)
            assert all(abs(a - b) < 1e-13 for a, b in zip(found, vector)), (name, found)
    assert names(data) == ["block 0"]


def test_inputs():
    """A single grid, a multi-block data set, single precision, an empty collection."""
    block = volume((1, 1, 1), sheared)
    expected = values(coordinates(blocks(update(sampler(collection([block])))[0])[0]))
    assert values(coordinates(blocks(update(sampler(block))[0])[0])) == expected

    tree = vtk.vtkMultiBlockDataSet()
    tree.SetBlock(0, block)
    assert values(coordinates(blocks(update(sampler(tree))[0])[0])) == expected

    single = vtk.vtkStructuredGrid()
    single.ShallowCopy(block)
    points = vtk.vtkPoints()
    points.SetDataTypeToFloat()
    points.DeepCopy(block.GetPoints())
    single.SetPoints(points)
    found = values(coordinates(blocks(update(sampler(single))[0])[0]))
    assert all(abs(a - b) < 1e-6 for x, y in zip(found, expected) for a, b in zip(x, y))

    assert "has no B-spline volume" in failure(sampler(vtk.vtkPartitionedDataSetCollection()))


def face(block, number):
    """Points of a face as {(s, t): xyz}, and the last s and t."""
    dims = dimensions(block)
    normal = number // 2
    u, v = [d for d in range(3) if d != normal]
    ijk = [0, 0, 0]
    ijk[normal] = dims[normal] - 1 if number % 2 else 0
    found = {}
    for t in range(dims[v]):
        for s in range(dims[u]):
            ijk[u], ijk[v] = s, t
            found[s, t] = block.GetPoint(ijk[0] + dims[0] * (ijk[1] + dims[1] * ijk[2]))
    return found, dims[u] - 1, dims[v] - 1


def test_demo_is_watertight_and_carries_its_contacts():
    before, _ = update(DEMO)
    data, _ = update(sampler(DEMO, Level=1))
    assert names(data) == names(before)
    assert data.GetDataAssembly().GetNumberOfChildren(0) == len(names(before))
    for name in ("Interfaces", "Boundaries", "BoundaryNames"):
        assert field(data, name) == field(before, name)
    contacts = field(data, "Interfaces")
    assert len(contacts) > 3
    for contact in contacts:
        block_a, face_a, block_b, face_b, code = (int(n) for n in contact[:5])
        points_a, ns, nt = face(blocks(data)[block_a], face_a)
        points_b, _, _ = face(blocks(data)[block_b], face_b)
        assert len(points_a) == len(points_b)
        for (s, t), point in points_a.items():
            u, v, nu, nv = (t, s, nt, ns) if code & 1 else (s, t, ns, nt)
            assert points_b[nu - u if code & 2 else u, nv - v if code & 4 else v] == point


def test_levels_are_nested():
    coarse, fine = (update(sampler(DEMO, Level=level))[0] for level in (0, 1))
    for a, b in zip(blocks(coarse), blocks(fine)):
        dims_a, dims_b = dimensions(a), dimensions(b)
        assert dims_b == tuple(2 * n - 1 for n in dims_a)
        for k in range(dims_a[2]):
            for j in range(dims_a[1]):
                for i in range(dims_a[0]):
                    assert a.GetPoint(i + dims_a[0] * (j + dims_a[1] * k)) == \
                        b.GetPoint(2 * i + dims_b[0] * (2 * j + dims_b[1] * 2 * k))


def test_threads_do_not_matter():
    found = []
    for threads in (1, 2):
        vtk.vtkSMPTools.Initialize(threads)
        data, _ = update(sampler(DEMO, Level=2))
        found.append(b"".join(bytes(memoryview(coordinates(block))) for block in blocks(data)))
    assert found[0] == found[1]


def test_errors():
    block = volume((2, 2, 2), sheared)
    for name in ("Degree", "KnotsU", "KnotsV", "KnotsW"):
        broken = vtk.vtkStructuredGrid()
        broken.ShallowCopy(block)
        fields = vtk.vtkFieldData()
        fields.ShallowCopy(block.GetFieldData())
        fields.RemoveArray(name)
        broken.SetFieldData(fields)
        assert "block 0 'block 0' has no field data array '%s'" % name in failure(sampler(broken))
        add_field(broken, name, [1, 2])
        assert "has 2 values instead of" in failure(sampler(broken))
    plain = grid((2, 2, 2), sheared)
    assert "it is no B-spline volume" in failure(sampler(plain))

    wrong = volume((2, 2, 2), sheared)
    wrong.GetFieldData().GetArray("Degree").SetValue(1, 9)
    assert "'Degree' has the value 9" in failure(sampler(wrong))
    wrong = volume((2, 2, 2), sheared)
    wrong.GetFieldData().GetArray("KnotsV").SetValue(4, 7.0)
    assert "knot 5 is smaller than the one before it in direction v" in failure(sampler(wrong))
    wrong = volume((2, 2, 2), sheared)
    wrong.GetFieldData().GetArray("KnotsW").SetValue(0, float("nan"))
    assert "knot 0 is not finite in direction w" in failure(sampler(wrong))

    data = collection([block, block])
    contacts = vtk.vtkIntArray()
    contacts.SetName("Interfaces")
    contacts.SetNumberOfComponents(12)
    contacts.InsertNextTuple((0, 1, 1, 0, 0, 1, 0, 2, 0, 4, 0, 0))
    data.GetFieldData().AddArray(contacts)
    assert "covers only part of face 1 of block 0" in failure(sampler(data))

    huge = collection([volume((300, 1, 1), sheared)] * 300)
    text = failure(sampler(huge, Level=8))
    assert "GB are free" in text or "too many samples" in text


def test_abort():
    aborted(sampler(DEMO, Level=2))


def test_refinement_at_walls():
    """Classes of parallel spans: conforming, nested in the uniform level bit for bit, with far fewer cells."""
    uniform, _ = update(sampler(DEMO, Level=2))
    coarse, _ = update(sampler(DEMO, Level=0))
    proxy = sampler(DEMO, Level=0, WallLevel=2)
    fine, warnings = update(proxy)
    assert not warnings
    assert uniform.GetNumberOfElements(1) > 50 * fine.GetNumberOfElements(1) > 50 * coarse.GetNumberOfElements(1)
    proxy.UpdatePropertyInformation()
    report = proxy.GetProperty("Report").GetData()
    assert "%d cells" % fine.GetNumberOfElements(1) in report and "at level 2" in report, report
    for few, many in zip(blocks(fine), blocks(uniform)):
        known = set(values(coordinates(many)))
        assert all(point in known for point in values(coordinates(few)))
    # The reader of the neutral map compares the points of all contacts.
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "a.xyz")
        simple.SaveData(path, proxy=proxy)
        back, _ = update(simple.HexBlockMeshReader(FileName=path))
        assert len(field(back, "Interfaces")) == len(field(fine, "Interfaces"))

    def cells(**properties):
        return update(sampler(DEMO, Level=0, **properties))[0].GetNumberOfElements(1)
    assert cells(WallLevel=2, WallLayers=2) > cells(WallLevel=2)
    assert cells(TangentialLevel=1) > cells(TangentialLevel=0) == coarse.GetNumberOfElements(1)
    assert cells(BlockLevels=[0, 2, 1]) > coarse.GetNumberOfElements(1)
    assert cells(FirstCellHeight=1e9) == cells(ChordError=1e9) == coarse.GetNumberOfElements(1)
    # A height between those of levels 1 and 2 takes level 2.
    proxy = sampler(DEMO, Level=0, FirstCellHeight=0.012)
    assert update(proxy)[0].GetNumberOfElements(1) == fine.GetNumberOfElements(1)
    assert cells(ChordError=1e-3) > coarse.GetNumberOfElements(1)
    error = failure(sampler(DEMO, Level=0, BlockLevels=[99, 0, 1]))
    assert "no block 99" in error
    _, warnings = update(sampler(DEMO, Level=0, WallLevel=2, BodyBoundaries=["nothing"]))
    assert len(warnings) == 1 and "'nothing' fits no boundary" in warnings[0], warnings


if __name__ == "__main__":
    main(globals())
