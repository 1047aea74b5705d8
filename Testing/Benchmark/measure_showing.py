# SPDX-License-Identifier: BSD-3-Clause
"""How long the default pictures take, as ratios to ParaView's own Surface of the input mesh in the same run.

    pvpython Testing/Benchmark/measure_showing.py build/lib/BSplineVolume/BSplineVolume.so [resolution ...]

Needs a display (xvfb-run -a). Of every picture: the time from Show to the end of the first frame, and the median of five
further frames from other directions; all data are up to date before. Resolutions 8, 20 and 44 of the wing source have 114
thousand, 1 million and 10 million points.
"""
import statistics
import sys
import time

from paraview import servermanager, simple

CONTROLLER = servermanager.vtkSMParaViewPipelineControllerWithRendering


def measured(source, port=0, representation=None):
    """Seconds of the first and of further frames, in a view of its own."""
    source.UpdatePipeline()
    view = simple.CreateRenderView()
    view.ViewSize = [1600, 1000]
    simple.Render(view)  # the window is made here
    start = time.perf_counter()
    if representation:
        display = simple.Show(simple.OutputPort(source, port), view, representation)
        display.SetRepresentationType("Surface")
        display.SetScalarColoring(None, 0)
    else:
        CONTROLLER().ShowInPreferredView(source.SMProxy, port, view.SMProxy)
    simple.ResetCamera(view)
    simple.Render(view)
    first = time.perf_counter() - start
    frames = []
    for _ in range(5):
        view.GetActiveCamera().Azimuth(17)
        start = time.perf_counter()
        simple.Render(view)
        frames.append(time.perf_counter() - start)
    simple.Delete(view)
    return first, statistics.median(frames)


def main(plugin, *resolutions):
    simple._DisableFirstRenderCameraReset()
    simple.LoadPlugin(plugin, remote=False, ns=simple.__dict__)
    measured(simple.Sphere())  # what is made once
    print("| points | picture | first frame s | ratio | further frames s | ratio |\n|---|---|---|---|---|---|")
    for resolution in [int(r) for r in resolutions] or [8, 20, 44]:
        mesh = simple.WingFuselageSource(Resolution=resolution)
        volume = simple.CatmullClarkToBSplineVolume(Input=mesh, CheckJoins=0)
        reference = measured(mesh, 0, "StructuredGridRepresentation")
        points = mesh.GetDataInformation(0).GetNumberOfPoints()
        pictures = [("mesh as Surface", reference), ("mesh", measured(mesh)), ("volume", measured(volume))]
        if resolution <= 20:
            body = simple.OutputPort(mesh, 1)
            other = simple.CatmullClarkToBSplineVolume(Input=mesh, CheckJoins=0, Twist="Parallelogram")
            for name, inputs, port in (
                    ("HexBlockTopology", {"Input": mesh}, 0), ("WallSpacing", {"Input": mesh}, 1),
                    ("BSplineVolumeQuality", {"Input": volume}, 0), ("BSplineVolumeSmoothness", {"Input": volume}, 4),
                    ("BodyDeviation", {"Input": volume, "Body": body}, 0),
                    ("BSplineVolumeDifference", {"Input": other, "Before": volume}, 0),
                    ("BSplineVolumeSampler", {"Input": volume}, 0), ("BSplineVolumeToBezierCells", {"Input": volume}, 0)):
                source = getattr(simple, name)(**inputs)
                pictures.append((name, measured(source, port)))
                simple.Delete(source)
            simple.Delete(other)
        for name, (first, frame) in pictures:
            print("| %d | %s | %.2f | %.2f | %.3f | %.2f |" % (
                points, name, first, first / reference[0], frame, frame / reference[1]), flush=True)
        simple.Delete(volume)
        simple.Delete(mesh)


if __name__ == "__main__":
    main(*sys.argv[1:])
