# SPDX-License-Identifier: BSD-3-Clause
"""Plays the steps of docs/tutorial.md in ParaView's window and photographs them: what one sees is what the page shows.

Arguments: the paraview program, the plugin's folder, a folder for the pictures. The page's pictures are of ParaView 5.11; of
another version it is only checked that all are taken.
"""
import os
import re
import subprocess
import sys

import numpy as np
from paraview import servermanager
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

HERE = os.path.dirname(os.path.abspath(__file__))
DOCS = os.path.join(HERE, "..", "..", "docs")
# Lines move by a pixel with the renderer's version and the processor; a mesh, a legend or a panel more is some percent.
SAME_COLOUR = 48
MOST_DIFFERENT = 0.02


def pixels(path):
    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[..., :3].astype(int)


def difference(taken, shown):
    """The part of the pixels that have another colour."""
    return (np.abs(pixels(taken) - pixels(shown)).max(axis=-1) > SAME_COLOUR).mean()


def main(paraview, plugin, folder):
    with open(os.path.join(DOCS, "tutorial.md"), encoding="utf-8") as file:
        names = re.findall(r"\]\(gui/(\w+)\.png\)", file.read())
    assert len(names) >= 5, names
    same_version = servermanager.vtkSMProxyManager.GetVersionMajor() == 5 and \
        servermanager.vtkSMProxyManager.GetVersionMinor() == 11
    wanted = names
    # A picture that a busy machine took before all was drawn is taken again.
    for _ in range(2):
        subprocess.run(["pvpython", os.path.join(HERE, "Screenshots.py"), paraview, plugin, folder, *wanted], check=True)
        differences = {name: difference(os.path.join(folder, name + ".png"), os.path.join(DOCS, "gui", name + ".png"))
                       for name in wanted} if same_version else {}
        print({name: "%.2f %%" % (100 * value) for name, value in differences.items()}, flush=True)
        wanted = [name for name, value in differences.items() if value > MOST_DIFFERENT]
        if not wanted:
            return
    sys.exit("docs/gui/ no longer shows what the window does: %s; the pictures in %s" % (wanted, folder))


if __name__ == "__main__":
    main(*sys.argv[1:])
