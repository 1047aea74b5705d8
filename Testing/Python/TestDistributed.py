# SPDX-License-Identifier: BSD-3-Clause
"""Conversion, topology and wall spacing of a mesh whose blocks are shared out over MPI ranks: the same bits as on one
rank, and one end for all of them. Run with pvbatch --sym on any number of ranks.

Every rank computes what it expects from the whole mesh, alone.
"""
import os
import random
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsv_support import client, vtk, blocks, coordinates, demo_mesh, field, grid, main, names

CONTROLLER = vtk.vtkMultiProcessController.GetGlobalController()
RANK = CONTROLLER.GetLocalProcessId() if CONTROLLER else 0
SIZE = CONTROLLER.GetNumberOfProcesses() if CONTROLLER else 1
assert SIZE == int(os.environ.get("BSV_EXPECTED_RANKS", "1"))


class Alone:
    """Filters believe that there is only this process."""

    def __enter__(self):
        vtk.vtkMultiProcessController.SetGlobalController(vtk.vtkDummyController())

    def __exit__(self, *_):
        vtk.vtkMultiProcessController.SetGlobalController(CONTROLLER)


def reduced(number, operation=vtk.vtkCommunicator.SUM_OP):
    """A whole number of all ranks together."""
    if SIZE == 1:
        return number
    mine, result = vtk.vtkIntArray(), vtk.vtkIntArray()
    mine.InsertNextValue(number)
    CONTROLLER.AllReduce(mine, result, operation)
    return result.GetValue(0)


def check(right, *what):
    """Fails on all ranks if it does on one, which says what is wrong: no rank waits for another that has gone."""
    if not right:
        print("rank", RANK, *what, file=sys.stderr, flush=True)
    assert reduced(int(bool(right)), vtk.vtkCommunicator.MIN_OP), "see the message of a rank"


def distributions(count):
    """Rank per block, in several ways."""
    dice = random.Random(SIZE)
    yield [b % SIZE for b in range(count)]
    yield [b * SIZE // count for b in range(count)]
    yield [SIZE - 1] * count
    yield [dice.randrange(max(1, SIZE - 1)) for _ in range(count)]  # the last rank has nothing


def part(whole, rank_of):
    """What this rank has of a collection; one without any block has no field data either."""
    data = vtk.vtkPartitionedDataSetCollection()
    data.SetNumberOfPartitionedDataSets(whole.GetNumberOfPartitionedDataSets())
    for b, block in enumerate(blocks(whole)):
        if rank_of[b] == RANK:
            data.SetPartition(b, 0, block)
        data.GetMetaData(b).Set(vtk.vtkCompositeDataSet.NAME(), names(whole)[b])
    if RANK in rank_of:
        data.GetFieldData().ShallowCopy(whole.GetFieldData())
    return data


def partitions(data):
    """The grids that this rank has, None for the others."""
    return [data.GetPartition(b, 0) if data.GetNumberOfPartitions(b) > 0 else None
            for b in range(data.GetNumberOfPartitionedDataSets())]


def array_bits(data):
    """All arrays of a vtkFieldData, by name."""
    arrays = [data.GetAbstractArray(a) for a in range(data.GetNumberOfArrays())]
    return {array.GetName(): [array.GetValue(n) for n in range(array.GetNumberOfValues())]
            if array.IsA("vtkStringArray") else bytes(memoryview(array)) for array in arrays}


def grid_bits(block):
    return (block.GetExtent(), bytes(memoryview(coordinates(block))), array_bits(block.GetPointData()),
            array_bits(block.GetFieldData()))


def compare_blocks(found, expected, what):
    """Every block is on one rank, with the right bits; everything else is the same on all."""
    check(names(found) == names(expected), what, "names")
    check(array_bits(found.GetFieldData()) == array_bits(expected.GetFieldData()), what, "field data")
    check(found.GetDataAssembly().SerializeToXML(vtk.vtkIndent()) ==
          expected.GetDataAssembly().SerializeToXML(vtk.vtkIndent()), what, "assembly")
    here = partitions(found)
    check(all(block is None or grid_bits(block) == grid_bits(other) for block, other in zip(here, blocks(expected))),
          what, "blocks")
    check(reduced(sum(block is not None for block in here)) == len(here), what, "number of blocks")
    return here


def demo():
    return client(demo_mesh(4)).GetOutputDataObject(0)


def wing():
    """Mesh and body of the example case."""
    source = bsplinevolume.vtkWingFuselageSource()
    source.SetResolution(4)
    source.Update()
    return source.GetOutputDataObject(0), source.GetOutputDataObject(1)


def converted(mesh, body=None, setup=lambda convert: None):
    """The conversion, executed."""
    convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    convert.SetInputDataObject(0, mesh)
    if body is not None:
        convert.SetInputDataObject(1, body)
    setup(convert)
    convert.Update()
    return convert


COUNTERS = ("InputBlocks", "Blocks", "ExtraordinaryEdges", "SingularNodes", "ControlPoints")


def compare_conversion(whole, parts, bodies=None, setup=lambda convert: None):
    """Converts the whole alone and its parts together. `bodies`: for the whole, and per distribution."""
    with Alone():
        serial = converted(whole, bodies[0] if bodies else None, setup)
    for n, rank_of in enumerate(parts):
        convert = converted(part(whole, rank_of), bodies[1][n] if bodies else None, setup)
        here = compare_blocks(convert.GetOutputDataObject(0), serial.GetOutputDataObject(0), rank_of)
        check(all(block is None or rank_of[block.GetFieldData().GetArray("ParentBlock").GetValue(0)] == RANK
                  for block in here), rank_of, "pieces are where their blocks are")
        check(all(getattr(convert, "GetNumberOf" + name)() == getattr(serial, "GetNumberOf" + name)()
                  for name in COUNTERS), "counters")
        lines = [line for line in convert.GetReport().splitlines(True) if not line.startswith("rank ")]
        check("".join(lines) == serial.GetReport(), rank_of, "report", convert.GetReport(), serial.GetReport())
        used = len(set(rank_of))
        check((convert.GetReceivedBytes() > 0) == (SIZE > 1), "received bytes")
        check(convert.GetReport().count("bytes from other ranks") == (SIZE if SIZE > 1 else 0), used, "report")


def test_demo():
    """Cut blocks, creases, extraordinary edges, a planar far field."""
    whole = demo()
    compare_conversion(whole, distributions(11))

    def every_option(convert):
        convert.SetInputPoints(2)  # on the body
        convert.SetWallSpacingMode(1)
        convert.SetPlanarSides(1)
        convert.ClearBodyBoundaries()
        for b in range(11):
            for f in range(6):
                if (b, f) in wall:
                    convert.AddBodyFace(b, f)
    tuples = field(whole, "Boundaries")
    tag = field(whole, "BoundaryNames").index("WALL")
    wall = {(int(entry[0]), int(entry[1])) for entry in tuples if entry[2] == tag}
    compare_conversion(whole, list(distributions(11))[:2], setup=every_option)


def test_more_ranks_than_blocks():
    whole = vtk.vtkPartitionedDataSetCollection()
    whole.SetNumberOfPartitionedDataSets(2)
    for b in range(2):
        whole.SetPartition(b, 0, grid((3, 2, 2), lambda i, j, k: (i + 0.1 * j * k, j - 0.1 * i * k, k), (3 * b, 0, 0)))
        whole.GetMetaData(b).Set(vtk.vtkCompositeDataSet.NAME(), "half %d" % b)
    compare_conversion(whole, distributions(2))


def test_wing_with_a_body_that_one_rank_has():
    mesh, body = wing()
    count = mesh.GetNumberOfPartitionedDataSets()
    nothing = vtk.vtkPartitionedDataSetCollection()
    spread = part(body, [n % SIZE for n in range(body.GetNumberOfPartitionedDataSets())])
    bodies = [spread, body if RANK == 0 else nothing]
    compare_conversion(mesh, list(distributions(count))[:2], (body, bodies))


def test_every_rank_may_have_everything():
    whole = demo()
    with Alone():
        serial = converted(whole)
    convert = converted(whole)
    check(all((block is not None) == (RANK == 0) for block in partitions(convert.GetOutputDataObject(0))), "owner")
    compare_blocks(convert.GetOutputDataObject(0), serial.GetOutputDataObject(0), "everything everywhere")


def entities(data):
    """Per cell of the topology: kind, points and arrays."""
    found = []
    for p, poly in enumerate(blocks(data)):
        arrays = [poly.GetCellData().GetArray(a) for a in range(poly.GetCellData().GetNumberOfArrays())]
        for c in range(poly.GetNumberOfCells()):
            points = poly.GetCell(c).GetPoints()
            found.append((p, tuple(points.GetPoint(n) for n in range(points.GetNumberOfPoints())),
                          tuple(array.GetTuple(c) for array in arrays)))
    return found


def test_topology():
    whole = demo()

    def topology(data):
        filter_ = bsplinevolume.vtkHexBlockTopology()
        filter_.SetInputDataObject(data)
        filter_.Update()
        return filter_

    with Alone():
        serial = topology(whole)
    expected = entities(serial.GetOutputDataObject(0))
    for rank_of in distributions(11):
        found = topology(part(whole, rank_of))
        data = found.GetOutputDataObject(0)
        mine = entities(data)
        check(len(mine) == len(set(mine)) and set(mine) <= set(expected), rank_of, "cells")
        check(reduced(len(mine)) == len(expected), rank_of, "number of cells")
        check(found.GetReport() == serial.GetReport(), "report")
        check(array_bits(data.GetFieldData()) == array_bits(serial.GetOutputDataObject(0).GetFieldData()), "fields")


def test_wall_spacing():
    whole = demo()

    def spacing(data):
        filter_ = bsplinevolume.vtkWallSpacing()
        filter_.SetTargetYPlus(2000.0)
        filter_.SetInputDataObject(data)
        silence(filter_)  # warns that the target is not reached
        filter_.Update()
        return filter_

    with Alone():
        serial = spacing(whole)
    wall = serial.GetOutputDataObject(1)
    for rank_of in distributions(11):
        found = spacing(part(whole, rank_of))
        compare_blocks(found.GetOutputDataObject(0), serial.GetOutputDataObject(0), rank_of)
        surface = found.GetOutputDataObject(1)
        check(reduced(surface.GetNumberOfCells()) == wall.GetNumberOfCells(), "wall cells")
        check(found.GetReport() == serial.GetReport(), "report")
        check(found.GetNumberOfWallPoints() == wall.GetNumberOfPoints(), "wall points")
        check(found.GetYPlusRange() == serial.GetYPlusRange(), "y+")


def once(name, text):
    """Whether a message names a block, and only once."""
    return text.count("'%s'" % name) + text.count('"%s"' % name) == 1


def silence(algorithm):
    for event in ("ErrorEvent", "WarningEvent"):
        algorithm.AddObserver(event, lambda *_: None)


def failure(mesh, setup=lambda convert: None):
    """Text of all messages of a conversion that must fail, or stop, on all ranks; what the pipeline says is left out."""
    window, before = vtk.vtkStringOutputWindow(), vtk.vtkOutputWindow.GetInstance()
    vtk.vtkOutputWindow.SetInstance(window)
    try:
        convert = converted(mesh, setup=setup)
    finally:
        vtk.vtkOutputWindow.SetInstance(before)
    data = convert.GetOutputDataObject(0)
    check(data.GetNumberOfPartitionedDataSets() == 0 and data.GetFieldData().GetNumberOfArrays() == 0, "output")
    text = window.GetOutput()
    check(RANK == 0 or text == "", "a message of another rank than the first:", text)
    return text


def test_one_rank_fails():
    whole = demo()
    rank_of = [(b + 1) % SIZE for b in range(11)]
    broken = min(1, SIZE - 1)
    block = rank_of.index(broken)

    mesh = vtk.vtkPartitionedDataSetCollection()
    mesh.DeepCopy(part(whole, rank_of))
    if RANK == broken:
        mesh.GetPartition(block, 0).GetPoints().SetPoint(5, float("nan"), 0.0, 0.0)
    text = failure(mesh)
    check(RANK > 0 or (once(names(whole)[block], text) and "nan" in text), text)

    mesh = part(whole, rank_of)
    if RANK == broken:
        array = vtk.vtkDoubleArray()
        array.SetName("SurfaceNormal")
        array.SetNumberOfComponents(2)
        array.SetNumberOfTuples(mesh.GetPartition(block, 0).GetNumberOfPoints())
        copy = mesh.GetPartition(block, 0).NewInstance()
        copy.ShallowCopy(mesh.GetPartition(block, 0))
        copy.GetPointData().AddArray(array)
        mesh.SetPartition(block, 0, copy)
    text = failure(mesh)
    check(RANK > 0 or (once(names(whole)[block], text) and "SurfaceNormal" in text), text)

    # And nothing is left of it: the next one succeeds.
    with Alone():
        serial = converted(whole)
    compare_blocks(converted(part(whole, rank_of)).GetOutputDataObject(0), serial.GetOutputDataObject(0), "afterwards")


def test_one_rank_aborts():
    whole = demo()
    rank_of = [b % SIZE for b in range(11)]
    for fraction in (0.0, 0.4, 0.7):
        def stop(convert, fraction=fraction):
            def progress(caller, _):
                if caller.GetProgress() >= fraction:
                    caller.SetAbortExecute(1)
            if RANK == min(1, SIZE - 1):
                convert.AddObserver("ProgressEvent", progress)
        check(failure(part(whole, rank_of), stop) == "", "an abort is no error")


if __name__ == "__main__":
    main(globals())
