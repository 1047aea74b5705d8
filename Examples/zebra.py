# SPDX-License-Identifier: BSD-3-Clause
"""Reflection lines over extraordinary vertices of the wall: single knots beside exact G1.

Sample run (without a display it starts one in memory):
    pvpython Examples/zebra.py

Above, the leading edge at the tip of the wing-fuselage source's wing; below, an L-shaped body, where five blocks meet in the corner. Where the
normals jump the lines break, where the curvature jumps they bend.
"""
import itertools
import os
import tempfile

import numpy as np
from paraview import simple as pv

from example_support import (body_patches, bounds, data, load_plugin, look, parser, save, show, stripes, surface, views,
                             wall_angles)

HEIGHT = 900
STRIPE = 2.0  # degrees
RULE = 6  # of control points at extraordinary vertices of the body, see ControlPointRule
L_CELLS = ((0, 0), (1, 0), (0, 1))


def parse_arguments():
    return parser(__doc__.split("\n")[0], "zebra.png", mesh=False).parse_args()


def write_l_shape(folder, cells=4, layers=4):
    """PLOT3D and neutral map of the outside of an L of three cubes, halfway to a ball; one block per square of its
    surface, with the wall at k = 1."""
    middle = np.array([0.75, 0.75, 0.5])
    blocks = []
    for (x, y), axis, side in itertools.product(L_CELLS, range(3), (0, 1)):
        beyond = [x, y]
        if axis < 2:
            beyond[axis] += 2 * side - 1
            if tuple(beyond) in L_CELLS:
                continue
        first, second = [(axis + 1) % 3, (axis + 2) % 3][::2 * side - 1]
        block = np.empty((layers + 1, cells + 1, cells + 1, 3))
        t = np.arange(cells + 1) / cells
        for k in range(layers + 1):
            point = np.empty((cells + 1, cells + 1, 3))
            point[..., axis], point[..., first], point[..., second] = side, t[None, :], t[:, None]
            point += np.array([x, y, 0]) - middle
            ball = 1.2 * point / np.linalg.norm(point, axis=-1, keepdims=True)
            block[k] = (0.5 * point + 0.5 * ball) * (1.0 + 0.12 * k)
        blocks.append(block)
    path = os.path.join(folder, "l_shape.xyz")
    size = "%d %d %d\n" % (cells + 1, cells + 1, layers + 1)
    with open(path, "w") as out:
        out.write("%d\n" % len(blocks) + len(blocks) * size)
        for block in blocks:
            for d in range(3):
                out.write("\n".join(map(repr, block[..., d].ravel().tolist())) + "\n")
    with open(os.path.join(folder, "l_shape.nmf"), "w") as out:
        out.write("%d\n" % len(blocks) + "".join("%d %s" % (b + 1, size) for b in range(len(blocks))))
        for b in range(len(blocks)):
            for face, name in ((1, "WALL"), (2, "FARFIELD")):
                out.write("'%s' %d %d  1 %d 1 %d\n" % (name, b + 1, face, cells + 1, cells + 1))
    return path


def extraordinary_points(volume):
    points = [patch.points[patch.rules == RULE] for patch in body_patches(data(volume), list(volume.BodyBoundaries))]
    return np.concatenate(points)


def main():
    arguments = parse_arguments()
    load_plugin(arguments.plugin)
    wing = pv.WingFuselageSource(Resolution=3)
    with tempfile.TemporaryDirectory() as folder:
        l_shape = pv.HexBlockMeshReader(FileName=write_l_shape(folder))
        l_shape.UpdatePipeline()
    # Mesh, its body, the extraordinary vertex by its least value of a function, the direction to look from, how much
    # of the body is drawn around it, zoom.
    cases = ((wing, {"Body": pv.OutputPort(wing, 1)}, lambda p: p[:, 0], (-1.0, 0.8, 0.5), 0.02, 2.3),
             (l_shape, {}, lambda p: np.linalg.norm(p - [0.25, 0.25, 0.6], axis=1), (0.5, 0.5, 1.0), 0.09, 1.6))
    layout, windows = views(("wing tip, single knots", "wing tip, exact G1", "L-shaped body, single knots",
                             "L-shaped body, exact G1"), HEIGHT, rows=2)
    views_of = iter(windows)
    for mesh, properties, least, towards, part, zoom in cases:
        center = None
        for continuity in ("SingleKnots", "ExactG1"):
            volume = pv.CatmullClarkToBSplineVolume(Input=mesh, Continuity=continuity, **properties)
            if center is None:
                vertices = extraordinary_points(volume)
                center = vertices[np.argmin(least(vertices))]
            whole = np.array(bounds(surface(body_patches(data(volume), list(volume.BodyBoundaries))))).reshape(3, 2)
            radius = part * np.linalg.norm(whole[:, 1] - whole[:, 0])
            # Light from a direction along which the stripes cross the vertex.
            light = np.cross(towards, (0.3, -0.2, 1.0))
            view = next(views_of)
            show(wall_angles(volume, light, center, radius), view, array=("POINTS", "Angle"))
            look(view, np.stack([center - radius, center + radius], axis=1).ravel(), towards, zoom=zoom)
    stripes(windows, STRIPE)
    save(arguments.output, layout, HEIGHT)


if __name__ == "__main__":
    main()
