# SPDX-License-Identifier: BSD-3-Clause
"""Readers and the wing source on several MPI ranks, each of which reads the piece of its own number: together they have
what one process alone reads, and they end together. Run with pvbatch --sym on any number of ranks.
"""
import contextlib
import os
import shutil
import struct
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsv_support import RANK, RANKS, Alone, coordinates, main, names, shared_folder, total, values, vtk
import make_demo_mesh  # bsv_support knows where it is

assert RANKS == int(os.environ.get("BSV_EXPECTED_RANKS", "1"))
LAST = RANKS - 1


def reader(kind, path):
    result = getattr(bsplinevolume, "vtk" + kind + "Reader")()
    result.SetFileName(path)
    return result


def block_bits(data):
    """Bytes of every block, None where it is elsewhere."""
    return [bytes(memoryview(coordinates(data.GetPartition(b, 0)))) if data.GetNumberOfPartitions(b) else None
            for b in range(data.GetNumberOfPartitionedDataSets())]


def common(data):
    """What all ranks must have."""
    fields = data.GetFieldData()
    arrays = [fields.GetAbstractArray(a) for a in range(fields.GetNumberOfArrays())]
    return names(data), {array.GetName(): values(array) for array in arrays}


def compare(make):
    """The piece of this rank with the whole, which this rank reads alone."""
    source = make()
    source.UpdatePiece(RANK, RANKS, 0)
    data = source.GetOutputDataObject(0)
    whole = make()
    whole.Update()  # piece 0 of 1: no other rank is asked
    expected = whole.GetOutputDataObject(0)
    found = block_bits(data)
    assert common(data) == common(expected)
    assert all(mine in (None, other) for mine, other in zip(found, block_bits(expected)))
    assert total(sum(mine is not None for mine in found)) == len(found) > 1
    return source, whole


def refused(source):
    """The one message of a reader that must fail on all ranks: on the first of them."""
    window, before = vtk.vtkStringOutputWindow(), vtk.vtkOutputWindow.GetInstance()
    vtk.vtkOutputWindow.SetInstance(window)
    try:
        source.UpdatePiece(RANK, RANKS, 0)
    finally:
        vtk.vtkOutputWindow.SetInstance(before)
    data = source.GetOutputDataObject(0)
    assert data.GetNumberOfPartitionedDataSets() == 0 and data.GetFieldData().GetNumberOfArrays() == 0
    assert source.GetErrorCode() != 0
    text = window.GetOutput()
    assert RANK == 0 or text == "", text
    return text


@contextlib.contextmanager
def inside(folder):
    """File names are relative to it: the same for all ranks, who see different files."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def write(folder):
    """A mesh with a neutral map and its volume, by the first rank."""
    if RANK == 0:
        with Alone():
            mesh = reader("HexBlockMesh", make_demo_mesh.write_demo(folder, 4))
            convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
            convert.SetInputConnection(mesh.GetOutputPort())
            for binary in (0, 1):
                writer = bsplinevolume.vtkQuadflowWriter()
                writer.SetInputConnection(convert.GetOutputPort())
                writer.SetFileName(os.path.join(folder, "demo%d.qfmb" % binary))
                writer.SetBinary(binary)
                assert writer.Write()
    total(0)


def test_pieces():
    with shared_folder() as folder:
        write(folder)
        compare(lambda: reader("HexBlockMesh", os.path.join(folder, "demo.xyz")))
        for binary in (0, 1):
            compare(lambda path="demo%d.qfmb" % binary: reader("Quadflow", os.path.join(folder, path)))


def test_wing():
    def make():
        source = bsplinevolume.vtkWingFuselageSource()
        source.SetResolution(3)
        return source
    source, whole = compare(make)
    assert source.GetNumberOfMeshPoints() == whole.GetNumberOfMeshPoints()
    assert source.GetMinimumScaledJacobian() == whole.GetMinimumScaledJacobian()
    assert source.GetOutputDataObject(1).GetNumberOfPoints() == whole.GetOutputDataObject(1).GetNumberOfPoints() > 0


def test_body_is_read_again():
    with shared_folder() as folder:
        path = os.path.join(folder, "body.g2")
        if RANK == 0:
            with Alone():
                source = bsplinevolume.vtkWingFuselageSource()
                source.SetResolution(2)
                writer = bsplinevolume.vtkNURBSSurfaceWriter()
                writer.SetInputConnection(source.GetOutputPort(1))
                writer.SetFileName(path)
                assert writer.Write()
        total(0)
        source = reader("NURBSSurface", path)
        for _ in range(2):
            source.Modified()
            source.UpdatePiece(RANK, RANKS, 0)
            count = source.GetOutputDataObject(0).GetNumberOfPartitionedDataSets()
            assert total(count) == RANKS * count > 0


def test_one_rank_fails():
    with shared_folder() as folder:
        write(folder)
        path = os.path.join(folder, "demo.xyz")
        broken = os.path.join(folder, "broken.xyz")
        unmapped = os.path.join(folder, "unmapped", "demo.xyz")
        if RANK == 0:
            with open(path, "rb") as file:
                data = bytearray(file.read())
            data[-8:] = struct.pack("<d", float("nan"))  # a coordinate of the last block
            with open(broken, "wb") as file:
                file.write(data)
            os.mkdir(os.path.dirname(unmapped))
            shutil.copy(path, unmapped)
        total(0)
        text = refused(reader("HexBlockMesh", broken))
        assert RANK > 0 or text.count("'block 11'") == 1 and "nan" in text, text
        with inside("/" if RANK == LAST else folder):
            text = refused(reader("HexBlockMesh", "demo.xyz"))
        assert RANK > 0 or text.count("no such file") == 1, text
        text = refused(reader("NURBSSurface", os.path.join(folder, "missing")))
        assert RANK > 0 or text.count("missing") == 1, text
        if RANKS > 1:
            # The others see a neutral map beside the mesh.
            with inside(os.path.dirname(unmapped) if RANK == LAST else folder):
                text = refused(reader("HexBlockMesh", "demo.xyz"))
            assert RANK > 0 or text.count("demo.nmf: no such file") == 1, text
        compare(lambda: reader("HexBlockMesh", path))


def test_one_rank_reads_for_itself():
    with shared_folder() as folder:
        write(folder)
        if RANK == LAST:
            for kind, name in (("HexBlockMesh", "demo.xyz"), ("Quadflow", "demo0.qfmb")):
                source = reader(kind, os.path.join(folder, name))
                source.Update()
                assert None not in block_bits(source.GetOutputDataObject(0))


if __name__ == "__main__":
    main(globals())
