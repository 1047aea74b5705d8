# SPDX-License-Identifier: BSD-3-Clause
"""What the measurements of the conversion filter share: memory of this process, and a box of blocks of any size."""
import ctypes

import numpy
from paraview.vtk.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkIntArray, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkPartitionedDataSetCollection, vtkStructuredGrid


def memory(key):
    """Bytes of this process: VmRSS, VmHWM (peak)."""
    with open("/proc/self/status") as status:
        return next(1024 * int(line.split()[1]) for line in status if line.startswith(key + ":"))


def reset_peak():
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")


def release_memory():
    ctypes.CDLL(None).malloc_trim(0)


def box(blocks, cells, chosen, kind=numpy.float64):
    """A curved box of blocks^3 blocks of cells^3 cells, of which only the `chosen` ones are there, in a
    vtkPartitionedDataSetCollection with `Interfaces` and `Boundaries` of all."""
    data = vtkPartitionedDataSetCollection()
    data.SetNumberOfPartitionedDataSets(blocks ** 3)
    for b in chosen:
        place = (b % blocks, b // blocks % blocks, b // blocks ** 2)
        # Shared points are computed from the same numbers, and are the same bits.
        x, y, z = (numpy.arange(place[d] * cells, (place[d] + 1) * cells + 1) / (blocks * cells) for d in range(3))
        z, y, x = numpy.meshgrid(z, y, x, indexing="ij")
        xyz = numpy.stack([x + 0.03 * numpy.sin(5 * y), y + 0.03 * numpy.sin(5 * z), z + 0.03 * numpy.sin(5 * x)], 3)
        points = vtkPoints()
        points.SetData(numpy_to_vtk(xyz.reshape(-1, 3).astype(kind), deep=1))
        grid = vtkStructuredGrid()
        grid.SetDimensions(cells + 1, cells + 1, cells + 1)
        grid.SetPoints(points)
        data.SetPartition(b, 0, grid)
    contacts, boundaries, names = vtkIntArray(), vtkIntArray(), vtkStringArray()
    for array, name, components in ((contacts, "Interfaces", 12), (boundaries, "Boundaries", 3)):
        array.SetName(name)
        array.SetNumberOfComponents(components)
        data.GetFieldData().AddArray(array)
    names.SetName("BoundaryNames")
    names.InsertNextValue("side")
    data.GetFieldData().AddArray(names)
    for b in range(blocks ** 3):
        for d in range(3):
            position = b // blocks ** d % blocks
            if position + 1 < blocks:
                contacts.InsertNextTuple([b, 2 * d + 1, b + blocks ** d, 2 * d] + 8 * [0])
            for side, last in enumerate((0, blocks - 1)):
                if position == last:
                    boundaries.InsertNextTuple([b, 2 * d + side, 0])
    return data
