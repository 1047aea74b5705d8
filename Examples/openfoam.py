# SPDX-License-Identifier: BSD-3-Clause
"""From the wing source to a solved flow solver's case and back: mesh and levels of the volume as OpenFOAM cases,
checked by checkMesh, solved by laplacianFoam and potentialFoam, the results read by ParaView.

Sample runs (needs OpenFOAM, for example Debian's package openfoam):
    pvpython Examples/openfoam.py                      levels 0 and 1, and level 0 with wall level 2; writes a picture
    pvpython Examples/openfoam.py --resolution 6 --folder cases

1. WingFuselageSource makes the mesh, the conversion the volume.
2. The sampler makes levels; Wall Level refines the cells at the wall alone.
3. The Hex Block Mesh Writer writes constant/polyMesh, with a patch per boundary.
4. laplacianFoam solves for a temperature: 1 on walls, 0 in the far field; potentialFoam for the potential of a flow along
   x; checkMesh reports on these meshes, the input mesh and level 2.
5. ParaView reads the cases and shows the temperature.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

from paraview import simple as pv

from example_support import data, load_plugin, look, parser, save, show, views

HEIGHT = 600
HEADER = "FoamFile { version 2.0; format ascii; class %s; object %s; }\n"
CONTROL = """application laplacianFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;
writeControl timeStep; writeInterval 1; writeFormat ascii; writePrecision 10;
"""
SCHEMES = """ddtSchemes { default steadyState; } gradSchemes { default Gauss linear; } divSchemes { default none; div(phi,U) Gauss linear; }
laplacianSchemes { default Gauss linear limited 0.5; } interpolationSchemes { default linear; }
snGradSchemes { default limited 0.5; }
"""
SOLUTION = """solvers
{
T { solver PCG; preconditioner DIC; tolerance 1e-9; relTol 0; }
Phi { solver PCG; preconditioner DIC; tolerance 1e-9; relTol 0; }
p { solver PCG; preconditioner DIC; tolerance 1e-9; relTol 0; }
}
SIMPLE { nNonOrthogonalCorrectors 20; }
potentialFlow { nNonOrthogonalCorrectors 20; PhiRefCell 0; PhiRefValue 0; pRefCell 0; pRefValue 0; }
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
    for field, kind, dimensions, start, wall, far in (
            ("T", "volScalarField", "0 0 0 1 0 0 0", "0", "fixedValue; value uniform 1", "fixedValue; value uniform 0"),
            ("U", "volVectorField", "0 1 -1 0 0 0 0", "(1 0 0)", "slip",
             "inletOutlet; inletValue uniform (1 0 0); value uniform (1 0 0)"),
            ("p", "volScalarField", "0 2 -2 0 0 0 0", "0", "zeroGradient", "zeroGradient")):
        values = ["%s { type %s; }" % (name, {"wall": wall, "symmetry": "symmetry"}.get(type_, far))
                  for name, type_ in patches]
        write(os.path.join(case, "0", field), kind,
              "dimensions [%s]; internalField uniform %s;\nboundaryField\n{\n%s\n}\n" % (
                  dimensions, start, "\n".join(values)))


def check(case):
    """checkMesh's verdict, largest non-orthogonality in degrees and largest skewness."""
    set_up(case)
    _, text = run(case, "checkMesh")
    worst = re.search(r"non-orthogonality Max: (\S+)", text).group(1)
    skewness = re.search(r"Max skewness = ([0-9.]+)", text).group(1)
    return "OK" if "Mesh OK" in text else "failed", float(worst), float(skewness)


def solve(case, program, field):
    """First initial residuals of a program's first and last correction, and what it printed."""
    code, text = run(case, program)
    residuals = re.findall(r"Solving for %s, Initial residual = ([0-9.e+-]+)," % field, text)
    if code != 0 or not residuals:
        raise SystemExit(case + ": " + program + " failed\n" + text[-2000:])
    return float(residuals[0]), float(residuals[-1]), text


def read(file):
    """The temperature that ParaView reads back: reader, range and number of cells."""
    reader = pv.OpenFOAMReader(FileName=file)
    reader.MeshRegions = ["internalMesh"]
    reader.CellArrays = ["T"]
    reader.UpdatePipeline(1.0)
    array = reader.CellData["T"]
    return reader, array.GetRange(), reader.GetDataInformation().GetNumberOfCells()


def show_results(results, path):
    """Picture of the temperature beside the symmetry plane."""
    layout, windows = views(["%s: temperature, %s cells" % (name, format(cells, ",")) for name, _, cells in results],
                            HEIGHT)
    for view, (_, reader, _) in zip(windows, results):
        part = pv.Slice(Input=reader)
        part.SliceType.Origin = [0.0, 0.15, 0.0]
        part.SliceType.Normal = [0.0, 1.0, 0.0]
        part.UpdatePipeline(1.0)
        show(part, view, array=("CELLS", "T"), representation="Surface With Edges", EdgeColor=[0.2, 0.2, 0.2])
        view.ViewTime = 1.0
        look(view, [-3.0, 3.0, 0.0, 0.3, -2.0, 2.0], [0.0, -1.0, 0.0], zoom=1.2)
    save(path, layout, HEIGHT)


def main():
    options = parser(__doc__.split("\n")[0], "openfoam.png", mesh=False)
    options.add_argument("--resolution", type=int, default=4, help="resolution of the wing source (default: 4)")
    options.add_argument("--folder", default="", help="folder of the cases (default: a temporary one)")
    arguments = options.parse_args()
    if not shutil.which("laplacianFoam"):
        print("laplacianFoam is missing; install OpenFOAM", file=sys.stderr)
        raise SystemExit(77)
    load_plugin(arguments.plugin)
    folder = arguments.folder or tempfile.mkdtemp()
    mesh = pv.WingFuselageSource(Resolution=arguments.resolution)
    volume = pv.CatmullClarkToBSplineVolume(Input=mesh)
    print("case              cells  checkMesh  non-orth.  skewness  T residual first..last  Phi residual first..last  "
          "continuity  T")
    results = []
    for name, options in (("input", None), ("level0", {"Level": 0}), ("level1", {"Level": 1}),
                          ("level0_wall2", {"Level": 0, "WallLevel": 2}), ("level2", {"Level": 2})):
        case = os.path.join(folder, name)
        os.makedirs(case, exist_ok=True)
        file = os.path.join(case, name + ".foam")
        source = pv.BSplineVolumeSampler(Input=volume, **options) if options else mesh
        pv.SaveData(file, proxy=source)
        cells = data(source).GetNumberOfElements(1)
        line = "%-14s %8d  %-9s  %8.2f  %8.2f" % (name, cells, *check(case))
        if name not in ("input", "level2"):
            first, last, _ = solve(case, "laplacianFoam", "T")
            start, end, text = solve(case, "potentialFoam", "Phi")
            reader, (low, high), cells = read(file)
            line += "  %.1e..%.1e       %.1e..%.1e         %s  %.4f..%.4f" % (
                first, last, start, end, re.findall(r"Continuity error = (\S+)", text)[-1], low, high)
            if not (last < 1e-3 * first and end < 1e-2 * start and low > -0.1 and high < 1.1):
                raise SystemExit(line + "\nthe solution has not converged")
            results.append((name, reader, cells))
        print(line, flush=True)
    show_results(results[1:], arguments.output)
    if arguments.folder:
        print("cases in " + folder)
    else:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
