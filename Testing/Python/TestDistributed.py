# SPDX-License-Identifier: BSD-3-Clause
"""Conversion, topology and wall spacing of a mesh whose blocks are shared out over MPI ranks: the same bits as on one
rank, and one end for all of them. Run with pvbatch --sym on any number of ranks.

Every rank computes what it expects from the whole mesh, alone.
"""
import os
import random
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsv_support import (RANK, RANKS, Alone, vtk, blocks, collection, coordinates, creased_mesh, field, grid, main,
                         names, total)
import make_demo_mesh

assert RANKS == int(os.environ.get("BSV_EXPECTED_RANKS", "1"))


def distributions(count):
    """Rank per block, in several ways."""
    dice = random.Random(RANKS)
    yield [b % RANKS for b in range(count)]
    yield [b * RANKS // count for b in range(count)]
    yield [RANKS - 1] * count
    yield [dice.randrange(max(1, RANKS - 1)) for _ in range(count)]  # the last rank has nothing


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
    assert names(found) == names(expected), what
    assert array_bits(found.GetFieldData()) == array_bits(expected.GetFieldData()), what
    assembly = [data.GetDataAssembly().SerializeToXML(vtk.vtkIndent()) for data in (found, expected)]
    assert assembly[0] == assembly[1], what
    here = blocks(found)
    assert all(block is None or grid_bits(block) == grid_bits(other)
               for block, other in zip(here, blocks(expected))), what
    assert total(sum(block is not None for block in here)) == len(here), what
    return here


def demo():
    """The demonstration mesh: cut blocks, creases, extraordinary edges, a planar far field."""
    reader = bsplinevolume.vtkHexBlockMeshReader()
    with Alone(), tempfile.TemporaryDirectory() as folder:
        reader.SetFileName(make_demo_mesh.write_demo(folder, 4))
        reader.Update()
    return reader.GetOutputDataObject(0)


def wing():
    """Mesh and body of the example case."""
    source = bsplinevolume.vtkWingFuselageSource()
    source.SetResolution(4)
    with Alone():
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
    assert serial.GetNumberOfBlocks() > 0
    for n, rank_of in enumerate(parts):
        convert = converted(part(whole, rank_of), bodies[1][n] if bodies else None, setup)
        here = compare_blocks(convert.GetOutputDataObject(0), serial.GetOutputDataObject(0), rank_of)
        assert all(block is None or rank_of[block.GetFieldData().GetArray("ParentBlock").GetValue(0)] == RANK
                   for block in here), rank_of
        for name in COUNTERS:
            assert getattr(convert, "GetNumberOf" + name)() == getattr(serial, "GetNumberOf" + name)(), name
        lines = [line for line in convert.GetReport().splitlines(True) if not line.startswith("rank ")]
        assert "".join(lines) == serial.GetReport(), convert.GetReport() + serial.GetReport()
        assert (convert.GetReceivedBytes() > 0) == (RANKS > 1)
        assert convert.GetReport().count("bytes from other ranks") == (RANKS if RANKS > 1 else 0)
    return serial


def test_demo():
    compare_conversion(demo(), distributions(11))


def test_options_that_name_faces():
    whole = demo()
    wall = field(whole, "BoundaryNames").index("WALL")
    faces = {tuple(map(int, entry[:2])) for entry in field(whole, "Boundaries") if entry[2] == wall}

    def setup(convert):
        convert.SetInputPoints(convert.ON_BODY)
        convert.SetWallSpacingMode(convert.AUTOMATIC_MODE)
        convert.SetPlanarSides(convert.ALL)
        convert.ClearBodyBoundaries()
        for block, face in sorted(faces):
            convert.AddBodyFace(block, face)
    compare_conversion(whole, list(distributions(11))[:2], setup=setup)


def row(count):
    """Blocks in a row, with plane faces between them."""
    grids = [grid((3, 2, 2), lambda i, j, k: (i + 0.03 * i * i, j + 0.1 * j * k, k), (3 * b, 0, 0))
             for b in range(count)]
    data = collection(grids)
    for b in range(count):
        data.GetMetaData(b).Set(vtk.vtkCompositeDataSet.NAME(), "part %d" % b)
    return data


def test_options_that_name_blocks():
    def setup(convert):
        convert.AddExtensionBlock("part 3")
    serial = compare_conversion(row(4), distributions(4), setup=setup)
    assert "far-field extension" in serial.GetReport()


def test_more_ranks_than_blocks():
    compare_conversion(row(2), distributions(2))


def test_repeated_knots():
    def setup(convert):
        convert.SetCreasesInsideBlocks(convert.REPEATED_KNOTS)
        convert.CheckJoinsOn()
    serial = compare_conversion(creased_mesh(), distributions(2), setup=setup)
    assert serial.GetNumberOfBlocks() == 2 and "stay whole" in serial.GetReport()


def test_wing_with_a_body_that_one_rank_has():
    mesh, body = wing()
    count = mesh.GetNumberOfPartitionedDataSets()
    nothing = vtk.vtkPartitionedDataSetCollection()
    spread = part(body, [n % RANKS for n in range(body.GetNumberOfPartitionedDataSets())])
    bodies = [spread, body if RANK == 0 else nothing]
    compare_conversion(mesh, list(distributions(count))[2:], (body, bodies))


def test_every_rank_may_have_everything():
    whole = demo()
    with Alone():
        serial = converted(whole)
    convert = converted(whole)
    assert all((block is not None) == (RANK == 0) for block in blocks(convert.GetOutputDataObject(0)))
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
        assert len(mine) == len(set(mine)) and set(mine) <= set(expected), rank_of
        assert total(len(mine)) == len(expected), rank_of
        assert found.GetReport() == serial.GetReport()
        assert array_bits(data.GetFieldData()) == array_bits(serial.GetOutputDataObject(0).GetFieldData())


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
        assert total(surface.GetNumberOfCells()) == wall.GetNumberOfCells()
        assert found.GetReport() == serial.GetReport()
        assert found.GetNumberOfWallPoints() == wall.GetNumberOfPoints()
        assert found.GetYPlusRange() == serial.GetYPlusRange()


def unstructured(mesh):
    """What Threshold makes of the blocks here: grids of hexahedra that know where their points were."""
    result = vtk.vtkPartitionedDataSetCollection()
    result.SetNumberOfPartitionedDataSets(mesh.GetNumberOfPartitionedDataSets())
    for b, block in enumerate(blocks(mesh)):
        if block is not None:
            append = vtk.vtkAppendFilter()
            append.AddInputData(block)
            append.Update()
            result.SetPartition(b, 0, append.GetOutput())
    result.GetFieldData().ShallowCopy(mesh.GetFieldData())
    return result


def test_blocks_that_became_unstructured_keep_their_names():
    def faces(convert):
        return sorted(line for line in convert.GetReport().split("\n") if line.endswith(" faces"))

    def made(convert):
        return [line for line in convert.GetReport().split("\n") if "Hex Mesh To Blocks" in line]

    whole = demo()
    with Alone():
        serial = converted(unstructured(whole))
    assert any(": body" in line for line in faces(serial)) and made(serial), serial.GetReport()
    for rank_of in distributions(11):
        found = converted(unstructured(part(whole, rank_of)))
        # The cells come in another order, and so may the blocks.
        assert faces(found) == faces(serial), (faces(found), faces(serial))
        assert made(found) == made(serial), found.GetReport()


def once(name, text):
    """Whether a message names a block, and only once."""
    return text.count("'%s'" % name) + text.count('"%s"' % name) == 1


def silence(algorithm):
    for event in ("ErrorEvent", "WarningEvent"):
        algorithm.AddObserver(event, lambda *_: None)


def failure(mesh, setup=lambda convert: None):
    """Text of all messages of a conversion that must fail, or stop, on all ranks."""
    window, before = vtk.vtkStringOutputWindow(), vtk.vtkOutputWindow.GetInstance()
    vtk.vtkOutputWindow.SetInstance(window)
    try:
        convert = converted(mesh, setup=setup)
    finally:
        vtk.vtkOutputWindow.SetInstance(before)
    data = convert.GetOutputDataObject(0)
    assert data.GetNumberOfPartitionedDataSets() == 0 and data.GetFieldData().GetNumberOfArrays() == 0
    text = window.GetOutput()
    assert RANK == 0 or text == "", text
    return text


def test_one_rank_fails():
    whole = demo()
    rank_of = [(b + 1) % RANKS for b in range(11)]
    broken = min(1, RANKS - 1)
    block = rank_of.index(broken)

    mesh = vtk.vtkPartitionedDataSetCollection()
    mesh.DeepCopy(part(whole, rank_of))
    if RANK == broken:
        mesh.GetPartition(block, 0).GetPoints().SetPoint(5, float("nan"), 0.0, 0.0)
    text = failure(mesh)
    assert RANK > 0 or (once(names(whole)[block], text) and "nan" in text), text

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
    assert RANK > 0 or (once(names(whole)[block], text) and "SurfaceNormal" in text), text

    # And nothing is left of it: the next one succeeds.
    with Alone():
        serial = converted(whole)
    compare_blocks(converted(part(whole, rank_of)).GetOutputDataObject(0), serial.GetOutputDataObject(0), "afterwards")


def test_ranks_with_different_properties():
    if RANKS > 1:
        text = failure(part(demo(), [b % RANKS for b in range(11)]), lambda convert: convert.SetCreaseAngle(30.0 + RANK))
        assert RANK > 0 or "rank 0 has 'CreaseAngle: 30', rank 1 has 'CreaseAngle: 31'" in text, text


def test_one_rank_aborts():
    whole = demo()
    rank_of = [b % RANKS for b in range(11)]
    for fraction in (0.0, 0.4, 0.7):
        def stop(convert, fraction=fraction):
            def progress(caller, _):
                if caller.GetProgress() >= fraction:
                    caller.SetAbortExecute(1)
            if RANK == min(1, RANKS - 1):
                convert.AddObserver("ProgressEvent", progress)
        assert failure(part(whole, rank_of), stop) == ""  # an abort is no error


if __name__ == "__main__":
    main(globals())
