# SPDX-License-Identifier: BSD-3-Clause
"""BSpline Volume Difference through its proxy: what it says of a volume that is the same, moved as a whole, and of one
with other joins; volumes of other blocks are refused."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import client, failure, main, simple, update, values

MESH = simple.WingFuselageSource(Resolution=3)
VOLUME = simple.CatmullClarkToBSplineVolume(Input=MESH, CheckJoins=0)


def difference(after, before):
    """The filter, up to date, and its outputs."""
    compare = simple.BSplineVolumeDifference(Input=after, Before=before)
    update(compare)
    return client(compare), [client(compare).GetOutputDataObject(port) for port in range(4)]


def blocks(collection):
    return [collection.GetPartition(n, 0) for n in range(collection.GetNumberOfPartitionedDataSets())]


def columns(table):
    return [values(table.GetColumnByName(name)) for name in
            ("1 Change (degrees)", "2 Before (degrees)", "3 After (degrees)")]


def test_same():
    compare, (_wall, _net, joins, verdict) = difference(VOLUME, VOLUME)
    assert compare.GetMaximumDisplacement() == compare.GetMaximumWallDisplacement() == 0.0
    assert compare.GetNumberOfSmootherJoins() == compare.GetNumberOfRougherJoins() == 0
    assert compare.GetNumberOfDefects() == compare.GetNumberOfDefectsBefore()
    assert set(columns(joins)[0]) == {0.0} and joins.GetNumberOfRows() > 186
    assert "bit for bit" in verdict.GetColumnByName("Text").GetValue(0)


def test_moved():
    # A volume moves with its control points.
    way = [0.25, -0.5, 1.0]
    length = sum(x * x for x in way) ** 0.5
    moved = simple.Transform(Input=simple.OutputPort(VOLUME, 0), Transform="Transform")
    moved.Transform.Translate = way
    compare, (wall, net, joins, _verdict) = difference(moved, VOLUME)
    assert len(blocks(net)) == 79 and 0 < len(blocks(wall)) < 79
    for part in blocks(wall) + blocks(net):
        displacement = part.GetPointData().GetArray("Displacement")
        for n in range(part.GetNumberOfPoints()):
            assert all(abs(a - b) <= 1e-12 for a, b in zip(displacement.GetTuple(n), way))
        assert max(abs(x - length) for x in values(part.GetPointData().GetArray("Moved"))) <= 1e-12
    assert abs(compare.GetMaximumWallDisplacement() - length) <= 1e-12
    assert compare.GetNumberOfSmootherJoins() == compare.GetNumberOfRougherJoins() == 0
    # Jumps do not depend on the place, but for rounding.
    assert max(map(abs, columns(joins)[0])) <= 1e-6


def test_other_joins():
    # As the filter Smoothness measures them, and the other way round the other way round.
    other = simple.CatmullClarkToBSplineVolume(Input=MESH, CheckJoins=0, Continuity="ExactG1")
    compare, (_wall, _net, joins, _verdict) = difference(other, VOLUME)
    back, (_wall, _net, turned, _verdict) = difference(VOLUME, other)
    assert compare.GetNumberOfSmootherJoins() == back.GetNumberOfRougherJoins() > 0
    assert compare.GetNumberOfDefects() == back.GetNumberOfDefectsBefore()
    assert compare.GetMaximumWallDisplacement() > 0.0 < back.GetMaximumWallDisplacement()
    # Blocks with double knots have other control points.
    assert "control points are not compared" in compare.GetReport()
    change, before, after = columns(joins)
    assert [abs(x) for x in change] == sorted((abs(x) for x in change), reverse=True)
    assert all(a - b == c for a, b, c in zip(after, before, change))
    assert change == [-x for x in columns(turned)[0]]
    for volume, jumps in ((VOLUME, before), (other, after)):
        smoothness = simple.BSplineVolumeSmoothness(Input=volume)
        update(smoothness)
        table = client(smoothness).GetOutputDataObject(2)
        kinds = values(table.GetColumnByName("Kind"))
        measured = [values(table.GetColumnByName("MaximumNormalJump" if kind == "crease" else "MaximumLayerJump"))[n]
                    for n, kind in enumerate(kinds)]
        assert sorted(measured) == sorted(jumps)


def test_errors():
    finer = simple.CatmullClarkToBSplineVolume(Input=simple.WingFuselageSource(Resolution=4), CheckJoins=0)
    message = failure(simple.BSplineVolumeDifference(Input=finer, Before=VOLUME))
    assert "block 0 '" in message and "not the same blocks" in message, message


if __name__ == "__main__":
    main(globals())
