# SPDX-License-Identifier: BSD-3-Clause
"""What other programs say of our files: cgnscheck, checkMesh, plot3dToFoam, gmsh. A program that is missing is named and
its part left out."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import cgrid, client, simple, demo_mesh, half_turn_ring, main, messages, producer, update

import openfoam  # the example
from TestBSplineVolumeWriter import ogrid

VOLUME = simple.CatmullClarkToBSplineVolume(Input=demo_mesh(8), UseCreaseAngle=1)
WING = simple.CatmullClarkToBSplineVolume(Input=simple.WingFuselageSource(Resolution=3))
PROGRAMS = {name: shutil.which(name) for name in ("cgnscheck", "checkMesh", "plot3dToFoam", "gmsh")}


def has(name):
    if not PROGRAMS[name]:
        print(name, "is missing: left out")
    return bool(PROGRAMS[name])


def write(writer, source, path, **properties):
    """Writes without an error. Returns the warnings."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    proxy = getattr(simple.servermanager.writers, writer)(Input=source, FileName=path, **properties)
    source.UpdatePipeline()
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert not caught["errors"], caught["errors"]
    return caught["warnings"]


def run(*command, folder=None):
    environment = dict(os.environ, WM_PROJECT_DIR=os.environ.get("WM_PROJECT_DIR", "/usr/share/openfoam"))
    result = subprocess.run(command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            text=True)
    return result.stdout


def test_cgns():
    if has("cgnscheck"):
        with tempfile.TemporaryDirectory() as folder:
            for writer, source in (("HexBlockMeshWriter", simple.BSplineVolumeSampler(Input=WING, Level=0)),
                                   ("BSplineVolumeWriter", VOLUME)):
                path = os.path.join(folder, "a.cgns")
                write(writer, source, path)
                text = run("cgnscheck", path)
                assert "checking complete" in text and not re.search(r"error", text, re.I), text


def test_openfoam():
    """Meshes with and without refinement at walls pass as level 0 does, and no face is much less orthogonal."""
    if has("checkMesh"):
        with tempfile.TemporaryDirectory() as folder:
            worst = []
            for name, options in (("a", {"Level": 0}), ("b", {"Level": 0, "WallLevel": 2})):
                samples = simple.BSplineVolumeSampler(Input=WING, **options)
                case = os.path.join(folder, name)
                write("HexBlockMeshWriter", samples, os.path.join(case, "a.foam"))
                openfoam.set_up(case)
                text = run("checkMesh", folder=case)
                assert "Mesh OK" in text, text
                cells = update(samples)[0].GetNumberOfElements(1)
                assert re.search(r"hexahedra:\s+%d\b" % cells, text), text
                assert all(re.search(r"\b%s\s+\d+" % patch, text) for patch in ("wall_wing", "symmetry", "farfield"))
                worst.append(float(re.search(r"non-orthogonality Max: (\S+)", text).group(1)))
            assert worst[1] <= 1.1 * worst[0], worst


def test_thin_cells_on_a_curved_wall():
    """Cells that are turned over by flat faces are those of which checkMesh finds wrong pyramids, and are said before;
    cells that are finer along the wall, too, are not."""
    for tangential, expected in ((0, True), (2, False)):
        samples = simple.BSplineVolumeSampler(Input=WING, Level=0, WallLevel=6, TangentialLevel=tangential)
        _, said = update(samples)
        assert bool(said) == ("cells are turned over" in client(samples).GetReport()) == expected, said
        if has("checkMesh"):
            with tempfile.TemporaryDirectory() as case:
                notes = write("HexBlockMeshWriter", samples, os.path.join(case, "a.foam"))
                openfoam.set_up(case)
                wrong = re.search(r"face pyramids: (\d+) faces", run("checkMesh", folder=case))
            assert bool(wrong) == bool(notes) == expected, (wrong, notes)
            if expected:
                # A face may have a wrong pyramid on either side.
                faces, cells = int(wrong.group(1)), int(re.search(r"(\d+) cells are turned over", notes[0]).group(1))
                assert faces <= cells <= 2 * faces, (faces, cells)


def test_plot3d():
    if has("plot3dToFoam"):
        with tempfile.TemporaryDirectory() as folder:
            samples = simple.BSplineVolumeSampler(Input=WING, Level=0)
            write("HexBlockMeshWriter", samples, os.path.join(folder, "a.xyz"), Encoding="ASCII")
            os.makedirs(os.path.join(folder, "system"))
            openfoam.write(os.path.join(folder, "system", "controlDict"), "dictionary", openfoam.CONTROL)
            text = run("plot3dToFoam", "-noBlank", "a.xyz", folder=folder)
            assert "FATAL" not in text and os.path.exists(os.path.join(folder, "constant", "polyMesh", "faces")), text


def smallest_jacobian(volume, folder, **properties):
    """Gmsh's smallest Jacobian determinant of the volume's curved cells."""
    write("BSplineVolumeWriter", volume, os.path.join(folder, "a.msh"), **properties)
    with open(os.path.join(folder, "a.geo"), "w") as file:
        file.write('Merge "a.msh";\nPlugin(AnalyseMeshQuality).JacobianDeterminant=1;\n'
                   "Plugin(AnalyseMeshQuality).CreateView=0;\n"
                   "Plugin(AnalyseMeshQuality).DimensionOfElements=3;\nPlugin(AnalyseMeshQuality).Run;\n")
    text = run("gmsh", "a.geo", "-nopopup", "-0", folder=folder)
    found = re.search(r"minJ\s+=\s*(\S+),", text)
    assert found and "Error" not in text, text
    return float(found.group(1))


def test_gmsh():
    """Gmsh's Jacobians are positive where ours are certified to be."""
    if has("gmsh"):
        quality = simple.BSplineVolumeQuality(Input=VOLUME)
        update(quality)
        with tempfile.TemporaryDirectory() as folder:
            for version in ("2.2", "4.1"):
                assert smallest_jacobian(VOLUME, folder, GmshVersion=version) > 0


def converted(mesh):
    return simple.CatmullClarkToBSplineVolume(Input=producer(mesh))


def test_block_that_meets_itself():
    """One block around an axis, right- and left-handed, also turned by half a turn on its way, without names of
    boundaries; C-grids of one and two blocks, as they were read and refined."""
    cases = [(source, simple.BSplineVolumeSampler(Input=source, Level=1))
             for source in (ogrid(), ogrid(turned=True), converted(half_turn_ring()), converted(cgrid()))]
    cases += [(converted(cgrid(cut)), producer(cgrid(cut))) for cut in (None, 10)]
    for source, samples in cases:
        with tempfile.TemporaryDirectory() as folder:
            if has("cgnscheck"):
                for writer, data in (("HexBlockMeshWriter", samples), ("BSplineVolumeWriter", source)):
                    path = os.path.join(folder, "a.cgns")
                    write(writer, data, path)
                    text = run("cgnscheck", path)
                    assert "checking complete" in text and not re.search(r"error", text, re.I), text
            if has("checkMesh"):
                case = os.path.join(folder, "case")
                write("HexBlockMeshWriter", samples, os.path.join(case, "a.foam"))
                openfoam.set_up(case)
                assert "Mesh OK" in run("checkMesh", folder=case)
            if has("gmsh"):
                assert smallest_jacobian(source, folder) > 0


if __name__ == "__main__":
    if not any(PROGRAMS.values()):
        print("none of", ", ".join(PROGRAMS), "is installed")
        sys.exit(77)
    main(globals())
