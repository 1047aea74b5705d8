# SPDX-License-Identifier: BSD-3-Clause
"""Shows which spans of a B-spline volume are proven valid, and which are not.

Sample runs (without a display each starts one in memory):
    pvpython Examples/validity.py                             a generated demonstration mesh
    pvpython Examples/validity.py --mesh wing.xyz

  1. converts the mesh; of the demonstration mesh, of which all spans are valid, it then drags one control point of the
     largest block through its neighbours;
  2. left the layer of spans with the first one that is not valid, or a middle one: valid ones between straight lines,
     invalid ones exactly, that is those on which the Jacobian determinant is not positive somewhere; such a point, the
     witness, is drawn as a ball;
  3. right all blocks cut open, coloured by the scaled Jacobian (1 is best).
"""
import numpy as np
from paraview import simple as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPartitionedDataSetCollection

from example_support import (bounds, color_range, convert, data, extract_cells, grids, legend, look, parser,
                             points, producer, read_mesh, save, show, size, views, viridis)

HEIGHT = 620


def with_inverted_span(volume):
    """Copy of a volume in which a control point of the largest block lies too far away; and the block."""
    copy = vtkPartitionedDataSetCollection()
    copy.DeepCopy(volume)
    blocks = [grid for _, grid in grids(copy)]
    number = max(range(len(blocks)), key=lambda b: blocks[b].GetNumberOfPoints())
    net = points(blocks[number])
    i, j, k = (n // 2 for n in size(blocks[number]))
    net[k, j, i] = net[k, j, i + 2] + 1.2 * (net[k, j, i + 2] - net[k, j, i])
    blocks[number].GetPoints().Modified()
    return copy, number


def main():
    arguments = parser(__doc__.split("\n")[0], "validity.png").parse_args()
    volume = data(convert(read_mesh(arguments), arguments))
    number = max(range(volume.GetNumberOfPartitionedDataSets()),
                 key=lambda b: volume.GetPartition(b, 0).GetNumberOfPoints())
    if not arguments.mesh:
        volume, number = with_inverted_span(volume)
    quality = pv.BSplineVolumeQuality(Input=producer(volume))
    quality.UpdatePipeline()
    quality.UpdatePropertyInformation()
    print("%d spans: %d valid, %d invalid, %d undecided" % (
        quality.NumberOfSpans, quality.NumberOfValidSpans, quality.NumberOfInvalidSpans,
        quality.NumberOfUndecidedSpans))

    layout, (left, right) = views(("a layer of spans; balls: witnesses", "all blocks, cut open"), HEIGHT)
    witnesses = data(quality, 1)
    indices = vtk_to_numpy(witnesses.GetPointData().GetArray("Span")).reshape(-1, 3)
    grid = [grid for _, grid in grids(data(quality))][number]
    k = (size(grid)[2] - 1) // 2
    if len(indices):
        number = int(witnesses.GetPointData().GetArray("BlockId").GetValue(0))
        k = int(indices[0, 2])
    cells = data(pv.BSplineVolumeToBezierCells(Input=producer(volume), Cells="Volume"))
    spans = vtk_to_numpy(cells.GetCellData().GetArray("SpanId"))
    layer = np.flatnonzero((vtk_to_numpy(cells.GetCellData().GetArray("BlockId")) == number) & (spans[:, 2] == k))
    grid = [grid for _, grid in grids(data(quality))][number]
    ni, nj, _ = (n - 1 for n in size(grid))
    verdicts = vtk_to_numpy(grid.GetCellData().GetArray("Validity"))[spans[layer] @ [1, ni, ni * nj]]
    straight = pv.ExtractSubset(Input=producer(grid))
    straight.VOI = [0, ni, 0, nj, k, k + 1]
    show(pv.Threshold(Input=straight, Scalars=["CELLS", "Validity"], LowerThreshold=0, UpperThreshold=0), left,
         array=("CELLS", "Validity"), Representation="Surface With Edges", EdgeColor=[0.3] * 3, Opacity=0.4)
    legend("Validity", left, "")
    for verdict, color in ((1, "#d62629"), (2, "#f2b529")):
        if verdict in verdicts:
            show(extract_cells(cells, layer[verdicts == verdict]), left, color, NonlinearSubdivisionLevel=4,
                 Opacity=0.7)
    positions = np.zeros((0, 3))
    if len(indices):
        here = (vtk_to_numpy(witnesses.GetPointData().GetArray("BlockId")) == number) & (indices[:, 2] == k)
        positions = vtk_to_numpy(witnesses.GetPoints().GetData())[here]
    edge = np.linalg.norm(np.ptp(np.reshape(grid.GetBounds(), (3, 2)), axis=1))
    for position in positions:
        ball = pv.Sphere(Center=list(position), Radius=0.006 * edge, ThetaResolution=24, PhiResolution=24)
        show(ball, left, "#000000")
    corners = points(grid)
    normal = np.cross(corners[0, 0, -1] - corners[0, 0, 0], corners[0, -1, 0] - corners[0, 0, 0])
    if len(positions):
        look(left, grid.GetBounds(), normal, zoom=2.0, center=positions.mean(axis=0))
    else:
        look(left, grid.GetBounds(), normal)

    box = np.reshape(bounds(quality), (3, 2))
    cut = pv.Clip(Input=quality, ClipType="Plane")
    cut.ClipType.Origin = list(box.mean(axis=1))
    cut.ClipType.Normal = [0.0, -1.0, 0.0]
    cut.Crinkleclip = 1
    show(cut, right, array=("CELLS", "ScaledJacobian"), Representation="Surface With Edges", EdgeColor=[0.3] * 3)
    viridis("ScaledJacobian")
    color_range("ScaledJacobian", -1.0 if quality.MinimumScaledJacobian < 0 else 0.0, 1.0)
    look(right, bounds(quality), (0.5, -1.0, 0.45), zoom=1.1)
    legend("ScaledJacobian", right, "scaled Jacobian")
    save(arguments.output, layout, HEIGHT)


if __name__ == "__main__":
    main()
