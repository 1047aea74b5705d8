# SPDX-License-Identifier: BSD-3-Clause
"""Runs an example script and checks that it wrote a picture with something in it.

Arguments: pvpython, the script, the picture, further arguments of the script.
"""
import collections
import os
import subprocess
import sys

from vtkmodules.vtkIOImage import vtkPNGReader


def main(pvpython, script, picture, *arguments):
    if os.path.exists(picture):
        os.remove(picture)
    subprocess.run([pvpython, script, "--plugin", os.environ["BSV_PLUGIN"], "--output", picture, *arguments],
                   check=True, timeout=240)
    reader = vtkPNGReader()
    reader.SetFileName(picture)
    reader.Update()
    width, height, _ = reader.GetOutput().GetDimensions()
    assert width == 1200 and height >= 500, (width, height)
    pixels = reader.GetOutput().GetPointData().GetScalars()
    # In every quarter: white around something with lines, shades and letters.
    quarters = [collections.Counter() for _ in range(4)]
    for y in range(0, height, 3):
        for x in range(0, width, 3):
            quarters[(x >= width // 2) + 2 * (y >= height // 2)][pixels.GetTuple(x + width * y)] += 1
    for colors in quarters:
        assert len(colors) > 50, len(colors)
    whole = sum(quarters, collections.Counter())
    assert whole[255.0, 255.0, 255.0] > 0.02 * sum(whole.values())


if __name__ == "__main__":
    main(*sys.argv[1:])
