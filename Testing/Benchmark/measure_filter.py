# SPDX-License-Identifier: BSD-3-Clause
"""The conversion filter in pvpython, compared with a copy of its input.

    pvpython measure_filter.py <BSplineVolume.so> [<points>] [float|double] [joins]

The mesh is 4 x 4 x 4 cubic blocks of a curved box with declared contacts and boundaries, in double precision by
default. With `joins` the filter also measures how smoothly the blocks join (Check Joins). Prints one line of JSON:
points, seconds of the filter and of a copy of all points in double precision, and the peak memory beyond input and
output by the size of the input. Set VTK_SMP_BACKEND_IN_USE and VTK_SMP_MAX_THREADS for threads.
"""
import json
import os
import sys
import time

import numpy
from paraview import simple
from paraview.vtk.util.numpy_support import vtk_to_numpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from measure_support import box, memory, release_memory, reset_peak

BLOCKS = 4
RUNS = 5
TYPES = {"float": numpy.float32, "double": numpy.float64}
# Of one thread the processor time is the same but for what else the machine does.
clock = time.process_time if os.environ.get("VTK_SMP_MAX_THREADS") == "1" else time.perf_counter


def doubles(grid):
    """The points of a block, copied to the type that the filter's output has."""
    return vtk_to_numpy(grid.GetPoints().GetData()).astype(numpy.float64)


def size(data):
    """Bytes of all arrays."""
    return 1024.0 * data.GetActualMemorySize()


def main(plugin, points=10**7, kind="double", joins=""):
    simple.LoadPlugin(plugin, remote=False, ns=globals())
    cells = max(2, round((int(points) / BLOCKS ** 3) ** (1.0 / 3.0)) - 1)
    data = box(BLOCKS, cells, range(BLOCKS ** 3), TYPES[kind])
    source = simple.TrivialProducer()
    source.GetClientSideObject().SetOutput(data)
    volume = CatmullClarkToBSplineVolume(Input=source, CheckJoins=int(joins == "joins"))  # noqa: F821, from the plugin
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
