# SPDX-License-Identifier: BSD-3-Clause
"""The Python package of a build without ParaView reads, converts, samples, writes and reads back; run by python3.

It was built without OpenCASCADE, too, and says so where it is needed.

Argument: the folder of the modules that must be used.
"""
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "Examples"))
import bsplinevolume
import make_demo_mesh
import TestDemoHash


def points(algorithm):
    data = algorithm.GetOutputDataObject(0)
    return [bytes(memoryview(data.GetPartition(block, 0).GetPoints().GetData()))
            for block in range(data.GetNumberOfPartitionedDataSets())]


def failure(algorithm, work):
    """The only error that comes while `work` is done."""
    errors = []

    def observe(_caller, _event, text):
        errors.append(text)
    observe.CallDataType = "string0"
    algorithm.AddObserver("ErrorEvent", observe)
    algorithm.GetExecutive().AddObserver("ErrorEvent", lambda *_: None)
    work()
    assert len(errors) == 1, errors
    return errors[0]


def refuses_cad(folder, convert):
    path = os.path.join(folder, "body.step")
    with open(path, "w") as stream:
        stream.write("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n")
    reader = bsplinevolume.vtkNURBSSurfaceReader()
    reader.SetFileName(path)
    writer = bsplinevolume.vtkNURBSSurfaceWriter()
    writer.SetInputConnection(convert.GetOutputPort())
    writer.SetFileName(os.path.join(folder, "wall.igs"))
    for error in failure(reader, reader.Update), failure(writer, writer.Write):
        assert "files need OpenCASCADE" in error, error
    assert not os.path.exists(writer.GetFileName())


def main(modules):
    with tempfile.TemporaryDirectory() as folder:
        reader = bsplinevolume.vtkHexBlockMeshReader()
        reader.SetFileName(make_demo_mesh.write_demo(folder, 4))
        convert = bsplinevolume.vtkCatmullClarkToBSplineVolume()
        convert.SetInputConnection(reader.GetOutputPort())
        sampler = bsplinevolume.vtkBSplineVolumeSampler()
        sampler.SetInputConnection(convert.GetOutputPort())
        sampler.Update()
        assert len(points(sampler)) == len(points(convert)) >= 11

        writer = bsplinevolume.vtkQuadflowWriter()
        writer.SetInputConnection(convert.GetOutputPort())
        writer.SetFileName(os.path.join(folder, "demo.qfmb"))
        assert writer.Write()
        reread = bsplinevolume.vtkQuadflowReader()
        reread.SetFileName(writer.GetFileName())
        reread.Update()
        assert points(reread) == points(convert)
        refuses_cad(folder, convert)
    TestDemoHash.main()

    with open("/proc/self/maps") as maps:
        loaded = {line.split()[-1] for line in maps}
    assert not [path for path in loaded if "libvtkRemoting" in path or "libvtkPV" in path]
    assert all(path.startswith(modules + "/") for path in loaded if "libBSplineVolume" in path)


if __name__ == "__main__":
    main(*sys.argv[1:])
