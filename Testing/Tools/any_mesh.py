# SPDX-License-Identifier: BSD-3-Clause
"""Any hexahedral mesh in: prints what is kept behind ParaView's filters, and which blocks are found, as tables.

    pvpython Testing/Tools/any_mesh.py build/lib/BSplineVolume/BSplineVolume.so [FOLDER_OF_HEX_MESHES] [MOST_BLOCKS]

First table: a mesh of three blocks with two contacts and eight named faces goes through a filter, then through the
conversion; compared with the conversion of the mesh that should come out, made directly.

Second table: unstructured hexahedra. Those of the folder (VTK and MFEM files), and lattices of blocks of 4^3
cells with holes, whose cells, points and corners are numbered at random. Every cell must be in one block, and another
numbering must give the same bits. Processor seconds and memory (peak beyond the input, by its size) are those of Hex Mesh To
Blocks. The ways in which CGNS says the same are printed by `TestMeshFileHabits --gtest_filter=*EightWays`.
"""
import glob
import itertools
import os
import sys
import time

PLUGIN = os.path.abspath(sys.argv[1])
os.environ["BSV_PLUGIN"] = PLUGIN
for folder in (os.path.join(os.path.dirname(__file__), "..", "Python"), os.path.dirname(PLUGIN)):
    sys.path.insert(0, os.path.abspath(folder))
import bsv_support  # noqa: E402
from bsv_support import bits, blocks, client, collection, failure, grid, producer, simple, update, vtk  # noqa: E402

bsv_support.main = lambda tests: None  # the meshes of the tests, not the tests
import TestConnectivity as connectivity  # noqa: E402
import TestHexMeshToBlocks as hexahedra  # noqa: E402


def row(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def control_points(data):
    """Whatever the order and directions of the blocks."""
    return sorted(block.GetPoint(p) for block in blocks(data) for p in range(block.GetNumberOfPoints()))


def contacts(data):
    array = data.GetFieldData().GetArray("Interfaces")
    return array.GetNumberOfTuples() if array else 0


def compare(name, filtered, expected, value=bits):
    data, report, warnings = connectivity.convert(filtered)
    other, other_report, _ = connectivity.convert(expected)
    names = connectivity.roles(report)
    same = value(data) == value(other)
    wanted = connectivity.roles(other_report)
    row(name, len(blocks(data)), contacts(data),
        "as expected" if names == wanted else "%s, expected %s" % (names, wanted), "same bits" if same else "DIFFERENT",
        "; ".join(warnings) or "none")
    return same and names == wanted


def filters():
    """The first table. Returns whether all is as it should be."""
    source = connectivity.read()
    parts = blocks(client(source).GetOutputDataObject(0))
    direct = connectivity.direct
    transform = simple.Transform(Input=source)
    transform.Transform.Translate = [0.0, 0.0, 8.0]
    moved = connectivity.with_names([grid(connectivity.COUNTS[b], lambda i, j, k, b=b: tuple(
        x + (8.0 if d == 2 else 0.0) for d, x in enumerate(connectivity.block_points(b, i, j, k)))) for b in range(3)],
        connectivity.NAMES)
    reversed_tree = vtk.vtkMultiBlockDataSet()
    for n, b in enumerate((2, 0, 1)):
        reversed_tree.SetBlock(n, parts[b])
    subset = simple.ExtractSubset(Input=source, VOI=[2, 6, 0, 4, 1, 4])
    one = simple.ExtractBlock(Input=subset, Assembly="Assembly", Selectors=connectivity.selectors(source, [0]))
    row("filter", "blocks", "contacts", "named faces", "control points", "warnings")
    row(*["---"] * 6)
    good = [compare("none", source, direct([0, 1, 2])),
            compare("Extract Block, 2 of 3", simple.ExtractBlock(
                Input=source, Assembly="Assembly", Selectors=connectivity.selectors(source, [1, 2])), direct([1, 2])),
            compare("Extract Block, both ends", simple.ExtractBlock(
                Input=source, Assembly="Assembly", Selectors=connectivity.selectors(source, [0, 2])), direct([0, 2])),
            compare("Extract Subset, a box of one block", one,
                    direct([0], (2, 0, 1), (4, 4, 3), named=[(0, 2, "symmetry")])),
            compare("Extract Subset, every second point", simple.ExtractSubset(
                Input=source, VOI=[0, 8, 0, 8, 0, 8], SampleRateI=2, SampleRateJ=2, SampleRateK=2),
                direct([0, 1, 2], step=2)),
            compare("Transform", transform, moved),
            compare("another order of blocks", producer(reversed_tree), direct([2, 0, 1])),
            compare("Group Datasets", simple.GroupDatasets(Input=[producer(part) for part in parts]), direct([0, 1, 2])),
            compare("Merge Blocks", simple.MergeBlocks(Input=source), connectivity.whole()),
            compare("Append Datasets", simple.AppendDatasets(Input=[source]), connectivity.whole()),
            compare("Clean To Grid", simple.CleantoGrid(Input=simple.MergeBlocks(Input=source)), connectivity.whole()),
            compare("Reflect, without the input", simple.Reflect(Input=source, Plane="Z", Center=0.0, CopyInput=0),
                    connectivity.with_names([grid((24, 6, 4), lambda i, j, k: (
                        *connectivity.bent(i, j, k)[:2], -connectivity.bent(i, j, k)[2]))], connectivity.WHOLE),
                    control_points),
            compare("Programmable Filter", simple.ProgrammableFilter(
                Input=source, Script="output.ShallowCopy(inputs[0].VTKObject)", CopyArrays=0), direct([0, 1, 2])),
            compare("Calculator", simple.Calculator(Input=source, Function="coordsX"), direct([0, 1, 2]))]
    surface = failure(simple.CatmullClarkToBSplineVolume(Input=simple.ExtractSurface(Input=source)))
    row("Extract Surface", "", "", "", "refused", surface.split("): ", 1)[-1].strip())
    print()
    return all(good)


def lattice_of(count):
    """A lattice of voxels, without those whose coordinates are all odd, that has `count` voxels, each a block."""
    def voxels(a, b, c):
        return a * b * c - (a // 2) * (b // 2) * (1 if c == 1 else c // 2)
    if count == 1:
        return 1, 1, 1
    found = [n for n in itertools.product(range(3, 40), repeat=3) if n[0] <= n[1] and voxels(*n) == count]
    found += [(a, b, 1) for a, b in itertools.product(range(3, 200), repeat=2) if a <= b and voxels(a, b, 1) == count]
    return sorted(found, key=lambda n: n[0] + n[1] + n[2])[0]


def lattice(count, cells=4):
    a, b, c = lattice_of(count)
    size = 1.0 / cells

    def bent(x, y, z):
        return x + 0.01 * y * y, y, z
    return collection([grid((cells,) * 3, lambda i, j, k, x=x, y=y, z=z: bent(
        x + i * size, y + j * size, z + k * size)) for z in range(c) for y in range(b) for x in range(a)
        if count == 1 or not (x % 2 and y % 2 and (c == 1 or z % 2))])


def status(key):
    with open("/proc/self/status") as lines:
        return [1024 * int(line.split()[1]) for line in lines if line.startswith(key)][0]


def decompose(data):
    """Output, report, seconds, and memory by that of the input."""
    source = producer(data)
    source.UpdatePipeline()
    proxy = simple.HexMeshToBlocks(Input=source, MaximumNumberOfBlocks=100000)
    with open("/proc/self/clear_refs", "w") as peak:
        peak.write("5")
    before, start = status("VmRSS"), time.process_time()
    made, _ = update(proxy)
    seconds, memory = time.process_time() - start, status("VmHWM") - before
    proxy.UpdatePropertyInformation()
    return made, str(proxy.Report), seconds, memory / (1024.0 * data.GetActualMemorySize())


def linear_mfem(path):
    """The hexahedra of an MFEM mesh v1.0 whose vertices have coordinates."""
    with open(path) as file:
        words = " ".join(line.split("#")[0] for line in file).split()
    at = words.index("elements")
    corners = [[int(v) for v in words[at + 4 + 10 * n:at + 12 + 10 * n]] for n in range(int(words[at + 1]))]
    at = words.index("vertices")
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    for n in range(int(words[at + 1])):
        points.InsertNextPoint([float(x) for x in words[at + 3 + 3 * n:at + 6 + 3 * n]])
    data = vtk.vtkUnstructuredGrid()
    data.SetPoints(points)
    data.Allocate(len(corners))
    for cell in corners:
        data.InsertNextCell(hexahedra.HEX, 8, cell)
    return data


def each_once(made, cells):
    found = []
    for block in blocks(made):
        ids = block.GetCellData().GetArray("OriginalCellIds")
        found += [int(ids.GetValue(n)) for n in range(ids.GetNumberOfTuples())]
    return sorted(found) == list(range(cells))


def decompositions(folder, most):
    row("mesh", "cells", "blocks", "processor seconds", "memory by the input's", "each cell once", "another numbering",
        "converted")
    row(*["---"] * 8)
    good = True
    meshes = []
    for path in sorted(glob.glob(os.path.join(folder, "*"))) if folder else []:
        if path.endswith(".mesh"):
            data = linear_mfem(path)
        else:
            reader = simple.LegacyVTKReader(FileNames=[path])
            reader.UpdatePipeline()
            data = client(reader).GetOutputDataObject(0)
        meshes.append((os.path.basename(path), collection([data]), None, None))
    for count in (1, 8, 100, 1000, 10000):
        if count <= most:
            meshes.append(("lattice", lattice(count), count, count <= 1000))
    for name, data, count, structured in meshes:
        random = hexahedra.unstructured(data, 1)
        made, report, seconds, memory = decompose(random)
        other = decompose(hexahedra.unstructured(data, 2))[0]
        once = each_once(made, random.GetNumberOfCells())
        same = hexahedra.geometry(made) == hexahedra.geometry(other)
        converted = ""
        if structured:
            equal = hexahedra.control_points(hexahedra.converted(made)) == \
                hexahedra.control_points(hexahedra.converted(data))
            converted = "same bits as the structured mesh" if equal else "DIFFERENT"
            good = good and equal
        good = good and once and same and count in (None, len(blocks(made)))
        row(name, random.GetNumberOfCells(), "%d%s" % (len(blocks(made)), " of %d" % count if count else ""),
            "%.2f" % seconds, "%.1f" % memory, "yes" if once else "NO", "same bits" if same else "DIFFERENT", converted)
    print()
    return good


if __name__ == "__main__":
    ALL = [filters(), decompositions(sys.argv[2] if len(sys.argv) > 2 else "",
                                     int(sys.argv[3]) if len(sys.argv) > 3 else 1000)]
    sys.exit(0 if all(ALL) else 1)
