# SPDX-License-Identifier: BSD-3-Clause
"""Plays ConvertAndSave.xml in ParaView's window and checks the file that it saved.

Arguments: the paraview program, the plugin's folder, an empty folder for the files.
"""
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "Examples"))
import bsplinevolume
import make_demo_mesh


def main(paraview, plugin_folder, folder):
    shutil.rmtree(folder, ignore_errors=True)
    mesh = make_demo_mesh.write_demo(folder, 4)
    saved = os.path.join(folder, "demo.qfmb")

    subprocess.run([paraview, "--dr", "--plugin-search-paths=" + plugin_folder, "--plugins=BSplineVolume",
                    "--test-directory=" + folder, "--test-script=" + os.path.join(HERE, "ConvertAndSave.xml"), "--exit"],
                   check=True, timeout=240, env=dict(os.environ, HOME=folder, XDG_RUNTIME_DIR=folder))

    # The same without the window.
    reader = bsplinevolume.vtkHexBlockMeshReader()
    reader.SetFileName(mesh)
    convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    convert.SetInputConnection(reader.GetOutputPort())
    convert.Update()
    reread = bsplinevolume.vtkQuadflowReader()
    reread.SetFileName(saved)
    reread.Update()
    expected, found = convert.GetOutputDataObject(0), reread.GetOutputDataObject(0)
    count = expected.GetNumberOfPartitionedDataSets()
    assert count >= 11 and found.GetNumberOfPartitionedDataSets() == count
    for block in range(count):
        points = [bytes(memoryview(data.GetPartition(block, 0).GetPoints().GetData())) for data in (expected, found)]
        assert points[0] == points[1], "block %d differs" % block


if __name__ == "__main__":
    main(*sys.argv[1:])
