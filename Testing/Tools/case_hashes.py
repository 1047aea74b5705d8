# SPDX-License-Identifier: BSD-3-Clause
"""Prints a hash of the results of every case, to compare two builds bit for bit.

    pvpython Testing/Tools/case_hashes.py PLUGIN.so [FOLDER_OF_REAL_MESHES] > hashes.txt

A line is: case, options, then hashes of control points, of rules, of samples at level 1, and of the `.qfmb` file, or the
error. Run it with both plugins and compare the two texts with diff. Cases are generated ones (wing source at three
resolutions, with and without its body), and, with the folder, all meshes in its `structured`.
"""
import hashlib
import os
import sys
import tempfile

from paraview import simple

simple.LoadPlugin(os.path.abspath(sys.argv[1]), remote=False, ns=simple.__dict__)
from vtkmodules.util.numpy_support import vtk_to_numpy  # noqa: E402
from vtkmodules.vtkCommonCore import vtkSMPTools  # noqa: E402

vtkSMPTools.SetBackend("STDThread")

OPTIONS = [
    {},
    {"UseCreaseAngle": 1},
    {"UseCreaseAngle": 1, "CreaseAngle": 60.0},
    {"PlanarSides": "All"},
    {"PlanarSides": "None"},
    {"Continuity": "ExactG1"},
    {"Continuity": "ExactG1", "UseCreaseAngle": 1, "CreaseAngle": 30.0},
    {"Continuity": "ExactG1", "Twist": "PCCM"},
    {"Twist": "Parallelogram"},
    {"Twist": "Mask"},
    {"WallSpacingMode": "Automatic", "FarFieldSpacing": "PerVertex"},
    {"WallSpacing": 0.8, "PropagationRange": 3.0},
]
BODY_OPTIONS = [
    {"InputPoints": "ControlNet"},
    {"InputPoints": "OnBody"},
    {"InputPoints": "OnBody", "UseCreaseAngle": 1, "CreaseAngle": 30.0},
    {"InputPoints": "OnBody", "WallSpacingMode": "Automatic"},
    {"InputPoints": "OnBody", "Continuity": "ExactG1"},
]


def client(proxy):
    return proxy.SMProxy.GetClientSideObject()


def leaves(collection):
    return [collection.GetPartition(b, 0) for b in range(collection.GetNumberOfPartitionedDataSets())]


def digest(arrays):
    total = hashlib.sha256()
    for array in arrays:
        total.update(vtk_to_numpy(array).tobytes())
    return total.hexdigest()[:12]


def run(name, mesh, options, body=None):
    """Converts `mesh` and prints the line of this case."""
    errors = []
    arguments = dict(options)
    if body is not None:
        arguments["Body"] = body
    volume = simple.CatmullClarkToBSplineVolume(Input=mesh, **arguments)
    algorithm = client(volume)
    algorithm.AddObserver("WarningEvent", lambda *_: None)

    def note(_algorithm, _event, text):
        errors.append(text.strip().split("): ", 1)[-1].split("\n")[0])

    note.CallDataType = "string0"
    algorithm.AddObserver("ErrorEvent", note)
    algorithm.GetExecutive().AddObserver("ErrorEvent", lambda *_: None)
    volume.UpdatePipeline()
    label = name + " " + " ".join(f"{key}={value}" for key, value in sorted(options.items()))
    if errors:
        print(label, "ERROR", errors[0])
    else:
        blocks = leaves(algorithm.GetOutputDataObject(0))
        fields = [digest([block.GetPoints().GetData() for block in blocks]),
                  digest([block.GetPointData().GetArray("ControlPointRule") for block in blocks])]
        samples = simple.BSplineVolumeSampler(Input=volume, Level=1)
        samples.UpdatePipeline()
        fields.append(digest([block.GetPoints().GetData() for block in leaves(client(samples).GetOutputDataObject(0))]))
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "case.qfmb")
            simple.SaveData(file, proxy=volume)
            if os.path.exists(file):
                with open(file, "rb") as stream:
                    fields.append(hashlib.sha256(stream.read()).hexdigest()[:12])
            else:
                fields.append("not-written")
        simple.Delete(samples)
        print(label, len(blocks), *fields)
    sys.stdout.flush()
    simple.Delete(volume)


for resolution in (3, 6, 8):
    source = simple.WingFuselageSource(Resolution=resolution)
    for options in OPTIONS:
        run(f"wing{resolution}", source, options)
    for options in BODY_OPTIONS:
        run(f"wing{resolution}+body", source, options, simple.OutputPort(source, 1))
if len(sys.argv) > 2:
    folder = os.path.join(sys.argv[2], "structured")
    for file in sorted(os.listdir(folder)):
        reader = simple.HexBlockMeshReader(FileName=os.path.join(folder, file))
        for options in OPTIONS[:2] if file == "n0012.cgns" else OPTIONS:
            run(file, reader, options)
    tip = simple.HexBlockMeshReader(FileName=os.path.join(folder, "near_tip_vol.xyz"))
    body = simple.NURBSSurfaceReader(FileName=os.path.join(sys.argv[2], "surfaces", "onera_m6_machaero.igs"))
    for options in BODY_OPTIONS:
        run("near_tip+M6", tip, dict(options, BodyFaces=[n for block in range(11) for n in (block, 4)]), body)
