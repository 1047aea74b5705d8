# SPDX-License-Identifier: BSD-3-Clause
"""Writes a mesh whose wall lies on a NURBS surface: an ellipsoid in the middle of a cubed sphere of six blocks.

Sample run:
    pvpython Examples/make_body_case.py body

The surface is exact, one rational biquadratic patch in a GoTools file; the eight corners of the cubed sphere, where
three blocks meet on the wall, are no special points of it.
"""
import math
import os
import sys

AXES = (1.6, 1.0, 0.6)


def write_body(path):
    """The ellipsoid: circles of four quarter arcs around the z axis, along a half circle of two."""
    half = math.sqrt(0.5)
    circle = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    meridian = [(0, -1), (1, -1), (1, 0), (1, 1), (0, 1)]
    with open(path, "w") as out:
        # Class 200 (spline surface), version 1.0; dimension, rational; then coefficients and order, and knots.
        out.write("200 1 0 0\n3 1\n9 3\n0 0 0 1 1 2 2 3 3 4 4 4\n5 3\n0 0 0 1 1 2 2 2\n")
        for b, (r, z) in enumerate(meridian):
            for a, (x, y) in enumerate(circle):
                weight = (half if a % 2 else 1.0) * (half if b % 2 else 1.0)
                point = [weight * axis * unit for axis, unit in zip(AXES, (r * x, r * y, z))]
                out.write(" ".join(map(repr, point + [weight])) + "\n")


def write_mesh(folder, cells, layers=6):
    """PLOT3D in ASCII with a neutral map file; `cells` cells along an edge of the cube, with the wall at k = 1."""
    path = os.path.join(folder, "ellipsoid.xyz")
    with open(path, "w") as out:
        out.write("6\n" + 6 * ("%d %d %d\n" % (cells + 1, cells + 1, layers + 1)))
        for axis in range(3):
            for sign in (-1, 1):
                rest = [(axis + 1) % 3, (axis + 2) % 3][::sign]
                block = []
                for k in range(layers + 1):
                    for j in range(cells + 1):
                        for i in range(cells + 1):
                            cube = [0.0] * 3
                            cube[axis] = sign
                            for d, n in zip(rest, (i, j)):
                                cube[d] = math.tan(0.25 * math.pi * (2 * n / cells - 1))
                            length = math.hypot(*cube)
                            reach = 1.0 + 0.1 * k + 0.04 * k * k
                            block.append([reach * half_axis * x / length for half_axis, x in zip(AXES, cube)])
                for d in range(3):
                    out.write("\n".join(repr(point[d]) for point in block) + "\n")
    with open(os.path.join(folder, "ellipsoid.nmf"), "w") as out:
        out.write("6\n" + "".join("%d %d %d %d\n" % (b, cells + 1, cells + 1, layers + 1) for b in range(1, 7)))
        for b in range(1, 7):
            # Faces 1 and 2 of a neutral map are k minimum and maximum.
            for face, name in ((1, "WALL"), (2, "FARFIELD")):
                out.write("'%s' %d %d  1 %d 1 %d\n" % (name, b, face, cells + 1, cells + 1))
    return path


def write_case(folder, cells=8):
    """Returns the paths of mesh and body."""
    os.makedirs(folder, exist_ok=True)
    body = os.path.join(folder, "ellipsoid.g2")
    write_body(body)
    return write_mesh(folder, cells), body


if __name__ == "__main__":
    print("\n".join(write_case(sys.argv[1] if len(sys.argv) > 1 else ".")))
