# SPDX-License-Identifier: BSD-3-Clause
"""Files that MPI ranks write together are those that one process writes, byte for byte; those of HDF5 node for node.
Run with pvbatch --sym on any number of ranks."""
import os
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsv_support import (RANK, RANKS, Alone, simple, vtk, blocks, client, coordinates, field, main, names, shared_folder,
                         total)

assert RANKS == int(os.environ.get("BSV_EXPECTED_RANKS", "1"))


def mesh():
    """All blocks, made by each rank alone."""
    source = bsplinevolume.vtkWingFuselageSource()
    source.SetResolution(3)
    with Alone():
        source.Update()
    copy = source.GetOutputDataObject(0).NewInstance()
    copy.ShallowCopy(source.GetOutputDataObject(0))
    return copy


def share(data):
    """Every rank's own blocks of a mesh."""
    mine = data.NewInstance()
    mine.ShallowCopy(data)
    for b in range(mine.GetNumberOfPartitionedDataSets()):
        if b % RANKS != RANK:
            mine.GetPartitionedDataSet(b).SetNumberOfPartitions(0)
    return mine


def write(data, path, encoding, levels=1):
    writer = bsplinevolume.vtkHexBlockMeshWriter()
    writer.SetInputDataObject(data)
    writer.SetFileName(path)
    writer.SetEncoding(encoding)
    writer.SetLevels(levels)
    assert writer.Write() == 1 and writer.GetErrorCode() == 0


def files(path):
    found = {}
    for at, _, here in os.walk(path):
        for name in here:
            with open(os.path.join(at, name), "rb") as file:
                found[os.path.relpath(os.path.join(at, name), path)] = file.read()
    return found


def tree(path):
    """All that a file of HDF5 holds: attributes and data by the path of their node; None if there is no h5py."""
    try:
        import h5py
    except ImportError:
        print("h5py is missing: left out")
        return None
    found = {}

    def visit(name, node):
        found[name] = [(key, node.attrs[key].dtype.str, node.attrs[key].tobytes()) for key in sorted(node.attrs)]
        if isinstance(node, h5py.Dataset):
            found[name] += [node.shape, node.dtype.str, node[()].tobytes()]
    with h5py.File(path) as file:
        visit("/", file)
        # Links to other nodes are not followed.
        file.visititems(visit)
    return found


def same_tree(one, other):
    """Two files of HDF5 hold the same. Their bytes differ: the libraries store times, and leave gaps as memory was."""
    a, b = tree(one), tree(other)
    assert a is None or (len(a) > 8 and list(a) == list(b)), (one, sorted(a), sorted(b))
    for name in a or ():
        assert a[name] == b[name], (one, name)
    if one.endswith(".cgns") and shutil.which("cgnsdiff"):
        said = subprocess.run(["cgnsdiff", "-d", one, other], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert said.returncode == 0 and not said.stdout.strip(), said.stdout


def content(path):
    reader = bsplinevolume.vtkHexBlockMeshReader()
    reader.SetFileName(path)
    with Alone():
        reader.Update()
    data = reader.GetOutputDataObject(0)
    return (names(data), field(data, "Interfaces"), field(data, "Boundaries"), field(data, "BoundaryNames"),
            [bytes(memoryview(coordinates(block))) for block in blocks(data)])


def test_same_files():
    whole = mesh()
    mine = share(mesh())
    with shared_folder() as path:
        for kind, (name, encoding) in enumerate((("a.xyz", 1), ("a.x", 0), ("a.p3d", 2), ("a.foam", 0), ("a.foam", 1),
                                                 ("a.cgns", 1))):
            together, alone = (os.path.join(path, "%d%s" % (kind, how)) for how in ("together", "alone"))
            if RANK == 0:
                os.mkdir(together)
                os.mkdir(alone)
            total(0)
            write(mine, os.path.join(together, name), encoding)
            total(0)
            if RANK == 0:
                with Alone():
                    write(whole, os.path.join(alone, name), encoding)
                if name == "a.cgns":
                    assert content(os.path.join(together, name)) == content(os.path.join(alone, name))
                    same_tree(os.path.join(together, name), os.path.join(alone, name))
                else:
                    assert files(together) == files(alone), (kind, name)
            total(0)


def volume_and_samples(data):
    """Control points and refined samples of a mesh, as leaves."""
    conversion = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    conversion.SetInputDataObject(data)
    sampler = bsplinevolume.vtkBSplineVolumeSampler()
    sampler.SetInputConnection(conversion.GetOutputPort())
    sampler.SetLevel(0)
    sampler.SetFirstCellHeight(0.003)
    sampler.SetChordError(0.01)
    sampler.Update()
    return conversion.GetOutputDataObject(0), sampler.GetOutputDataObject(0), sampler.GetReport()


def test_refinement_and_volumes():
    """Levels chosen by targets, and text files of volumes, do not depend on who has which block."""
    all_blocks = mesh()
    mine, own, report = volume_and_samples(share(all_blocks))
    with Alone():
        whole, expected, alone = volume_and_samples(all_blocks)
    assert report == alone and "levels" in report
    for b, block in enumerate(blocks(expected)):
        if b % RANKS == RANK:
            assert bytes(memoryview(coordinates(own.GetPartition(b, 0)))) == bytes(memoryview(coordinates(block)))
    with shared_folder() as path:
        for extension in ("mesh", "xml", "g2", "msh", "cgns", "h5"):
            names_ = [os.path.join(path, how + "." + extension) for how in ("together", "alone")]
            for name, data in zip(names_, (mine, whole)):
                writer = bsplinevolume.vtkBSplineVolumeWriter()
                writer.SetInputDataObject(data)
                writer.SetFileName(name)
                if data is mine:
                    assert writer.Write() == 1
                    total(0)
                elif RANK == 0:
                    with Alone():
                        assert writer.Write() == 1
            if RANK == 0 and extension in ("cgns", "h5"):
                same_tree(*names_)
            elif RANK == 0:
                with open(names_[0], "rb") as one, open(names_[1], "rb") as other:
                    assert one.read() == other.read(), extension
            total(0)


def test_one_error():
    """A folder that is missing is the error of all, raised by the first rank."""
    writer = bsplinevolume.vtkHexBlockMeshWriter()
    errors = []

    def observe(_object, _event, text):
        errors.append(text)
    observe.CallDataType = "string0"
    writer.AddObserver("ErrorEvent", observe)
    writer.SetInputDataObject(share(mesh()))
    for name in ("missing/a.xyz", "missing/a.cgns"):
        writer.SetFileName(name)
        assert writer.Write() == 0 and writer.GetErrorCode() != 0
    assert len(errors) == (2 if RANK == 0 else 0)


if __name__ == "__main__":
    main(globals())
