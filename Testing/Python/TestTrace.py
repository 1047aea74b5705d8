# SPDX-License-Identifier: BSD-3-Clause
"""A Python trace of the whole workflow, from the mesh file to the written volume, replays in a fresh session.

Arguments: the pvpython program.
"""
import hashlib
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import simple, client
from paraview import smtrace
import make_demo_mesh

# What is added to the trace: the same digests, taken in the fresh session.
SOURCES = ("HexBlockMeshReader", "CatmullClarkToBSplineVolume", "BSplineVolumeSmoothness", "BSplineVolumeQuality",
           "BSplineVolumeToBezierCells")


def leaves(data):
    if data.IsA("vtkPartitionedDataSetCollection"):
        return [data.GetPartition(b, 0) for b in range(data.GetNumberOfPartitionedDataSets())]
    return [data]


def digest(proxy):
    """Of all numbers of all outputs."""
    text = hashlib.sha256()
    for port in range(client(proxy).GetNumberOfOutputPorts()):
        for leaf in leaves(client(proxy).GetOutputDataObject(port)):
            if leaf.IsA("vtkTable"):
                groups = [leaf.GetRowData()]
            else:
                if leaf.GetNumberOfPoints():
                    text.update(bytes(memoryview(leaf.GetPoints().GetData())))
                groups = [leaf.GetPointData(), leaf.GetCellData()]
            for group in groups:
                for n in range(group.GetNumberOfArrays()):
                    array = group.GetAbstractArray(n)
                    text.update(array.GetName().encode())
                    if array.IsA("vtkDataArray") and array.GetNumberOfTuples():
                        text.update(bytes(memoryview(array)))
    return text.hexdigest()


def digests():
    """By the kind of source; the traced script names them all in the pipeline."""
    found = {}
    for source in simple.GetSources().values():
        found[source.SMProxy.GetXMLName()] = digest(source)
    return [found[name] for name in SOURCES]


def apply(proxy, **properties):
    """Changes properties as the Apply button does; the trace knows of no others."""
    item = smtrace.PropertiesModified(proxy.SMProxy)
    for name, value in properties.items():
        setattr(proxy, name, value)
    item.finalize()


def workflow(folder, written):
    """What a user does, with properties that are not the defaults."""
    view = simple.GetActiveViewOrCreate("RenderView")
    mesh = simple.HexBlockMeshReader(registrationName="demo.xyz", FileName=os.path.join(folder, "demo.xyz"))
    simple.Show(mesh, view)
    volume = simple.CatmullClarkToBSplineVolume(registrationName="volume", Input=mesh)
    apply(volume, UseCreaseAngle=1, CreaseAngle=35.0, BodyBoundaries=["WALL"])
    simple.Show(volume, view)
    smoothness = simple.BSplineVolumeSmoothness(registrationName="smoothness", Input=volume)
    apply(smoothness, SamplesPerSpan=2)
    simple.Show(simple.OutputPort(smoothness, 0), view)
    quality = simple.BSplineVolumeQuality(registrationName="quality", Input=volume)
    simple.Show(quality, view)
    cells = simple.BSplineVolumeToBezierCells(registrationName="cells", Input=volume)
    apply(cells, Cells="All Faces")
    simple.Show(cells, view)
    # File > Save Data; scripts' own SaveData() leaves no trace.
    writer = simple.CreateWriter(written, proxy=volume, IndexBase=1)
    smtrace.SaveData(writer.SMProxy, written, volume.SMProxy, 0)
    writer.UpdatePipeline()


def main(pvpython):
    with tempfile.TemporaryDirectory() as folder:
        make_demo_mesh.write_demo(folder, 4)
        written = os.path.join(folder, "written.qfmb")
        smtrace.start_trace()
        workflow(folder, written)
        trace = smtrace.stop_trace()
        expected = digests()
        assert all(name + "(" in trace for name in SOURCES), trace
        # ParaView 6.1 sets properties as keywords of the constructor, older ones by assignments: without and with blanks.
        for line in ("UseCreaseAngle=1", "CreaseAngle=35.0", "BodyBoundaries=['WALL']", "SamplesPerSpan=2",
                     "Cells='AllFaces'", "IndexBase=1"):
            assert line in trace.replace(" ", ""), line + "\n" + trace
        with open(written, "rb") as file:
            volume = file.read()
        os.remove(written)

        script = os.path.join(folder, "trace.py")
        with open(script, "w") as file:
            # bsv_support loads the plugin; its trace names everything else.
            file.write("import sys\nsys.path.insert(0, %r)\nimport bsv_support, TestTrace\n" %
                       os.path.dirname(os.path.abspath(__file__)))
            file.write(trace)
            file.write("\nprint(*TestTrace.digests(), sep='\\n')\n")
        output = subprocess.run([pvpython, script], check=True, stdout=subprocess.PIPE, text=True, timeout=120).stdout
        assert output.split()[-len(SOURCES):] == expected, output + "\n" + trace
        with open(written, "rb") as file:
            assert file.read() == volume
    print("trace of %d lines replayed" % len(trace.splitlines()))


if __name__ == "__main__":
    main(*sys.argv[1:])
