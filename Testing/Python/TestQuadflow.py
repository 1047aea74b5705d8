# SPDX-License-Identifier: BSD-3-Clause
"""vtkQuadflowWriter and vtkQuadflowReader through ParaView: SaveData, OpenDataFile, round trip, options, errors."""
import contextlib
import itertools
import os
import resource
import signal
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (simple, vtk, blocks, cgrid, client, coordinates, creased_mesh, demo_mesh, failure, field, main, names,
                         producer, update, values)
from paraview import servermanager

DEMO = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(8), UseCreaseAngle=1)
KNOTS = simple.CatmullClarkToBSplineVolume(Input=producer(creased_mesh()), CreasesInsideBlocks="RepeatedKnots")
# One block that meets itself along the wake, and becomes three.
WAKE = simple.CatmullClarkToBSplineVolume(Input=producer(cgrid()))


def writer(path, source=DEMO, **properties):
    return simple.servermanager.writers.QuadflowWriter(Input=source, FileName=path, **properties)


def reader(path):
    return simple.QuadflowReader(FileName=path)


def content(data):
    """All that must come back: names, points, knots, contacts and boundaries."""
    result = {"names": names(data)}
    for name in ("Interfaces", "Boundaries", "BoundaryNames"):
        if data.GetFieldData().GetAbstractArray(name):
            result[name] = field(data, name)
    for n, block in enumerate(blocks(data)):
        result["points", n] = bytes(memoryview(coordinates(block)))
        for name in ("Degree", "KnotsU", "KnotsV", "KnotsW"):
            result[name, n] = field(block, name)
    return result


def lines(path):
    with open(path) as file:
        return file.read().splitlines()


@contextlib.contextmanager
def folder():
    with tempfile.TemporaryDirectory() as path:
        yield path


def write_errors(path, source=DEMO, code=None, **properties):
    """Errors of a write that must fail, with this error code of VTK."""
    proxy = writer(path, source, **properties)
    caught = []

    def observe(_object, _event, text):
        caught.append(text)
    observe.CallDataType = "string0"
    client(proxy).AddObserver("ErrorEvent", observe)
    source.UpdatePipeline()
    client(proxy).SetInputDataObject(client(source).GetOutputDataObject(0))
    assert client(proxy).Write() == 0
    assert client(proxy).GetErrorCode() != 0
    assert code is None or client(proxy).GetErrorCode() == getattr(vtk.vtkErrorCode, code)
    return caught


def test_save_data_and_open():
    for source, count in ((DEMO, 16), (KNOTS, 2), (WAKE, 3)):
        before, _ = update(source)
        with folder() as path:
            file = os.path.join(path, "demo.qfmb")
            simple.SaveData(file, proxy=source)
            assert os.listdir(path) == ["demo.qfmb"]
            opened = simple.OpenDataFile(file)
            assert opened.SMProxy.GetXMLName() == "QuadflowReader"
            data, warnings = update(opened)
            assert not warnings
            assert len(blocks(data)) == count and content(data) == content(before)
            for block in blocks(data):
                assert coordinates(block).GetDataTypeAsString() == "double"


def test_the_writer_is_offered():
    DEMO.UpdatePipeline()
    manager = servermanager.vtkSMProxyManager.GetProxyManager().GetWriterFactory()
    text = manager.GetSupportedFileTypes(DEMO.SMProxy, 0)
    assert "Quadflow Topology" in text and "qfmb" in text, text


def test_options():
    before, _ = update(DEMO)
    with folder() as path:
        file = os.path.join(path, "a.qfmb")
        for base in (0, 1):
            for scaling in ("Integer", "Unit"):
                for separate in (0, 1):
                    simple.SaveData(file, proxy=DEMO, IndexBase=base, KnotScaling=scaling, SeparateGeometry=separate)
                    text = lines(file)
                    assert "index_base %d" % base in text and "knots " + scaling.lower() in text
                    assert ("GEOMETRY file a.bsp" in text) == bool(separate)
                    assert content(update(reader(file))[0]) == content(before)
                    if separate:
                        os.remove(os.path.join(path, "a.bsp"))
                        assert "Cannot open" in failure(reader(file))
        simple.SaveData(file, proxy=DEMO)
        size = os.path.getsize(file)
        simple.SaveData(file, proxy=DEMO, Binary=1)
        with open(file, "rb") as saved:
            assert b"\nGEOMETRY binary %s_endian\n" % sys.byteorder.encode() in saved.read()
        assert os.path.getsize(file) < size
        assert content(update(reader(file))[0]) == content(before)
        names_of_boundaries = field(before, "BoundaryNames")
        simple.SaveData(file, proxy=DEMO, BoundaryIds=[names_of_boundaries[1], "42"])
        text = lines(file)
        table = [line.split() for line in text[text.index("BCTABLE # bc name") + 1:text.index("GEOMETRY")]]
        assert table[1] == ["42", names_of_boundaries[1]] and table[0] == ["1", names_of_boundaries[0]]
        assert content(update(reader(file))[0]) == content(before)


def test_read_and_written_again_is_the_same_file():
    with folder() as path:
        for number, options in enumerate(itertools.product((0, 1), ("Integer", "Unit"), (0, 1), (0, 1))):
            base, scaling, separate, binary = options
            chosen = {"IndexBase": base, "KnotScaling": scaling, "SeparateGeometry": separate, "Binary": binary,
                      "BoundaryIds": ["symmetry", "42"] if number % 2 else []}
            saved = []
            source = DEMO
            for name in ("first", "second"):
                os.makedirs(os.path.join(path, name), exist_ok=True)
                file = os.path.join(path, name, "a.qfmb")
                simple.SaveData(file, proxy=source, **chosen)
                source = reader(file)
                files = [file] + ([file[:-4] + "bsp"] if separate else [])
                saved.append([open(f, "rb").read() for f in files])
            assert saved[0] == saved[1], chosen


def test_files_of_other_versions_keep_their_first_line():
    with folder() as path:
        first, second = os.path.join(path, "a.qfmb"), os.path.join(path, "b.qfmb")
        simple.SaveData(first, proxy=DEMO)
        with open(first, "rb") as file:
            lines = file.read().split(b"\n", 1)
        for line in (b"# Multi-block B-spline topology, dialect of BSplineVolume; see quadflow_format.md.", b"#of another"):
            with open(first, "wb") as file:
                file.write(line + b"\n" + lines[1])
            simple.SaveData(second, proxy=reader(first))
            with open(second, "rb") as file:
                assert file.read() == line + b"\n" + lines[1]


def test_edge_classes():
    with folder() as path:
        file = os.path.join(path, "a.qfmb")
        simple.SaveData(file, proxy=DEMO)
        text = lines(file)
        start, end = (next(n for n, line in enumerate(text) if line.startswith(word)) for word in ("EDGES", "FACES"))
        classes = {line.split()[4] for line in text[start + 1:end]}
        assert {"boundary", "crease", "planar"} <= classes
        assert any(name.startswith("extraordinary:") for name in classes), classes


def test_contacts_are_found_without_the_array():
    before, _ = update(DEMO)
    bare = before.NewInstance()
    bare.ShallowCopy(before)
    fields = vtk.vtkFieldData()
    fields.ShallowCopy(before.GetFieldData())
    fields.RemoveArray("Interfaces")
    bare.SetFieldData(fields)
    with folder() as path:
        file = os.path.join(path, "a.qfmb")
        simple.SaveData(file, proxy=producer(bare))

        def pairs(data):
            return {frozenset((tuple(row[:2]), tuple(row[2:4]))) for row in field(data, "Interfaces")}
        assert pairs(update(reader(file))[0]) == pairs(before)


def test_what_cannot_be_written():
    with folder() as path:
        file = os.path.join(path, "a.qfmb")
        with open(file, "w") as old:
            old.write("old")
        mesh = demo_mesh(8)
        errors = write_errors(file, mesh, "FileFormatError")
        assert len(errors) == 1 and "is no B-spline volume" in errors[0], errors
        assert "File Name is empty" in write_errors("")[0]
        assert "No such file" in write_errors(os.path.join(path, "no", "a.qfmb"), code="CannotOpenFileError")[0]

        before, _ = update(DEMO)
        torn = before.NewInstance()
        torn.DeepCopy(before)
        contact = [int(n) for n in field(torn, "Interfaces")[0]]
        block = blocks(torn)[contact[0]]
        moved = coordinates(block)
        dims = [0, 0, 0]
        block.GetDimensions(dims)
        ijk = [n // 2 for n in dims]
        ijk[contact[1] // 2] = dims[contact[1] // 2] - 1 if contact[1] % 2 else 0
        moved.SetComponent(ijk[0] + dims[0] * (ijk[1] + dims[1] * ijk[2]), 0, 1e9)
        errors = write_errors(file, producer(torn))
        assert "block %d, face %d" % tuple(contact[:2]) in errors[0] and "differ" in errors[0], errors

        # A limit on the size of files stands for a full disk.
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, limits[1]))
        try:
            errors = write_errors(file, code="OutOfDiskSpaceError")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
            signal.signal(signal.SIGXFSZ, handler)
        assert "Cannot write" in errors[0], errors

        # Abort.
        proxy = writer(file)
        client(proxy).SetInputDataObject(before)
        client(proxy).AddObserver("ProgressEvent", lambda caller, _: caller.SetAbortExecute(1))
        assert client(proxy).Write() == 0

        assert lines(file) == ["old"] and os.listdir(path) == ["a.qfmb"]


def test_what_cannot_be_read():
    with folder() as path:
        file = os.path.join(path, "a.qfmb")
        simple.SaveData(file, proxy=DEMO)
        text = lines(file)

        def error(change):
            broken = os.path.join(path, "broken.qfmb")
            with open(broken, "w") as out:
                out.write("\n".join(change(list(text))) + "\n")
            proxy = reader(broken)
            message = failure(proxy)
            assert client(proxy).GetErrorCode() == vtk.vtkErrorCode.FileFormatError
            assert "broken.qfmb, line " in message
            return message
        assert "the file ends" in error(lambda t: t[:-1])
        assert "bytes that follow" in error(lambda t: t[:len(t) // 2])
        assert "'QFMB' expected" in error(lambda t: ["HELLO"] + t[1:])
        counts = next(n for n, line in enumerate(text) if line.startswith("counts"))
        assert "bytes that follow" in error(
            lambda t: t[:counts] + [t[counts].replace("vertices ", "vertices 9999999")] + t[counts + 1:])
        first = next(n for n, line in enumerate(text) if line.startswith("CONNECTIVITY")) + 1
        assert "is in no interface and no boundary" in error(lambda t: t[:first] + t[first + 1:])
        vertex = next(n for n, line in enumerate(text) if line.startswith("VERTICES")) + 1
        assert "vertex 0 is not the control point at corner 0 of block 0" in error(
            lambda t: t[:vertex] + ["0 1e9 1e9 1e9"] + t[vertex + 1:])
        proxy = reader(os.path.join(path, "none.qfmb"))
        assert "Cannot open" in failure(proxy)
        assert client(proxy).GetErrorCode() == vtk.vtkErrorCode.FileNotFoundError


def test_can_read_file():
    import bsplinevolume
    with folder() as path:
        file = os.path.join(path, "a.qfmb")
        simple.SaveData(file, proxy=DEMO)
        assert bsplinevolume.vtkQuadflowReader.CanReadFile(file) == 1
        assert bsplinevolume.vtkQuadflowReader.CanReadFile(__file__) == 0
        assert bsplinevolume.vtkQuadflowReader.CanReadFile(path) == 0


if __name__ == "__main__":
    main(globals())
