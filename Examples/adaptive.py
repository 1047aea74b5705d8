# SPDX-License-Identifier: BSD-3-Clause
"""Refinement at walls alone, against refinement everywhere: the same first cells at the wall, far fewer cells.

Sample runs (without a display each starts one in memory):
    pvpython Examples/adaptive.py                           the wing source, level 2 of everything and of the wall
    pvpython Examples/adaptive.py --mesh wing.xyz --level 1

Left the samples at a level, right those of level 0 whose spans at walls are cut as finely in the direction off the wall.
Both are one structured grid per block without hanging nodes. Every wall point of the right mesh is one of the left, and
the cell on it has the same height to the last bit, which this script checks. Shown are wall and symmetry plane.
"""
import sys

import numpy as np
from paraview import simple as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from example_support import (boundary_patches, bounds, convert, data, grids, load_plugin, look, matches, parser, points,
                             read_mesh, save, show, strings, surface, views)

HEIGHT = 600


def first_heights(collection, patterns):
    """Height of the first cell at every point of the walls."""
    names = strings(collection.GetFieldData(), "BoundaryNames")
    blocks = [grid for _, grid in grids(collection)]
    heights = {}
    for row in vtk_to_numpy(collection.GetFieldData().GetArray("Boundaries")):
        if row[2] >= 0 and matches(names[row[2]], patterns):
            direction, side = divmod(row[1], 2)
            layer = [np.take(points(blocks[row[0]]), -1 - n if side else n, axis=2 - direction).reshape(-1, 3)
                     for n in (0, 1)]
            # Where two walls meet, a point has a cell of each.
            for point, height in zip(map(tuple, layer[0]), np.linalg.norm(layer[1] - layer[0], axis=1)):
                heights.setdefault(point, set()).add(height)
    return heights


def main():
    arguments = parser(__doc__.split("\n")[0], "adaptive.png")
    arguments.add_argument("--level", type=int, default=2, help="level at the walls (default: 2)")
    arguments.add_argument("--resolution", type=int, default=4, help="resolution of the wing source (default: 4)")
    arguments = arguments.parse_args()
    if arguments.mesh:
        mesh = read_mesh(arguments)
    else:
        load_plugin(arguments.plugin)
        mesh = pv.WingFuselageSource(Resolution=arguments.resolution)
    volume = convert(mesh, arguments)
    walls, planes = list(volume.BodyBoundaries), list(volume.SymmetryBoundaries)
    meshes = [pv.BSplineVolumeSampler(Input=volume, Level=arguments.level),
              pv.BSplineVolumeSampler(Input=volume, Level=0, WallLevel=arguments.level)]
    cells = [data(mesh).GetNumberOfElements(1) for mesh in meshes]
    heights = [first_heights(data(mesh), walls) for mesh in meshes]
    if not heights[1]:
        sys.exit("The mesh has no walls; name them with --body")
    for point, own in heights[1].items():
        if not own <= heights[0].get(point, set()):
            sys.exit("A first cell differs at %s: %s, not %s" % (point, own, heights[0].get(point)))
    everywhere = np.array([height for own in heights[1].values() for height in own])
    print("level %d everywhere: %d cells; at walls alone: %d cells, %.0f times fewer" % (
        arguments.level, cells[0], cells[1], cells[0] / cells[1]))
    print("first cells at %d wall points: the same heights, %.3g to %.3g" % (
        len(heights[1]), everywhere.min(), everywhere.max()))

    layout, windows = views(["level %d everywhere: %s cells" % (arguments.level, format(cells[0], ",")),
                             "level 0, wall level %d: %s cells" % (arguments.level, format(cells[1], ","))], HEIGHT)
    for view, mesh in zip(windows, meshes):
        patches = list(boundary_patches(data(mesh)))
        wall = surface([patch for patch in patches if matches(patch.name, walls)])
        box = np.array(bounds(wall)).reshape(3, 2)
        style = {"representation": "Surface With Edges", "EdgeColor": [0.33, 0.38, 0.48], "Ambient": 0.35, "Diffuse": 0.65}
        show(wall, view, "#f0c896", **style)
        near = [patch for patch in patches if matches(patch.name, planes)]
        if near:
            part = pv.Clip(Input=surface(near), ClipType="Sphere", Crinkleclip=1, Invert=1)
            part.ClipType.Center = box.mean(axis=1)
            part.ClipType.Radius = 0.45 * np.linalg.norm(box[:, 1] - box[:, 0])
            show(part, view, "#e6ebf1", **style)
        look(view, box.ravel(), [-0.5, -1.0, 0.35], zoom=1.5)
    save(arguments.output, layout, HEIGHT)


if __name__ == "__main__":
    main()
