# SPDX-License-Identifier: BSD-3-Clause
"""Shows the exact Bezier cells of a B-spline volume as ParaView draws them.

Sample runs (without a display each starts one in memory):
    pvpython Examples/bezier.py                             a generated demonstration mesh, coarse
    pvpython Examples/bezier.py --mesh wing.xyz --body WALL

The cells are the volume itself, one per span. How finely they are drawn is said by the display's Nonlinear Subdivision
Level: 0 draws the corners only. Body and symmetry planes are picked from the quadrilaterals of the outer faces.
"""
from paraview import simple as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from example_support import (body_patches, body_viewpoint, boundary_faces, bounds, convert, data, extract_cells, look,
                             parser, read_mesh, save, show, views)

HEIGHT = 600


def cells_of(cells, faces):
    """Source of the cells that lie on the given (block, face)."""
    owners = zip(*(vtk_to_numpy(cells.GetCellData().GetArray(name)) for name in ("BlockId", "FaceId")))
    return extract_cells(cells, [cell for cell, owner in enumerate(owners) if owner in faces])


def main():
    arguments = parser(__doc__.split("\n")[0], "bezier.png").parse_args()
    volume = convert(read_mesh(arguments, cells=4), arguments)
    faces = pv.BSplineVolumeToBezierCells(Input=volume, Cells="Outer Faces")
    walls = boundary_faces(data(volume), list(volume.BodyBoundaries))
    planes = boundary_faces(data(volume), list(volume.SymmetryBoundaries)) - walls
    patches = body_patches(data(volume), list(volume.BodyBoundaries))
    levels = (0, 3)
    layout, windows = views(["%d Bezier cells, drawn at level %d" % (data(faces).GetNumberOfCells(), level)
                             for level in levels], HEIGHT)
    for view, level in zip(windows, levels):
        for part, color in ((walls, "#f0c896"), (planes, "#e6ebf1")):
            if part:
                show(cells_of(data(faces), part), view, color, Representation="Surface With Edges",
                     EdgeColor=[0.33, 0.38, 0.48], NonlinearSubdivisionLevel=level, Ambient=0.35, Diffuse=0.65)
        look(view, bounds(cells_of(data(faces), walls)), body_viewpoint(patches), zoom=1.1)
    save(arguments.output, layout, HEIGHT)


if __name__ == "__main__":
    main()
