# SPDX-License-Identifier: BSD-3-Clause
"""Plays recorded events in ParaView's window and checks the files that it saved.

Arguments: the paraview program, the plugin's folder, a folder for the files, the name of the recording.
"""
import csv
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "Examples"))
import bsplinevolume
import make_demo_mesh
from vtkmodules.vtkIOImage import vtkPNGReader


def converted(mesh):
    """The volume of the mesh file, made without the window."""
    reader = bsplinevolume.vtkHexBlockMeshReader()
    reader.SetFileName(mesh)
    convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    convert.SetInputConnection(reader.GetOutputPort())
    convert.Update()
    return convert


def compare(convert, topology):
    """The saved topology must hold the volume, bit for bit. Returns the number of blocks."""
    reread = bsplinevolume.vtkQuadflowReader()
    reread.SetFileName(topology)
    reread.Update()
    expected, found = convert.GetOutputDataObject(0), reread.GetOutputDataObject(0)
    count = expected.GetNumberOfPartitionedDataSets()
    assert found.GetNumberOfPartitionedDataSets() == count
    for block in range(count):
        points = [bytes(memoryview(data.GetPartition(block, 0).GetPoints().GetData())) for data in (expected, found)]
        assert points[0] == points[1], "block %d differs" % block
    return count


def check_ConvertAndSave(mesh, folder):
    assert compare(converted(mesh), os.path.join(folder, "demo.qfmb")) >= 11


def check_WingFuselage(_mesh, folder):
    source = bsplinevolume.vtkWingFuselageSource()
    convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    convert.SetInputConnection(source.GetOutputPort(0))
    convert.Update()
    assert compare(convert, os.path.join(folder, "wing.qfmb")) == 79


def check_Inspect(mesh, folder):
    # All spans are valid: the body is to be seen as a green ghost, and no red span.
    reader = vtkPNGReader()
    reader.SetFileName(os.path.join(folder, "quality.png"))
    reader.Update()
    pixels = reader.GetOutput().GetPointData().GetScalars()
    width, height = reader.GetOutput().GetDimensions()[:2]
    ghost = red = 0
    for n in range(0, pixels.GetNumberOfTuples(), 7):
        # The axes in the lower left corner have a red x.
        if n % width < 0.2 * width and n // width < 0.25 * height:
            continue
        r, g, b = pixels.GetTuple(n)[:3]
        ghost += g > r + 12 and g > b + 12
        red += r > 180 and g < 60 and b < 60
    assert ghost > 0.03 * pixels.GetNumberOfTuples() / 7 and red == 0, (ghost, red)

    # The table is that of the filter, the worst join first.
    smoothness = bsplinevolume.vtkBSplineVolumeSmoothness()
    volume = converted(mesh)
    smoothness.SetInputConnection(volume.GetOutputPort())
    smoothness.Update()
    joins = smoothness.GetOutputDataObject(2)
    with open(os.path.join(folder, "joins.csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == joins.GetNumberOfRows() > 0
    for row, found in enumerate(rows):
        for name in ("Continuity", "Kind", "NameA", "NameB"):
            assert found[name] == joins.GetColumnByName(name).GetValue(row), (row, name)
        expected = joins.GetColumnByName("MaximumLayerJump").GetValue(row)
        assert abs(float(found["MaximumLayerJump"]) - expected) <= 1e-4 * max(expected, 1), row  # five digits written


def main(paraview, plugin_folder, folder, recording):
    shutil.rmtree(folder, ignore_errors=True)
    mesh = make_demo_mesh.write_demo(folder, 4)
    subprocess.run([paraview, "--dr", "--plugin-search-paths=" + plugin_folder, "--plugins=BSplineVolume",
                    "--test-directory=" + folder, "--test-script=" + os.path.join(HERE, recording + ".xml"), "--exit"],
                   check=True, timeout=240, env=dict(os.environ, HOME=folder, XDG_RUNTIME_DIR=folder))
    globals()["check_" + recording](mesh, folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
