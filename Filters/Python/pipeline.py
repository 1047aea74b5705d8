# SPDX-License-Identifier: BSD-3-Clause
"""Runs the readers, filters and writers of this package from plain Python: values in, values out, errors as exceptions."""
import difflib
import importlib
import os
import re

from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkTrivialProducer

from . import BSplineVolumeFilters, BSplineVolumeReaders, BSplineVolumeWriters


class Error(RuntimeError):
    """What a reader, filter or writer reports, in its own words."""


def _constants(algorithm, name):
    """The constants of an enumerated property, {"EXACT_G1": 1, ..}; empty for other properties."""
    kind = type(algorithm)
    enumeration = getattr(kind, {"FileUnit": "LengthUnit"}.get(name, name) + "Type", None)
    return {} if enumeration is None else {
        word: int(value) for one in kind.__mro__ for word, value in vars(one).items() if isinstance(value, enumeration)}


def words_of(algorithm, name):
    """The words of an enumerated property and their numbers, as in ParaView's panel: {"ExactG1": 1, ..}; empty for
    other properties."""
    members = _constants(algorithm, name)
    # The name of the property is no part of the words: CHECK_ALL of CheckSpans, LITTLE_ENDIAN_ORDER of ByteOrder,
    # UNIT_KNOTS of KnotScaling.
    whole = name.upper()
    parts = {}
    for constant in members:
        word = constant.split("_")
        tails = ["".join(word[n:]) for n in range(1, len(word))]
        parts[constant] = word[:next((n for n, tail in enumerate(tails, 1)
                                      if whole.endswith(tail) or whole.startswith(tail.rstrip("S"))), None)]
    while len(parts) > 1 and len({word[0] for word in parts.values()}) == 1:
        parts = {constant: word[1:] for constant, word in parts.items()}
    return {"".join(part if part in ("ACC", "PCCM", "G1", "ASCII") else part.capitalize() for part in word):
            members[constant] for constant, word in parts.items()}


def property_names(algorithm):
    """What set_properties() can set, apart from properties of every VTK algorithm."""
    common = set(dir(vtkAlgorithm)) | {"SetFileName"}
    own = [method for method in dir(algorithm) if method not in common]
    names = {method[3:] for method in own if re.fullmatch(r"Set[A-Z]\w*", method) and not re.search(
        r"Connection|InputData|To[A-Z]\w*$|ByNumber$", method)}
    lists = {method[5:] for method in own if method.startswith("Clear")}
    return sorted(names | lists)


def set_properties(algorithm, properties):
    """Sets `Name=value` by SetName(value). A list goes to ClearNames() and AddName(item), a single text as a list of one;
    an enumerated property takes words_of() it, too.

    @throws TypeError for a property that does not exist, with the names alike
    @throws Error for a word or a value that the property does not take
    """
    def unknown(name):
        alike = difflib.get_close_matches(name, property_names(algorithm), 3)
        return TypeError(f"{algorithm.GetClassName()[3:]} has no property {name}" +
                         (f"; is it {' or '.join(alike)}?" if alike else ""))

    for name, value in properties.items():
        if isinstance(value, (str, list, tuple)) and not hasattr(algorithm, "Set" + name):
            singular = name[:-3] + "y" if name.endswith("ies") else name[:-1] if name.endswith("s") else name
            adder = getattr(algorithm, "Add" + singular, None)
            clearer = getattr(algorithm, "Clear" + name, None) or getattr(algorithm, "Clear" + name + "s", None)
            if adder is None or clearer is None:
                raise unknown(name)
            clearer()
            for item in [value] if isinstance(value, str) else value:
                adder(*item) if isinstance(item, (list, tuple)) else adder(item)
            continue
        setter = getattr(algorithm, "Set" + name, None)
        if setter is None:
            raise unknown(name)
        words = words_of(algorithm, name)
        if isinstance(value, str) and words:
            plain = re.sub(r"\W|_", "", value).lower()
            # Also by the names of the constants.
            known = {word.replace("_", "").lower(): number for word, number in _constants(algorithm, name).items()}
            known.update((word.lower(), number) for word, number in words.items())
            if plain not in known:
                raise Error(f"{name} is {' or '.join(words)}, not {value}")
            value = known[plain]
        try:
            setter(*value) if isinstance(value, (list, tuple)) else setter(value)
        except TypeError as error:
            raise Error(f"{name} does not take {value!r}: {error}") from None
        # Setters cut what is out of range to it.
        taken = getattr(algorithm, "Get" + name, lambda: value)()
        if isinstance(value, (int, float)) and isinstance(taken, (int, float)) and taken != value:
            ends = [getattr(algorithm, f"Get{name}{end}Value", lambda: None)() for end in ("Min", "Max")]
            raise Error(f"{name} does not take {value}" +
                        (f"; from {ends[0]:g} to {ends[1]:g}" if None not in ends else f"; it would become {taken}"))


def message(text):
    """What VTK's event says, without the class and the address of who says it."""
    return text.strip().split("): ", 1)[-1].strip()


def input_message(algorithm, text):
    """What VTK says of data that an algorithm does not take, without numbers and addresses."""
    found = re.search(r"on input port index (\d+) for algorithm (\w+) .* is of type (\w+)", text)
    if found is None or found[2] != algorithm.GetClassName():
        return text
    key, port = vtkAlgorithm.INPUT_REQUIRED_DATA_TYPE(), algorithm.GetInputPortInformation(int(found[1]))
    kinds = [port.Get(key, n) for n in range(port.Length(key))]
    return f"{found[2][3:]} takes {' or '.join(kinds)}, not {found[3]}"


def run(algorithm, progress=None):
    """Updates `algorithm`; returns the warnings of it and of all that it reads from.

    @param progress called with the fraction done; returns False to stop
    @throws Error with the first message
    """
    errors, warnings, of_pipeline, observed = [], [], [], []

    def observe(one, event, texts):
        def note(_object, _event, text):
            texts.append(message(text))
        note.CallDataType = "string0"
        observed.append((one, one.AddObserver(event, note)))

    def listen(one):
        observe(one, "ErrorEvent", errors)
        observe(one, "WarningEvent", warnings)
        # Only that an algorithm failed, which has said why itself; or that it was not even asked.
        observe(one.GetExecutive(), "ErrorEvent", of_pipeline)
        for port in range(one.GetNumberOfInputPorts()):
            for connection in range(one.GetNumberOfInputConnections(port)):
                listen(one.GetInputConnection(port, connection).GetProducer())

    listen(algorithm)
    if progress is not None:
        def tell(sender, _event):
            if progress(sender.GetProgress()) is False:
                sender.SetAbortExecute(1)
        observed.append((algorithm, algorithm.AddObserver("ProgressEvent", tell)))
    try:
        algorithm.Update() if not hasattr(algorithm, "Write") else algorithm.Write()
    finally:
        for one, tag in observed:
            one.RemoveObserver(tag)
    if errors or of_pipeline:
        raise Error(errors[0] if errors else input_message(algorithm, of_pipeline[0].splitlines()[0]))
    return warnings


#: VTK's own readers by the ending of files: module and class.
VTK_READERS = {
    **dict.fromkeys([".vts", ".vtu", ".vtm", ".vtmb", ".vti", ".vtr"], ("vtkIOXML", "vtkXMLGenericDataObjectReader")),
    ".vtpc": ("vtkIOXML", "vtkXMLPartitionedDataSetCollectionReader"),
    ".vtpd": ("vtkIOXML", "vtkXMLPartitionedDataSetReader"),
    ".pvtu": ("vtkIOXML", "vtkXMLPUnstructuredGridReader"),
    ".pvts": ("vtkIOXML", "vtkXMLPStructuredGridReader"),
    ".vtk": ("vtkIOLegacy", "vtkGenericDataObjectReader"),
    **dict.fromkeys([".e", ".ex2", ".exo", ".exii", ".g"], ("vtkIOExodus", "vtkExodusIIReader")),
}


def vtk_reader(path):
    """VTK's reader of a mesh file, after it has read, or None.

    @throws Error with the first message. These readers hand on neither the events of the readers inside them nor a status.
    """
    module, name = VTK_READERS.get(os.path.splitext(path)[1].lower(), (None, None))
    if module is None:
        return None
    try:
        reader = getattr(importlib.import_module("vtkmodules." + module), name)()
    except ImportError:
        raise Error(f"{path}: this VTK has no {module}, which reads such files") from None
    reader.SetFileName(path)
    errors = []

    def note(_object, _event, text):
        errors.append(message(text))
    note.CallDataType = "string0"
    window, before = vtkStringOutputWindow(), vtkOutputWindow.GetInstance()
    window.AddObserver("ErrorEvent", note)
    vtkOutputWindow.SetInstance(window)
    try:
        if reader.IsA("vtkExodusIIReader"):
            # Its boundaries, which it leaves out unless asked.
            reader.UpdateInformation()
            for n in range(reader.GetNumberOfSideSetArrays()):
                reader.SetSideSetArrayStatus(reader.GetSideSetArrayName(n), 1)
        reader.Update()
    finally:
        vtkOutputWindow.SetInstance(before)
    if errors:
        raise Error(f"{path}: {errors[0]}")
    return reader


def is_volume_of_vtk(path):
    """Whether this is a .vtpc file of blocks with knots, as ParaView and write() make of a volume."""
    if os.path.splitext(path)[1].lower() != ".vtpc":
        return False
    data = vtk_reader(path).GetOutputDataObject(0)
    grids = [data.GetPartition(n, 0) for n in range(data.GetNumberOfPartitionedDataSets())]
    return bool(grids) and all(grid is not None and grid.GetFieldData().HasArray("KnotsU") for grid in grids)


def why_unreadable(path, reader_classes):
    """What a file is instead of what `reader_classes` read, or what the first of them says of it."""
    if os.path.isdir(path):
        return "it is a folder"
    for others, kind in ((MESH_READERS, "mesh"), (BODY_READERS, "body"), (VOLUME_READERS, "volume")):
        if others is not reader_classes and any(getattr(BSplineVolumeReaders, name)().CanReadFile(path) for name in others):
            return f"it is a {kind}"
    reader = getattr(BSplineVolumeReaders, reader_classes[0])()
    reader.SetFileName(path)
    try:
        run(reader)
    except Error as error:
        return str(error).replace(path, "", 1).lstrip(":, ")
    return "another kind of file"


def source_of(data, reader_classes=None):
    """A producer of `data`: an algorithm, a data object, or the path of a file."""
    if isinstance(data, vtkAlgorithm):
        return data
    if hasattr(data, "to_vtk"):
        data = data.to_vtk()
    if isinstance(data, (str, bytes, os.PathLike)):
        path = os.fsdecode(data)
        if not os.path.exists(path):
            raise Error(path + " does not exist")
        for name in reader_classes:
            reader = getattr(BSplineVolumeReaders, name)()
            if reader.CanReadFile(path):
                reader.SetFileName(path)
                return reader
        reader = vtk_reader(path) if reader_classes is MESH_READERS else None
        if reader_classes is VOLUME_READERS and is_volume_of_vtk(path):
            reader = vtk_reader(path)
        if reader is None:
            raise Error(path + " is no file that " + " or ".join(name[3:] for name in reader_classes) + " can read" +
                        (", and none of VTK's (" + " ".join(VTK_READERS) + ")" if reader_classes is MESH_READERS else "") +
                        ": " + why_unreadable(path, reader_classes))
        return reader
    if not isinstance(data, vtkDataObject):
        kind = type(data)
        raise Error(f"a path, data of VTK or an algorithm that gives it is wanted, not {kind.__module__}.{kind.__name__}")
    producer = vtkTrivialProducer()
    producer.SetOutput(data)
    return producer


def connect(setter, data, reader_classes=None):
    """setter(output port of the producer of `data`). An output port does not keep its producer alive, an input does."""
    producer = source_of(data, reader_classes)
    setter(producer.GetOutputPort())


MESH_READERS = ("vtkHexBlockMeshReader",)
BODY_READERS = ("vtkNURBSSurfaceReader",)
VOLUME_READERS = ("vtkQuadflowReader", "vtkBSplineVolumeReader")

#: Ending of a file: the writer, and whether it takes the volume itself (else a mesh sampled from it).
WRITERS = {
    ".vtpc": ("vtkXMLPartitionedDataSetCollectionWriter", True),
    ".qfmb": ("vtkQuadflowWriter", True),
    ".mesh": ("vtkBSplineVolumeWriter", True),
    ".xml": ("vtkBSplineVolumeWriter", True),
    ".g2": ("vtkBSplineVolumeWriter", True),
    ".msh": ("vtkBSplineVolumeWriter", True),
    ".step": ("vtkNURBSSurfaceWriter", True),
    ".stp": ("vtkNURBSSurfaceWriter", True),
    ".igs": ("vtkNURBSSurfaceWriter", True),
    ".iges": ("vtkNURBSSurfaceWriter", True),
    ".h5": ("vtkBSplineVolumeWriter", True),
    ".cgns": ("vtkHexBlockMeshWriter", False),
    ".xyz": ("vtkHexBlockMeshWriter", False),
    ".x": ("vtkHexBlockMeshWriter", False),
    ".p3d": ("vtkHexBlockMeshWriter", False),
    ".foam": ("vtkHexBlockMeshWriter", False),
}


def writer_of(path):
    """Class of the writer for the ending of `path`, and whether it writes the exact volume; a folder that is missing is
    an error, too."""
    ending = os.path.splitext(path)[1].lower()
    if ending not in WRITERS:
        raise Error(f"{path}: no writer for the ending '{ending}'; there are " + " ".join(sorted(WRITERS)))
    if ending != ".foam":  # a case makes its folder
        require_folder(path)
    return WRITERS[ending]


def files_of_mesh(path):
    """A PLOT3D file has its neutral map beside it; other meshes are one file."""
    name, ending = os.path.splitext(path)
    return [path] if ending.lower() in (".cgns", ".foam", *VTK_READERS) else [path, name + ".nmf"]


def require_folder(path):
    folder = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(folder):
        raise Error(f"{path}: there is no folder {folder}")


def write(path, volume, samples, properties):
    """Writes by the ending of `path`. @param samples a function of no argument that gives the sampled mesh"""
    name, exact = writer_of(path)
    library = BSplineVolumeWriters if hasattr(BSplineVolumeWriters, name) else importlib.import_module("vtkmodules.vtkIOParallelXML")
    writer = getattr(library, name)()
    writer.SetFileName(os.fspath(path))
    set_properties(writer, properties)
    connect(writer.SetInputConnection, volume if exact else samples())
    return run(writer)


def filter_named(name):
    """A filter of this package by its class name."""
    return getattr(BSplineVolumeFilters, name)()
