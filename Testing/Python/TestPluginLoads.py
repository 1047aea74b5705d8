# SPDX-License-Identifier: BSD-3-Clause
"""The plugin loads and the whole chain runs: in pvpython, and in pvbatch on any number of MPI ranks (run with --sym),
which share the blocks out.
"""
import glob
import os
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsv_support import (RANKS, simple, blocks, coordinates, demo_mesh, field, main, names, shared_folder, total,
                         update)


def test_number_of_ranks():
    assert RANKS == int(os.environ.get("BSV_EXPECTED_RANKS", "1"))


def test_chain():
    volume = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(4))
    net, _ = update(volume)
    volume.SMProxy.UpdatePropertyInformation()
    assert (volume.SMProxy.GetProperty("ReceivedBytes").GetElement(0) > 0) == (RANKS > 1)
    count = net.GetNumberOfPartitionedDataSets()
    assert count >= 11
    assert total(sum(block is not None for block in blocks(net))) == count
    assert all(block.GetFieldData().GetArray("Degree").GetValue(0) == 3 for block in blocks(net) if block)

    samples, _ = update(simple.BSplineVolumeSampler(Input=volume, Level=1))
    for block, grid in zip(blocks(net), blocks(samples)):
        assert (block is None) == (grid is None)
        assert not block or [2 * (n - 3) + 1 for n in size(block)] == size(grid)

    with shared_folder() as folder:
        path = os.path.join(folder, "demo.qfmb")
        writer = bsplinevolume.vtkQuadflowWriter()
        writer.SetInputDataObject(net)
        writer.SetFileName(path)
        assert writer.Write()
        # Every rank reads it all.
        reader = bsplinevolume.vtkQuadflowReader()
        reader.SetFileName(path)
        reader.Update()
        copy = reader.GetOutputDataObject(0)
        assert names(copy) == names(net)
        for block, read in zip(blocks(net), blocks(copy)):
            assert not block or bytes(memoryview(coordinates(block))) == bytes(memoryview(coordinates(read)))
        assert field(copy, "BoundaryNames") == field(net, "BoundaryNames")


def test_nothing_of_qt():
    """Servers and Python load the plugin without its part for ParaView's window, and no library of Qt."""
    libraries = glob.glob(os.path.join(os.path.dirname(os.environ["BSV_PLUGIN"]), "*.so"))
    assert len(libraries) >= 5
    for library in libraries:
        linked = subprocess.run(["ldd", library], capture_output=True, text=True, check=True).stdout
        assert "libc.so" in linked and "libQt" not in linked, library
    with open("/proc/self/maps") as maps:
        loaded = {line.split("/")[-1].strip() for line in maps}
    assert any(name.startswith("libBSplineVolumeDisplays") for name in loaded)
    assert not [name for name in loaded if name.startswith(("libQt", "BSplineVolumeQt"))]


def size(grid):
    extent = grid.GetExtent()
    return [extent[2 * d + 1] - extent[2 * d] + 1 for d in range(3)]


if __name__ == "__main__":
    main(globals())
