# SPDX-License-Identifier: BSD-3-Clause
"""Plays recorded events in ParaView's window and checks the files that it saved.

Arguments: the paraview program, the plugin's folder, a folder for the files, the name of the recording.
"""
import csv
import math
import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "Examples"))
import bsplinevolume
import make_body_case
import make_demo_mesh
from vtkmodules.vtkIOImage import vtkPNGReader


def converted(mesh, body=None):
    """The volume of the mesh file, made without the window."""
    reader = bsplinevolume.vtkHexBlockMeshReader()
    reader.SetFileName(mesh)
    convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    convert.SetInputConnection(reader.GetOutputPort())
    if body:
        convert.SetInputConnection(1, body.GetOutputPort())
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


def clicks(recording):
    """Events of each part of a recording after a comment "what: most clicks", and how many there may be."""
    with open(os.path.join(HERE, recording + ".xml")) as file:
        parts = re.split(r"<!-- ([^:>]*): (\d+) -->", file.read())
    return {parts[n]: (parts[n + 2].count("<pqevent "), int(parts[n + 1])) for n in range(1, len(parts), 3)}


def check_Jobs(mesh, folder):
    counted = clicks("Jobs")
    assert all(0 < count <= most for count, most in counted.values()), counted
    print("clicks:", {job: count for job, (count, _) in counted.items()})
    # The export is the conversion with the body.
    body = bsplinevolume.vtkNURBSSurfaceReader()
    body.SetFileName(os.path.join(folder, "ellipsoid.g2"))
    volume = converted(os.path.join(folder, "ellipsoid.xyz"), body)
    assert compare(volume, os.path.join(folder, "body.qfmb")) == 6
    # The camera looks at the place where the first join of the list is worst.
    smoothness = bsplinevolume.vtkBSplineVolumeSmoothness()
    smoothness.SetInputConnection(volume.GetOutputPort())
    smoothness.Update()
    worst = smoothness.GetOutputDataObject(4).GetCellData().GetArray("Where").GetTuple(0)
    state = ElementTree.parse(os.path.join(folder, "worst.pvsm"))
    looked_at = [[float(element.get("value")) for element in prop.iter("Element")]
                 for proxy in state.iter("Proxy") if proxy.get("type") == "RenderView"
                 for prop in proxy.iter("Property") if prop.get("name") == "CameraFocalPoint"]
    assert len(looked_at) == 1 and math.dist(looked_at[0], worst) < 1e-6, (looked_at, worst)


def check_WingFuselage(_mesh, folder):
    # The window has chosen the only body that there is.
    source = bsplinevolume.vtkWingFuselageSource()
    convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    convert.SetInputConnection(source.GetOutputPort(0))
    convert.SetInputConnection(1, source.GetOutputPort(1))
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
        # The axes in the lower left corner have a red x, the legend at the right has all colours.
        if n % width < 0.2 * width and n // width < 0.25 * height or n % width > 0.9 * width:
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
    make_body_case.write_case(folder, 4)
    subprocess.run([paraview, "--dr", "--plugin-search-paths=" + plugin_folder, "--plugins=BSplineVolume",
                    "--test-directory=" + folder, "--test-script=" + os.path.join(HERE, recording + ".xml"), "--exit"],
                   check=True, timeout=240, env=dict(os.environ, HOME=folder, XDG_RUNTIME_DIR=folder))
    globals()["check_" + recording](mesh, folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
