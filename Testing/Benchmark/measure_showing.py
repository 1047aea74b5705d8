# SPDX-License-Identifier: BSD-3-Clause
"""How long the default pictures take, as ratios to ParaView's own Surface of the input mesh in the same run.

    pvpython Testing/Benchmark/measure_showing.py build/lib/BSplineVolume/BSplineVolume.so [resolution ...]

Needs a display (xvfb-run -a) with software rendering: of every picture the processor time from Show to the end of the first
frame, and that of a further frame from another direction, after everything is up to date. All are shown three times in turn,
each time in a view of its own with five further frames, and the least times count. Resolutions 8, 20 and 44 of the wing
source have 114 thousand, 1 million and 10 million points.
"""
import sys
import time

from paraview import servermanager, simple

CONTROLLER = servermanager.vtkSMParaViewPipelineControllerWithRendering


def shown(source, port=0, representation=None):
    """Processor seconds of the first and of a further frame, in a view of its own."""
    view = simple.CreateRenderView()
    view.ViewSize = [1600, 1000]
    simple.Render(view)  # the window is made here
    start = time.process_time()
    if representation:
        display = simple.Show(simple.OutputPort(source, port), view, representation)
        display.SetRepresentationType("Surface")
        display.SetScalarColoring(None, 0)
    else:
        CONTROLLER().ShowInPreferredView(source.SMProxy, port, view.SMProxy)
    simple.ResetCamera(view)
    simple.Render(view)
    first = time.process_time() - start
    frames = []
    for _ in range(5):
        view.GetActiveCamera().Azimuth(17)
        start = time.process_time()
        simple.Render(view)
        frames.append(time.process_time() - start)
    simple.Delete(view)
    return first, min(frames)


def main(plugin, *resolutions):
    simple._DisableFirstRenderCameraReset()
    simple.LoadPlugin(plugin, remote=False, ns=simple.__dict__)
    shown(simple.Sphere())  # what is made once
    print("| points | picture | first frame s | ratio | further frames s | ratio |\n|---|---|---|---|---|---|")
    for resolution in [int(r) for r in resolutions] or [8, 20, 44]:
        mesh = simple.WingFuselageSource(Resolution=resolution)
        volume = simple.CatmullClarkToBSplineVolume(Input=mesh, CheckJoins=0)
        other = simple.CatmullClarkToBSplineVolume(Input=mesh, CheckJoins=0, Twist="Parallelogram")
        pictures = {
            "mesh as Surface": (mesh, 0, "StructuredGridRepresentation"),
            "mesh": (mesh, 0),
            "CatmullClarkToBSplineVolume": (volume, 0),
            "HexBlockTopology": (simple.HexBlockTopology(Input=mesh), 0),
            "WallSpacing": (simple.WallSpacing(Input=mesh), 1),
            "BSplineVolumeQuality": (simple.BSplineVolumeQuality(Input=volume), 0),
            "BSplineVolumeSmoothness": (simple.BSplineVolumeSmoothness(Input=volume), 4),
            "BodyDeviation": (simple.BodyDeviation(Input=volume, Body=simple.OutputPort(mesh, 1)), 0),
            "BSplineVolumeDifference": (simple.BSplineVolumeDifference(Input=other, Before=volume), 0),
            "BSplineVolumeSampler": (simple.BSplineVolumeSampler(Input=volume), 0),
            "BSplineVolumeToBezierCells": (simple.BSplineVolumeToBezierCells(Input=volume), 0)}
        for picture in pictures.values():
            picture[0].UpdatePipeline()
        times = {name: [] for name in pictures}
        for _ in range(3):
            for name, picture in pictures.items():
                times[name].append(shown(*picture))
        points = mesh.GetDataInformation(0).GetNumberOfPoints()
        least = {name: [min(column) for column in zip(*rows)] for name, rows in times.items()}
        reference = least["mesh as Surface"]
        for name, (first, frame) in least.items():
            print("| %d | %s | %.2f | %.2f | %.3f | %.2f |" % (
                points, name, first, first / reference[0], frame, frame / reference[1]), flush=True)
        for source in simple.GetSources().values():
            simple.Delete(source)


if __name__ == "__main__":
    main(*sys.argv[1:])
