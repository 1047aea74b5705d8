# SPDX-License-Identifier: BSD-3-Clause
"""The plugin loads and the whole chain runs: in pvpython, and in pvbatch on any number of MPI ranks (run with --sym).

Every rank does the whole job; all must get the same bits.
"""
import hashlib
import os
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsv_support import simple, vtk, bits, blocks, coordinates, demo_mesh, field, main, update


def ranks():
    """This process and the number of processes."""
    controller = vtk.vtkMultiProcessController.GetGlobalController()
    return (controller.GetLocalProcessId(), controller.GetNumberOfProcesses()) if controller else (0, 1)


def same_on_all_ranks(value):
    """Whether the bytes are the same on all processes."""
    controller = vtk.vtkMultiProcessController.GetGlobalController()
    if ranks()[1] == 1:
        return True
    mine, lowest, highest = (vtk.vtkUnsignedCharArray() for _ in range(3))
    for byte in hashlib.sha256(value).digest():
        mine.InsertNextValue(byte)
    controller.AllReduce(mine, lowest, vtk.vtkCommunicator.MIN_OP)
    controller.AllReduce(mine, highest, vtk.vtkCommunicator.MAX_OP)
    return bytes(memoryview(lowest)) == bytes(memoryview(highest)) == hashlib.sha256(value).digest()


def test_number_of_ranks():
    assert ranks()[1] == int(os.environ.get("BSV_EXPECTED_RANKS", "1"))


def test_chain():
    volume = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(4))
    net, _ = update(volume)
    assert net.GetNumberOfPartitionedDataSets() >= 11
    assert all(block.GetFieldData().GetArray("Degree").GetValue(0) == 3 for block in blocks(net))
    assert same_on_all_ranks(bits(net))

    samples, _ = update(simple.BSplineVolumeSampler(Input=volume, Level=1))
    for block, grid in zip(blocks(net), blocks(samples)):
        assert [2 * (n - 3) + 1 for n in size(block)] == size(grid)

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "demo.qfmb")
        writer = bsplinevolume.vtkQuadflowWriter()
        writer.SetInputDataObject(net)
        writer.SetFileName(path)
        assert writer.Write()
        if ranks()[0] > 0:
            return  # rank 0 writes the file
        reader = bsplinevolume.vtkQuadflowReader()
        reader.SetFileName(path)
        reader.Update()
        copy = reader.GetOutputDataObject(0)
        assert [bytes(memoryview(coordinates(block))) for block in blocks(copy)] == \
            [bytes(memoryview(coordinates(block))) for block in blocks(net)]
        assert field(copy, "BoundaryNames") == field(net, "BoundaryNames")


def size(grid):
    extent = grid.GetExtent()
    return [extent[2 * d + 1] - extent[2 * d] + 1 for d in range(3)]


if __name__ == "__main__":
    main(globals())
