# SPDX-License-Identifier: BSD-3-Clause
"""The command bsplinevolume as a program, with the calls of ./convert.sh: all files of a folder, each read back.

Arguments: the command, a folder.
"""
import base64
import os
import re
import subprocess
import sys

import bsplinevolume as bsv
from vtkmodules.vtkIOXML import vtkXMLPartitionedDataSetCollectionReader

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def run(*words, status=0):
    """What the command says, on both streams."""
    result = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert result.returncode == status, (words, result.returncode, result.stdout)
    return result.stdout


def collection(path):
    reader = vtkXMLPartitionedDataSetCollectionReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutputDataObject(0)


def points(data):
    return [bytes(memoryview(data.GetPartition(n, 0).GetPoints().GetData()))
            for n in range(data.GetNumberOfPartitionedDataSets())]


def main(command, folder):
    mesh = run("python3", os.path.join(ROOT, "Examples", "make_demo_mesh.py"), folder).strip()
    said = run(command, "convert", "--output", folder + os.sep, "--level", "0", mesh, "--crease-angle", "30")
    files = {os.path.basename(path): path for path in re.findall("^written: (.*)$", said, re.M)}
    assert sorted(files) == ["demo.html", "demo.qfmb", "demo_after.vtpc", "demo_before.vtpc", "demo_samples.vtpc"], said
    volume = bsv.convert(mesh, UseCreaseAngle=True, CreaseAngle=30, CheckJoins=True)
    assert said.startswith(volume.report), said
    net = points(volume.to_vtk())
    for name in "demo.qfmb", "demo_after.vtpc":
        again = bsv.read(files[name])
        assert points(again.to_vtk()) == net and again.quality() == volume.quality()
    assert points(collection(files["demo_samples.vtpc"])) == points(volume.sampled(0))
    reader = bsv.vtkHexBlockMeshReader()
    reader.SetFileName(mesh)
    reader.Update()
    assert points(collection(files["demo_before.vtpc"])) == points(reader.GetOutputDataObject(0))
    # A file of VTK's is a mesh like any other.
    assert "written" in run(command, "convert", files["demo_before.vtpc"], "--output", os.path.join(folder, "again.qfmb"),
                            "--crease-angle", "30")
    assert points(bsv.read(os.path.join(folder, "again.qfmb")).to_vtk()) == net
    with open(files["demo.html"], encoding="utf-8") as file:
        pictures = re.findall(r"data:image/png;base64,([^']+)", file.read())
    assert len(pictures) == 4 and all(base64.b64decode(p).startswith(b"\x89PNG") for p in pictures)

    for file in mesh, files["demo_after.vtpc"]:
        assert "0 invalid" in run(command, "check", file)
    assert run(command, "--version").strip() == bsv.__version__
    # An empty word, as of an unset variable of a shell, is a word.
    assert "spans proven valid" in run(command, "check", mesh, "--body", "")
    missing = run(command, "check", os.path.join(folder, "missing.xyz"), status=3)
    assert missing.count("\n") == 1 and "missing.xyz does not exist" in missing, missing


if __name__ == "__main__":
    main(*sys.argv[1:])
