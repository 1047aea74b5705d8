# SPDX-License-Identifier: BSD-3-Clause
"""Samples, quality, smoothness, Bezier cells and topology files of a volume whose blocks are shared out over MPI ranks:
the same bits as on one rank. Run with pvbatch --sym on any number of ranks.

Every rank computes what it expects from the whole volume, alone.
"""
import contextlib
import hashlib
import os
import random
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsv_support import (RANK, RANKS, Alone, vtk, collection, coordinates, dimensions, field, grid, main, names,
                         shared_folder, total, values)

assert RANKS == int(os.environ.get("BSV_EXPECTED_RANKS", "1"))
SPANS = (3, 2, 2)
SHAPE = (2, 2, 3)  # blocks per direction


def volume(fold=0.0, rational=False):
    """A wavy lattice of control points in 12 blocks, no two of the same orientation in a row.

    With `fold` some blocks are turned inside out in part; one may be rational, with weights 1 on its surface.
    """
    def place(i, j, k):
        x, y, z = float(i), 0.8 * j, 0.3 * k * k
        wave = 0.05 * ((7 * i + 3 * j + 5 * k) % 11)
        return x + wave - fold * (i == 2 and j == 1), y - wave * z, z + 0.2 * wave * x

    blocks = []
    for w in range(SHAPE[2]):
        for v in range(SHAPE[1]):
            for u in range(SHAPE[0]):
                offset = (u * (SPANS[0] + 2), v * (SPANS[1] + 2), w * (SPANS[2] + 2))
                order = [0, 1, 2] if (u + v + w) % 2 else [1, 2, 0]

                def at(*local, offset=offset, order=order):
                    i = [0, 0, 0]
                    for d in range(3):
                        i[order[d]] = local[d]
                    return place(*(i[d] + offset[d] for d in range(3)))
                data = grid([SPANS[d] + 2 for d in order], at)
                degree = vtk.vtkIntArray()
                degree.SetName("Degree")
                for d, name in zip(order, ("KnotsU", "KnotsV", "KnotsW")):
                    degree.InsertNextValue(3)
                    knots = vtk.vtkDoubleArray()
                    knots.SetName(name)
                    for knot in [0] * 3 + list(range(SPANS[d] + 1)) + [SPANS[d]] * 3:
                        knots.InsertNextValue(knot)
                    data.GetFieldData().AddArray(knots)
                data.GetFieldData().AddArray(degree)
                blocks.append(data)
    if rational:
        size = dimensions(blocks[4])
        weights = vtk.vtkDoubleArray()
        weights.SetName("Weights")
        for k in range(size[2]):
            for j in range(size[1]):
                for i in range(size[0]):
                    inside = all(0 < n < last - 1 for n, last in zip((i, j, k), size))
                    weights.InsertNextValue(1.0 + 0.1 * (i + j) if inside else 1.0)
        blocks[4].GetPointData().AddArray(weights)
    whole = collection(blocks)
    for b in range(len(blocks)):
        whole.GetMetaData(b).Set(vtk.vtkCompositeDataSet.NAME(), "zone %d" % b)
    boundaries = vtk.vtkIntArray()
    boundaries.SetName("Boundaries")
    boundaries.SetNumberOfComponents(3)
    for b in (2, 0):
        boundaries.InsertNextTuple((b, 0, 0))
    whole.GetFieldData().AddArray(boundaries)
    tags = vtk.vtkStringArray()
    tags.SetName("BoundaryNames")
    tags.InsertNextValue("wall")
    whole.GetFieldData().AddArray(tags)
    return whole


def part(whole, owners):
    """What this rank has of a volume."""
    count = whole.GetNumberOfPartitionedDataSets()
    result = vtk.vtkPartitionedDataSetCollection()
    result.SetNumberOfPartitionedDataSets(count)
    for b in range(count):
        if owners[b] == RANK:
            result.SetPartition(b, 0, whole.GetPartition(b, 0))
        result.GetMetaData(b).Set(vtk.vtkCompositeDataSet.NAME(), names(whole)[b])
    result.GetFieldData().ShallowCopy(whole.GetFieldData())
    return result


def distributions(count):
    """Blocks in turn, all on the last rank, at random; the same on all ranks."""
    dice = random.Random(RANKS)
    return [[b % RANKS for b in range(count)], [RANKS - 1] * count, [dice.randrange(RANKS) for _ in range(count)]]


def arrays(attributes):
    return {attributes.GetArrayName(a): values(attributes.GetAbstractArray(a))
            for a in range(attributes.GetNumberOfArrays())}


def content(data):
    """Points and all arrays of a data set; NaN-free, so that they can be compared."""
    return (bytes(memoryview(coordinates(data))) if data.GetNumberOfPoints() else b"", arrays(data.GetPointData()),
            arrays(data.GetCellData()), arrays(data.GetFieldData()))


def run(kind, data, **properties):
    """A filter after its execution, and the messages that it raised here."""
    algorithm = getattr(bsplinevolume, kind)()
    for name, value in properties.items():
        getattr(algorithm, "Set" + name)(value)
    said = []

    def observe(_object, _event, text):
        said.append(text)
    observe.CallDataType = "string0"
    algorithm.AddObserver("ErrorEvent", observe)
    algorithm.AddObserver("WarningEvent", observe)
    silent = algorithm.GetExecutive().AddObserver("ErrorEvent", lambda *_: None)
    algorithm.SetInputDataObject(data)
    algorithm.Update()
    algorithm.GetExecutive().RemoveObserver(silent)
    return algorithm, said


def both(kind, whole, owners, **properties):
    """The filter on this rank's part, after that on the whole volume."""
    with Alone():
        alone, said = run(kind, whole, **properties)
    assert not said or kind == "vtkBSplineVolumeQuality", said
    here, here_said = run(kind, part(whole, owners), **properties)
    # Messages of all ranks are raised by the first.
    assert [text.split("): ")[-1] for text in here_said] == \
        ([text.split("): ")[-1] for text in said] if RANK == 0 else []), (here_said, said)
    return alone, here


def expect_parts(alone, here, owner):
    """The data sets are those of the whole; `owner(n)` has the partition of number n."""
    assert names(here) == names(alone)
    assert here.GetNumberOfPartitionedDataSets() == alone.GetNumberOfPartitionedDataSets()
    assert arrays(here.GetFieldData()) == arrays(alone.GetFieldData())
    for n in range(alone.GetNumberOfPartitionedDataSets()):
        if owner(n) == RANK:
            assert content(here.GetPartition(n, 0)) == content(alone.GetPartition(n, 0)), n
        else:
            assert here.GetNumberOfPartitions(n) == 0


def in_all_ways(check, **options):
    """check(volume, owners) for all distributions without, and for one with declared interfaces."""
    whole = volume(**options)
    with Alone():
        quality, _ = run("vtkBSplineVolumeQuality", whole)
    declared = vtk.vtkPartitionedDataSetCollection()
    declared.ShallowCopy(whole)
    declared.GetFieldData().AddArray(quality.GetOutputDataObject(0).GetFieldData().GetArray("Interfaces"))
    # In 2 x 2 x 3 blocks.
    assert len(field(declared, "Interfaces")) == 20
    ways = distributions(whole.GetNumberOfPartitionedDataSets())
    for owners in ways:
        check(whole, owners)
    check(declared, ways[-1])


def test_samples():
    def check(whole, owners):
        alone, here = both("vtkBSplineVolumeSampler", whole, owners, Level=1, ComputeDerivatives=True)
        expect_parts(alone.GetOutputDataObject(0), here.GetOutputDataObject(0), lambda b: owners[b])
    in_all_ways(check)


def test_quality():
    def check(whole, owners):
        alone, here = both("vtkBSplineVolumeQuality", whole, owners)
        expect_parts(alone.GetOutputDataObject(0), here.GetOutputDataObject(0), lambda b: owners[b])
        for name in ("NumberOfSpans", "NumberOfValidSpans", "NumberOfInvalidSpans", "NumberOfUndecidedSpans",
                     "MinimumJacobian", "MinimumScaledJacobian", "WorstBlock"):
            assert getattr(here, "Get" + name)() == getattr(alone, "Get" + name)(), name
        assert alone.GetNumberOfInvalidSpans() > 0
        everywhere, mine = alone.GetOutputDataObject(1), here.GetOutputDataObject(1)
        assert everywhere.GetNumberOfPoints() > 0
        rows = list(zip(*arrays(everywhere.GetPointData()).values()))
        block = list(arrays(everywhere.GetPointData())).index("BlockId")
        assert list(zip(*arrays(mine.GetPointData()).values())) == \
            [row for row in rows if owners[int(row[block])] == RANK]
    in_all_ways(check, fold=2.5)


def test_smoothness():
    def check(whole, owners):
        alone, here = both("vtkBSplineVolumeSmoothness", whole, owners, AllOuterFaces=True)
        expected, output = alone.GetOutputDataObject(0), here.GetOutputDataObject(0)
        first = [int(field(expected.GetPartition(n, 0), "Blocks")[0])
                 for n in range(expected.GetNumberOfPartitionedDataSets())]
        assert len(first) == 20
        expect_parts(expected, output, lambda n: owners[first[n]])
        expect_parts(alone.GetOutputDataObject(1), here.GetOutputDataObject(1), lambda b: owners[b])
        assert here.GetReport() == alone.GetReport() != ""
        for name in ("MaximumGap", "MaximumNormalJump", "MaximumC1Jump", "MaximumC2Jump", "NumberOfInterfaces",
                     "NumberOfWallBorders", "NumberOfExtraordinaryCurves"):
            assert getattr(here, "Get" + name)() == getattr(alone, "Get" + name)(), name
        rows = arrays(alone.GetOutputDataObject(2).GetRowData())
        assert arrays(here.GetOutputDataObject(2).GetRowData()) == \
            (rows if RANK == 0 else {name: [] for name in rows})
        curves = [arrays(a.GetOutputDataObject(3).GetCellData()) for a in (alone, here)]
        mine = [n for n, block in enumerate(curves[0]["BlockA"]) if owners[int(block)] == RANK]
        assert curves[1] == {name: [column[n] for n in mine] for name, column in curves[0].items()}
        assert total(len(mine)) == len(curves[0]["BlockA"]) > 0
    in_all_ways(check, rational=True)


def test_probe():
    def check(whole, owners):
        points = vtk.vtkPoints()
        dice = random.Random(5)
        for _ in range(60):
            points.InsertNextPoint(dice.uniform(-1, 11), dice.uniform(-1, 7), dice.uniform(-1, 30))
        cloud = vtk.vtkPolyData()
        cloud.SetPoints(points)
        results = []
        for context, data in ((Alone(), whole), (contextlib.nullcontext(), part(whole, owners))):
            with context:
                probe = bsplinevolume.vtkBSplineVolumeProbe()
                probe.SetInputDataObject(0, data)
                probe.SetInputDataObject(1, cloud)
                probe.SetComputeDerivatives(True)
                probe.Update()
                results.append((probe, arrays(probe.GetOutputDataObject(0).GetPointData())))
        assert results[0][1] == results[1][1]
        alone, here = (probe for probe, _ in results)
        assert 0 < alone.GetNumberOfPointsInside() < alone.GetNumberOfPoints() == 60
        assert here.GetNumberOfPoints() == 60 * RANKS
        assert here.GetNumberOfPointsInside() == alone.GetNumberOfPointsInside() * RANKS
    in_all_ways(check)


def cells(data):
    """Block, span, face and points of all cells, in their order."""
    ids = arrays(data.GetCellData())
    points = data.GetPoints().GetData() if data.GetPoints() else None
    result = []
    for c in range(data.GetNumberOfCells()):
        corner = vtk.vtkIdList()
        data.GetCellPoints(c, corner)
        result.append(([column[c] for column in ids.values()], ids["BlockId"][c],
                       [points.GetTuple3(corner.GetId(p)) for p in range(corner.GetNumberOfIds())]))
    return result


def test_bezier_cells():
    def check(whole, owners):
        for kind in range(3):
            alone, here = both("vtkBSplineVolumeToBezier", whole, owners, Cells=kind)
            expected = [cell for cell in cells(alone.GetOutputDataObject(0)) if owners[int(cell[1])] == RANK]
            assert cells(here.GetOutputDataObject(0)) == expected
            assert field(here.GetOutputDataObject(0), "BlockNames") == names(whole)
            assert total(len(expected)) == alone.GetOutputDataObject(0).GetNumberOfCells() > 0
            weights = [a.GetOutputDataObject(0).GetPointData().GetArray("RationalWeights") for a in (alone, here)]
            assert weights[0] and weights[1]
    in_all_ways(check, rational=True)


def test_isoparametric():
    def pieces(data):
        ids = data.GetCellData()
        result = []
        for c in range(data.GetNumberOfCells()):
            corners = data.GetCell(c).GetPointIds()
            result.append((ids.GetArray("BlockId").GetTuple1(c), ids.GetArray("Position").GetTuple(c),
                           [data.GetPoint(corners.GetId(n)) for n in range(corners.GetNumberOfIds())]))
        return result

    def check(whole, owners):
        for shape in (0, 1):
            alone, here = both("vtkBSplineVolumeIsoparametric", whole, owners, Shape=shape, Level=0)
            everywhere, mine = (pieces(a.GetOutputDataObject(0)) for a in (alone, here))
            assert mine == [piece for piece in everywhere if owners[int(piece[0])] == RANK]
            assert total(len(mine)) == len(everywhere) > 0
    in_all_ways(check)


def files(folder):
    """Names and hashes of the files of a folder."""
    result = {}
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), "rb") as file:
            result[name] = hashlib.sha256(file.read()).hexdigest()
    return result


def write(path, data, kind="vtkQuadflowWriter", **properties):
    writer = getattr(bsplinevolume, kind)()
    writer.SetFileName(path)
    for name, value in properties.items():
        getattr(writer, "Set" + name)(value)
    said = []

    def observe(_object, _event, text):
        said.append(text)
    observe.CallDataType = "string0"
    writer.AddObserver("ErrorEvent", observe)
    writer.SetInputDataObject(data)
    return writer.Write(), said


def test_topology_files():
    def check(folder, whole, owners):
        for properties in ({}, {"Binary": True}, {"SeparateGeometry": True, "IndexBase": 1}):
            with Alone(), tempfile.TemporaryDirectory() as own:
                done, said = write(os.path.join(own, "a.qfmb"), whole, **properties)
                assert (done, said) == (1, []), (done, said)
                expected = files(own)
            if RANK == 0:
                for name in os.listdir(folder):
                    os.remove(os.path.join(folder, name))
            total(0)  # all are here
            done, said = write(os.path.join(folder, "a.qfmb"), part(whole, owners), **properties)
            assert (done, said) == (1, []), (done, said)
            total(0)
            assert files(folder) == expected
            total(0)
    with shared_folder() as folder:
        in_all_ways(lambda whole, owners: check(folder, whole, owners))


def test_bodies_are_written_wherever_they_are():
    with Alone(), tempfile.TemporaryDirectory() as own:
        source = bsplinevolume.vtkWingFuselageSource()
        source.SetResolution(2)
        source.Update()
        body = source.GetOutputDataObject(1)
        assert write(os.path.join(own, "body.g2"), body, kind="vtkNURBSSurfaceWriter") == (1, [])
        expected = files(own)
    count = body.GetNumberOfPartitionedDataSets()
    with shared_folder() as folder:
        for data in (body, part(body, [RANKS - 1] * count), part(body, [b % RANKS for b in range(count)])):
            assert write(os.path.join(folder, "body.g2"), data, kind="vtkNURBSSurfaceWriter") == (1, [])
            total(0)
            assert files(folder) == expected
            total(0)


def test_error_of_one_rank_is_told_once():
    whole = volume()
    owners = distributions(12)[0]
    bad = 12 - 1
    if owners[bad] == RANK:
        broken = whole.GetPartition(bad, 0).NewInstance()
        broken.DeepCopy(whole.GetPartition(bad, 0))
        broken.GetFieldData().RemoveArray("KnotsV")
        whole.SetPartition(bad, 0, broken)
    mine = part(whole, owners)
    for kind in ("Sampler", "Quality", "Smoothness", "ToBezier"):
        algorithm, said = run("vtkBSplineVolume" + kind, mine)
        assert len(said) == (1 if RANK == 0 else 0), said
        assert all("zone 11" in text and "KnotsV" in text for text in said), said
        output = algorithm.GetOutputDataObject(0)
        assert output.GetNumberOfElements(output.POINT) == 0
    with shared_folder() as folder:
        # The second is a folder that is not there.
        for path, data in ((os.path.join(folder, "a.qfmb"), mine),
                           (os.path.join(folder, "no", "a.qfmb"), part(volume(), owners))):
            done, said = write(path, data)
            assert done == 0 and len(said) == (1 if RANK == 0 else 0)
            total(0)
            assert os.listdir(folder) == []


if __name__ == "__main__":
    main(globals())
