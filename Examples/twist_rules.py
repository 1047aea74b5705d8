# SPDX-License-Identifier: BSD-3-Clause
"""Converts one mesh by all rules for extraordinary edges and vertices, and draws their walls side by side.

Sample runs (without a display each starts one in memory):
    pvpython Examples/twist_rules.py                        a generated mesh around an ellipsoid
    pvpython Examples/twist_rules.py --mesh wing.xyz --cad wing.igs --unit Metre --body WALL

The stripes are those of a zebra: they are continuous where the wall's normal is, and smooth where its curvature is. The
table says how large the jump of the normals is, how far the wall is from the body, and how many seconds it took.
"""
import time

import numpy as np
from paraview import simple as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from example_support import (body_case_arguments, body_patches, bounds, convert, data, look, parser, read_body_case, save,
                             show, stripes, views, wall_angles)

HEIGHT = 900
STRIPE = 4.5  # degrees
RULES = (("thesis formulas (Literal)", {"Twist": "Literal"}),
         ("Parallelogram", {"Twist": "Parallelogram"}),
         ("ACC", {"Twist": "ACC"}),
         ("SecondFundamentalForm", {}),
         ("PCCM", {"Twist": "PCCM", "Continuity": "ExactG1"}),
         ("exact G1", {"Continuity": "ExactG1"}))


def parse_arguments():
    arguments = parser(__doc__.split("\n")[0], "twist_rules.png")
    body_case_arguments(arguments)
    arguments.set_defaults(zoom=3.0)
    return arguments.parse_args()


def main():
    arguments = parse_arguments()
    mesh, body = read_body_case(arguments)
    layout, windows = views([name for name, _ in RULES], HEIGHT, rows=2)
    print("%-28s %12s %12s %12s %9s" % ("rule", "jump, deg", "distance", "RMS", "seconds"))
    towards, place = arguments.towards, arguments.look_at
    for (name, properties), view in zip(RULES, windows):
        start = time.perf_counter()
        volume = convert(mesh, arguments, Body=body, **properties)
        seconds = time.perf_counter() - start
        patterns = list(volume.BodyBoundaries)
        smoothness = pv.BSplineVolumeSmoothness(Input=volume)
        borders = pv.Threshold(Input=pv.OutputPort(smoothness, 3), Scalars=["CELLS", "Kind"], LowerThreshold=1,
                               UpperThreshold=1)
        jumps = vtk_to_numpy(data(borders).GetPointData().GetArray("NormalJump"))
        # All rules where the first one is roughest.
        place = place or data(borders).GetPoint(int(jumps.argmax()))
        measured = pv.BodyDeviation(Input=volume, Body=body)
        measured.UpdatePipeline()
        measured.UpdatePropertyInformation()
        print("%-28s %12.3g %12.3g %12.3g %9.2f" % (name, jumps.max(), measured.MaximumDistance, measured.RMSDistance,
                                                  seconds))
        if towards is None:  # from outside, above the place
            wall = np.concatenate([patch.points.reshape(-1, 3) for patch in body_patches(data(volume), patterns)])
            towards = list(np.asarray(place) - wall.mean(axis=0))
        wall = wall_angles(volume, towards)
        show(wall, view, array=("POINTS", "Angle"))
        look(view, bounds(wall), towards, zoom=arguments.zoom, center=place)
    stripes(windows, STRIPE)
    save(arguments.output, layout, HEIGHT)


if __name__ == "__main__":
    main()
