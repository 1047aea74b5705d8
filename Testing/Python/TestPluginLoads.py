# SPDX-License-Identifier: BSD-3-Clause
"""The plugin loads and the whole chain runs: in pvpython, and in pvbatch on any number of MPI ranks (run with --sym),
which share out the blocks.
"""
import os
import shutil
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsv_support import simple, blocks, coordinates, demo_mesh, dimensions, field, main, update
from bsv_ranks import RANK, SIZE, Alone, check, partitions, reduced, shared_folder


def test_chain():
    volume = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(4))
    net, _ = update(volume)
    assert net.GetNumberOfPartitionedDataSets() >= 11
    mine = partitions(net)
    check(all(block is None or block.GetFieldData().GetArray("Degree").GetValue(0) == 3 for block in mine), "degree")
    check(reduced(sum(block is not None for block in mine)) == len(mine), "every block is somewhere")
    check(SIZE == 1 or None in mine, "no rank has everything")

    samples, _ = update(simple.BSplineVolumeSampler(Input=volume, Level=1))
    check([block and [2 * (n - 3) + 1 for n in dimensions(block)] for block in mine] ==
          [grid and list(dimensions(grid)) for grid in partitions(samples)], "samples")

    folder = shared_folder()
    path = os.path.join(folder, "demo.qfmb")
    writer = bsplinevolume.vtkQuadflowWriter()
    writer.SetInputDataObject(net)
    writer.SetFileName(path)
    assert writer.Write()
    with Alone():
        reader = bsplinevolume.vtkQuadflowReader()
        reader.SetFileName(path)
        reader.Update()
    copy = reader.GetOutputDataObject(0)
    check(all(block is None or bytes(memoryview(coordinates(block))) == bytes(memoryview(coordinates(other)))
              for block, other in zip(mine, blocks(copy))), "file")
    check(field(copy, "BoundaryNames") == field(net, "BoundaryNames"), "names")
    if RANK == 0:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main(globals())
