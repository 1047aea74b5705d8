# SPDX-License-Identifier: BSD-3-Clause
"""Shows the body's surface in the levels 0 to 3 of the sampling hierarchy side by side.

Sample runs (without a display each starts one in memory):
    pvpython Examples/hierarchy.py                             a generated demonstration mesh
    pvpython Examples/hierarchy.py --mesh wing.xyz --body WALL

Every span is cut into 2^level parts per direction; the points of a level are points of the next one, bit for bit.
"""
from paraview import simple as pv

from example_support import (body_patches, body_viewpoint, bounds, convert, data, look, parser, read_mesh, save, show,
                             surface, views)

HEIGHT = 800


def main():
    arguments = parser(__doc__.split("\n")[0], "hierarchy.png").parse_args()
    volume = convert(read_mesh(arguments, cells=6), arguments)
    patterns = list(volume.BodyBoundaries)
    levels = range(4)
    samples = [pv.BSplineVolumeSampler(Input=volume, Level=level) for level in levels]
    counts = [data(source).GetNumberOfElements(0) for source in samples]
    layout, windows = views(["level %d: %s points in the volume" % (level, format(count, ",")) for level, count in
                             zip(levels, counts)], HEIGHT, rows=2)
    patches = body_patches(data(volume), patterns)
    for source, view in zip(samples, windows):
        wall = surface(body_patches(data(source), patterns))
        show(wall, view, "#f0c896", Representation="Surface With Edges", EdgeColor=[0.33, 0.38, 0.48],
             Ambient=0.35, Diffuse=0.65)
        look(view, bounds(wall), body_viewpoint(patches), zoom=1.5)
    save(arguments.output, layout, HEIGHT)


if __name__ == "__main__":
    main()
