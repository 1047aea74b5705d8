# SPDX-License-Identifier: BSD-3-Clause
"""The Python package without ParaView: conversion, evaluation and its inverse, files, errors, the command."""
import contextlib
import io
import os
import re
import shutil
import tempfile

import bsplinevolume as bsv
import numpy as np
from bsplinevolume.__main__ import main as command
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkAppendFilter
from vtkmodules.vtkIOLegacy import vtkUnstructuredGridWriter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

RANDOM = np.random.default_rng(7)


def wing(resolution=3):
    source = bsv.vtkWingFuselageSource()
    source.SetResolution(resolution)
    return source


def random_parameters(block, n):
    low, high = block.range.T
    return low + (high - low) * RANDOM.random((n, 3))


def test_convert():
    seen = []
    volume = bsv.convert(wing(), progress=lambda fraction: seen.append(fraction))
    assert len(volume.blocks) == 79 and volume.report and seen and seen == sorted(seen)
    block = volume.blocks[0]
    assert block.degree == (3, 3, 3) and block.points.shape[:3] == block.rules.shape
    assert [len(k) for k in block.knots] == [n + 4 for n in reversed(block.rules.shape)]
    # A view of VTK's memory.
    block.points[0, 0, 0, 0] += 1.0
    assert block.grid.GetPoint(0)[0] == block.points[0, 0, 0, 0]
    assert re.fullmatch(r"\d+\.\d+\.\d+", bsv.__version__)


def test_evaluate_agrees_with_the_sampler():
    volume = bsv.convert(wing())
    for block, samples in zip(volume.blocks[::13], volume.sample(1)[::13]):
        axes = [np.linspace(*r, n) for r, n in zip(block.range, reversed(samples.shape[:3]))]
        w, v, u = np.meshgrid(*reversed(axes), indexing="ij")
        points = block.evaluate(u, v, w)
        assert np.abs(points - samples).max() <= 1e-14 * np.abs(samples).max()


def test_derivatives_are_limits_of_differences():
    block = bsv.convert(wing()).blocks[5]
    uvw = block.range.mean(axis=1) + 0.3
    _, slopes = block.evaluate(*uvw, derivatives=1)
    for d in range(3):
        h = np.eye(3)[d] * 1e-5
        difference = (block.evaluate(*(uvw + h)) - block.evaluate(*(uvw - h))) / 2e-5
        assert np.linalg.norm(difference - slopes[d]) <= 1e-8 * np.linalg.norm(slopes[d])


def test_locate_is_the_inverse():
    volume = bsv.convert(wing())
    count = 40
    truth = [random_parameters(block, count) for block in volume.blocks]
    points = np.concatenate([block.evaluate(*uvw.T) for block, uvw in zip(volume.blocks, truth)])
    blocks, uvw = volume.locate(points)
    assert (blocks == np.repeat(np.arange(len(volume.blocks)), count)).all()
    assert np.abs(uvw - np.concatenate(truth)).max() <= 1e-9
    again = np.stack([volume.evaluate(b, *x) for b, x in zip(blocks, uvw)])
    assert np.abs(again - points).max() <= 1e-12 * np.abs(points).max()
    # Inside the body and far away there is no volume.
    outside, nothing = volume.locate([[1e3, 0, 0], [0, 1e6, 0]])
    assert (outside == -1).all() and np.isnan(nothing).all()


def test_multiblock():
    """The same blocks and names; and PyVista, where it is installed, takes them."""
    volume = bsv.convert(wing())
    for level in None, 0:
        data = volume.to_vtk() if level is None else volume.sampled(level)
        blocks = volume.to_multiblock(level)
        assert blocks.GetNumberOfBlocks() == len(volume.blocks)
        for n in range(blocks.GetNumberOfBlocks()):
            assert blocks.GetBlock(n) is data.GetPartition(n, 0) or level is not None
            assert blocks.GetBlock(n).GetBounds() == data.GetPartition(n, 0).GetBounds()
            assert blocks.GetMetaData(n).Get(blocks.NAME()) == volume.blocks[n].name
        with contextlib.suppress(ImportError):
            import pyvista
            wrapped = pyvista.wrap(blocks)
            assert wrapped.n_blocks == len(volume.blocks) and tuple(wrapped.bounds) == tuple(blocks.GetBounds())


def test_files_and_measures():
    volume = bsv.convert(wing())
    joins = volume.smoothness()
    assert len({len(column) for column in joins.values()}) == 1
    quality = volume.quality()
    cells = sum(np.prod([len(np.unique(k)) - 1 for k in block.knots]) for block in volume.blocks)
    assert quality["valid"] + quality["invalid"] + quality["undecided"] == cells
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "wing.qfmb")
        volume.write(path)
        again = bsv.read(path)
        assert all((a.points == b.points).all() for a, b in zip(volume.blocks, again.blocks))
        mesh = os.path.join(folder, "wing.xyz")
        volume.write(mesh, level=0)
        text = io.StringIO()
        with contextlib.redirect_stdout(text):
            status = command(["check", mesh])
        assert status == 0 and "0 invalid" in text.getvalue()
        with contextlib.redirect_stdout(text):
            assert command(["convert", mesh, "--output", os.path.join(folder, "b.qfmb")]) == 0
        assert os.path.exists(os.path.join(folder, "b.qfmb"))
        with contextlib.redirect_stderr(text):
            assert command(["check", os.path.join(folder, "missing.xyz")]) == 3
        assert "missing.xyz does not exist" in text.getvalue()


def test_report():
    with tempfile.TemporaryDirectory() as folder:
        mesh = os.path.join(folder, "wing.xyz")
        bsv.convert(wing()).write(mesh, level=0)
        path = os.path.join(folder, "report.html")
        with contextlib.redirect_stdout(io.StringIO()):
            assert command(["report", mesh, "--crease-angle", "40", "--output", path]) == 0
        with open(path, encoding="utf-8") as file:
            text = file.read()
    quality = bsv.convert(wing()).quality()
    assert f"{quality['valid']} spans proven valid" in text and "CreaseAngle" in text
    # One row per block, and the pictures.
    table = text[text.index("<h2>Blocks"):text.index("<h2>Settings")]
    assert table.count("<tr>") == 1 + int(re.search(r"of (\d+)\)", table).group(1))
    pictures = re.findall(r"data:image/png;base64,([^']+)", text)
    assert len(pictures) == 4 and all(len(picture) > 5000 for picture in pictures), [len(p) for p in pictures]


def test_meshes_of_vtk():
    """The same volume from blocks and from their cells as one unstructured mesh, through VTK's files."""
    volume = bsv.convert(wing())
    data = volume.sampled(0)
    with tempfile.TemporaryDirectory() as folder:
        grids = []
        whole = vtkAppendFilter()
        whole.MergePointsOn()
        for n in range(data.GetNumberOfPartitionedDataSets()):
            grids.append(data.GetPartition(n, 0))
            whole.AddInputData(grids[-1])
        whole.Update()
        for ending, writer in ((".vtu", vtkXMLUnstructuredGridWriter()), (".vtk", vtkUnstructuredGridWriter())):
            path = os.path.join(folder, "cells" + ending)
            writer.SetFileName(path)
            writer.SetInputData(whole.GetOutput())
            if ending == ".vtk":
                writer.SetFileTypeToBinary()
            writer.Write()
            from_cells = bsv.convert(path)
            sizes = [sum(int(np.prod([len(set(k)) - 1 for k in block.knots])) for block in v.blocks)
                     for v in (from_cells, bsv.convert(data))]
            assert sizes[0] == sizes[1], sizes
            quality = from_cells.quality()
            assert quality["invalid"] == 0
        broken = os.path.join(folder, "broken.vtu")
        with open(path.replace(".vtk", ".vtu"), "rb") as file, open(broken, "wb") as copy:
            copy.write(file.read()[:2000])
        text = io.StringIO()
        with contextlib.redirect_stderr(text):
            assert command(["check", broken]) == 3
        assert text.getvalue().startswith("error: ") and len(text.getvalue()) > 10


def test_settings_of_the_command():
    with tempfile.TemporaryDirectory() as folder:
        mesh = os.path.join(folder, "wing.xyz")
        bsv.convert(wing()).write(mesh, level=0)

        def run(*words):
            text = io.StringIO()
            with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
                status = command(["convert", mesh] + [word for setting in words for word in ("--set", setting)] +
                                 ["--output", os.path.join(folder, "out.qfmb")])
            return status, text.getvalue()

        status, _ = run("Continuity=ExactG1", "WallSpacing=0.5")
        assert status == 0
        expected = bsv.convert(mesh, CheckJoins=True, Continuity=1, WallSpacing=0.5)
        again = bsv.read(os.path.join(folder, "out.qfmb"))
        assert all((a.points == b.points).all() for a, b in zip(expected.blocks, again.blocks))
        # A list of one.
        status, text = run("BodyBoundaries=wall_wing")
        assert status == 0 and "wall_wing: body" in text and "wall_fuselage: far field" in text, text
        for setting, words in (("Continuity=G2", "Continuity is SingleKnots or ExactG1, not G2"),
                               ("Continuity=7", "Continuity does not take 7"), ("Continity=ExactG1", "is it Continuity?"),
                               ("WallSpacing=wide", "WallSpacing does not take 'wide'"), ("WallSpacing", "PROPERTY=VALUE")):
            status, text = run(setting)
            assert status == 3 and words in text, (setting, text)


def test_mistakes_in_the_command():
    with tempfile.TemporaryDirectory() as folder:
        mesh = os.path.join(folder, "wing.xyz")
        bsv.convert(wing()).write(mesh, level=0)
        gone = os.path.join(folder, "gone", "out")
        first, body = mesh[:-4] + "_L0.xyz", mesh[:-4] + ".igs"
        shutil.copy(mesh, first)
        bsv.convert(wing()).write(body)

        def run(*words):
            text = io.StringIO()
            with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
                try:
                    status = command(list(words))
                except SystemExit as end:
                    status = end.code
            return status, text.getvalue()

        # Before any work.
        for words, expected in ((("convert", mesh, "--body-faces", "a,b"), "pairs of block and face"),
                                (("convert", mesh, "--body-faces", "0"), "pairs of block and face"),
                                (("convert", mesh, "--output", gone + ".qfmb"), "no folder"),
                                (("convert", mesh, "--output", mesh + ".txt"), "no writer for the ending '.txt'"),
                                (("report", mesh, "--output", gone + ".html"), "no folder"),
                                (("levels", mesh, os.path.join(folder, "level")), "no writer for the ending ''"),
                                (("levels", mesh, os.path.join(folder, "level.qfmb")), "no levels"),
                                (("levels", mesh, os.path.join(folder, "level.cgns"), "--levels", "-1"), "invalid choice"),
                                (("levels", mesh, os.path.join(folder, "level.cgns"), "--levels", "9"), "invalid choice"),
                                (("convert", mesh, "--level", "9"), "invalid choice"),
                                (("convert", mesh, "--output", mesh), "replace the input " + mesh),
                                (("convert", mesh, "--output", mesh[:-4] + ".p3d"), "replace the input " + mesh[:-4] + ".nmf"),
                                (("convert", mesh, "--body-file", body, "--output", body), "replace the input " + body),
                                (("report", mesh, "--output", mesh), "replace the input " + mesh),
                                (("levels", first, mesh, "--levels", "1"), "replace the input " + first)):
            status, text = run(*words)
            assert status in (2, 3) and expected in text and "spans" not in text, (words, status, text)
        # Cases of OpenFOAM are folders: no level replaces another.
        status, text = run("levels", mesh, os.path.join(folder, "case.foam"), "--levels", "1")
        points = [os.path.join(folder, "case_L%d" % n, "constant", "polyMesh", "points") for n in range(2)]
        assert status == 0 and os.path.getsize(points[0]) < os.path.getsize(points[1]), text


def test_errors():
    for call, words in ((lambda: bsv.convert("missing.xyz"), "missing.xyz does not exist"),
                        (lambda: bsv.convert(wing(), WallSpacing=2.0), "2"),
                        (lambda: bsv.convert(vtkUnstructuredGrid()), "the input has no hexahedra"),
                        (lambda: bsv.convert(vtkPolyData()), "vtkImageData, not vtkPolyData"),
                        (lambda: bsv.convert(None), "not builtins.NoneType"),
                        (lambda: bsv.convert(np.zeros((3, 3, 3, 3))), "not numpy.ndarray"),
                        (lambda: bsv.convert(os.path.dirname(__file__)), "it is a folder"),
                        (lambda: bsv.convert(__file__), "Fortran writes stars"),
                        (lambda: bsv.convert(wing(), body=os.fsencode(__file__)), "neither an IGES, STEP"),
                        (lambda: bsv.read(__file__), "can read")):
        try:
            call()
        except bsv.Error as error:
            assert words in str(error), str(error)
        else:
            raise AssertionError(words + ": no error")
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "wing.qfmb")
        bsv.convert(wing()).write(file)
        for call in (lambda: bsv.convert(file), lambda: bsv.convert(wing(), body=file)):
            try:
                call()
            except bsv.Error as error:
                assert "it is a volume" in str(error), str(error)
            else:
                raise AssertionError("a volume was taken for a mesh or a body")
    try:
        bsv.convert(wing(), NoSuchProperty=1)
    except TypeError as error:
        assert "NoSuchProperty" in str(error)
    else:
        raise AssertionError("an unknown property was taken")


if __name__ == "__main__":
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            test()
            print(name, "passed")
