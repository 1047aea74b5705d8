# SPDX-License-Identifier: BSD-3-Clause
"""vtkBSplineVolumeSmoothness through its proxy: the four outputs on a converted mesh and on a bent pair of blocks,
colours, bad input, abort."""
import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (aborted, simple, vtk, blocks, client, collection, demo_mesh, field, grid, main, messages,
                         names, producer, update, values)

DEMO = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(8), UseCreaseAngle=1)
ORDER = ("open", "C0", "G1", "C1", "C2")
POINT_ARRAYS = {"Gap": 1, "NormalJump": 2, "WorstNormalJump": 1, "LayerJump": 1, "Kink": 1, "C1Jump": 1, "C2Jump": 1}
MEASURES = ("Gap", "NormalJump", "LayerJump", "Kink", "C1Jump", "C2Jump")


def add_field(data, name, numbers, integer=False):
    array = vtk.vtkIntArray() if integer else vtk.vtkDoubleArray()
    array.SetName(name)
    for number in numbers:
        array.InsertNextValue(number)
    data.GetFieldData().AddArray(array)


def box(place, degree=1):
    """One Bezier block with the control points place(u, v, w)."""
    data = grid((degree,) * 3, lambda i, j, k: place(i / degree, j / degree, k / degree))
    add_field(data, "Degree", [degree] * 3, integer=True)
    for name in ("KnotsU", "KnotsV", "KnotsW"):
        add_field(data, name, [0.0] * (degree + 1) + [1.0] * (degree + 1))
    return data


def bent(degrees, gap=0.0):
    """Two unit cubes that meet at x = 0; the second one turns towards y."""
    c, s = (f(math.radians(degrees)) for f in (math.cos, math.sin))
    return collection([box(lambda u, v, w: (u - 1, v, w)), box(lambda u, v, w: (c * u + gap, s * u + v, w))])


def smoothness(data, **properties):
    return simple.BSplineVolumeSmoothness(Input=data if hasattr(data, "SMProxy") else producer(data), **properties)


def table(proxy):
    """Rows of the table as dictionaries."""
    data = client(proxy).GetOutputDataObject(2)
    columns = {data.GetColumnName(c): values(data.GetColumn(c)) for c in range(data.GetNumberOfColumns())}
    return [{name: column[row] for name, column in columns.items()} for row in range(data.GetNumberOfRows())]


def total(proxy, name):
    """Information-only property, as the panel shows it."""
    proxy.UpdatePropertyInformation()
    return proxy.GetProperty(name)[0]


def severity(row):
    """What rows of the same continuity are sorted by, from the documentation."""
    name = {"open": "Gap", "C0": "LayerJump", "G1": "C1Jump", "C1": "C2Jump", "C2": "C2Jump"}[row["Continuity"]]
    assert row["RankedBy"] == name
    return row["Maximum" + name]


def test_properties():
    proxy = smoothness(DEMO)
    assert proxy.SamplesPerSpan == 3 and proxy.CreaseAngle == 30 and not proxy.AllOuterFaces
    assert proxy.Tolerance == 1e-6 and proxy.GapTolerance == 1e-10 and proxy.MatchTolerance == 0.05
    assert len(proxy.BodyBoundaries) == 6


def test_converted_mesh():
    proxy = smoothness(DEMO)
    surfaces, _ = update(proxy)
    volume = client(DEMO).GetOutputDataObject(0)
    contacts = field(volume, "Interfaces")
    block_names = names(volume)

    # Interfaces: one each, with all arrays; maxima are at least what is seen at the samples.
    assert len(blocks(surfaces)) == len(contacts) == total(proxy, "NumberOfInterfaces")
    for n, (surface, contact) in enumerate(zip(blocks(surfaces), contacts)):
        a, face_a, b, face_b, code = (int(x) for x in contact[:5])
        assert names(surfaces)[n] == block_names[a] + "|" + block_names[b]
        assert field(surface, "InterfaceId") == [n] and field(surface, "Blocks") == [a, b]
        assert field(surface, "Faces") == [face_a, face_b] and field(surface, "Orientation") == [code]
        assert len(field(surface, "Valences")) == 4
        for name, components in POINT_ARRAYS.items():
            array = surface.GetPointData().GetArray(name)
            assert array.GetNumberOfTuples() == surface.GetNumberOfPoints()
            assert array.GetNumberOfComponents() == components
        for name in MEASURES:
            points = surface.GetPointData().GetArray("WorstNormalJump" if name == "NormalJump" else name)
            spans = surface.GetCellData().GetArray("Span" + name)
            assert spans.GetNumberOfTuples() == surface.GetNumberOfCells()
            assert points.GetRange()[1] <= spans.GetRange()[1] == field(surface, "Maximum" + name)[0]
        assert max(values(surface.GetPointData().GetArray("Gap"))) == 0.0

    # The table: sorted, and the same maxima.
    rows = table(proxy)
    assert len(rows) == len(contacts) + total(proxy, "NumberOfWallBorders")
    keys = [(row["Kind"] == "crease", ORDER.index(row["Continuity"]), -severity(row)) for row in rows]
    assert keys == sorted(keys)
    assert {row["Kind"] for row in rows} == {"interface", "wall border", "crease"}
    assert {row["Continuity"] for row in rows if row["Kind"] == "interface"} <= {"C0", "G1", "C1", "C2"}
    maxima = sorted(row["MaximumC2Jump"] for row in rows if row["Kind"] == "interface")
    assert maxima == sorted(field(surface, "MaximumC2Jump")[0] for surface in blocks(surfaces))
    for row in rows:
        assert row["NameA"] == block_names[int(row["BlockA"])] and row["NameB"] == block_names[int(row["BlockB"])]
        assert row["MaximumNormalJump"] == max(row["MaximumNormalJumpS"], row["MaximumNormalJumpT"])
        assert row["MaximumLayerJump"] <= row["MaximumNormalJump"]
        assert (row["EdgeA"] < 0) == (row["Kind"] == "interface")
    # The rim of the body is sharp by about a right angle, and meant to be.
    assert all(row["MaximumNormalJump"] > 30 for row in rows if row["Kind"] == "crease")

    # Blocks: what the table says, and the totals.
    skins = client(proxy).GetOutputDataObject(1)
    assert names(skins) == block_names
    for b, skin in enumerate(blocks(skins)):
        mine = [row for row in rows if b in (row["BlockA"], row["BlockB"]) and row["Kind"] != "crease"]
        for name in MEASURES:
            expected = max(row["Maximum" + name] for row in mine)
            assert field(skin, name) == [expected]
            assert skin.GetCellData().GetArray(name).GetRange() == (expected, expected)
        worst = int(field(skin, "WorstJoin")[0])
        assert rows[worst] == mine[0]
        assert field(skin, "Continuity") == [ORDER.index(mine[0]["Continuity"])]
    for name in MEASURES:
        expected = max(row["Maximum" + name] for row in rows if row["Kind"] != "crease")
        assert total(proxy, "Maximum" + name) == expected == field(surfaces, "Maximum" + name)[0]

    # Curves: the four extraordinary curves of the demonstration mesh have valence 3.
    curves = client(proxy).GetOutputDataObject(3)
    kinds = values(curves.GetCellData().GetArray("Kind"))
    valences = values(curves.GetCellData().GetArray("Valence"))
    assert {v for k, v in zip(kinds, valences) if k == 0} == {3}
    assert kinds.count(0) == total(proxy, "NumberOfExtraordinaryCurves") > 0
    assert kinds.count(2) == sum(row["Kind"] == "crease" for row in rows) > 0
    assert curves.GetPointData().GetArray("NormalJump").GetNumberOfTuples() == curves.GetNumberOfPoints()
    report = client(proxy).GetReport()
    assert "%d interfaces: " % len(contacts) in report and "worst of all" in report


def test_all_outer_faces_and_patterns():
    wall = smoothness(DEMO)
    every = smoothness(DEMO, AllOuterFaces=1)
    nothing = smoothness(DEMO, BodyBoundaries=["no such name"])
    counts = []
    for proxy in (wall, every, nothing):
        update(proxy)
        counts.append(total(proxy, "NumberOfWallBorders"))
    assert counts[0] < counts[1] == counts[2]


def test_known_joins():
    proxy = smoothness(bent(7))
    surfaces, _ = update(proxy)
    row = [r for r in table(proxy) if r["Kind"] == "interface"][0]
    assert abs(row["MaximumKink"] - 7) < 1e-12 and abs(row["MaximumNormalJump"] - 7) < 1e-12
    assert abs(row["MaximumC1Jump"] - 2 * math.sin(math.radians(3.5))) < 1e-14
    assert row["Continuity"] == "G1"  # the layers y = const are flat, those z = const too: only one family kinks
    assert names(surfaces) == ["block 0|block 1"]

    proxy = smoothness(bent(0, gap=1e-9))
    update(proxy)
    row = table(proxy)[0]
    assert row["Continuity"] == "open" and abs(row["MaximumGap"] - 1e-9) < 1e-16
    assert abs(row["Where"][0] - 0.5e-9) < 1e-15

    # A single grid has no interface; a multi-block data set is as good as a collection.
    single = smoothness(box(lambda u, v, w: (u, v, w)))
    update(single)
    assert total(single, "NumberOfInterfaces") == 0
    assert [row["Kind"] for row in table(single)] == ["crease"] * 12
    assert field(blocks(client(single).GetOutputDataObject(1))[0], "WorstJoin") == [-1]
    tree = vtk.vtkMultiBlockDataSet()
    for b, block in enumerate(blocks(bent(7))):
        tree.SetBlock(b, block)
    proxy = smoothness(tree)
    update(proxy)
    assert total(proxy, "NumberOfInterfaces") == 1


def test_colours():
    """The arrays can be used for colours, and blocks tell apart."""
    proxy = smoothness(DEMO)
    proxy.UpdatePipeline()
    for port, arrays in ((0, ("WorstNormalJump", "C1Jump", "C2Jump")), (3, ("NormalJump", "Valence"))):
        information = simple.OutputPort(proxy, port).PointData
        for name in arrays:
            low, high = information[name].GetRange()
            assert 0 <= low < high
    first = (blocks(client(proxy).GetOutputDataObject(0))[0].GetPointData(),
             blocks(client(proxy).GetOutputDataObject(1))[0].GetCellData(),
             client(proxy).GetOutputDataObject(3).GetPointData())
    assert [data.GetScalars().GetName() for data in first] == ["Layer jump (degrees)", "LayerJump", "NormalJump"]
    information = simple.OutputPort(proxy, 1).CellData
    for name in ("NormalJump", "C1Jump", "C2Jump"):
        low, high = information[name].GetRange()
        assert 0 <= low <= high > 0


def test_threads_do_not_matter():
    found = []
    for threads in (1, 2):
        vtk.vtkSMPTools.Initialize(threads)
        proxy = smoothness(DEMO)
        data, _ = update(proxy)
        found.append([bytes(memoryview(surface.GetPointData().GetArray(name)))
                      for surface in blocks(data) for name in POINT_ARRAYS] + [table(proxy)])
    assert found[0] == found[1]


def failure(proxy):
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert len(caught["errors"]) == 1, caught
    for port in (0, 1):
        assert blocks(client(proxy).GetOutputDataObject(port)) == []
    assert client(proxy).GetOutputDataObject(2).GetNumberOfRows() == 0
    assert client(proxy).GetOutputDataObject(3).GetNumberOfPoints() == 0
    return caught["errors"][0]


def test_errors():
    assert "it is no B-spline volume" in failure(smoothness(grid((2, 2, 2), lambda i, j, k: (i, j, k))))

    broken = bent(0)
    blocks(broken)[1].GetPoints().SetPoint(0, 0.0, float("nan"), 0.0)
    assert "is not finite" in failure(smoothness(broken))
    twice = vtk.vtkIntArray()
    twice.SetName("Interfaces")
    twice.SetNumberOfComponents(12)
    twice.InsertNextTuple((0, 1, 1, 0) + (0,) * 8)
    broken.GetFieldData().AddArray(twice)
    text = failure(smoothness(broken))
    assert "block 1 'block 1'" in text and "is not finite" in text, text
    good = bent(0)
    twice.InsertNextTuple((0, 1, 1, 0) + (0,) * 8)
    good.GetFieldData().AddArray(twice)
    assert "is in two interfaces" in failure(smoothness(good))

    for name, value, text in (("Tolerance", -1, "tolerance"), ("GapTolerance", float("nan"), "Gap Tolerance"),
                              ("MatchTolerance", 0.5, "MatchTolerance")):
        proxy = smoothness(bent(0))
        getattr(client(proxy), "Set" + name)(value)
        assert text in failure(proxy)

    assert "has no B-spline volume" in failure(smoothness(vtk.vtkPartitionedDataSetCollection()))


def test_abort():
    aborted(smoothness(DEMO))


if __name__ == "__main__":
    main(globals())
