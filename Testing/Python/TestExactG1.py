# SPDX-License-Identifier: BSD-3-Clause
"""Continuity ExactG1 through ParaView: no kinks at extraordinary curves, and all filters and the writer take the knots."""
import math
import os
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import blocks, client, collection, failure, field, grid, main, producer, simple, update


def ring(valence=5, cells=5):
    """Bent blocks around one extraordinary edge."""
    spokes = [(math.cos(2 * math.pi * k / valence), math.sin(2 * math.pi * k / valence)) for k in range(valence + 1)]
    spokes[valence] = spokes[0]

    def place(sector, i, j, k):
        (ax, ay), (bx, by) = spokes[sector], spokes[sector + 1]
        x, y, z = i * ax + j * bx, i * ay + j * by, 1.0 * k
        return x + 0.3 * math.sin(0.5 * y + 0.2 * z), y + 0.2 * math.cos(0.4 * x), z + 0.3 * math.sin(0.5 * x + 0.3 * y)

    return producer(collection([grid((cells, cells, 4), lambda i, j, k, s=s: place(s, i, j, k))
                                for s in range(valence)]))


MESH = ring()
SINGLE = simple.CatmullClarkToBSplineVolume(Input=MESH)
EXACT = simple.CatmullClarkToBSplineVolume(Input=MESH, Continuity="ExactG1")


def layer_jumps(volume):
    """Largest angle between the layers on both sides of an interface, degrees."""
    smoothness = simple.BSplineVolumeSmoothness(Input=volume)
    update(smoothness)
    smoothness.UpdatePropertyInformation()
    return smoothness.MaximumLayerJump


def test_kinks_vanish():
    update(SINGLE)
    update(EXACT)
    single, exact = layer_jumps(SINGLE), layer_jumps(EXACT)
    assert single > 0.05, single
    assert exact < 1e-5, exact
    report = client(EXACT).GetReport()
    assert "exact G1 at" in report, report


def test_only_classes_with_extraordinary_neighbours_change():
    for a, b in zip(blocks(update(SINGLE)[0]), blocks(update(EXACT)[0])):
        for name in ("KnotsU", "KnotsV", "KnotsW"):
            before, after = field(a, name), field(b, name)
            assert set(before) == set(after)
            assert len(after) in (len(before), len(before) + 2), (before, after)


def test_all_filters_take_the_knots():
    quality = simple.BSplineVolumeQuality(Input=EXACT)
    update(quality)
    update(simple.BSplineVolumeSampler(Input=EXACT, Level=1))
    update(simple.BSplineVolumeToBezierCells(Input=EXACT))
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "exact.qfmb")
        simple.SaveData(path, proxy=EXACT)
        read = simple.OpenDataFile(path)
        for a, b in zip(blocks(update(EXACT)[0]), blocks(update(read)[0])):
            for name in ("KnotsU", "KnotsV", "KnotsW"):
                assert field(a, name) == field(b, name)
            assert a.GetNumberOfPoints() == b.GetNumberOfPoints()
            assert a.GetPoints().GetBounds() == b.GetPoints().GetBounds()


def test_pccm_needs_double_knots():
    wrong = simple.CatmullClarkToBSplineVolume(Input=MESH, Twist="PCCM")
    assert "ExactG1" in failure(wrong)
    wrong.Continuity = "ExactG1"
    assert layer_jumps(wrong) < 1e-5


if __name__ == "__main__":
    main(globals())
