# SPDX-License-Identifier: BSD-3-Clause
"""What the tests share: the loaded plugin, messages of filters, small meshes, access to blocks and arrays.

No numpy: ParaView's packages do not bring it.
"""
import contextlib
import math
import os
import shutil
import sys
import tempfile
import traceback

import bsplinevolume  # noqa: F401  gives the VTK objects behind our proxies their own methods
from paraview import simple, vtk

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "Examples"))
simple.LoadPlugin(os.environ["BSV_PLUGIN"], remote=False, ns=simple.__dict__)


CONTROLLER = vtk.vtkMultiProcessController.GetGlobalController()
RANK = CONTROLLER.GetLocalProcessId() if CONTROLLER else 0
RANKS = CONTROLLER.GetNumberOfProcesses() if CONTROLLER else 1


def total(number):
    """Sum over all ranks. They wait for each other."""
    if RANKS == 1:
        return number
    mine, result = vtk.vtkIdTypeArray(), vtk.vtkIdTypeArray()
    mine.InsertNextValue(number)
    CONTROLLER.AllReduce(mine, result, vtk.vtkCommunicator.SUM_OP)
    return result.GetValue(0)


class Alone:
    """Filters believe that there is only this process."""

    def __enter__(self):
        vtk.vtkMultiProcessController.SetGlobalController(vtk.vtkDummyController())

    def __exit__(self, *_):
        vtk.vtkMultiProcessController.SetGlobalController(CONTROLLER)


@contextlib.contextmanager
def shared_folder():
    """A temporary folder that all ranks use."""
    path = vtk.vtkCharArray()
    if RANK == 0:
        for letter in tempfile.mkdtemp():
            path.InsertNextValue(letter)
    if RANKS > 1:
        CONTROLLER.Broadcast(path, 0)
    folder = "".join(path.GetValue(n) for n in range(path.GetNumberOfValues()))
    yield folder
    total(0)
    if RANK == 0:
        shutil.rmtree(folder)


def client(proxy):
    """The VTK object behind a proxy."""
    return proxy.SMProxy.GetClientSideObject()


@contextlib.contextmanager
def messages(proxy):
    """Errors and warnings that the filter behind `proxy` raises in the block, instead of on the console."""
    caught = {"errors": [], "warnings": []}

    def observe(event, into):
        def callback(_object, _event, text):
            into.append(text)
        callback.CallDataType = "string0"
        return client(proxy).AddObserver(event, callback)

    tags = [observe("ErrorEvent", caught["errors"]), observe("WarningEvent", caught["warnings"])]
    # What the pipeline says besides would be a second message.
    executive = client(proxy).GetExecutive()

    def pipeline(_object, _event, text):
        caught["errors"].append(text)
    pipeline.CallDataType = "string0"
    tag = executive.AddObserver("ErrorEvent", pipeline)
    try:
        yield caught
    finally:
        for own in tags:
            client(proxy).RemoveObserver(own)
        executive.RemoveObserver(tag)


def update(proxy):
    """Executes a filter that must succeed. Returns its output and its warnings."""
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert not caught["errors"], caught["errors"]
    return client(proxy).GetOutputDataObject(0), caught["warnings"]


def assert_no_output(proxy):
    """All outputs of the filter behind `proxy` are empty."""
    for port in range(client(proxy).GetNumberOfOutputPorts()):
        output = client(proxy).GetOutputDataObject(port)
        assert all(output.GetNumberOfElements(kind) == 0 for kind in (output.POINT, output.CELL, output.ROW)), port
        assert not output.IsA("vtkCompositeDataSet") or blocks(output) == [], port


def failure(proxy):
    """Executes a filter that must fail with one error and empty outputs. Returns the error."""
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert len(caught["errors"]) == 1, caught
    assert_no_output(proxy)
    return caught["errors"][0]


def aborted(proxy):
    """Stops a filter at its first progress: no error, empty outputs."""
    client(proxy).AddObserver("ProgressEvent", lambda caller, _: caller.SetAbortExecute(1))
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert not caught["errors"]
    assert_no_output(proxy)


def producer(data):
    """Proxy of a source that gives `data`."""
    source = simple.TrivialProducer()
    client(source).SetOutput(data)
    return source


def grid(cells, place, offset=(0, 0, 0)):
    """Structured grid with the points place(i, j, k), i = offset.., in double precision."""
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    for k in range(cells[2] + 1):
        for j in range(cells[1] + 1):
            for i in range(cells[0] + 1):
                points.InsertNextPoint(place(i + offset[0], j + offset[1], k + offset[2]))
    data = vtk.vtkStructuredGrid()
    data.SetDimensions([n + 1 for n in cells])
    data.SetPoints(points)
    return data


def collection(grids):
    """The grids as blocks of a collection."""
    data = vtk.vtkPartitionedDataSetCollection()
    data.SetNumberOfPartitionedDataSets(len(grids))
    for b, block in enumerate(grids):
        data.SetPartition(b, 0, block)
    return data


def blocks(data):
    """The leaves of a collection."""
    return [data.GetPartition(b, 0) for b in range(data.GetNumberOfPartitionedDataSets())]


def names(data):
    return [data.GetMetaData(b).Get(vtk.vtkCompositeDataSet.NAME())
            for b in range(data.GetNumberOfPartitionedDataSets())]


def dimensions(block):
    """Points per direction."""
    dims = [0, 0, 0]
    block.GetDimensions(dims)
    return tuple(dims)


def values(array):
    """All tuples of a numeric array (plain values for one component), or the strings of a string array."""
    if array.IsA("vtkStringArray"):
        return [array.GetValue(n) for n in range(array.GetNumberOfValues())]
    if array.GetNumberOfComponents() == 1:
        return [array.GetTuple1(n) for n in range(array.GetNumberOfTuples())]
    return [array.GetTuple(n) for n in range(array.GetNumberOfTuples())]


def field(data, name):
    """Field array of a data object, as a list."""
    array = data.GetFieldData().GetAbstractArray(name)
    assert array is not None, "no field array " + name
    return values(array)


def coordinates(data):
    return data.GetPoints().GetData()


def bits(data):
    """Everything that a conversion computed, as bytes."""
    return b"".join(bytes(memoryview(coordinates(block))) +
                    bytes(memoryview(block.GetPointData().GetArray("ControlPointRule"))) for block in blocks(data))


def demo_mesh(cells=8):
    """Proxy of a reader of the demonstration mesh."""
    import make_demo_mesh
    with shared_folder() as folder:
        path = os.path.join(folder, "demo.xyz")
        if RANK == 0:
            assert make_demo_mesh.write_demo(folder, cells) == path
        total(0)
        reader = simple.HexBlockMeshReader(FileName=path)
        reader.UpdatePipeline()
        data = client(reader).GetOutputDataObject(0)
        copy = data.NewInstance()
        copy.ShallowCopy(data)
    return producer(copy)


def creased_mesh():
    """Two blocks under a ridge: creases cut the first into four pieces and the second into two."""
    def place(i, j, k):
        return i + 0.1 * math.sin(j), j + 0.1 * math.sin(i + k), k - 0.4 * abs(j - 2) + 0.05 * math.cos(i)

    data = collection([grid((4, 4, 2), place), grid((3, 4, 2), place, (4, 0, 0))])
    for b in range(2):
        data.GetMetaData(b).Set(vtk.vtkCompositeDataSet.NAME(), "part %d" % b)
    tables = (("Boundaries", 3, [(b, face, face != 4) for b in (0, 1) for face in range(6) if face != 1 - b]),
              ("CreaseEdges", 7, [(0, 0, 2, 0, 4, 2, 0), (1, 0, 2, 0, 3, 2, 0), (0, 2, 0, 0, 2, 2, 0)]))
    for name, components, rows in tables:
        array = vtk.vtkIntArray()
        array.SetName(name)
        array.SetNumberOfComponents(components)
        for row in rows:
            array.InsertNextTuple(row)
        data.GetFieldData().AddArray(array)
    boundary = vtk.vtkStringArray()
    boundary.SetName("BoundaryNames")
    boundary.InsertNextValue("wall")
    boundary.InsertNextValue("outside")
    data.GetFieldData().AddArray(boundary)
    return data


def name_boundaries(data, rows, labels):
    """Gives a mesh boundaries: (block, face, number of the label), and the range of points along both axes of the face, if any."""
    table = vtk.vtkIntArray()
    table.SetName("Boundaries")
    table.SetNumberOfComponents(len(rows[0]))
    for row in rows:
        table.InsertNextTuple(row)
    strings = vtk.vtkStringArray()
    strings.SetName("BoundaryNames")
    for label in labels:
        strings.InsertNextValue(label)
    data.GetFieldData().AddArray(table)
    data.GetFieldData().AddArray(strings)
    return data


WAKE, BODY, OUT, SPAN = 4, 12, 3, 2


def cgrid(cut=None):
    """C-grid around a profile with a sharp trailing edge: along i the wake, the lower and the upper side, and the wake
    again, so that both ends of face j = 0 meet. One block, or two that are cut at i = `cut`, where the wake then joins
    a part of a face of each."""
    count = 2 * WAKE + BODY

    def place(p, j, k):
        i = min(p, count - p)
        side = 0.0 if 2 * p == count else -1.0 if 2 * p < count else 1.0
        x, y = 1 + 2 * (WAKE - i) / WAKE, 0.0
        if i > WAKE:
            x = 1 - 2 * (i - WAKE) / BODY
            y = 0.3 * x * (1 - x)
        bend = 2 * i / count
        angle = 0.5 * math.pi * bend
        outer = 4 * math.cos(angle) - 2 * bend, 2 * math.cos(angle) + 2 * math.sin(2 * angle)
        w = j / OUT
        return x + w * (outer[0] - x), side * (y + w * (outer[1] - y)), k / SPAN

    ends = [0, count] if cut is None else [0, cut, count]
    data = collection([grid((b - a, OUT, SPAN), place, (a, 0, 0)) for a, b in zip(ends, ends[1:])])
    rows = []
    for b, (first, last) in enumerate(zip(ends, ends[1:])):
        cells = last - first
        rows += [(b, 2, 0, max(0, WAKE - first), min(cells, WAKE + BODY - first), 0, SPAN),
                 (b, 3, 1, 0, cells, 0, SPAN), (b, 4, 2, 0, cells, 0, OUT), (b, 5, 2, 0, cells, 0, OUT)]
    last = len(ends) - 2
    rows += [(0, 0, 1, 0, OUT, 0, SPAN), (last, 1, 1, 0, OUT, 0, SPAN)]
    return name_boundaries(data, rows, ("wall", "farfield", "sides"))


def half_turn_ring():
    """One block around an axis that is turned by half a turn on its way: its ends meet with both directions reversed."""
    n = (12, 2, 2)

    def place(i, j, k):
        if i == n[0]:
            i, j, k = 0, n[1] - j, n[2] - k
        angle = 2 * math.pi * i / n[0]
        u, v = j / n[1] - 0.5, k / n[2] - 0.5
        radius = 3 + u * math.cos(angle / 2) - v * math.sin(angle / 2)
        return (radius * math.cos(angle), -radius * math.sin(angle),
                u * math.sin(angle / 2) + v * math.cos(angle / 2))
    return collection([grid(n, place)])


def folded_ring():
    """One block around an axis whose inner face is folded flat: it meets itself all over, and so do its ends."""
    n = (12, 3, 2)

    def place(i, j, k):
        i %= n[0]
        angle = 2 * math.pi * min(i, n[0] - i) / n[0]
        side = 0.0 if 2 * i in (0, n[0]) else 1.0 if 2 * i > n[0] else -1.0
        w = j / n[1]
        return math.cos(angle) * (1 + w), side * math.sin(angle) * 2 * w, k / n[2]
    return collection([grid(n, place)])


def has_opencascade():
    """Whether CAD files can be read and written here."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "a.step")
        with open(path, "w") as file:
            file.write("ISO-10303-21;\n")
        reader = simple.NURBSSurfaceReader(FileName=path)
        with messages(reader) as caught:
            reader.UpdatePipeline()
    assert caught["errors"]
    return not any("without which this program was built" in text for text in caught["errors"])


def main(tests):
    """Runs all functions named test_* of a module's globals()."""
    for name, test in list(tests.items()):
        if name.startswith("test_"):
            try:
                test()
            except BaseException:
                if RANKS == 1:
                    raise
                # Or the other ranks would wait.
                traceback.print_exc()
                sys.stderr.flush()
                os._exit(1)
            print(name, "passed", flush=True)
