# SPDX-License-Identifier: BSD-3-Clause
"""Runs the readers, filters and writers of this package from plain Python: values in, values out, errors as exceptions."""
import os

from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkTrivialProducer

from . import BSplineVolumeFilters, BSplineVolumeReaders, BSplineVolumeWriters


class Error(RuntimeError):
    """What a reader, filter or writer reports, in its own words."""


def set_properties(algorithm, properties):
    """Sets `Name=value` by SetName(value). A list goes to ClearNames() and AddName(item), a word to SetNameToWord()."""
    for name, value in properties.items():
        if isinstance(value, (list, tuple)) and not hasattr(algorithm, "Set" + name):
            singular = name[:-3] + "y" if name.endswith("ies") else name[:-1] if name.endswith("s") else name
            adder = getattr(algorithm, "Add" + singular, None)
            clearer = getattr(algorithm, "Clear" + name, None) or getattr(algorithm, "Clear" + name + "s", None)
            if adder is None or clearer is None:
                raise TypeError(f"{algorithm.GetClassName()} has no property {name}")
            clearer()
            for item in value:
                adder(*item) if isinstance(item, (list, tuple)) else adder(item)
            continue
        setter = getattr(algorithm, "Set" + name, None)
        if setter is None:
            raise TypeError(f"{algorithm.GetClassName()} has no property {name}")
        if isinstance(value, str) and hasattr(algorithm, f"Set{name}To{value}"):
            getattr(algorithm, f"Set{name}To{value}")()
        else:
            setter(value)


def run(algorithm, progress=None):
    """Updates `algorithm`; returns the warnings of it and of all that it reads from.

    @param progress called with the fraction done; returns False to stop
    @throws Error with the first message
    """
    errors, warnings, observed = [], [], []

    def listen(one):
        for event, texts in (("ErrorEvent", errors), ("WarningEvent", warnings)):
            def note(_object, _event, text, texts=texts):
                texts.append(text.strip().split("): ", 1)[-1].strip())
            note.CallDataType = "string0"
            observed.append((one, one.AddObserver(event, note)))
        silent = one.GetExecutive()
        observed.append((silent, silent.AddObserver("ErrorEvent", lambda *_: None)))
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
    if errors:
        raise Error(errors[0])
    return warnings


def source_of(data, reader_classes=None):
    """A producer of `data`: an algorithm, a data object, or the path of a file."""
    if isinstance(data, vtkAlgorithm):
        return data
    if hasattr(data, "to_vtk"):
        data = data.to_vtk()
    if isinstance(data, (str, os.PathLike)):
        path = os.fspath(data)
        if not os.path.exists(path):
            raise Error(path + " does not exist")
        for name in reader_classes:
            reader = getattr(BSplineVolumeReaders, name)()
            if reader.CanReadFile(path):
                reader.SetFileName(path)
                return reader
        raise Error(path + " is no file that " + " or ".join(name[3:] for name in reader_classes) + " can read")
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


def write(path, volume, samples, properties):
    """Writes by the ending of `path`. @param samples a function of no argument that gives the sampled mesh"""
    ending = os.path.splitext(path)[1].lower()
    if ending not in WRITERS:
        raise Error(f"{path}: no writer for the ending '{ending}'; there are " + " ".join(sorted(WRITERS)))
    name, exact = WRITERS[ending]
    writer = getattr(BSplineVolumeWriters, name)()
    writer.SetFileName(os.fspath(path))
    set_properties(writer, properties)
    connect(writer.SetInputConnection, volume if exact else samples())
    return run(writer)


def filter_named(name):
    """A filter of this package by its class name."""
    return getattr(BSplineVolumeFilters, name)()
