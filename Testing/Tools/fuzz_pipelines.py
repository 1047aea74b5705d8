# SPDX-License-Identifier: BSD-3-Clause
"""Random pipelines on tiny meshes in one process: random meshes, mostly spoiled, filters, properties and aborts.

    pvpython Testing/Tools/fuzz_pipelines.py build/lib/BSplineVolume/BSplineVolume.so [RUNS] [FIRST_RUN]

Each filter must end in finite points or in one error, valid UTF-8, with empty outputs; a writer after an error leaves
the old file. The first answer of every twentieth run is compared with that of a second one, bit by bit. The number of a
run says all of it: `fuzz_pipelines.py PLUGIN 1 4711` repeats run 4711. Should the process end, the file whose name is
printed first holds the number. Prints a table of filters at the end: runs, errors, warnings, aborts; finds before.
"""
import glob
import math
import os
import random
import shutil
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

PLUGIN = os.path.abspath(sys.argv[1])
os.environ["BSV_PLUGIN"] = PLUGIN
for folder in (os.path.join(os.path.dirname(__file__), "..", "Python"), os.path.dirname(PLUGIN)):
    sys.path.insert(0, os.path.abspath(folder))
import bsplinevolume  # noqa: E402
from bsv_support import ROOT, vtk  # noqa: E402

FOLDER = tempfile.mkdtemp()
# Seconds of a filter after which it is stopped, which must work at any time.
PATIENCE = 0.5
NUMBERS = (0.0, 1.0, -1.0, 0.5, 2.0, 30.0, 1e-9, 1e9, 1e300, 1e-300, -1e300, math.nan, math.inf, -math.inf)
INTEGERS = (0, 1, 2, 3, -1, 5, 100, 2 ** 31 - 1, -2 ** 31)
WORDS = ("wall", "outside", "", "*", "wall*", "[", "wa?l", "no such name", "Fl\u00fcgel", "block 0", "x" * 300, "a\nb",
         "%s", "FaceOfBody")
MESH_FILTERS = ("HexBlockTopology", "MirrorHexBlocks", "WallSpacing", "CatmullClarkToBSplineVolume", "HexMeshToBlocks",
                "HexBlockMeshWriter")
VOLUME_FILTERS = ("BSplineVolumeSampler", "BSplineVolumeQuality", "BSplineVolumeSmoothness", "BSplineVolumeDifference",
                  "BSplineVolumeIsoparametric", "BSplineVolumeProbe", "BSplineVolumeToBezierCells", "BodyDeviation",
                  "BSplineVolumeWriter", "QuadflowWriter", "NURBSSurfaceWriter")
FILES = {"HexBlockMeshWriter": ("a.cgns", "a.xyz", "a.foam", "a.doc"), "QuadflowWriter": ("a.qfmb",),
         "BSplineVolumeWriter": ("a.mesh", "a.xml", "a.g2", "a.msh"), "NURBSSurfaceWriter": ("a.g2",)}


def proxies():
    """XML element of every algorithm by the name of its proxy."""
    found = {}
    for file in glob.glob(os.path.join(ROOT, "Plugin", "*.xml")):
        for proxy in ElementTree.parse(file).iter():
            if proxy.tag in ("SourceProxy", "WriterProxy") and proxy.get("class"):
                found[proxy.get("name")] = proxy
    return found


PROXIES = proxies()


def spoiled(choice, points):
    """Changes the coordinates of a block."""
    kind = choice.choice(("nan", "inf", "moved", "moved", "shifted", "shifted", "collapsed", "huge", "tiny", "same",
                          "noise"))
    n = choice.randrange(len(points))
    if kind in ("nan", "inf"):
        points[n][choice.randrange(3)] = float(kind)
    elif kind == "moved":
        points[n][choice.randrange(3)] += choice.choice((1e-6, 1e-3, 0.05, 0.3, 0.5, 1.0, 3.0))
    elif kind == "shifted":
        step = choice.choice((1e-9, 1e-6, 1e-3, 0.06, 0.2, 0.5, 1.0))
        axis = choice.randrange(3)
        for point in points:
            point[axis] += step
    elif kind == "collapsed":
        points[n] = list(points[choice.randrange(len(points))])
    elif kind in ("huge", "tiny"):
        scale = choice.choice((1e6, 1e150, 1e300)) if kind == "huge" else choice.choice((1e-6, 1e-150, 1e-310))
        for point in points:
            point[:] = [x * scale for x in point]
    elif kind == "same":
        for point in points:
            point[:] = points[0]
    else:
        for point in points:
            point[:] = [x + choice.uniform(-0.6, 0.6) for x in point]


def block(choice, at, cells, bend, spoil):
    """One block of the lattice, in a random orientation."""
    axes = list(range(3))
    flips = [False] * 3
    if choice.random() < 0.3:
        choice.shuffle(axes)
        flips = [choice.random() < 0.5 for _ in range(3)]
    counts = [cells[axis] + 1 for axis in axes]
    points = []
    for k in range(counts[2]):
        for j in range(counts[1]):
            for i in range(counts[0]):
                place = [0.0, 0.0, 0.0]
                for index, axis, flip, count in zip((i, j, k), axes, flips, counts):
                    place[axis] = at[axis] + (count - 1 - index if flip else index)
                x, y, z = place
                points.append([x + bend * math.sin(y), y + bend * z * z / 4.0, z + bend * math.cos(x)])
    if spoil:
        spoiled(choice, points)
    array = vtk.vtkPoints()
    array.SetDataType(vtk.VTK_FLOAT if choice.random() < 0.1 else vtk.VTK_DOUBLE)
    for point in points:
        array.InsertNextPoint(point)
    grid = vtk.vtkStructuredGrid()
    grid.SetDimensions(counts)
    grid.SetPoints(array)
    return grid


def table(choice, name, components, most, rows):
    array = vtk.vtkIntArray()
    array.SetName(name)
    array.SetNumberOfComponents(components)
    for _ in range(rows):
        array.InsertNextTuple([choice.randrange(-1, most + 1) for _ in range(components)])
    return array


def mesh(choice):
    """A few blocks of a lattice, with arrays of connectivity that may be wrong."""
    shape = [choice.choice((1, 1, 2)) for _ in range(3)]
    cells = [choice.choice((1, 2, 2, 3)) for _ in range(3)]
    places = [(x, y, z) for z in range(shape[2]) for y in range(shape[1]) for x in range(shape[0])]
    if choice.random() < 0.2 and len(places) > 2:
        del places[choice.randrange(len(places))]
    bad = choice.choice((-1, -1, -1, choice.randrange(len(places))))
    bend = choice.choice((0.0, 0.05, 0.2, 1.0))
    grids = [block(choice, [n * c for n, c in zip(place, cells)], cells, bend, n == bad)
             for n, place in enumerate(places)]
    if choice.random() < 0.05:
        grids.append(choice.choice((None, vtk.vtkStructuredGrid(), vtk.vtkPolyData(), vtk.vtkUnstructuredGrid(),
                                    grids[0])))
    if choice.random() < 0.03:
        return grids[0]
    data = vtk.vtkPartitionedDataSetCollection()
    data.SetNumberOfPartitionedDataSets(len(grids))
    for b, part in enumerate(grids):
        data.SetPartition(b, 0, part)
        if choice.random() < 0.5:
            data.GetMetaData(b).Set(vtk.vtkCompositeDataSet.NAME(), choice.choice(WORDS))
    fields = data.GetFieldData()
    if choice.random() < 0.6:
        names = vtk.vtkStringArray()
        names.SetName("BoundaryNames")
        boundaries = vtk.vtkIntArray()
        boundaries.SetName("Boundaries")
        boundaries.SetNumberOfComponents(3)
        for name in ("wall", choice.choice(("outside", "symmetry"))):
            names.InsertNextValue(name if choice.random() < 0.9 else choice.choice(WORDS))
        for b in range(len(grids)):
            for face in range(6):
                if choice.random() < 0.5:
                    boundaries.InsertNextTuple((b, face, choice.randrange(2) if choice.random() < 0.97 else 7))
        fields.AddArray(names)
        fields.AddArray(boundaries)
    if choice.random() < 0.05:
        name, components, most = choice.choice((
            ("Interfaces", 12, 4), ("Interfaces", 12, 1), ("Boundaries", 7, 4), ("Boundaries", 3, 1),
            ("CreaseEdges", 7, 2), ("BoundaryTypes", 1, 2), ("BoundaryNames", 1, 1), ("Interfaces", 5, 6)))
        fields.AddArray(table(choice, name, components, most, choice.randrange(4)))
    return data


def unstructured(data):
    """The cells of all blocks in one grid, as hexahedra."""
    # Not by vtkAppendFilter, whose search for equal points ends the process at infinite and huge coordinates.
    made = vtk.vtkUnstructuredGrid()
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    ids = {}
    for b in range(data.GetNumberOfPartitionedDataSets() if data.IsA("vtkPartitionedDataSetCollection") else 0):
        part = data.GetPartition(b, 0)
        if part and part.IsA("vtkStructuredGrid"):
            for c in range(part.GetNumberOfCells()):
                cell = part.GetCell(c)
                if cell.GetCellType() != vtk.VTK_HEXAHEDRON:
                    continue
                corners = []
                for n in range(8):
                    place = part.GetPoint(cell.GetPointId(n))
                    if place not in ids:
                        ids[place] = points.InsertNextPoint(place)
                    corners.append(ids[place])
                made.InsertNextCell(vtk.VTK_HEXAHEDRON, 8, corners)
    made.SetPoints(points)
    return made


def bodies():
    """Surfaces: the floor z = 0 of meshes that are not bent, and that of the wing and fuselage."""
    path = os.path.join(FOLDER, "body.g2")
    with open(path, "w") as out:
        out.write("200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n-9 -9 0\n9 -9 0\n-9 9 0\n9 9 0\n")
    reader = bsplinevolume.vtkNURBSSurfaceReader()
    reader.SetFileName(path)
    reader.Update()
    source = bsplinevolume.vtkWingFuselageSource()
    source.SetResolution(2)
    source.Update()
    return [reader.GetOutputDataObject(0)] + [source.GetOutputDataObject(n)
                                              for n in range(1, source.GetNumberOfOutputPorts())]


def value(choice, prop):
    """Random arguments of a setter."""
    kind = prop.tag[:-len("VectorProperty")]
    width = int(prop.get("number_of_elements_per_command") or prop.get("number_of_elements") or 1)
    if kind == "String":
        types = (prop.get("element_types") or "2").split()
        return [choice.choice(WORDS) if types[n % len(types)] == "2" else choice.choice((0, 1)) for n in range(width)]
    if kind == "Double":
        default = [float(word) for word in (prop.get("default_values") or "1").split() if word != "none"] or [1.0]
        return [choice.choice(NUMBERS) if choice.random() < 0.2 else choice.choice(default) * choice.uniform(0.5, 2.0)
                for _ in range(width)]
    entries = [int(entry.get("value")) for entry in prop.iter("Entry")]
    if entries and choice.random() < 0.95:
        return [choice.choice(entries)]
    return [choice.choice(INTEGERS if choice.random() < 0.15 else INTEGERS[:4]) for _ in range(width)]


def configure(choice, algorithm, proxy):
    """Sets a few properties, mostly none."""
    settable = [prop for prop in proxy if prop.tag.endswith("VectorProperty") and
                prop.get("information_only") != "1" and not prop.get("si_class") and
                prop.get("command") not in (None, "SetFileName")]
    if hasattr(algorithm, "SetAllowOpenInterior") and choice.random() < 0.4:
        algorithm.SetAllowOpenInterior(True)
    count = choice.choice((0, 0, 1, 2, 3, len(settable) // 4))
    for prop in choice.sample(settable, min(count, len(settable))):
        if prop.get("set_number_command"):
            getattr(algorithm, prop.get("set_number_command"))(1)
        arguments = value(choice, prop)
        if prop.get("use_index") == "1":
            arguments.insert(0, 0)
        try:
            getattr(algorithm, prop.get("command"))(*arguments)
        except (TypeError, ValueError, OverflowError):
            pass  # Python's own checks


class Messages:
    """What an algorithm and its executive say."""

    def __init__(self, algorithm):
        self.errors, self.warnings = [], []
        for caller in (algorithm, algorithm.GetExecutive()):
            self.observe(caller, "ErrorEvent", self.errors)
            self.observe(caller, "WarningEvent", self.warnings)

    @staticmethod
    def observe(caller, event, into):
        def callback(_object, _event, text):
            into.append(text)
        callback.CallDataType = "string0"
        caller.AddObserver(event, callback)


def leaves(data):
    if data is None:
        return []
    if not data.IsA("vtkCompositeDataSet"):
        return [data] if data.IsA("vtkDataSet") else []
    iterator = data.NewIterator()
    found = []
    iterator.InitTraversal()
    while not iterator.IsDoneWithTraversal():
        found.append(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    return found


def arrays(data):
    """Coordinates of all leaves."""
    return [leaf.GetPoints().GetData() for leaf in leaves(data)
            if leaf.IsA("vtkPointSet") and leaf.GetPoints() and leaf.GetNumberOfPoints() > 0]


def finite(array):
    view = memoryview(array).cast("B").cast("f" if array.GetDataType() == vtk.VTK_FLOAT else "d")
    return all(map(math.isfinite, view))


def empty(data):
    return data is None or data.GetNumberOfElements(data.POINT) == 0 and data.GetNumberOfElements(data.CELL) == 0


def bits(algorithm):
    return [bytes(memoryview(array)) for port in range(algorithm.GetNumberOfOutputPorts())
            for array in arrays(algorithm.GetOutputDataObject(port))]


class Fuzzer:
    def __init__(self):
        self.bodies = bodies()
        self.counts = {}
        self.finds = []
        self.run_number = 0

    def find(self, name, what):
        self.finds.append((self.run_number, name, what))
        print("run %d, %s: %s" % (self.run_number, name, what), flush=True)

    def made(self, name, choice, inputs):
        algorithm = getattr(bsplinevolume, PROXIES[name].get("class"))()
        for port, data in enumerate(inputs[:algorithm.GetNumberOfInputPorts()]):
            if data is not None:
                algorithm.SetInputDataObject(port, data)
        configure(choice, algorithm, PROXIES[name])
        if name in FILES:
            algorithm.SetFileName(os.path.join(FOLDER, choice.choice(FILES[name])))
        return algorithm

    def run_filter(self, name, seed, inputs):
        """Returns the algorithm, or nothing after an error or an abort."""
        choice = random.Random(seed)
        algorithm = self.made(name, choice, inputs)
        writer = name in FILES
        said = Messages(algorithm)
        stop = choice.randrange(1, 30) if choice.random() < 0.1 else -1
        state = [0, time.perf_counter(), False]

        def progress(caller, _event):
            state[0] += 1
            if state[0] == stop or time.perf_counter() - state[1] > PATIENCE:
                state[2] = True
                caller.SetAbortExecute(1)
        algorithm.AddObserver("ProgressEvent", progress)
        if writer:
            path = algorithm.GetFileName()
            with open(path, "w") as out:
                out.write("old")
            result = algorithm.Write()
        else:
            algorithm.Update()
        counts = self.counts.setdefault(name, [0, 0, 0, 0, 0.0])
        for text in said.errors if os.environ.get("BSV_SHOW_ERRORS") else []:
            print(name + ": " + text.split("): ", 1)[-1].strip())
        for n, count in enumerate((1, bool(said.errors), bool(said.warnings), state[2])):
            counts[n] += count
        counts[4] = max(counts[4], time.perf_counter() - state[1])
        ports = range(algorithm.GetNumberOfOutputPorts())
        outputs = [algorithm.GetOutputDataObject(port) for port in ports]
        if len(said.errors) > 1:
            self.find(name, "%d errors: %s" % (len(said.errors), said.errors))
        if said.errors and not said.errors[0].strip():
            self.find(name, "an error without a word")
        if writer:
            with open(path, errors="replace") as file:
                old = file.read(4) == "old"
            if said.errors and not old:
                self.find(name, "no old file after " + said.errors[0])
            family = name == "HexBlockMeshWriter" and algorithm.GetLevels() > 1  # files of other names
            if old and not said.errors and not state[2] and not family:
                self.find(name, "neither a file nor an error")
            if result == (1 if said.errors else 0) and not state[2]:
                self.find(name, "Write() returned %d after %s" % (result, said.errors))
            return None
        if said.errors or state[2]:
            if said.errors and not all(map(empty, outputs)) or state[2] and not said.errors and stop > 0 and \
                    algorithm.GetProgress() < 1.0 and not all(map(empty, outputs)):
                self.find(name, "outputs are not empty after " + (said.errors[0] if said.errors else "an abort"))
            return None
        for port in ports:
            if not all(map(finite, arrays(outputs[port]))):
                self.find(name, "points of output %d are not finite, and no error" % port)
        if seed % 20 == 0 and not state[2]:
            again = self.made(name, random.Random(seed), inputs)
            again.Update()
            if bits(again) != bits(algorithm):
                self.find(name, "a second run has other points")
        return algorithm

    def run(self, number):
        self.run_number = number
        choice = random.Random(number)
        data = mesh(choice)
        names = list(MESH_FILTERS)
        for step in range(choice.choice((1, 2, 2, 3))):
            name = choice.choice(names) if choice.random() < 0.97 else choice.choice(MESH_FILTERS + VOLUME_FILTERS)
            if step == 0 and choice.random() < 0.5:
                name = "CatmullClarkToBSplineVolume"
            second = None
            if name in ("CatmullClarkToBSplineVolume", "BodyDeviation"):
                second = choice.choice(self.bodies) if choice.random() < (0.2 if name[0] == "C" else 0.9) else None
            elif name == "BSplineVolumeDifference":
                second = data
            elif name == "BSplineVolumeProbe":
                second = unstructured(mesh(choice))
            if name == "HexMeshToBlocks" and choice.random() < 0.9:
                data = unstructured(data)
            inputs = [data if choice.random() < 0.99 else None, second]
            algorithm = self.run_filter(name, choice.randrange(2 ** 30), inputs)
            if algorithm is None:
                return
            data = algorithm.GetOutputDataObject(0)
            if name == "CatmullClarkToBSplineVolume":
                names = list(VOLUME_FILTERS)
            elif name == "BSplineVolumeSampler":
                names = list(MESH_FILTERS)
            elif name not in MESH_FILTERS[1:3] + ("HexMeshToBlocks",):
                return


def main():
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 1000
    first = int(sys.argv[3]) if len(sys.argv) > 3 else 0
    place = os.path.join(FOLDER, "run")
    print(place, flush=True)
    fuzzer = Fuzzer()
    start = time.process_time()
    with open(place, "w") as file:
        for n in range(first, first + runs):
            file.seek(0)
            file.write("%d\n" % n)
            file.flush()
            fuzzer.run(n)
            if (n - first + 1) % 1000 == 0:
                print("%d runs, %d filters, %d finds, %.0f s" % (
                    n - first + 1, sum(c[0] for c in fuzzer.counts.values()), len(fuzzer.finds),
                    time.process_time() - start), flush=True)
    print("| filter | runs | errors | with warnings | stopped | longest, s |\n|---|---|---|---|---|---|")
    for name, (count, errors, warnings, stopped, longest) in sorted(fuzzer.counts.items()):
        print("| %s | %d | %d | %d | %d | %.2f |" % (name, count, errors, warnings, stopped, longest))
    print("%d pipelines of %d filters, %d finds" % (runs, sum(c[0] for c in fuzzer.counts.values()), len(fuzzer.finds)))
    shutil.rmtree(FOLDER)
    return 1 if fuzzer.finds else 0


if __name__ == "__main__":
    sys.exit(main())
