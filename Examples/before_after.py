# SPDX-License-Identifier: BSD-3-Clause
"""Draws the control nets of a mesh before and after the conversion: body and symmetry planes with their points.

Sample runs (without a display each starts one in memory):
    pvpython Examples/before_after.py                             a generated demonstration mesh
    pvpython Examples/before_after.py --mesh wing.xyz --body WALL

Before, the mesh points; after, the control points in the colours of the rules that made them.
"""
import numpy as np
from paraview import simple as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from example_support import (boundary_patches, bounds, convert, data, legend, look, matches, parser, read_mesh, rgb,
                             save, strings, surface, viewpoint, views)

HEIGHT = 600

# Colours of the control points by rule; the names come with the data.
RULE_COLORS = ["#9a9a9a", "#b8c4d6", "#7f9fbf", "#4e79a7", "#d4c39a", "#59a14f", "#e15759", "#f28e2b", "#000000",
               "#b07aa1", "#ff9da7", "#8cd17d"]


def skin(source):
    """The outer surface of all blocks together; copies of shared points have the same bits, so no tolerance."""
    return pv.ExtractSurface(Input=pv.MergeBlocks(Input=source, MergePoints=1, Tolerance=0.0))


def skin_normals(surface_data):
    xyz = vtk_to_numpy(surface_data.GetPoints().GetData()).astype(float)
    quads = xyz[vtk_to_numpy(surface_data.GetPolys().GetConnectivityArray()).reshape(-1, 4)]
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    # Left-handed blocks have their faces inside out.
    return normals if np.sum(normals * quads.mean(axis=1)) > 0 else -normals


def draw(view, net, rule_names):
    """Shows faces, edges and points of a control net; the points in the colours of their rules, if they have any."""
    used = set()
    for source, color, backface in net:
        display = pv.Show(source, view)
        display.Representation = "Surface With Edges"
        display.BackfaceRepresentation = backface
        display.ColorArrayName = [None, ""]
        display.AmbientColor = display.DiffuseColor = rgb(color)
        display.Ambient, display.Diffuse = 0.55, 0.5
        display.EdgeColor = rgb("#55617a")
        # A second source, because a source can be shown only once in a view.
        dots = pv.Show(pv.ExtractSurface(Input=source), view)
        dots.Representation = "Points"
        dots.PointSize = 5 if data(source).GetNumberOfPoints() < 5000 else 3
        dots.ColorArrayName = [None, ""]
        dots.AmbientColor = dots.DiffuseColor = rgb("#101820")
        rules = data(source).GetPointData().GetArray("ControlPointRule")
        if rules:
            pv.ColorBy(dots, ("POINTS", "ControlPointRule"))
            used |= set(vtk_to_numpy(rules))
    if used:
        table = pv.GetColorTransferFunction("ControlPointRule")
        table.InterpretValuesAsCategories = 1
        table.Annotations = [text for rule in sorted(used) for text in (str(rule), rule_names[rule])]
        table.IndexedColors = [value for rule in sorted(used) for value in rgb(RULE_COLORS[rule])]
        legend("ControlPointRule", view, "", Orientation="Vertical", ScalarBarLength=0.05 * len(used))


def picture(before, after, body, symmetry, path):
    """Body and symmetry planes before and after; without named boundaries all sides of the mesh that face away."""
    nets = []
    for source in (before, after):
        patches = list(boundary_patches(data(source)))
        bodies = [patch for patch in patches if matches(patch.name, body)]
        planes = [patch for patch in patches if matches(patch.name, symmetry) and not matches(patch.name, body)]
        if bodies:
            normals = np.concatenate([patch.normals for patch in bodies + planes])
            nets.append([(surface(group), color, "Follow Frontface")
                         for group, color in ((bodies, "#f0c896"), (planes, "#e6ebf1")) if group])
        else:
            nets.append([(skin(source), "#e6ebf1", "Cull Frontface")])
            normals = skin_normals(data(nets[-1][0][0]))
    layout, windows = views(("before: mesh", "after: B-spline control net"), HEIGHT)
    for view, net in zip(windows, nets):
        draw(view, net, strings(data(after).GetFieldData(), "ControlPointRuleNames"))
        look(view, bounds(nets[0][0][0]), viewpoint(normals))
    save(path, layout, HEIGHT)


def main():
    arguments = parser(__doc__.split("\n")[0], "before_after.png").parse_args()
    mesh = read_mesh(arguments)
    volume = convert(mesh, arguments)
    picture(mesh, volume, list(volume.BodyBoundaries), list(volume.SymmetryBoundaries), arguments.output)


if __name__ == "__main__":
    main()
