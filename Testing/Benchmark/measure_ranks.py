# SPDX-License-Identifier: BSD-3-Clause
"""The conversion on several ranks: its time, memory, traffic, and what identifies its result.

    mpiexec -n <ranks> pvbatch --sym measure_ranks.py wing <resolution>
    mpiexec -n <ranks> pvbatch --sym measure_ranks.py blocks <blocks per direction> <cells per direction of a block>

wing: Wing Fuselage Source without its body; blocks: a curved box. Every rank makes the blocks that it has. Rank 0 prints one
line of JSON: points, seconds of the source and of the fastest of three conversions (from when all ranks start until all
have ended), and per rank the points, the bytes received from other ranks, the peak memory beyond what stays and the
memory of the input; `result` is the same for equal bits of all control points and rules, whatever rank has them.

Set PYTHONPATH to the folder of the package bsplinevolume, and VTK_SMP_BACKEND_IN_USE and VTK_SMP_MAX_THREADS for threads.
"""
import hashlib
import json
import os
import sys
import time

import numpy
from paraview.vtk.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIdTypeArray
from vtkmodules.vtkParallelCore import vtkMultiProcessController

import bsplinevolume

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from measure_support import box, memory, release_memory, reset_peak

RUNS = 3
CONTROLLER = vtkMultiProcessController.GetGlobalController()
RANK, RANKS = CONTROLLER.GetLocalProcessId(), CONTROLLER.GetNumberOfProcesses()


def gathered(values):
    """The integers of all ranks, one list per rank."""
    mine, everyone = vtkIdTypeArray(), vtkIdTypeArray()
    for value in values:
        mine.InsertNextValue(value)
    everyone.SetNumberOfValues(len(values) * RANKS)
    CONTROLLER.AllGather(mine, everyone)
    return vtk_to_numpy(everyone).reshape(RANKS, len(values)).tolist()


def timed(work):
    """Seconds until all ranks have done the work."""
    CONTROLLER.Barrier()
    start = time.perf_counter()
    work()
    CONTROLLER.Barrier()
    return time.perf_counter() - start


def partitions(data):
    for b in range(data.GetNumberOfPartitionedDataSets()):
        if data.GetNumberOfPartitions(b) > 0 and data.GetPartition(b, 0):
            yield b, data.GetPartition(b, 0)


def main(case, *sizes):
    volume = bsplinevolume.vtkCatmullClarkToBSplineVolume()
    if case == "wing":
        source = bsplinevolume.vtkWingFuselageSource()
        source.SetResolution(int(sizes[0]))
        source_seconds = timed(lambda: source.UpdatePiece(RANK, RANKS, 0))
        mesh = source.GetOutputDataObject(0)
    else:
        blocks, cells = map(int, sizes)
        chosen = range(RANK * blocks ** 3 // RANKS, (RANK + 1) * blocks ** 3 // RANKS)
        made = []
        source_seconds = timed(lambda: made.append(box(blocks, cells, chosen)))
        mesh = made[0]
    volume.SetInputDataObject(mesh)

    times, extra = [], 0
    for _ in range(RUNS):
        volume.GetOutputDataObject(0).Initialize()
        release_memory()
        reset_peak()
        volume.Modified()
        times.append(timed(lambda: volume.UpdatePiece(RANK, RANKS, 0)))
        peak = memory("VmHWM")
        release_memory()
        extra = max(extra, peak - memory("VmRSS"))
    net = volume.GetOutputDataObject(0)

    # Sums of hashes do not depend on which rank has which block.
    sums = [0] * 8
    for b, block in partitions(net):
        digest = hashlib.sha256(b"%d" % b)
        digest.update(vtk_to_numpy(block.GetPoints().GetData()).tobytes())
        digest.update(vtk_to_numpy(block.GetPointData().GetArray("ControlPointRule")).tobytes())
        sums = [s + int(part) for s, part in zip(sums, numpy.frombuffer(digest.digest(), ">u4"))]
    points = sum(grid.GetNumberOfPoints() for _, grid in partitions(mesh))
    ranks = gathered([points, volume.GetReceivedBytes(), extra, 1024 * mesh.GetActualMemorySize()] + sums)
    if RANK == 0:
        total = [sum(rank[4 + n] for rank in ranks) % 2 ** 32 for n in range(8)]
        print(json.dumps({
            "points": sum(rank[0] for rank in ranks), "blocks": net.GetNumberOfPartitionedDataSets(),
            "source_seconds": source_seconds, "seconds": min(times), "rank_points": [rank[0] for rank in ranks],
            "received_bytes": [rank[1] for rank in ranks], "extra_bytes": [rank[2] for rank in ranks],
            "input_bytes": [rank[3] for rank in ranks], "result": "".join("%08x" % part for part in total)}),
            flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
