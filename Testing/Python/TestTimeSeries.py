# SPDX-License-Identifier: BSD-3-Clause
"""Several files are time steps: behind the filters each is as if it had been read alone."""
import json
import os
import shutil
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import simple, vtk, bits, blocks, client, coordinates, failure, field, main, messages, update, values

FOLDER = tempfile.TemporaryDirectory()


def place(b, i, j, k, time):
    """Two blocks in a row, swaying with time; exact in single precision."""
    x, y, z = 4.0 * b + i, float(j), float(k)
    return x, y + time * x * x / 64, z + time * y / 32


def write(name, time, neutral_map=False):
    path = os.path.join(FOLDER.name, name)
    with open(path, "w") as out:
        print(2, "\n5 4 3\n5 4 3", file=out)
        for b in range(2):
            points = [place(b, i, j, k, time) for k in range(3) for j in range(4) for i in range(5)]
            for d in range(3):
                print(*(repr(p[d]) for p in points), file=out)
    if neutral_map:
        with open(os.path.splitext(path)[0] + ".nmf", "w") as out:
            print("2\n1 5 4 3\n2 5 4 3", file=out)
            print("ONE_TO_ONE 1 4 1 4 1 3 2 3 1 4 1 3 FALSE", file=out)
            for b in (1, 2):
                print("'the wall'", b, "1 1 5 1 4", file=out)
    return path


PATHS = [write("sway_%d.xyz" % n, n, n == 0) for n in range(3)]


def times(proxy):
    proxy.UpdatePipelineInformation()
    found = proxy.TimestepValues
    return list(found) if hasattr(found, "__len__") else [found]


def at(proxy, time):
    with messages(proxy) as caught:
        proxy.UpdatePipeline(time)
    assert not caught["errors"], caught["errors"]
    data = client(proxy).GetOutputDataObject(0)
    copy = data.NewInstance()
    copy.ShallowCopy(data)
    return copy, caught["warnings"]


def points(data):
    return [bytes(memoryview(coordinates(block))) for block in blocks(data)]


def expect_steps(reader, expected):
    """(time asked for, number of the file) per step: points, names and the converted volume."""
    conversion = simple.CatmullClarkToBSplineVolume(Input=reader, BodyBoundaries=["the*"])
    keys = set()
    for time, number in expected:
        data, warnings = at(reader, time)
        assert not warnings, warnings
        alone = simple.HexBlockMeshReader(FileName=PATHS[number], NeutralMapFile=PATHS[0][:-3] + "nmf")
        assert points(data) == points(update(alone)[0]), (time, number)
        assert field(data, "BoundaryNames") == ["the wall"] and len(field(data, "Interfaces")) == 1
        keys.add(tuple(field(data, "MeshBlockKeys")))
        volume, warnings = at(conversion, time)
        assert not warnings, warnings
        assert bits(volume) == bits(update(simple.CatmullClarkToBSplineVolume(
            Input=alone, BodyBoundaries=["the*"]))[0]), (time, number)
    # The same blocks at all times.
    assert len(keys) == 1


def test_files():
    reader = simple.HexBlockMeshReader(FileName=PATHS)
    assert times(reader) == [0, 1, 2]
    # Any order of asking; between two times the earlier one.
    expect_steps(reader, [(0, 0), (2, 2), (1, 1), (1.75, 1), (0, 0), (-1, 0), (7, 2)])
    data, _ = at(reader, 1.75)
    assert data.GetInformation().Get(vtk.vtkDataObject.DATA_TIME_STEP()) == 1
    # A single file has no time.
    alone = simple.HexBlockMeshReader(FileName=PATHS[1])
    assert not times(alone) or times(alone) == [None], times(alone)
    assert points(at(alone, 5)[0]) == points(update(alone)[0])


def test_opening_a_group_of_files():
    reader = simple.OpenDataFile(PATHS)
    assert reader.SMProxy.GetXMLName() == "HexBlockMeshReader"
    assert times(reader) == [0, 1, 2]
    scene = simple.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    assert list(scene.TimeKeeper.TimestepValues) == [0, 1, 2]
    conversion = simple.CatmullClarkToBSplineVolume(Input=reader)
    seen = []
    scene.GoToFirst()
    for _ in range(3):
        conversion.UpdatePipeline(scene.TimeKeeper.Time)
        seen.append(bits(client(conversion).GetOutputDataObject(0)))
        scene.GoToNext()
    assert len(set(seen)) == 3
    simple.Delete(conversion)
    simple.Delete(reader)


def write_list(name, entries):
    path = os.path.join(FOLDER.name, name)
    with open(path, "w") as out:
        json.dump({"file-series-version": "1.0", "files": entries}, out, indent=2)
    return path


def test_lists_of_files():
    names = [os.path.basename(path) for path in PATHS]
    path = write_list("sway.xyz.series", [{"name": names[0], "time": 0.5}, {"name": PATHS[2], "time": 2},
                                          {"time": 3e1, "name": names[1]}])
    for reader in (simple.HexBlockMeshReader(FileName=path), simple.OpenDataFile(path)):
        assert reader.SMProxy.GetXMLName() == "HexBlockMeshReader"
        assert times(reader) == [0.5, 2, 30]
        expect_steps(reader, [(0.5, 0), (2, 2), (30, 1), (29, 2)])


def test_names_in_lists():
    # Python writes what is not ASCII as codes.
    strange = os.path.join(FOLDER.name, "Flügel {1} \\ \U0001d54f.xyz")
    shutil.copy(PATHS[0], strange)
    shutil.copy(os.path.splitext(PATHS[0])[0] + ".nmf", os.path.splitext(strange)[0] + ".nmf")
    reader = simple.HexBlockMeshReader(FileName=write_list("strange.series", [
        {"comment": "a } b", "name": os.path.basename(strange), "time": "0.5"}, {"name": PATHS[2], "time": 2}]))
    assert times(reader) == [0.5, 2]
    expect_steps(reader, [(0.5, 0), (2, 2)])


def test_wrong_lists():
    many = "x" * 400000
    for name, text, words in (("long.series", '{"files": [{"name": "%s", "time": 0}]}' % many, ["no such file"]),
                              ("late.series", '{"files": [\n{"name": "a", "time": late}]}', ["line 2", "'late'"]),
                              ("comma.series", '{"files": [{"name": "a", "time": "1,5"}]}', ["entry 0", "'1,5'"]),
                              ("nan.series", '{"files": [{"name": "a", "time": nan}]}', ["line 1", "'nan'"]),
                              ("self.series", '{"files": [{"name": "self.series"}]}', ["entry 0", "a list itself"]),
                              ("cut.series", '{"files": [{"name": "a', ["line 1", "should be"]),
                              ("nul.series", '{"files": [\n{"name": "a\\u0000b"}]}', ["line 2", "no character"]),
                              ("half.series", '{"files": [\n{"name": "a\\ud83d\\u0041"}]}', ["line 2", "no character"]),
                              ("zero.series", '{"files": [\n{"name": "a\0b"}]}', ["line 2", "a byte of 0"]),
                              ("short.series", "a", ["names no files"]),
                              ("nested.series", '{"files": [{"name": "a", "time": [0]}]}', ["entry 0"])):
        with open(os.path.join(FOLDER.name, name), "w") as out:
            out.write(text)
        error = failure(simple.HexBlockMeshReader(FileName=os.path.join(FOLDER.name, name)))
        assert all(word in error for word in words), error[:300]
    for name, entries, words in (("no_names.series", [{"time": 1}], ["entry 0", "name"]),
                                 ("empty.series", [], ["names no files"]),
                                 ("back.series", [{"name": "a", "time": 1}, {"name": "b", "time": 0}],
                                  ["entry 1", "'", "not later"])):
        error = failure(simple.HexBlockMeshReader(FileName=write_list(name, entries)))
        assert all(word in error for word in words + [name]), error
    error = failure(simple.HexBlockMeshReader(FileName=os.path.join(FOLDER.name, "none.series")))
    assert "none.series" in error
    # A step that is missing is an error of that step only.
    reader = simple.HexBlockMeshReader(FileName=[PATHS[0], os.path.join(FOLDER.name, "gone.xyz"), PATHS[2]])
    at(reader, 0)
    with messages(reader) as caught:
        reader.UpdatePipeline(1)
    assert len(caught["errors"]) == 1 and "gone.xyz" in caught["errors"][0], caught
    at(reader, 2)


def test_volumes():
    # The other readers take series in the same way.
    saved = []
    for n, path in enumerate(PATHS[:2]):
        saved.append(os.path.join(FOLDER.name, "volume_%d.qfmb" % n))
        mesh = simple.HexBlockMeshReader(FileName=path)
        simple.SaveData(saved[-1], proxy=simple.CatmullClarkToBSplineVolume(Input=mesh))
    reader = simple.QuadflowReader(FileName=saved)
    assert times(reader) == [0, 1]
    for n in (1, 0):
        assert points(at(reader, n)[0]) == points(update(simple.QuadflowReader(FileName=saved[n]))[0])


main(globals())
