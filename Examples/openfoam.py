# SPDX-License-Identifier: BSD-3-Clause
"""From the wing source to a solved flow solver's case and back: levels of the volume as OpenFOAM cases, a Laplace
equation solved on each by laplacianFoam, the results read by ParaView.

Sample runs (needs OpenFOAM, for example Debian's package openfoam):
    pvpython Examples/openfoam.py                      levels 0 and 1, and level 0 with wall level 2
    pvpython Examples/openfoam.py --resolution 6 --folder cases

1. WingFuselageSource makes the mesh, the conversion the volume.
2. The sampler makes levels; Wall Level refines the cells at the wall alone.
3. The Hex Block Mesh Writer writes constant/polyMesh, with a patch per boundary.
4. laplacianFoam solves for a temperature: 1 on walls, 0 in the far field; checkMesh reports on the mesh.
5. ParaView reads the case.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

from paraview import simple as pv

from example_support import load_plugin, parser

HEADER = "FoamFile { version 2.0; format ascii; class %s; object %s; }\n"
CONTROL = """application laplacianFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;
writeControl timeStep; writeInterval 1; writeFormat ascii; writePrecision 10;
"""
SCHEMES = """ddtSchemes { default steadyState; } gradSchemes { default Gauss linear; } divSchemes { default none; }
laplacianSchemes { default Gauss linear limited 0.5; } interpolationSchemes { default linear; }
snGradSchemes { default limited 0.5; }
"""
SOLUTION = """solvers { T { solver PCG; preconditioner DIC; tolerance 1e-9; relTol 0; } }
SIMPLE { nNonOrthogonalCorrectors 20; }
"""


def write(path, kind, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as file:
        file.write(HEADER % (kind, os.path.basename(path)) + text)


def run(case, command):
    """Runs an OpenFOAM program in a case and returns what it printed."""
    environment = dict(os.environ)
    environment.setdefault("WM_PROJECT_DIR", "/usr/share/openfoam")
    result = subprocess.run([command], cwd=case, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            text=True)
    return result.returncode, result.stdout


def set_up(case):
    """Dictionaries and the temperature field of a case whose mesh is written."""
    write(os.path.join(case, "system", "controlDict"), "dictionary", CONTROL)
    write(os.path.join(case, "system", "fvSchemes"), "dictionary", SCHEMES)
    write(os.path.join(case, "system", "fvSolution"), "dictionary", SOLUTION)
    write(os.path.join(case, "constant", "transportProperties"), "dictionary", "DT DT [0 2 -1 0 0 0 0] 1;\n")
    with open(os.path.join(case, "constant", "polyMesh", "boundary")) as file:
        patches = re.findall(r"(\S+)\s*\{\s*type\s+(\w+);", file.read().split("(\n", 1)[1])
    values = []
    for name, kind in patches:
        value = {"wall": "type fixedValue; value uniform 1;", "symmetry": "type symmetry;"}.get(
            kind, "type fixedValue; value uniform 0;")
        values.append("%s { %s }" % (name, value))
    write(os.path.join(case, "0", "T"), "volScalarField",
          "dimensions [0 0 0 1 0 0 0]; internalField uniform 0;\nboundaryField\n{\n%s\n}\n" % "\n".join(values))


def solve(case):
    """Solves on a mesh and returns its cells, checkMesh's verdict and the last residual."""
    set_up(case)
    _, checked = run(case, "checkMesh")
    code, text = run(case, "laplacianFoam")
    residuals = re.findall(r"Solving for T, Initial residual = (\S+), Final residual = (\S+),", text)
    if code != 0 or not residuals:
        raise SystemExit(case + ": laplacianFoam failed\n" + text[-2000:])
    worst = re.search(r"non-orthogonality Max: (\S+)", checked).group(1)
    skewness = re.search(r"Max skewness = ([0-9.]+)", checked).group(1)
    verdict = "OK" if "Mesh OK" in checked else "failed"
    return verdict, float(worst), float(skewness), float(residuals[0][0]), float(residuals[-1][0])


def read(file):
    """Range of the temperature that ParaView reads back."""
    reader = pv.OpenFOAMReader(FileName=file)
    reader.MeshRegions = ["internalMesh"]
    reader.CellArrays = ["T"]
    reader.UpdatePipeline(1.0)
    array = reader.CellData["T"]
    return array.GetRange(), reader.GetDataInformation().GetNumberOfCells()


def main():
    options = parser(__doc__.split("\n")[0], mesh=False)
    options.add_argument("--resolution", type=int, default=4, help="resolution of the wing source (default: 4)")
    options.add_argument("--folder", default="", help="folder of the cases (default: a temporary one)")
    arguments = options.parse_args()
    if not shutil.which("laplacianFoam"):
        print("laplacianFoam is missing; install OpenFOAM", file=sys.stderr)
        raise SystemExit(77)
    load_plugin(arguments.plugin)
    folder = arguments.folder or tempfile.mkdtemp()
    volume = pv.CatmullClarkToBSplineVolume(Input=pv.WingFuselageSource(Resolution=arguments.resolution))
    print("case              cells  checkMesh  non-orth.  skewness  residual first..last   T")
    for name, options in (("level0", {"Level": 0}), ("level1", {"Level": 1}),
                          ("level0_wall2", {"Level": 0, "WallLevel": 2})):
        case = os.path.join(folder, name)
        os.makedirs(case, exist_ok=True)
        file = os.path.join(case, name + ".foam")
        pv.SaveData(file, proxy=pv.BSplineVolumeSampler(Input=volume, **options))
        verdict, worst, skewness, first, last = solve(case)
        (low, high), cells = read(file)
        print("%-14s %8d  %-9s  %8.2f  %8.2f  %.1e..%.1e  %.4f..%.4f" % (
            name, cells, verdict, worst, skewness, first, last, low, high))
        if not (last < 1e-3 * first and low > -0.1 and high < 1.1):
            raise SystemExit("the solution has not converged")
    if arguments.folder:
        print("cases in " + folder)


if __name__ == "__main__":
    main()
