# SPDX-License-Identifier: BSD-3-Clause
"""Compares the wall of a B-spline volume with the exact NURBS surface of the body.

Sample runs (without a display each starts one in memory):
    pvpython Examples/body_deviation.py                        a generated mesh around an ellipsoid
    pvpython Examples/body_deviation.py --mesh wing.xyz --cad wing.igs --unit Metre --body WALL
    pvpython Examples/body_deviation.py --mesh wing.xyz --cad wing.igs --body-face 4     face k = 1 of all blocks

Above, the distance of the wall from the body, and the control net over the surface; below, the angle between the two
sides of the wall along the borders of the blocks, with the twist rule Literal and with the default.
"""
import numpy as np
from paraview import simple as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from example_support import (body_case_arguments, body_patches, body_viewpoint, bounds, color_range, convert, data,
                             legend, look, parser, read_body_case, save, show, surface, views, viridis)

HEIGHT = 1000
WALL = "#d8dde3"
FULL = 5.0  # degrees: where the colours of the angles end


def parse_arguments():
    arguments = parser(__doc__.split("\n")[0], "body_deviation.png")
    body_case_arguments(arguments)
    arguments.add_argument("--body-face", type=int, metavar="FACE", choices=range(6),
                           help="face of every block that is the body, where the mesh names no boundaries")
    return arguments.parse_args()


def main():
    arguments = parse_arguments()
    mesh, body = read_body_case(arguments)
    properties = {}
    if arguments.body_face is not None:
        blocks = data(mesh).GetNumberOfPartitionedDataSets()
        properties["BodyFaces"] = [number for block in range(blocks) for number in (block, arguments.body_face)]
    volume = convert(mesh, arguments, Body=body, **properties)
    literal = convert(mesh, arguments, Body=body, Twist="Literal", **properties)
    patterns = list(volume.BodyBoundaries)

    def wall(source):
        return body_patches(data(source), patterns)

    layout, windows = views(("distance from the body", "control net over the surface", "kinks of the wall: Literal",
                             "kinks of the wall: default"), HEIGHT, rows=2)
    deviation, net, first, second = windows

    measured = pv.BodyDeviation(Input=volume, Body=body)
    measured.UpdatePipeline()
    measured.UpdatePropertyInformation()
    print("distance: at most %.3g, RMS %.3g; normals: at most %.3g degrees" % (
        measured.MaximumDistance, measured.RMSDistance, measured.MaximumNormalDeviation))
    show(pv.ExtractBlock(Input=measured, Assembly="Assembly", Selectors=["/BodyDeviation/Wall"]), deviation,
         array=("POINTS", "Distance"))
    viridis("Distance")
    color_range("Distance", 0.0, measured.MaximumDistance)
    legend("Distance", deviation, "distance")

    samples = surface(wall(pv.BSplineVolumeSampler(Input=volume, Level=2)))
    show(samples, net, WALL)
    lines = surface(wall(volume))
    show(lines, net, "#20486e", Representation="Wireframe", LineWidth=1.0)
    dots = pv.ExtractSurface(Input=lines)
    show(dots, net, "#c0400a", Representation="Points", PointSize=4)

    extent = np.ptp(np.reshape(bounds(samples), (3, 2)), axis=1).max()
    largest = []
    for source, view in ((literal, first), (volume, second)):
        show(surface(wall(pv.BSplineVolumeSampler(Input=source, Level=2))), view, WALL)
        smoothness = pv.BSplineVolumeSmoothness(Input=source)
        borders = pv.Threshold(Input=pv.OutputPort(smoothness, 3), Scalars=["CELLS", "Kind"], LowerThreshold=1,
                               UpperThreshold=1)
        tubes = pv.Tube(Input=pv.ExtractSurface(Input=borders), Radius=0.006 * extent / arguments.zoom,
                        Scalars=[None, ""])
        show(tubes, view, array=("POINTS", "NormalJump"))
        jumps = vtk_to_numpy(data(borders).GetPointData().GetArray("NormalJump"))
        largest.append(jumps.max())
        print("angle between the normals of the wall: at most %.3g degrees, at %s" % (
            largest[-1], " ".join("%.4g" % x for x in data(borders).GetPoint(int(jumps.argmax())))))
        legend("NormalJump", view, "angle, degrees; at most %.3g here" % largest[-1])
    color_range("NormalJump", 0.0, FULL)

    towards = arguments.towards or body_viewpoint(wall(volume))
    for view in windows:
        look(view, bounds(samples), towards, zoom=1.5 * arguments.zoom, center=arguments.look_at)
    save(arguments.output, layout, HEIGHT)


if __name__ == "__main__":
    main()
