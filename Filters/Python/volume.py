# SPDX-License-Identifier: BSD-3-Clause
"""B-spline volumes for Python: control points, knots and rules as numpy views, evaluation and its inverse."""
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

from . import pipeline


def _basis(knots, degree, u, derivatives):
    """Non-zero basis functions at u, and their derivatives: first index (n,), values (derivatives + 1, n, degree + 1).

    The recurrence (2.5) and, for derivatives, (2.7) of L. Piegl and W. Tiller, The NURBS Book, 2nd ed., 1997.
    """
    last = len(knots) - degree - 2
    span = np.clip(np.searchsorted(knots, u, side="right") - 1, degree, last)
    # At the end of the range the last span that is not empty.
    while True:
        empty = (knots[span + 1] <= knots[span]) & (span > degree)
        if not empty.any():
            break
        span = span - empty
    tables = [np.ones((len(u), 1))]
    for p in range(1, degree + 1):
        lower = np.zeros((len(u), p + 1))
        for j in range(p):
            left = knots[span - p + 1 + j]
            right = knots[span + 1 + j]
            width = right - left
            part = tables[-1][:, j] / np.where(width > 0, width, 1)
            lower[:, j] += np.where(width > 0, (right - u) * part, 0)
            lower[:, j + 1] += np.where(width > 0, (u - left) * part, 0)
        tables.append(lower)
    result = [tables[degree]]
    for order in range(1, derivatives + 1):
        if order > degree:
            result.append(np.zeros((len(u), degree + 1)))
            continue
        values = tables[degree - order]
        for p in range(degree - order + 1, degree + 1):
            raised = np.zeros((len(u), p + 1))
            for j in range(p):
                width = knots[span + 1 + j] - knots[span - p + 1 + j]
                part = p * values[:, j] / np.where(width > 0, width, 1) * (width > 0)
                raised[:, j] -= part
                raised[:, j + 1] += part
            values = raised
        result.append(values)
    return span - degree, np.stack(result)


def _shape(grid):
    """Points per direction, the last one first."""
    dimensions = [0, 0, 0]
    grid.GetDimensions(dimensions)
    return tuple(reversed(dimensions))


class Block:
    """One B-spline volume.

    name            of the block
    degree          three ints
    knots           three arrays
    points          control points (nw, nv, nu, 3), a view of VTK's memory
    weights         (nw, nv, nu), or None if polynomial
    rules           how each control point was made (nw, nv, nu), or None
    """

    def __init__(self, name, grid):
        self.name = name
        self.grid = grid
        shape = _shape(grid)
        fields, points = grid.GetFieldData(), grid.GetPointData()
        self.degree = tuple(int(p) for p in vtk_to_numpy(fields.GetArray("Degree")).ravel())
        self.knots = tuple(vtk_to_numpy(fields.GetArray("Knots" + d)).ravel() for d in "UVW")
        self.points = vtk_to_numpy(grid.GetPoints().GetData()).reshape(shape + (3,))
        weights, rules = points.GetArray("Weights"), points.GetArray("ControlPointRule")
        self.weights = None if weights is None else vtk_to_numpy(weights).reshape(shape)
        self.rules = None if rules is None else vtk_to_numpy(rules).reshape(shape)

    @property
    def range(self):
        """The parameters: (3, 2)."""
        return np.array([[k[p], k[-p - 1]] for k, p in zip(self.knots, self.degree)])

    def evaluate(self, u, v, w, derivatives=0, chunk=20000):
        """Points at parameters, arrays of one shape S: (S, 3).

        With derivatives=1 also the first partial derivatives (S, 3, 3), the second-to-last axis being u, v, w.
        @throws ValueError for parameters outside the block's range, or other derivatives than 0 and 1
        """
        if derivatives not in (0, 1):
            raise ValueError("derivatives is 0 or 1")
        uvw = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (u, v, w)))
        shape = uvw[0].shape
        uvw = np.stack([x.ravel() for x in uvw])
        low, high = self.range.T
        if not ((uvw >= low[:, None]) & (uvw <= high[:, None])).all():
            raise ValueError(f"parameters of block {self.name} lie in {self.range.tolist()}")
        parts = [self._evaluate(uvw[:, n:n + chunk], derivatives) for n in range(0, uvw.shape[1], chunk)]
        points = np.concatenate([part[0] for part in parts] or [np.zeros((0, 3))]).reshape(shape + (3,))
        if derivatives == 0:
            return points
        return points, np.concatenate([part[1] for part in parts] or [np.zeros((0, 3, 3))]).reshape(shape + (3, 3))

    def _evaluate(self, uvw, derivatives):
        first, values = zip(*(_basis(k, p, x, derivatives) for k, p, x in zip(self.knots, self.degree, uvw)))
        k, j, i = (first[d][:, None] + np.arange(self.degree[d] + 1) for d in (2, 1, 0))
        index = k[:, :, None, None], j[:, None, :, None], i[:, None, None, :]
        net = self.points[index]
        if self.weights is not None:
            weight = self.weights[index][..., None]
            net = np.concatenate([net * weight, weight], axis=-1)

        # One direction after the other; along each the values, and the slopes where they are asked for.
        rows = [np.einsum("na,ncbad->ncbd", values[0][order], net) for order in range(derivatives + 1)]
        layers = [np.einsum("nb,ncbd->ncd", values[1][order], rows[0]) for order in range(derivatives + 1)]
        value = np.einsum("nc,ncd->nd", values[2][0], layers[0])
        slopes = []
        if derivatives:
            across = np.einsum("nb,ncbd->ncd", values[1][0], rows[1])
            slopes = [np.einsum("nc,ncd->nd", values[2][0], across), np.einsum("nc,ncd->nd", values[2][0], layers[1]),
                      np.einsum("nc,ncd->nd", values[2][1], layers[0])]
        if self.weights is None:
            return value, np.stack(slopes, axis=1) if slopes else None
        points = value[:, :3] / value[:, 3:]
        return points, np.stack([(s[:, :3] - s[:, 3:] * points) / value[:, 3:] for s in slopes], axis=1) if slopes else None


class Volume:
    """A multi-block B-spline volume: what convert() and read() return."""

    def __init__(self, data, report="", warnings=()):
        """@param data the output of a reader or of the conversion: a vtkPartitionedDataSetCollection"""
        self._data = data
        self.report = report
        self.warnings = list(warnings)
        self.blocks = []
        for n in range(data.GetNumberOfPartitionedDataSets()):
            meta = data.GetMetaData(n) if data.HasMetaData(n) else None
            name = meta.Get(data.NAME()) if meta is not None and meta.Has(data.NAME()) else f"block {n}"
            self.blocks.append(Block(name, data.GetPartition(n, 0)))

    def to_vtk(self):
        """The vtkPartitionedDataSetCollection."""
        return self._data

    def to_multiblock(self, level=None):
        """The control nets, or the samples at a level, as a vtkMultiBlockDataSet with the blocks' names.

        It is for programs without a class for collections: pyvista.wrap() makes a pyvista.MultiBlock of it.
        """
        data = self._data if level is None else self.sampled(level)
        blocks = vtkMultiBlockDataSet()
        for n, block in enumerate(self.blocks):
            blocks.SetBlock(n, data.GetPartition(n, 0))
            blocks.GetMetaData(n).Set(vtkMultiBlockDataSet.NAME(), block.name)
        return blocks

    def evaluate(self, block, u, v, w, derivatives=0):
        """Block.evaluate() of a block by number."""
        return self.blocks[block].evaluate(u, v, w, derivatives)

    def locate(self, points, tolerance=1e-12):
        """Blocks and parameters of points (n, 3): ints (n,), and (n, 3); -1 and NaN for points outside the volume.

        BSpline Volume Probe finds them. At points that blocks share the lowest block is given.
        @param tolerance distance at which a point is found, as a fraction of the volume's diagonal
        @throws bsplinevolume.Error for points that are not finite
        """
        probe = pipeline.filter_named("vtkBSplineVolumeProbe")
        probe.SetTolerance(tolerance)
        pipeline.connect(probe.SetInputConnection, self._data)
        cloud = vtkPolyData()
        cloud.SetPoints(vtkPoints())
        given = np.array(points, dtype=float).reshape(-1, 3)
        cloud.GetPoints().SetData(numpy_to_vtk(given, deep=True))
        pipeline.connect(probe.SetPointsConnection, cloud)
        pipeline.run(probe)
        found = probe.GetOutput().GetPointData()
        blocks = np.array(vtk_to_numpy(found.GetArray("BlockId")))
        uvw = np.array(vtk_to_numpy(found.GetArray("UVW")))
        uvw[blocks < 0] = np.nan
        return blocks, uvw

    def sample(self, level=1, **properties):
        """Points of all blocks with every span cut into 2^level parts: a list of arrays (nw, nv, nu, 3)."""
        data = self.sampled(level, **properties)
        return [vtk_to_numpy(data.GetPartition(n, 0).GetPoints().GetData()).reshape(
            _shape(data.GetPartition(n, 0)) + (3,))
            for n in range(data.GetNumberOfPartitionedDataSets())]

    def sampled(self, level=1, **properties):
        """The output of BSpline Volume Sampler, with contacts and boundaries."""
        return self._filtered("vtkBSplineVolumeSampler", 0, Level=level, **properties)

    def smoothness(self, **properties):
        """The table of joins of BSpline Volume Smoothness, the worst first: a dictionary of columns."""
        sampler = pipeline.filter_named("vtkBSplineVolumeSmoothness")
        pipeline.set_properties(sampler, properties)
        pipeline.connect(sampler.SetInputConnection, self._data)
        pipeline.run(sampler)
        for port in range(sampler.GetNumberOfOutputPorts()):
            table = sampler.GetOutputDataObject(port)
            if table.IsA("vtkTable") and table.GetNumberOfColumns() > 1:
                columns = {}
                for n in range(table.GetNumberOfColumns()):
                    column = table.GetColumn(n)
                    columns[column.GetName()] = (
                        [column.GetValue(i) for i in range(column.GetNumberOfValues())] if column.IsA("vtkStringArray")
                        else vtk_to_numpy(column))
                return columns
        raise pipeline.Error("the table of joins is missing")

    def quality(self, **properties):
        """Numbers of spans that are valid, invalid and undecided, smallest scaled Jacobian, and a report of one line."""
        quality = pipeline.filter_named("vtkBSplineVolumeQuality")
        pipeline.set_properties(quality, properties)
        pipeline.connect(quality.SetInputConnection, self._data)
        pipeline.run(quality)
        counts = {"valid": quality.GetNumberOfValidSpans(), "invalid": quality.GetNumberOfInvalidSpans(),
                  "undecided": quality.GetNumberOfUndecidedSpans()}
        counts["minimum_scaled_jacobian"] = quality.GetMinimumScaledJacobian()
        counts["report"] = (f"{counts['valid']} spans proven valid, {counts['invalid']} invalid, "
                            f"{counts['undecided']} undecided; smallest scaled Jacobian "
                            f"{counts['minimum_scaled_jacobian']:.3g}")
        return counts

    def write(self, path, level=1, **properties):
        """Writes the volume (.qfmb .vtpc .mesh .xml .g2 .msh .h5), its wall (.step .stp .igs .iges), or a mesh sampled at `level`
        (.cgns .xyz .x .p3d .foam)."""
        self.warnings.extend(pipeline.write(path, self._data, lambda: self.sampled(level), properties))

    def _filtered(self, name, port, **properties):
        algorithm = pipeline.filter_named(name)
        pipeline.set_properties(algorithm, properties)
        pipeline.connect(algorithm.SetInputConnection, self._data)
        pipeline.run(algorithm)
        return algorithm.GetOutputDataObject(port)


def convert(mesh, body=None, progress=None, **properties):
    """Converts a block-structured hexahedral mesh to a Volume.

    @param mesh path of a PLOT3D, CGNS, VTK (.vts .vtu .vti .vtm .vtpc .vtk ..) or Exodus file, a data object of VTK, or an
        algorithm that gives one; blocks, or unstructured hexahedra
    @param body path of an IGES, STEP, BREP or .g2 file, a data object, or an algorithm; None for no body
    @param progress called with the fraction done; returns False to stop
    @param properties of CatmullClark To BSpline Volume, for instance UseCreaseAngle=True, BodyBoundaries=["wing*"],
        Continuity="ExactG1"
    @throws bsplinevolume.Error with the message of the reader or filter, or for a value that a property does not take
    @throws TypeError for a property that does not exist
    """
    conversion = pipeline.filter_named("vtkCatmullClarkToBSplineVolume")
    pipeline.set_properties(conversion, properties)
    pipeline.connect(conversion.SetInputConnection, mesh, pipeline.MESH_READERS)
    if body is not None:
        pipeline.connect(conversion.SetBodyConnection, body, pipeline.BODY_READERS)
    warnings = pipeline.run(conversion, progress)
    return Volume(conversion.GetOutputDataObject(0), conversion.GetReport(), warnings)


def read(path):
    """Reads a Volume from .qfmb, .vtpc, GoTools .g2 or MFEM .mesh."""
    reader = pipeline.source_of(path, pipeline.VOLUME_READERS)
    warnings = pipeline.run(reader)
    return Volume(reader.GetOutputDataObject(0), "", warnings)
