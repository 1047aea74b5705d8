# SPDX-License-Identifier: BSD-3-Clause
"""Names and contacts of blocks behind ParaView's own filters: as if the mesh that comes out had been read directly."""
import os
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (simple, vtk, bits, blocks, client, collection, dimensions, failure, field, grid, main, names,
                         producer, update, values)

# Three blocks in a row along x, of which the second runs backwards in j and the third has its axes exchanged.
N = (8, 6, 4)


def bent(x, y, z):
    """A bent box of 24 x 6 x 4 cells, whose coordinates are exact in single precision."""
    return x + y * y / 16, y + x * z / 64, z + x * x / 512


def block_points(b, i, j, k):
    x, y, z = [(i, j, k), (8 + i, 6 - j, 4 - k), (16 + k, i, j)][b]
    return bent(x, y, z)


COUNTS = [(8, 6, 4), (8, 6, 4), (6, 4, 8)]
# block, face, name
NAMES = [(0, 0, "inlet"), (0, 4, "wall below"), (1, 5, "wall below"), (2, 2, "wall below"), (2, 5, "outlet"),
         (0, 2, "symmetry"), (1, 3, "symmetry"), (2, 0, "symmetry")]


def write_mesh(folder):
    """PLOT3D and a neutral map, so that the reader makes the mesh. Returns the path."""
    path = os.path.join(folder, "three.xyz")
    with open(path, "w") as out:
        print(3, file=out)
        for c in COUNTS:
            print(*(n + 1 for n in c), file=out)
        for b, c in enumerate(COUNTS):
            points = [block_points(b, i, j, k) for k in range(c[2] + 1) for j in range(c[1] + 1)
                      for i in range(c[0] + 1)]
            for d in range(3):
                print(*(repr(p[d]) for p in points), file=out)
    faces = {0: 3, 1: 4, 2: 5, 3: 6, 4: 1, 5: 2}  # of neutral maps
    axes = {0: (1, 2), 1: (1, 2), 2: (2, 0), 3: (2, 0), 4: (0, 1), 5: (0, 1)}
    with open(path[:-3] + "nmf", "w") as out:
        print(3, file=out)
        for b, c in enumerate(COUNTS):
            print(b + 1, *(n + 1 for n in c), file=out)
        # j, k of block 1 at i = 8 are 7 - j', 5 - k' of block 2 at i = 0.
        print("ONE_TO_ONE 1 4 1 7 1 5 2 3 7 1 5 1 FALSE", file=out)
        # j', k' of block 2 at i = 8 are y = 6 - j', z = 4 - k': i and j of block 3 at k = 0.
        print("ONE_TO_ONE 2 4 1 7 1 5 3 1 7 1 5 1 FALSE", file=out)
        for b, f, name in NAMES:
            s, t = (COUNTS[b][a] + 1 for a in axes[f])
            print("'%s'" % name, b + 1, faces[f], 1, s, 1, t, file=out)
    return path


FOLDER = tempfile.TemporaryDirectory()
PATH = write_mesh(FOLDER.name)


def read():
    reader = simple.HexBlockMeshReader(FileName=PATH)
    reader.UpdatePipeline()
    return reader


def convert(mesh, **properties):
    conversion = simple.CatmullClarkToBSplineVolume(Input=mesh, **properties)
    data, warnings = update(conversion)
    conversion.UpdatePropertyInformation()
    return data, str(conversion.Report), warnings


def roles(report):
    """Faces per boundary."""
    return {line.split(":")[0]: int(line.split(", ")[1].split()[0]) for line in report.split("\n")
            if line.endswith(" faces") and ": " in line and ", " in line}


def direct(chosen, lo=(0, 0, 0), counts=None, step=1, named=None):
    """The blocks chosen, or boxes of them, as a mesh made directly: contacts are found by the points."""
    grids = []
    for b in chosen:
        n = counts or COUNTS[b]
        grids.append(grid([c // step for c in n], lambda i, j, k, b=b: block_points(
            b, lo[0] + step * i, lo[1] + step * j, lo[2] + step * k)))
    return with_names(grids, [(chosen.index(b), f, name) for b, f, name in (NAMES if named is None else named)
                              if b in chosen])


def with_names(grids, entries):
    """Proxy of the grids as a mesh with named faces: block, face, name."""
    mesh = collection(grids)
    boundaries, texts = vtk.vtkIntArray(), vtk.vtkStringArray()
    boundaries.SetName("Boundaries")
    boundaries.SetNumberOfComponents(3)
    texts.SetName("BoundaryNames")
    tags = []
    for b, f, name in entries:
        if name not in tags:
            tags.append(name)
            texts.InsertNextValue(name)
        boundaries.InsertNextTypedTuple((b, f, tags.index(name)))
    mesh.GetFieldData().AddArray(boundaries)
    mesh.GetFieldData().AddArray(texts)
    return producer(mesh)


def expect_same(filtered, expected):
    """The conversion of a filter's output is that of the mesh made directly. Returns its report."""
    data, report, warnings = convert(filtered)
    other, other_report, _ = convert(expected)
    assert not warnings, warnings
    assert bits(data) == bits(other)
    assert roles(report) == roles(other_report), (roles(report), roles(other_report))
    return report


def selectors(source, chosen):
    assembly = client(source).GetOutputDataObject(0).GetDataAssembly()
    return [assembly.GetNodePath(assembly.GetChildNodes(0, False)[b]) for b in chosen]


def test_the_mesh_itself():
    report = expect_same(read(), direct([0, 1, 2]))
    assert roles(report) == {"inlet": 1, "outlet": 1, "wall below": 3, "symmetry": 3}
    assert "bring with them" not in report


def test_extract_block():
    source = read()
    for chosen in ([0], [1, 2], [0, 2], [2]):
        report = expect_same(simple.ExtractBlock(Input=source, Assembly="Assembly",
                                                 Selectors=selectors(source, chosen)), direct(chosen))
        kept = {(0,): 0, (1, 2): 1, (0, 2): 0, (2,): 0}[tuple(chosen)]
        brought = 2 if 0 in chosen and 1 in chosen else 1 if 0 in chosen or 1 in chosen else 0
        if brought:
            assert "%d of " % kept in report and "interfaces" in report, report


def test_extract_subset():
    # The plane k = 1 is no wall, and the sides keep their names.
    source = read()
    subset = simple.ExtractSubset(Input=source, VOI=[2, 6, 0, 4, 1, 4])
    single = simple.ExtractBlock(Input=subset, Assembly="Assembly", Selectors=selectors(source, [0]))
    expected = [(0, 2, "symmetry")]
    expect_same(single, direct([0], (2, 0, 1), (4, 4, 3), named=expected))
    # All three: whatever fits together still does.
    data, report, warnings = convert(subset)
    assert len(blocks(data)) >= 3 and "named boundaries" in report and "outlet" not in roles(report)


def test_extract_subset_with_sampling():
    # Coarsened everywhere: the contacts are those of the coarse mesh.
    coarse = simple.ExtractSubset(Input=read(), VOI=[0, 8, 0, 8, 0, 8], SampleRateI=2, SampleRateJ=2, SampleRateK=2)
    report = expect_same(coarse, direct([0, 1, 2], step=2))
    assert "2 of 2 interfaces" in report and "8 of 8 parts" in report, report


def test_partial_boundaries_and_contacts_follow_the_box():
    # A wall on i 2..6 of k = 0; what a box of the block keeps of it.
    def mesh():
        data = collection([grid((8, 4, 4), lambda i, j, k: bent(i, j, k))])
        boundaries, texts = vtk.vtkIntArray(), vtk.vtkStringArray()
        boundaries.SetName("Boundaries")
        boundaries.SetNumberOfComponents(7)
        boundaries.InsertNextTypedTuple((0, 4, 0, 2, 6, 0, 4))
        texts.SetName("BoundaryNames")
        texts.InsertNextValue("wall")
        data.GetFieldData().AddArray(boundaries)
        data.GetFieldData().AddArray(texts)
        return producer(data)

    # Mirrored at nothing: the filter hands the mesh on with what its blocks bring.
    tagged = simple.HexMeshToBlocks(Input=mesh())
    tagged.UpdatePipeline()
    for voi, rate, expected, noted in (([0, 8, 0, 4, 0, 4], 2, [(0, 4, 0, 1, 3, 0, 2)], False),
                                       ([4, 8, 0, 4, 0, 4], 1, [(0, 4, 0, 0, 2, 0, 4)], False),
                                       ([0, 8, 0, 4, 1, 4], 1, [], False),
                                       ([0, 8, 0, 4, 0, 4], 4, [], False)):
        box = simple.ExtractSubset(Input=tagged, VOI=voi, SampleRateI=rate, SampleRateJ=rate if rate == 2 else 1)
        topology = simple.HexBlockTopology(Input=box)
        data, _ = update(topology)
        array = data.GetFieldData().GetArray("Boundaries")
        found = [tuple(int(v) for v in t) for t in values(array)] if array else []
        found = [t if len(t) == 7 else t + (None,) * 4 for t in found]
        assert len(found) == len(expected), (voi, found)
        for a, b in zip(found, expected):
            assert a[:2] == b[:2] and (a[3] is None or a[3:] == b[3:]), (voi, found)


def test_reordering_and_grouping():
    source = read()
    update(source)
    data = client(source).GetOutputDataObject(0)
    parts = blocks(data)
    # One file per block, in another order.
    tree = vtk.vtkMultiBlockDataSet()
    for n, b in enumerate((2, 0, 1)):
        tree.SetBlock(n, parts[b])
    report = expect_same(producer(tree), direct([2, 0, 1]))
    assert "2 of 2 interfaces" in report, report
    singles = [simple.ExtractBlock(Input=source, Assembly="Assembly", Selectors=selectors(source, [b]))
               for b in range(3)]
    grouped = simple.GroupDatasets(Input=[producer(part) for part in parts])
    expect_same(grouped, direct([0, 1, 2]))
    assert singles


def test_transform():
    transform = simple.Transform(Input=read())
    transform.Transform.Translate = [0.0, 0.0, 8.0]
    data, report, warnings = convert(transform)
    assert not warnings
    assert roles(report) == {"inlet": 1, "outlet": 1, "wall below": 3, "symmetry": 3}
    assert len(field(data, "Interfaces")) == 2


def test_programmable_filters():
    keep = simple.ProgrammableFilter(Input=read(), Script="output.ShallowCopy(inputs[0].VTKObject)", CopyArrays=0)
    expect_same(keep, direct([0, 1, 2]))
    # Only the first two blocks, as leaves of a new tree with the arrays of the old one.
    script = ("c = inputs[0].VTKObject\noutput.SetNumberOfPartitionedDataSets(2)\n"
              "for n in range(2):\n    output.SetPartition(n, 0, c.GetPartition(1 - n, 0))\n")
    expect_same(simple.ProgrammableFilter(Input=read(), Script=script, CopyArrays=0), direct([1, 0]))


def test_reflect_and_merge_blocks():
    # Unstructured behind both; the blocks are found again. Names are those of the points.
    expected = {"inlet": 1, "outlet": 1, "wall below": 1, "symmetry": 1}
    merged = simple.MergeBlocks(Input=read())
    data, report, warnings = convert(merged)
    assert len(blocks(data)) == 1 and roles(report) == expected, report
    assert "unstructured hexahedra were made to 1 blocks" in report
    # The same bits as of the three blocks as one.
    whole = with_names([grid((24, 6, 4), bent)],
                       [(0, 0, "inlet"), (0, 1, "outlet"), (0, 2, "symmetry"), (0, 4, "wall below")])
    found, _ = update(simple.HexMeshToBlocks(Input=merged))
    assert sorted(dimensions(blocks(found)[0])) == [5, 7, 25]
    assert bits(data) == bits(convert(whole)[0])

    def control_points(data):
        return sorted(block.GetPoint(p) for block in blocks(data) for p in range(block.GetNumberOfPoints()))

    # Mirrored alone: what the mirrored mesh gives, in whatever direction its blocks run.
    mirrored = with_names([grid((24, 6, 4), lambda i, j, k: (*bent(i, j, k)[:2], -bent(i, j, k)[2]))], WHOLE)
    expected_points = control_points(convert(mirrored)[0])
    for source in (read(), without_contacts()):
        alone = simple.Reflect(Input=source, Plane="Z", Center=0.0, CopyInput=0)
        data, report, _ = convert(alone)
        assert roles(report) == expected, report
        assert control_points(data) == expected_points

    reflected = simple.Reflect(Input=read(), Plane="Z Min", CopyInput=1)
    data, report, warnings = convert(reflected)
    assert roles(report)["inlet"] >= 1 and "wall below" in roles(report), report


WHOLE = [(0, 0, "inlet"), (0, 1, "outlet"), (0, 2, "symmetry"), (0, 4, "wall below")]


def whole(place=bent):
    """The three blocks as one, in the directions in which unstructured cells come back."""
    return with_names([grid((24, 6, 4), place)], WHOLE)


def without_contacts():
    """The mesh whose neutral map names boundaries only: that blocks meet is found by the points."""
    folder = tempfile.mkdtemp(dir=FOLDER.name)
    path = write_mesh(folder)
    with open(path[:-3] + "nmf") as file:
        kept = [line for line in file if "ONE_TO_ONE" not in line]
    with open(path[:-3] + "nmf", "w") as file:
        file.writelines(kept)
    reader = simple.HexBlockMeshReader(FileName=path)
    reader.UpdatePipeline()
    return reader


def test_filters_that_keep_the_structure():
    for source in (read(), without_contacts()):
        expect_same(simple.Calculator(Input=source, Function="coordsX*coordsY"), direct([0, 1, 2]))
        # Moved by a vector: the mesh made there.
        vector = simple.Calculator(Input=source, Function="8*kHat", ResultArrayName="up")
        moved = with_names([grid(COUNTS[b], lambda i, j, k, b=b: tuple(
            x + (8.0 if d == 2 else 0.0) for d, x in enumerate(block_points(b, i, j, k)))) for b in range(3)], NAMES)
        expect_same(simple.WarpByVector(Input=vector, Vectors=["POINTS", "up"]), moved)
        transform = simple.Transform(Input=source)
        transform.Transform.Translate = [0.0, 0.0, 8.0]
        expect_same(transform, moved)


def test_filters_that_make_it_unstructured():
    expected = bits(convert(whole())[0])
    for source in (read(), without_contacts()):
        cells = simple.Calculator(Input=source, Function="1", AttributeType="Cell Data", ResultArrayName="one")
        append = simple.AppendDatasets(Input=[source])
        for made in (append, simple.CleantoGrid(Input=append), simple.MergeBlocks(Input=source),
                     simple.MergeBlocks(Input=source, MergePoints=0),
                     simple.Threshold(Input=cells, Scalars=["CELLS", "one"], LowerThreshold=0.5, UpperThreshold=2)):
            data, report, warnings = convert(made)
            name = made.SMProxy.GetXMLName()
            assert not warnings, (name, warnings)
            assert roles(report) == {"inlet": 1, "outlet": 1, "wall below": 1, "symmetry": 1}, (name, report)
            assert bits(data) == expected, name
    # A part: the faces that are cut free have no name.
    half = simple.ExtractCellsByRegion(Input=simple.MergeBlocks(Input=without_contacts()))
    half.IntersectWith = "Box"
    half.IntersectWith.Position = [-0.5, -50.0, -50.0]
    half.IntersectWith.Length = [10.0, 100.0, 100.0]
    data, report, _ = convert(half)
    assert {name for name, faces in roles(report).items() if faces} == {"inlet", "wall below", "symmetry"}, report


def test_cells_without_a_named_face():
    # Boundaries have names and types, but none is left: the new ones have no type of the old.
    for low, size in (((8.5, 1.5, 1.2), (6.0, 3.5, 2.2)), ((2.5, 1.5, 1.2), (20.0, 2.0, 1.9))):
        inner = simple.ExtractCellsByRegion(Input=simple.MergeBlocks(Input=read()))
        inner.IntersectWith = "Box"
        inner.IntersectWith.Position = low
        inner.IntersectWith.Length = size
        data, report, _ = convert(inner)
        assert len(blocks(data)) > 0 and "body" not in "".join(
            line for line in report.split("\n") if line.startswith("boundary ")), report
        assert not set(roles(report)) & {"inlet", "outlet", "wall below", "symmetry"}, report
        counted = len([name for name in roles(report) if name.startswith("boundary ")])
        assert "%d boundaries were made" % counted in report, report


def test_names_that_are_lost_are_said():
    # Without the numbers of their points nothing tells where the boundaries of unstructured cells were.
    volume = simple.CatmullClarkToBSplineVolume(Input=read())
    samples = simple.BSplineVolumeSampler(Input=volume, Level=0)
    for source in (simple.PassArrays(Input=read(), PointDataArrays=["nothing"]), samples):
        _, report, warnings = convert(simple.MergeBlocks(Input=source))
        assert len(warnings) == 1 and "'wall below'" in warnings[0] and "is lost" in warnings[0], warnings
        assert "wall below" not in roles(report)


def test_control_points_made_unstructured_are_no_mesh():
    volume = simple.CatmullClarkToBSplineVolume(Input=read())
    for made in (simple.MergeBlocks(Input=volume),
                 simple.Threshold(Input=volume, Scalars=["POINTS", "ControlPointRule"], LowerThreshold=0,
                                  UpperThreshold=100)):
        for reader in (simple.CatmullClarkToBSplineVolume, simple.HexMeshToBlocks, simple.HexBlockTopology):
            error = failure(reader(Input=made))
            assert "control points of a B-spline volume" in error, error


def test_files_of_paraview():
    # Saved and read back, the blocks still know their names and contacts.
    source = read()
    expected = bits(convert(direct([0, 1, 2]))[0])
    parts = simple.GroupDatasets(Input=[producer(part) for part in blocks(client(source).GetOutputDataObject(0))])
    # Group Datasets takes no collections, but what Convert To MultiBlock makes of them.
    whole_tree = simple.GroupDatasets(Input=[simple.ConvertToMultiBlock(Input=source)])
    for ending, made in (("vtpc", source), ("vtm", parts), ("vtm", whole_tree),
                         ("vtu", simple.MergeBlocks(Input=source)), ("vtu", simple.MergeBlocks(Input=without_contacts()))):
        path = os.path.join(FOLDER.name, "saved." + ending)
        simple.SaveData(path, proxy=made)
        data, report, warnings = convert(simple.OpenDataFile(path))
        assert not warnings, (ending, warnings)
        if ending == "vtu":
            assert roles(report) == {"inlet": 1, "outlet": 1, "wall below": 1, "symmetry": 1}, (ending, report)
            assert bits(data) == bits(convert(whole())[0])
        else:
            assert roles(report) == {"inlet": 1, "outlet": 1, "wall below": 3, "symmetry": 3}, (ending, report)
            assert bits(data) == expected, ending


def test_surfaces_beside_blocks_name_boundaries():
    # As ParaView's CGNS reader makes them of patches: flat structured grids beside the blocks; or polygons.
    def flat(b, f):
        counts = list(COUNTS[b])
        counts[f // 2] = 0
        offset = [0, 0, 0]
        offset[f // 2] = COUNTS[b][f // 2] * (f % 2)
        return grid(counts, lambda i, j, k: block_points(b, i, j, k), offset)

    def polygons(surface):
        made = vtk.vtkPolyData()
        made.SetPoints(surface.GetPoints())
        cells = vtk.vtkCellArray()
        for c in range(surface.GetNumberOfCells()):
            cells.InsertNextCell(surface.GetCell(c))
        made.SetPolys(cells)
        return made

    for change in (lambda surface: surface, polygons):
        tree = vtk.vtkMultiBlockDataSet()

        def add(name, data, tree=tree):
            tree.SetBlock(tree.GetNumberOfBlocks(), data)
            tree.GetMetaData(tree.GetNumberOfBlocks() - 1).Set(vtk.vtkCompositeDataSet.NAME(), name)
        for b in range(3):
            add("zone %d" % b, grid(COUNTS[b], lambda i, j, k, b=b: block_points(b, i, j, k)))
            for block, f, name in NAMES:
                if block == b:
                    add(name, change(flat(block, f)))
        # Between two blocks there is no boundary.
        add("contact", change(flat(0, 1)))
        report = expect_same(producer(tree), direct([0, 1, 2]))
        assert "Surfaces beside the blocks name 4 boundaries" in report, report
        # What lies on no block is said.
        add("elsewhere", change(grid((3, 2, 0), lambda i, j, k: (i, j, 99.0))))
        _, report, warnings = convert(producer(tree))
        assert len(warnings) == 1 and "6 of " in warnings[0] and "'elsewhere'" in warnings[0], warnings


def test_extract_surface_is_refused():
    surface = simple.ExtractSurface(Input=read())
    conversion = simple.CatmullClarkToBSplineVolume(Input=surface)
    assert "vtkPolyData" in failure(conversion)


def test_half_models():
    # Half a box with the plane y = 0; the mirrored mesh is the whole box bit for bit.
    def half(i, j, k):
        return 0.5 * i, 0.25 * j * j, 1.0 + k + 0.125 * i

    source = with_names([grid((4, 3, 2), half)], [(0, 2, "symmetry"), (0, 4, "wall")])
    data = client(source).GetOutputDataObject(0)
    # Rounding on the plane.
    data.GetPartition(0, 0).GetPoints().SetPoint(2, 1.0, 1e-13, 1.25)
    mirror = simple.MirrorHexBlocks(Input=source)
    whole, warnings = update(mirror)
    mirror.UpdatePropertyInformation()
    assert "plane y = 0" in str(mirror.Report), mirror.Report
    assert len(blocks(whole)) == 2 and not warnings
    volume, report, warnings = convert(mirror)
    assert roles(report) == {"wall": 2, "symmetry": 0} or roles(report) == {"wall": 2}, report
    assert not warnings
    assert len(field(volume, "Interfaces")) == 1
    expected = with_names([grid((4, 3, 2), half),
                           grid((4, 3, 2), lambda i, j, k: (half(4 - i, j, k)[0], -half(4 - i, j, k)[1] + 0.0,
                                                            half(4 - i, j, k)[2]))], [(0, 4, "wall"), (1, 4, "wall")])
    assert bits(volume) == bits(convert(expected)[0])

    curved = collection([grid((4, 3, 2), lambda i, j, k: (i, j + 0.1 * i * i, k))])
    curved.GetFieldData().ShallowCopy(data.GetFieldData())
    assert "not in one plane" in failure(simple.MirrorHexBlocks(Input=producer(curved)))
    none = collection([grid((4, 3, 2), half)])
    assert "no symmetry boundary" in failure(simple.MirrorHexBlocks(Input=producer(none)))


def test_blocks_of_volumes():
    # The same behind the conversion: the contact and the names of the blocks that are left.
    volume = simple.CatmullClarkToBSplineVolume(Input=read())
    update(volume)
    part = simple.ExtractBlock(Input=volume, Assembly="Assembly", Selectors=selectors(volume, [1, 2]))
    samples, warnings = update(simple.BSplineVolumeSampler(Input=part))
    assert not warnings
    assert [tuple(int(v) for v in c[:4]) for c in field(samples, "Interfaces")] == [(0, 1, 1, 4)]
    assert sorted(field(samples, "BoundaryNames")) == ["outlet", "symmetry", "wall below"]
    assert len(field(samples, "Boundaries")) == 5


def test_hidden_cells_are_left_out():
    block = grid((6, 6, 2), lambda i, j, k: (i, j, k))
    block.AllocateCellGhostArray()
    for k in range(2):
        for j in (2, 3):
            for i in (2, 3):
                block.BlankCell(i + 6 * (j + 6 * k))
    data, report, warnings = convert(producer(collection([block])))
    assert len(blocks(data)) == 8, report
    assert any("8 hidden" in w for w in warnings), warnings


main(globals())
