# SPDX-License-Identifier: BSD-3-Clause
"""Blocks are shared out over the ranks: the wall fitted to the body, and its deviation, are those of one process alone.

    mpiexec -n 3 pvbatch --sym TestDistributedBody.py
"""
import os
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsv_support import Alone, vtk, blocks, coordinates, field, main, names, values
from TestBody import ellipsoid_patch, shell, write_g2

WALL_ARRAYS = ("Distance", "NormalDeviation", "PatchUV", "ProjectedPoint", "SurfaceNormal", "SecondFundamentalForm")
BODY_ARRAYS = ("Distance", "NormalDeviation", "Covered")
TOTALS = ("MaximumDistance", "RMSDistance", "MaximumNormalDeviation")


def controller():
    return vtk.vtkMultiProcessController.GetGlobalController()


def body():
    reader = bsplinevolume.vtkNURBSSurfaceReader()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "body.g2")
        write_g2(path, [ellipsoid_patch()])
        reader.SetFileName(path)
        reader.Update()
    return reader.GetOutputDataObject(0)


def volume():
    """Converted mesh around the ellipsoid, with boundaries that are on it."""
    convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    convert.SetInputDataObject(shell())
    convert.SetInputPoints(convert.CONTROL_NET)
    convert.Update()
    return convert.GetOutputDataObject(0)


def deviation(net, surface):
    measure = bsplinevolume.vtkBodyDeviation()
    measure.SetLevel(1)
    measure.SetInputDataObject(0, net)
    measure.SetInputDataObject(1, surface)
    measure.Update()
    return measure, measure.GetOutputDataObject(0)


def only(data, keep):
    """The collection with the partitions that this rank shall have."""
    part = data.NewInstance()
    part.CompositeShallowCopy(data)
    for b in range(data.GetNumberOfPartitionedDataSets()):
        if not keep(b):
            part.GetPartitionedDataSet(b).SetNumberOfPartitions(0)
    return part


def rows(data, arrays, block=None):
    """Points and arrays of all samples, or of those of a block."""
    columns = [values(coordinates(data))] + [values(data.GetPointData().GetArray(name)) for name in arrays]
    ids = values(data.GetPointData().GetArray("BlockId")) if block is not None else [None] * len(columns[0])
    return [row for row, b in zip(zip(*columns), ids) if b == block]


def test_any_distribution():
    rank, size = controller().GetLocalProcessId(), controller().GetNumberOfProcesses()
    assert size == int(os.environ["BSV_EXPECTED_RANKS"])
    with Alone():
        net, surface = volume(), body()
        _, expected = deviation(net, surface)
    wall, tessellation = blocks(expected)
    assert len(rows(tessellation, BODY_ARRAYS)) > 100 and field(expected, "MaximumDistance")[0] > 1e-4
    # One after the other; all on the last rank, the body elsewhere; the body everywhere.
    for owner, has_body in ((lambda b: b % size, lambda r: r == 0), (lambda b: size - 1, lambda r: r == size // 2),
                            (lambda b: (b // 2) % size, lambda r: True)):
        measure, found = deviation(only(net, lambda b: owner(b) == rank),
                                   surface if has_body(rank) else only(surface, lambda b: False))
        assert names(found) == ["Wall", "Body"]
        for name in TOTALS:
            assert field(found, name) == field(expected, name), name
        assert field(found, "HausdorffDistance") == field(expected, "HausdorffDistance")
        assert measure.GetHausdorffDistance() == field(expected, "HausdorffDistance")[0]
        mine, here = blocks(found)
        own = [b for b in range(6) if owner(b) == rank]
        assert (mine is not None) == bool(own)
        if mine:
            assert set(values(mine.GetPointData().GetArray("BlockId"))) == set(own)
            assert all(field(mine, name) == field(wall, name) for name in TOTALS)
            for b in own:
                assert rows(mine, WALL_ARRAYS, b) == rows(wall, WALL_ARRAYS, b)
        first = next(r for r in range(size) if has_body(r))
        assert (here is not None) == (rank == first)
        if here:
            assert rows(here, BODY_ARRAYS) == rows(tessellation, BODY_ARRAYS)
            assert all(field(here, name) == field(tessellation, name) for name in TOTALS)


def fitted(mesh, surface):
    convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    convert.SetInputPoints(convert.ON_BODY)
    convert.SetInputDataObject(0, mesh)
    convert.SetInputDataObject(1, surface)
    convert.Update()
    return convert, convert.GetOutputDataObject(0)


def test_fitted_wall():
    """The wall is moved to the body before the conversion; the points that move lie in blocks of all ranks."""
    rank, size = controller().GetLocalProcessId(), controller().GetNumberOfProcesses()
    mesh = shell(scale=1.01)
    with alone():
        surface = body()
        _, expected = fitted(mesh, surface)
    convert, found = fitted(only(mesh, lambda b: b % size == rank),
                            surface if rank == size - 1 else only(surface, lambda b: False))
    assert "taken as OnBody" in convert.GetReport() and "wall fitted in" in convert.GetReport()
    for b, (here, whole) in enumerate(zip(blocks(found), blocks(expected))):
        assert (here is not None) == (b % size == rank)
        if here:
            assert bytes(memoryview(coordinates(here))) == bytes(memoryview(coordinates(whole)))


def test_an_error_ends_on_all_ranks():
    """A body without patches, which all learn from each other: one message, on the first rank."""
    rank = controller().GetLocalProcessId()
    with alone():
        net, surface = volume(), body()
    measure = bsplinevolume.vtkBodyDeviation()
    measure.SetInputDataObject(0, net)
    measure.SetInputDataObject(1, only(surface, lambda b: False))
    errors = []
    measure.AddObserver("ErrorEvent", lambda *_: errors.append(1))
    measure.GetExecutive().AddObserver("ErrorEvent", lambda *_: None)
    measure.Update()
    assert len(errors) == (1 if rank == 0 else 0)
    assert measure.GetOutputDataObject(0).GetNumberOfPartitionedDataSets() == 0


if __name__ == "__main__":
    main(globals())
