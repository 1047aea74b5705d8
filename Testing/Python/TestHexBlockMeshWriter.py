# SPDX-License-Identifier: BSD-3-Clause
"""vtkHexBlockMeshWriter through ParaView: round trips through our readers, OpenFOAM through ParaView's reader, nested
levels, errors."""
import contextlib
import math
import os
import resource
import signal
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (simple, vtk, blocks, cgrid, client, collection, coordinates, demo_mesh, dimensions, field,
                         folded_ring, grid, half_turn_ring, main, messages, name_boundaries, names, producer, update,
                         values)
from paraview import servermanager
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter

DEMO = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(8), UseCreaseAngle=1)


def ogrid():
    """One block around the z axis that meets itself, with a wall inside; no arrays."""
    n = (24, 4, 3)

    def place(i, j, k):
        angle = 2 * math.pi * (i % n[0]) / n[0]
        radius = 1 + 0.5 * j
        return radius * math.cos(angle), radius * math.sin(angle), 0.4 * k
    return producer(collection([grid(n, place)]))


def odd_names(data):
    """The same mesh with names that no format allows, and the type of a boundary by its array."""
    copy = data.NewInstance()
    copy.ShallowCopy(data)
    for b in range(copy.GetNumberOfPartitionedDataSets()):
        copy.GetMetaData(b).Set(vtk.vtkCompositeDataSet.NAME(), "zone / %d of a long name, longer than 32" % (99 - b))
    fields = vtk.vtkFieldData()
    fields.ShallowCopy(data.GetFieldData())
    old = fields.GetAbstractArray("BoundaryNames")
    new = vtk.vtkStringArray()
    new.SetName("BoundaryNames")
    for n in range(old.GetNumberOfValues()):
        new.InsertNextValue("boundary %d" % n)
    fields.AddArray(new)
    copy.SetFieldData(fields)
    return producer(copy)


CASES = {
    "demo": simple.BSplineVolumeSampler(Input=DEMO, Level=1),
    "wing": simple.WingFuselageSource(Resolution=3),
    "ogrid": ogrid(),
    "names": odd_names(update(simple.BSplineVolumeSampler(Input=DEMO, Level=0))[0]),
    "c-grid": producer(cgrid()),
    "two blocks": producer(cgrid(10)),
    "half turn": producer(half_turn_ring()),
    "folded": producer(folded_ring()),
}
# Contacts that the writers find by themselves, and whether boundaries are left without a name.
FOUND = {
    "ogrid": ([(0, 0, 0, 1, 0) + 7 * (0,)], True),
    "c-grid": ([(0, 2, 0, 2, 2, 1, 0, 4, 0, 2, 16, 0)], False),
    "two blocks": ([(0, 1, 1, 0, 0) + 7 * (0,), (0, 2, 1, 2, 2, 1, 0, 4, 0, 2, 6, 0)], False),
    "half turn": ([(0, 0, 0, 1, 6) + 7 * (0,)], True),
    "folded": ([(0, 0, 0, 1, 0) + 7 * (0,), (0, 2, 0, 2, 2, 1, 0, 6, 0, 2, 6, 0)], True),
}


def writer(source, path, **properties):
    return simple.servermanager.writers.HexBlockMeshWriter(Input=source, FileName=path, **properties)


def write(source, path, **properties):
    """Writes without an error. Returns the warnings."""
    proxy = writer(source, path, **properties)
    source.UpdatePipeline()
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert not caught["errors"], caught["errors"]
    return caught["warnings"]


def write_error(source, path, **properties):
    proxy = writer(source, path, **properties)
    source.UpdatePipeline()
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert len(caught["errors"]) == 1 and client(proxy).GetErrorCode() != 0, caught
    return caught["errors"][0]


def sides(row):
    """A contact as the set of its two sides."""
    a, b = tuple(int(n) for n in row[:2]), tuple(int(n) for n in row[2:4])
    return frozenset((a, b)), int(row[4]) if a < b else None


def content(data):
    """What must come back: points with their type, contacts, boundaries by name."""
    arrays = data.GetFieldData()
    labels = field(data, "BoundaryNames") if arrays.GetAbstractArray("BoundaryNames") else []
    patches = field(data, "Boundaries") if labels else []
    contacts = field(data, "Interfaces") if arrays.GetAbstractArray("Interfaces") else []
    return {
        "points": [(dimensions(block), coordinates(block).GetDataTypeAsString(), bytes(memoryview(coordinates(block))))
                   for block in blocks(data)],
        "contacts": sorted(sorted(sides(row)[0]) for row in contacts),
        "boundaries": sorted((labels[int(row[2])], int(row[0]), int(row[1])) + tuple(row[3:]) for row in patches),
    }


@contextlib.contextmanager
def folder():
    with tempfile.TemporaryDirectory() as path:
        yield path


def test_round_trips():
    kinds = [("a.cgns", {}), ("b.xyz", {}), ("c.x", {"Encoding": "ASCII"}),
             ("d.p3d", {"Encoding": "Fortran Unformatted", "ByteOrder": "Big Endian"}),
             ("e.xyz", {"IBlank": "With"})]
    for name, source in CASES.items():
        before, _ = update(source)
        expected = content(before)
        rows, unnamed = FOUND.get(name, (None, False))
        if rows:
            del expected["contacts"]
        with folder() as path:
            for file, properties in kinds:
                said = write(source, os.path.join(path, file), **properties)
                assert bool(said) == unnamed, (name, file, said)
                after, _ = update(simple.HexBlockMeshReader(FileName=os.path.join(path, file)))
                found = content(after)
                for part in expected:
                    assert found[part] == expected[part], (name, file, part)
                assert not rows or sorted(field(after, "Interfaces")) == rows, (name, file, field(after, "Interfaces"))
                if file.endswith("cgns"):
                    assert names(after) == [n or "block %d" % b for b, n in enumerate(names(before))], names(after)
                if properties.get("IBlank"):
                    assert set(values(blocks(after)[0].GetPointData().GetArray("IBlank"))) == {1}


def test_iblank_and_single_precision():
    """iblank of the input and float points come back as they are, in binary files."""
    block = grid((3, 2, 2), lambda i, j, k: (0.1 * i, 0.3 * j, 0.7 * k))
    points = vtk.vtkPoints()
    points.DeepCopy(block.GetPoints())
    single = vtk.vtkFloatArray()
    single.DeepCopy(block.GetPoints().GetData())
    points.SetData(single)
    block.SetPoints(points)
    blank = vtk.vtkIntArray()
    blank.SetName("IBlank")
    for n in range(block.GetNumberOfPoints()):
        blank.InsertNextValue(n % 3)
    block.GetPointData().AddArray(blank)
    source = producer(collection([block]))
    with folder() as path:
        for file in ("a.xyz", "a.cgns"):
            write(source, os.path.join(path, file))
            back = blocks(update(simple.HexBlockMeshReader(FileName=os.path.join(path, file)))[0])[0]
            assert coordinates(back).GetDataTypeAsString() == "float"
            assert bytes(memoryview(coordinates(back))) == bytes(memoryview(single))
            if file == "a.xyz":
                assert values(back.GetPointData().GetArray("IBlank")) == [n % 3 for n in range(36)]


def cells_of(data):
    """Cells, and leaves by name, of what ParaView's reader made of a case."""
    found = {}

    def visit(node, name):
        if node is None:
            return
        if node.IsA("vtkMultiBlockDataSet"):
            for n in range(node.GetNumberOfBlocks()):
                label = node.GetMetaData(n).Get(vtk.vtkCompositeDataSet.NAME()) if node.HasMetaData(n) else ""
                visit(node.GetBlock(n), label or name)
        else:
            found[name] = node
    visit(data, "")
    return found


def test_openfoam_folders():
    """A folder holds one case; what lies beside the mesh and is not replaced is said."""
    mesh = producer(collection([grid((2, 2, 2), lambda i, j, k: (i, j, float(k)))]))
    with folder() as path:
        first = os.path.join(path, "first.foam")
        write(mesh, first)
        points = os.path.join(path, "constant", "polyMesh", "points")
        before = open(points, "rb").read()
        larger = producer(collection([grid((3, 2, 2), lambda i, j, k: (i, j, float(k)))]))
        error = write_error(larger, os.path.join(path, "second.foam"))
        assert "'first.foam'" in error and "folder of its own" in error, error
        assert open(points, "rb").read() == before and not os.path.exists(os.path.join(path, "second.foam"))
        with open(os.path.join(os.path.dirname(points), "cellZones"), "w"):
            pass
        said = write(larger, first)
        assert any("still holds 'cellZones'" in text for text in said), said
        assert open(points, "rb").read() != before


def test_openfoam():
    """A box of 8 blocks is the mesh of one block: every point and face once, every patch with its faces."""
    n = 4
    pieces = []
    for c in range(8):
        at = [n // 2 * (c >> d & 1) for d in range(3)]
        if c == 3:  # left-handed
            pieces.append(grid((2, 2, 2), lambda i, j, k, at=at: (at[0] + 2.0 - i, at[1] + j, at[2] + k)))
        else:
            pieces.append(grid((2, 2, 2), lambda i, j, k, at=at: (at[0] + i, at[1] + j, at[2] + float(k))))
    data = collection(pieces)
    tags = vtk.vtkIntArray()
    tags.SetName("Boundaries")
    tags.SetNumberOfComponents(3)
    labels = vtk.vtkStringArray()
    labels.SetName("BoundaryNames")
    for tag, name in enumerate(("wall low", "far")):
        labels.InsertNextValue(name)
    for c in range(8):
        if c >> 2 == 0:
            tags.InsertNextTuple3(c, 4, 0)
        else:
            tags.InsertNextTuple3(c, 5, 1)
    data.GetFieldData().AddArray(tags)
    data.GetFieldData().AddArray(labels)
    source = producer(data)
    with folder() as path:
        for encoding in ("ASCII", "Binary"):
            file = os.path.join(path, encoding, "box.foam")
            os.makedirs(os.path.dirname(file))
            said = write(source, file, Encoding=encoding)
            assert "'wall low' is patch 'wall_low'" in said[-1], said
            assert any("64 quadrilaterals are in no interface" in text for text in said), said
            reader = simple.OpenFOAMReader(FileName=file)
            reader.UpdatePipelineInformation()
            reader.MeshRegions = list(reader.GetPropertyValue("MeshRegions").Available)
            found = cells_of(update(reader)[0])
            mesh = found.pop("internalMesh")
            assert mesh.GetNumberOfCells() == n ** 3 and mesh.GetNumberOfPoints() == (n + 1) ** 3
            assert {name: leaf.GetNumberOfCells() for name, leaf in found.items()} == {
                "wall_low": n * n, "far": n * n, "defaultFaces": 4 * n * n}
            sizes = vtkCellSizeFilter()
            sizes.SetInputData(mesh)
            sizes.Update()
            volumes = values(sizes.GetOutput().GetCellData().GetArray("Volume"))
            assert all(abs(volume - 1) < 1e-12 for volume in volumes)
            with open(os.path.join(path, encoding, "constant", "polyMesh", "boundary")) as text:
                assert text.read().count("wall;") == 1


def test_openfoam_of_meshes_that_meet_themselves():
    """Cells, points that are left, and boundary quadrilaterals: what is glued is neither there twice nor a boundary."""
    expected = {"c-grid": (120, 252 - 15, {"wall": 24, "farfield": 40 + 12, "sides": 120}),
                "two blocks": (120, 252 - 15, {"wall": 24, "farfield": 40 + 12, "sides": 120}),
                "half turn": (48, 117 - 9, {"defaultFaces": 96}),
                # Of 13 points along the fold 7 are left.
                "folded": (72, 156 - 12 - 15, {"defaultFaces": 24 + 72})}
    for name, (cells, points, sides_) in expected.items():
        with folder() as path:
            file = os.path.join(path, "a.foam")
            write(CASES[name], file)
            reader = simple.OpenFOAMReader(FileName=file)
            reader.UpdatePipelineInformation()
            reader.MeshRegions = list(reader.GetPropertyValue("MeshRegions").Available)
            found = cells_of(update(reader)[0])
            mesh = found.pop("internalMesh")
            assert (mesh.GetNumberOfCells(), mesh.GetNumberOfPoints()) == (cells, points), (name, mesh)
            assert {label: leaf.GetNumberOfCells() for label, leaf in found.items()} == sides_, name


def test_levels():
    """Levels of a family are the sampler's own levels, bit for bit."""
    finest = simple.BSplineVolumeSampler(Input=DEMO, Level=2)
    with folder() as path:
        simple.SaveData(os.path.join(path, "demo.cgns"), proxy=finest, Levels=3, ReynoldsNumber=1e6)
        assert sorted(os.listdir(path)) == ["demo_level%d.cgns" % level for level in range(3)] + ["demo_levels.csv"]
        with open(os.path.join(path, "demo_levels.csv")) as file:
            table = [line.strip().split(",") for line in file]
        heights = []
        for level in range(3):
            expected = update(simple.BSplineVolumeSampler(Input=DEMO, Level=level))[0]
            file = os.path.join(path, "demo_level%d.cgns" % level)
            assert content(update(simple.HexBlockMeshReader(FileName=file))[0]) == content(expected)
            row = dict(zip(table[0], table[1 + level]))
            assert int(row["cells"]) == expected.GetNumberOfElements(1)
            heights.append(float(row["first_cell_mean"]))
            assert abs(float(row["yplus_mean"]) / float(row["first_cell_mean"]) -
                       1e6 * math.sqrt(0.0592 / 1e6 ** 0.2 / 2)) < 1e-3 * 4e4
        assert heights[0] > heights[1] > heights[2] > 0


def test_writers_are_offered():
    """Block meshes get our CGNS writer, other data ParaView's."""
    factory = servermanager.vtkSMProxyManager.GetProxyManager().GetWriterFactory()

    def name(source, file):
        source.UpdatePipeline()
        proxy = factory.CreateWriter(file, source.SMProxy, 0)
        found = proxy.GetXMLName()
        proxy.UnRegister(None)
        return found
    for extension in ("xyz", "x", "p3d", "foam"):
        assert name(CASES["demo"], "a." + extension) == "HexBlockMeshWriter"
    assert name(CASES["demo"], "a.cgns") == "BlockMeshCGNSWriter"
    assert name(simple.Wavelet(), "a.cgns") != "BlockMeshCGNSWriter"
    # One block has no interfaces, but boundaries, or control points, which are no points of a mesh.
    alone = grid((2, 2, 2), lambda *p: p)
    assert name(producer(collection([alone])), "a.cgns") != "BlockMeshCGNSWriter"
    walls = collection([alone])
    name_boundaries(walls, [(0, 4, 0)], ["wall"])
    volume = simple.CatmullClarkToBSplineVolume(Input=producer(collection([alone])))
    for source in (producer(walls), volume, simple.BSplineVolumeSampler(Input=volume)):
        assert name(source, "a.cgns") == "BlockMeshCGNSWriter"


def test_what_cannot_be_written():
    with folder() as path:
        def file(name):
            return os.path.join(path, name)
        with open(file("a.cgns"), "w") as old:
            old.write("old")
        mesh = CASES["demo"]
        assert "extension must be" in write_error(mesh, file("a.stl"))
        assert "File Name is empty" in write_error(mesh, "")
        assert "sample it first" in write_error(DEMO, file("a.xyz"))
        assert "no Fortran unformatted" in write_error(mesh, file("a.foam"), Encoding="Fortran Unformatted")
        assert "has no hexahedra" in write_error(producer(collection([])), file("a.xyz"))
        odd = producer(collection([grid((3, 4, 4), lambda i, j, k: (i, j, float(k)))]))
        assert "has 3 cells along i, which 2 does not divide" in write_error(odd, file("a.xyz"), Levels=2)
        assert "No such file" in write_error(mesh, file("no/a.xyz"))

        # A limit on the size of files stands for a full disk.
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, limits[1]))
        try:
            for name in ("a.cgns", "a.xyz", "a.foam"):
                assert "Cannot write" in write_error(mesh, file(name))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
            signal.signal(signal.SIGXFSZ, handler)

        for name in ("a.cgns", "a.xyz", "a.foam"):
            proxy = writer(mesh, file(name))
            client(proxy).AddObserver("ProgressEvent", lambda caller, _: caller.SetAbortExecute(1))
            with messages(proxy) as caught:
                proxy.UpdatePipeline()
            assert not caught["errors"] and client(proxy).GetErrorCode() != 0
        with open(file("a.cgns")) as old:
            assert old.read() == "old"
        left = [os.path.join(at, name) for at, _, found in os.walk(path) for name in found]
        assert left == [file("a.cgns")], left


if __name__ == "__main__":
    main(globals())
