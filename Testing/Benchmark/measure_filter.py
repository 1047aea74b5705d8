# SPDX-License-Identifier: BSD-3-Clause
"""The conversion filter in pvpython, compared with a copy of its input.

    pvpython measure_filter.py <BSplineVolume.so> [<points>] [float|double]

The mesh is 4 x 4 x 4 cubic blocks of a curved box with declared contacts and boundaries, in double precision by
default. Prints one line of JSON: points, seconds of the filter and of a copy of all points in double precision, and the
peak memory beyond input and output by the size of the input. Set VTK_SMP_BACKEND_IN_USE and VTK_SMP_MAX_THREADS for
threads.
"""
import ctypes
import json
import os
import sys
import time

import numpy
from paraview import simple
from paraview.vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIntArray, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkPartitionedDataSetCollection, vtkStructuredGrid

BLOCKS = 4
RUNS = 5
TYPES = {"float": numpy.float32, "double": numpy.float64}
# Of one thread the processor time is the same but for what else the machine does.
clock = time.process_time if os.environ.get("VTK_SMP_MAX_THREADS") == "1" else time.perf_counter


def memory(key):
    """Bytes of this process: VmRSS, VmHWM (peak)."""
    with open("/proc/self/status") as status:
        return next(1024 * int(line.split()[1]) for line in status if line.startswith(key + ":"))


def reset_peak():
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")


def release_memory():
    ctypes.CDLL(None).malloc_trim(0)


def box(points, kind):
    """Blocks of about `points` points in all, in a vtkPartitionedDataSetCollection with `Interfaces`."""
    cells = max(2, round((points / BLOCKS ** 3) ** (1.0 / 3.0)) - 1)
    data = vtkPartitionedDataSetCollection()
    for b in range(BLOCKS ** 3):
        place = (b % BLOCKS, b // BLOCKS % BLOCKS, b // BLOCKS ** 2)
        # Shared points are computed from the same numbers, and are the same bits.
        x, y, z = (numpy.arange(place[d] * cells, (place[d] + 1) * cells + 1) / (BLOCKS * cells) for d in range(3))
        z, y, x = numpy.meshgrid(z, y, x, indexing="ij")
        xyz = numpy.stack([x + 0.03 * numpy.sin(5 * y), y + 0.03 * numpy.sin(5 * z), z + 0.03 * numpy.sin(5 * x)], 3)
        points_array = vtkPoints()
        points_array.SetData(numpy_to_vtk(xyz.reshape(-1, 3).astype(TYPES[kind]), deep=1))
        grid = vtkStructuredGrid()
        grid.SetDimensions(cells + 1, cells + 1, cells + 1)
        grid.SetPoints(points_array)
        data.SetPartition(b, 0, grid)
    contacts, boundaries, names = vtkIntArray(), vtkIntArray(), vtkStringArray()
    for array, name, components in ((contacts, "Interfaces", 12), (boundaries, "Boundaries", 3)):
        array.SetName(name)
        array.SetNumberOfComponents(components)
        data.GetFieldData().AddArray(array)
    names.SetName("BoundaryNames")
    names.InsertNextValue("side")
    data.GetFieldData().AddArray(names)
    for b in range(BLOCKS ** 3):
        for d in range(3):
            position = b // BLOCKS ** d % BLOCKS
            if position + 1 < BLOCKS:
                contacts.InsertNextTuple([b, 2 * d + 1, b + BLOCKS ** d, 2 * d] + 8 * [0])
            for side, last in enumerate((0, BLOCKS - 1)):
                if position == last:
                    boundaries.InsertNextTuple([b, 2 * d + side, 0])
    return data


def doubles(grid):
    """The points of a block, copied to the type that the filter's output has."""
    return vtk_to_numpy(grid.GetPoints().GetData()).astype(numpy.float64)


def size(data):
    """Bytes of all arrays."""
    return 1024.0 * data.GetActualMemorySize()


def main(plugin, points=10**7, kind="double"):
    simple.LoadPlugin(plugin, remote=False, ns=globals())
    data = box(int(points), kind)
    source = simple.TrivialProducer()
    source.GetClientSideObject().SetOutput(data)
    volume = CatmullClarkToBSplineVolume(Input=source)  # noqa: F821, from the plugin
    algorithm = volume.GetClientSideObject()

    times, copies, extra = [], [], []
    for _ in range(RUNS):
        # Both start without memory of the process that is free, and ask the system for theirs.
        algorithm.GetOutputDataObject(0).Initialize()
        release_memory()
        before = memory("VmRSS")
        reset_peak()
        start = clock()
        algorithm.Modified()
        algorithm.Update()
        times.append(clock() - start)
        extra.append(memory("VmHWM") - before - size(algorithm.GetOutputDataObject(0)))
        start = clock()
        copy = [doubles(data.GetPartition(b, 0)) for b in range(BLOCKS ** 3)]
        copies.append(clock() - start)
        del copy
    print(json.dumps({
        "points": sum(data.GetPartition(b, 0).GetNumberOfPoints() for b in range(BLOCKS ** 3)), "type": kind,
        "filter_seconds": min(times), "copy_seconds": min(copies), "ratio": min(times) / min(copies),
        "extra_memory": max(extra) / size(data)}))


if __name__ == "__main__":
    main(*sys.argv[1:])
