# SPDX-License-Identifier: BSD-3-Clause
"""Shows how smoothly the blocks of a B-spline volume join.

Sample runs (without a display each starts one in memory):
    pvpython Examples/smoothness.py                             a generated demonstration mesh
    pvpython Examples/smoothness.py --mesh wing.xyz --crease-angle 30

Left the blocks, moved apart, in the colour of their worst join; right the interfaces themselves, point by point, with
the extraordinary curves as tubes. The jump is the angle between the layers on both sides, where they need not kink;
around the edges of the demonstration's box the layers along its sides turn by 90 degrees.
"""
import numpy as np
from paraview import simple as pv

from example_support import (bounds, color_range, convert, data, grids, legend, look, parser, producer, read_mesh, save,
                             show, views)

HEIGHT = 620
APART = 0.35  # how far the blocks move from the centre, as a fraction of their distance from it


def moved_apart(smoothness):
    """One source per block."""
    skins = [skin for _, skin in grids(data(smoothness, 1))]
    centers = np.array([np.reshape(skin.GetBounds(), (3, 2)).mean(axis=1) for skin in skins])
    for skin, center in zip(skins, centers):
        move = pv.Transform(Input=producer(skin))
        move.Transform.Translate = list(APART * (center - centers.mean(axis=0)))
        yield move


def main():
    arguments = parser(__doc__.split("\n")[0], "smoothness.png").parse_args()
    volume = convert(read_mesh(arguments), arguments)
    smoothness = pv.BSplineVolumeSmoothness(Input=volume)
    table = data(smoothness, 2)
    print("worst join: %s and %s: %s, %s" % tuple(table.GetValueByName(0, name).ToString() for name in
                                                 ("NameA", "NameB", "Continuity", "RankedBy")))

    layout, (left, right) = views(("blocks by their worst join", "interfaces and extraordinary curves"), HEIGHT)
    towards = (0.8, -1.0, 0.7)
    for block in moved_apart(smoothness):
        show(block, left, array=("CELLS", "LayerJump"))
    look(left, (1.0 + APART) * np.array(bounds(smoothness, 1)), towards, zoom=0.97)

    show(pv.OutputPort(smoothness, 0), right, array=("POINTS", "LayerJump"))
    look(right, bounds(smoothness, 1), towards, zoom=0.97)
    extent = np.ptp(np.array(bounds(smoothness, 1)).reshape(3, 2), axis=1).max()
    curves = pv.Threshold(Input=pv.OutputPort(smoothness, 3), Scalars=["CELLS", "Kind"], LowerThreshold=0,
                          UpperThreshold=0)
    show(pv.Tube(Input=pv.ExtractSurface(Input=curves), Radius=0.006 * extent, Scalars=[None, ""]), right, "#202020")

    smoothness.UpdatePropertyInformation()
    color_range("LayerJump", 0.0, max(smoothness.MaximumLayerJump, 1e-3))
    for view in (left, right):
        legend("LayerJump", view, "jump of the layers, degrees")
    save(arguments.output, layout, HEIGHT)


if __name__ == "__main__":
    main()
