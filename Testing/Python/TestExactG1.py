# SPDX-License-Identifier: BSD-3-Clause
"""Continuity ExactG1 through ParaView: no kinks at extraordinary curves, and all filters and the writer take the knots."""
import os
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import bits, blocks, client, demo_mesh, field, main, simple, update, values

MESH = demo_mesh(6)
SINGLE = simple.CatmullClarkToBSplineVolume(Input=MESH)
EXACT = simple.CatmullClarkToBSplineVolume(Input=MESH, Continuity="ExactG1")


def layer_jumps(volume):
    """Largest kink along the extraordinary curves inside the volume."""
    smoothness = simple.BSplineVolumeSmoothness(Input=volume)
    update(smoothness)
    curves = client(smoothness).GetOutputDataObject(3)
    kinds = values(curves.GetCellData().GetArray("Kind"))
    jumps = values(curves.GetPointData().GetArray("NormalJump"))
    worst = 0.0
    for cell, kind in enumerate(kinds):
        points = curves.GetCell(cell).GetPointIds()
        if kind == 0:
            for i in range(points.GetNumberOfIds()):
                jump = jumps[points.GetId(i)]
                worst = max(worst, max(jump) if isinstance(jump, tuple) else jump)
    return worst


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
    quality.UpdatePropertyInformation()
    assert quality.InvalidSpans == 0 if hasattr(quality, "InvalidSpans") else True
    update(simple.BSplineVolumeSampler(Input=EXACT, Level=1))
    update(simple.BSplineVolumeToBezier(Input=EXACT))
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
    from bsv_support import failure
    assert "ExactG1" in failure(wrong)
    wrong.Continuity = "ExactG1"
    assert layer_jumps(wrong) < 1e-5


if __name__ == "__main__":
    main(globals())
