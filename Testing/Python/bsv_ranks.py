# SPDX-License-Identifier: BSD-3-Clause
"""What the tests on several MPI ranks share. All of them run in all processes, by pvbatch --sym."""
import os
import sys
import tempfile

from paraview import vtk

CONTROLLER = vtk.vtkMultiProcessController.GetGlobalController()
RANK = CONTROLLER.GetLocalProcessId() if CONTROLLER else 0
SIZE = CONTROLLER.GetNumberOfProcesses() if CONTROLLER else 1
assert SIZE == int(os.environ.get("BSV_EXPECTED_RANKS", "1"))


class Alone:
    """Filters believe that there is only this process."""

    def __enter__(self):
        vtk.vtkMultiProcessController.SetGlobalController(vtk.vtkDummyController())

    def __exit__(self, *_):
        vtk.vtkMultiProcessController.SetGlobalController(CONTROLLER)


def reduced(number, operation=vtk.vtkCommunicator.SUM_OP):
    """A whole number of all ranks together, by default their sum."""
    if SIZE == 1:
        return number
    mine, result = vtk.vtkIdTypeArray(), vtk.vtkIdTypeArray()
    mine.InsertNextValue(number)
    CONTROLLER.AllReduce(mine, result, operation)
    return result.GetValue(0)


def check(right, *what):
    """Fails on all ranks if it does on one, which says what is wrong: no rank waits for another that has gone."""
    if not right:
        print("rank", RANK, *what, file=sys.stderr, flush=True)
    assert reduced(int(bool(right)), vtk.vtkCommunicator.MIN_OP), "see the message of a rank"


def shared_folder():
    """A new folder, made by the first rank."""
    path = vtk.vtkCharArray()
    if RANK == 0:
        for letter in tempfile.mkdtemp():
            path.InsertNextValue(letter)
    if SIZE > 1:
        CONTROLLER.Broadcast(path, 0)
    return "".join(path.GetValue(n) for n in range(path.GetNumberOfValues()))


def partitions(data):
    """The blocks of a collection that this rank has, None for the others."""
    return [data.GetPartition(b, 0) if data.GetNumberOfPartitions(b) > 0 else None
            for b in range(data.GetNumberOfPartitionedDataSets())]
