# SPDX-License-Identifier: BSD-3-Clause
"""Valid in, valid out: prints how many spans of real meshes are not valid after the conversion, as a table.

    pvpython Testing/Tools/valid_spans.py PLUGIN.so FOLDER_OF_REAL_MESHES [PATTERN ...] > table.txt

All meshes in its `structured` and `hex` folders (or those whose names contain a pattern) are converted with all
combinations of crease angle off, 30, 60, Input Points ControlNet and OnBody, wall spacing constant and automatic; OnBody
and the spacing only where the mesh has a wall. Meshes that are refused, and files that are left out, are a line of their
own with the reason. A line is: mesh, options, blocks of the output, spans, of these not
valid although the filter says nothing about their mesh cells, repaired, and left invalid or undecided by the filter's own
report, largest distance of the wall from its mesh points, seconds. With a plugin that does not check spans itself the
middle columns are missing.
"""
import os
import sys
import time

from paraview import simple

simple.LoadPlugin(os.path.abspath(sys.argv[1]), remote=False, ns=simple.__dict__)
from vtkmodules.vtkCommonCore import vtkPoints, vtkSMPTools  # noqa: E402
from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON, vtkUnstructuredGrid  # noqa: E402

vtkSMPTools.SetBackend("STDThread")
# Cubes and other bodies that cannot interpolate their points, and meshes that are refused, are told as they are.
CREASES = [{}, {"UseCreaseAngle": 1, "CreaseAngle": 30.0}, {"UseCreaseAngle": 1, "CreaseAngle": 60.0}]
POINTS = [{"InputPoints": "ControlNet"}, {"InputPoints": "OnBody"}]
SPACINGS = [{}, {"WallSpacingMode": "Automatic"}]


def value(proxy, name):
    found = proxy.GetProperty(name)
    return None if found is None else found.GetData()


def errors_of(proxy):
    """A list that the errors of an algorithm go to."""
    errors = []

    def note(_algorithm, _event, text):
        errors.append(text.strip().split("): ", 1)[-1].split("\n")[0])

    note.CallDataType = "string0"
    algorithm = proxy.SMProxy.GetClientSideObject()
    algorithm.AddObserver("WarningEvent", lambda *_: None)
    algorithm.AddObserver("ErrorEvent", note)
    algorithm.GetExecutive().AddObserver("ErrorEvent", lambda *_: None)
    return errors


def run(name, mesh, options, body=None):
    arguments = dict(options)
    if body is not None:
        arguments["Body"] = body
    volume = simple.CatmullClarkToBSplineVolume(Input=mesh, **arguments)
    errors = errors_of(volume)
    start = time.time()
    volume.UpdatePipeline()
    seconds = time.time() - start
    label = f"{name:28s} {' '.join(f'{k}={v}' for k, v in sorted(options.items()) if k != 'BodyFaces') or 'default':60s}"
    if errors:
        print(label, "ERROR", errors[0][:100])
    else:
        quality = simple.BSplineVolumeQuality(Input=volume)
        quality.SMProxy.GetClientSideObject().AddObserver("WarningEvent", lambda *_: None)
        quality.UpdatePipeline()
        volume.UpdatePropertyInformation()
        quality.UpdatePropertyInformation()
        bad = value(quality, "NumberOfInvalidSpans") + value(quality, "NumberOfUndecidedSpans")
        wall = [line for line in (value(volume, "Report") or "").split("\n") if line.startswith("converted wall off")]
        print(label, value(volume, "NumberOfBlocks"), "blocks", value(quality, "NumberOfSpans"), "spans", bad, "not valid",
              value(volume, "NumberOfRepairedSpans"), "repaired", value(volume, "NumberOfInvalidSpans"), "+",
              value(volume, "NumberOfUndecidedSpans"), "left",
              wall[0].split("at most ")[1].split(",")[0] if wall else "-", "off", f"{seconds:.2f} s")
        simple.Delete(quality)
    sys.stdout.flush()
    simple.Delete(volume)


def combinations(name, mesh, wall, body=None, extra=None):
    errors = errors_of(mesh)
    mesh.UpdatePipeline()
    if errors:
        print(f"{name:28s} REFUSED {errors[0][:200]}", flush=True)
        return
    for crease in CREASES:
        for points in POINTS if wall else POINTS[:1]:
            for spacing in SPACINGS if wall else SPACINGS[:1]:
                run(name, mesh, dict(extra or {}, **crease, **points, **spacing), body)


def mfem_hexahedra(path):
    """The hexahedra of an `MFEM mesh v1.0` with straight edges."""
    with open(path) as file:
        words = [word for line in file for word in line.split("#")[0].split()]

    def section(name):
        at = words.index(name)
        return int(words[at + 1]), iter(words[at + 2:])

    grid, points = vtkUnstructuredGrid(), vtkPoints()
    points.SetDataTypeToDouble()
    count, rest = section("vertices")
    assert next(rest) == "3", "curved, or not in space"
    for _ in range(count):
        points.InsertNextPoint([float(next(rest)) for _ in range(3)])
    grid.SetPoints(points)
    count, rest = section("elements")
    for _ in range(count):
        assert (next(rest), next(rest))[1] == "5", "not only hexahedra"
        grid.InsertNextCell(VTK_HEXAHEDRON, 8, [int(next(rest)) for _ in range(8)])
    source = simple.TrivialProducer()
    source.SMProxy.GetClientSideObject().SetOutput(grid)
    return source


folder = sys.argv[2]
patterns = sys.argv[3:]


def chosen(file):
    return not patterns or any(pattern in file for pattern in patterns)


for resolution in (3, 6):
    if chosen(f"wing{resolution}"):
        source = simple.WingFuselageSource(Resolution=resolution)
        combinations(f"wing{resolution}", source, True)
        combinations(f"wing{resolution}+body", source, True, simple.OutputPort(source, 1))
for file in sorted(os.listdir(os.path.join(folder, "structured"))):
    if not chosen(file):
        continue
    if file.startswith(("sduct", "combxyz", "step_grdgen", "multi")):
        print(f"{file:28s} left out: refused or degenerate input, or a mesh of one cell across", flush=True)
    else:
        reader = simple.HexBlockMeshReader(FileName=os.path.join(folder, "structured", file))
        faces = [n for block in range(11) for n in (block, 4)] if file == "near_tip_vol.xyz" else None
        wall = faces is not None or file.endswith(".cgns") or os.path.exists(
            os.path.join(folder, "structured", file + ".nmf"))
        combinations(file, reader, wall, None, {"BodyFaces": faces} if faces else None)
for file in ("joint_hex_paper.vtk", "ant_hex_paper.vtk", "rod_hex_paper_used.vtk", "fichera.mesh", "beam-hex.mesh"):
    path = os.path.join(folder, "hex", file)
    if chosen(file) and not os.path.exists(path):
        print(f"{file:28s} left out: there is no such file", flush=True)
    elif chosen(file):
        source = simple.LegacyVTKReader(FileNames=[path]) if file.endswith(".vtk") else mfem_hexahedra(path)
        combinations(file, simple.HexMeshToBlocks(Input=source), False)
