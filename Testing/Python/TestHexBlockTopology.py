# SPDX-License-Identifier: BSD-3-Clause
"""Counts, classes and arrays of vtkHexBlockTopology on complexes whose topology is known."""
import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (simple, vtk, blocks, client, collection, demo_mesh, failure, field, grid, main,
                         names, producer, update, values)

REGULAR, BOUNDARY, EXTRAORDINARY, SINGULAR, CREASE, CORNER = range(6)


def topology(mesh, **properties):
    return simple.HexBlockTopology(Input=mesh if hasattr(mesh, "SMProxy") else producer(mesh), **properties)


def entities(part):
    """Cell data per entity: {id: (class, valence, block ids, boundary tag)}; equal in all cells of an entity."""
    found = {}
    arrays = [values(part.GetCellData().GetArray(name))
              for name in ("GlobalId", "Class", "Valence", "BlockIds", "BoundaryTag")]
    for number, what, valence, ids, tag in zip(*arrays):
        ids = ids if isinstance(ids, tuple) else (ids,)
        data = (int(what), int(valence), tuple(int(b) for b in ids if b >= 0), int(tag))
        assert found.setdefault(int(number), data) == data
    assert sorted(found) == list(range(len(found)))
    return found


def count(part, what, valence=None):
    return sum(1 for c, v, _, _ in entities(part).values() if c == what and valence in (None, v))


def check_incidence(data, number_of_blocks):
    """Every block has 8 corners, 12 edges and 6 faces, all of which are somebody's."""
    for part, each in zip(blocks(data), (8, 12, 6)):
        assert sum(valence for _, valence, _, _ in entities(part).values()) == each * number_of_blocks
    # ParaView merges the parts' array information and complains of arrays of several widths.
    assert len({part.GetCellData().GetArray("BlockIds").GetNumberOfComponents() for part in blocks(data)}) == 1


def regular_mesh(n, cut):
    """cut^3 blocks of n^3 cells each of a unit grid."""
    return collection([grid((n, n, n), lambda i, j, k: (i, j, k), (a * n, b * n, c * n))
                       for c in range(cut) for b in range(cut) for a in range(cut)])


def fan_mesh(valence, layers, n=2):
    """Blocks around an axis, `layers` of them stacked along it."""
    def rim(s):
        angle = math.pi * s / valence
        radius = 1.0 if s % 2 == 0 else 1.2
        return radius * math.cos(angle), radius * math.sin(angle)

    made = []
    for layer in range(layers):
        for sector in range(valence):
            corners = ((0, 0), rim(2 * sector), rim(2 * sector + 2), rim(2 * sector + 1))

            def place(i, j, k, corners=corners):
                s, t = i / n, j / n
                weights = ((1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t)
                return tuple(sum(w * c[d] for w, c in zip(weights, corners)) for d in (0, 1)) + (k,)
            made.append(grid((n, n, n), place, (0, 0, layer * n)))
    return collection(made)


def tetrahedron_mesh(n=2):
    """A tetrahedron cut into four blocks, one per vertex, that meet in its centre."""
    tetrahedron = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))

    def centre(*which):
        return tuple(sum(tetrahedron[v][d] for v in which) / len(which) for d in range(3))

    made = []
    for v in range(4):
        a, b, c = (w for w in range(4) if w != v)
        corners = (centre(v), centre(v, a), centre(v, b), centre(v, a, b),
                   centre(v, c), centre(v, a, c), centre(v, b, c), centre(0, 1, 2, 3))

        def place(i, j, k, corners=corners):
            s = (i / n, j / n, k / n)
            weights = [math.prod(s[d] if corner >> d & 1 else 1 - s[d] for d in range(3)) for corner in range(8)]
            return tuple(sum(w * p[d] for w, p in zip(weights, corners)) for d in range(3))
        made.append(grid((n, n, n), place))
    return collection(made)


def test_properties():
    proxy = topology(regular_mesh(1, 1))
    assert abs(proxy.MatchTolerance - 0.05) < 1e-15 and proxy.CreaseAngle == 30
    assert not proxy.AllowDegenerate and not proxy.UseCreaseAngle


def test_one_block():
    proxy = topology(grid((2, 3, 4), lambda i, j, k: (i, j, k)))
    data, _ = update(proxy)
    assert names(data) == ["Vertices", "Edges", "Faces"]
    vertices, edges, faces = blocks(data)
    assert [part.GetNumberOfCells() for part in (vertices, edges)] == [8, 12]
    assert faces.GetNumberOfPolys() == 2 * (2 * 3 + 3 * 4 + 4 * 2) and len(entities(faces)) == 6
    assert edges.GetNumberOfLines() == 12 and edges.GetNumberOfPoints() == 4 * (3 + 4 + 5)
    assert all(count(part, BOUNDARY) == len(entities(part)) for part in (edges, faces))
    check_incidence(data, 1)
    # Quadrilaterals face outwards: the divergence theorem gives the volume.
    volume = 0.0
    for c in range(faces.GetNumberOfCells()):
        corners = [faces.GetPoint(faces.GetCell(c).GetPointId(p)) for p in range(4)]
        u, v = ([corners[n][d] - corners[0][d] for d in range(3)] for n in (1, 3))
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        volume += sum(normal[d] * sum(p[d] for p in corners) / 4 for d in range(3)) / 3
    assert abs(volume - 24) < 1e-12, volume


def test_regular():
    proxy = topology(regular_mesh(2, 2))
    data, _ = update(proxy)
    vertices, edges, faces = blocks(data)
    assert [len(entities(part)) for part in (vertices, edges, faces)] == [27, 54, 36]
    assert count(vertices, REGULAR, 8) == 1 and count(edges, REGULAR, 4) == 6 and count(faces, REGULAR, 2) == 12
    assert sum(len(ids) == 8 for _, _, ids, _ in entities(vertices).values()) == 1
    check_incidence(data, 8)
    proxy.UpdatePropertyInformation()
    assert (proxy.NumberOfVertices, proxy.NumberOfEdges, proxy.NumberOfFaces, proxy.NumberOfBlocks) == (27, 54, 36, 8)
    assert proxy.NumberOfExtraordinaryEdges == 0 and proxy.NumberOfSingularNodes == 0
    assert proxy.Report.startswith("8 blocks")


def test_extraordinary():
    for valence in (3, 5, 6):
        proxy = topology(fan_mesh(valence, 2))
        data, _ = update(proxy)
        vertices, edges, _ = blocks(data)
        assert count(edges, EXTRAORDINARY, valence) == count(edges, EXTRAORDINARY) == 2
        # The vertex between the two edges, and the ends of the curve in the two outer faces.
        assert count(vertices, EXTRAORDINARY, 2 * valence) == 1
        assert count(vertices, EXTRAORDINARY, valence) == 2
        assert count(vertices, SINGULAR) == 0
        assert field(data, "ExtraordinaryCurves") == [(valence, 1)]
        check_incidence(data, 2 * valence)


def test_singular():
    proxy = topology(tetrahedron_mesh())
    data, _ = update(proxy)
    vertices, edges, _ = blocks(data)
    assert count(vertices, SINGULAR, 4) == 1
    assert count(edges, EXTRAORDINARY, 3) == 4
    assert field(data, "ExtraordinaryCurves") == [(3, 4)]
    proxy.UpdatePropertyInformation()
    assert proxy.NumberOfSingularNodes == 1


def test_creases():
    cube = regular_mesh(2, 2)
    data, _ = update(topology(cube, UseCreaseAngle=1, CreaseAngle=60))
    vertices, edges, _ = blocks(data)
    assert count(edges, CREASE) == 24 and count(vertices, CORNER) == 8 and count(vertices, CREASE) == 12
    data, _ = update(topology(cube, UseCreaseAngle=1, CreaseAngle=100))
    assert count(blocks(data)[1], CREASE) == 0


def test_demo():
    for cells in (4, 8):
        proxy = topology(demo_mesh(cells), UseCreaseAngle=1)
        data, _ = update(proxy)
        vertices, edges, faces = blocks(data)
        proxy.UpdatePropertyInformation()
        assert (proxy.NumberOfInputBlocks, proxy.NumberOfBlocks) == (11, 16)
        assert sorted(set(field(data, "ParentBlock"))) == list(range(11))
        assert field(data, "ExtraordinaryCurves") == [(3, 4)]
        assert count(edges, EXTRAORDINARY, 3) == 8
        check_incidence(data, 16)
        # Mesh quadrilaterals per boundary.
        boundary = field(data, "BoundaryNames")
        tags = [int(t) for t in values(faces.GetCellData().GetArray("BoundaryTag"))]
        quads = {name: tags.count(tag) for tag, name in enumerate(boundary)}
        n = cells
        assert quads == {"WALL": 3 * n * n, "FARFIELD": 3 * n * n, "SYMMETRY": 8 * n * n}, quads
        # The rim: mesh edges of the wall with z = 0 that do not lie in the symmetry plane, all of them creases.
        rim = 0
        for e in range(edges.GetNumberOfCells()):
            if edges.GetCellData().GetArray("Class").GetTuple1(e) == CREASE:
                ids = edges.GetCell(e).GetPointIds()
                points = [edges.GetPoint(ids.GetId(p)) for p in range(ids.GetNumberOfIds())]
                if all(abs(p[2]) < 1e-12 for p in points) and max(abs(p[0]) for p in points) < 2:
                    rim += len(points) - 1
        assert rim == 2 * n, rim


# Extraordinary curves and singular nodes of third-party meshes, known from their makers' construction.
REAL = {
    "near_tip_vol.xyz": ({3: 4}, 0), "bwb_vol.xyz": ({3: 4}, 0), "717_wl_L2.cgns": ({3: 4}, 0),
    "t_joint.xyz": ({3: 6, 6: 1}, 0), "torus.xyz": ({3: 4}, 0), "sphere7ProjectedEdges.xyz": ({3: 20}, 8),
    "even_sphere_vol.xyz": ({3: 8}, 0), "n0012.cgns": ({}, 0), "mixer.xyz": ({}, 0), "multi-bin.xyz": ({}, 0),
}


def test_real_meshes():
    folder = os.path.join(os.environ.get("BSV_SHARED_DATA", ""), "structured")
    if not os.path.isdir(folder):
        print("test_real_meshes skipped: no BSV_SHARED_DATA")
        return
    for name, (curves, nodes) in REAL.items():
        proxy = topology(simple.HexBlockMeshReader(FileName=os.path.join(folder, name)))
        data, _ = update(proxy)
        proxy.UpdatePropertyInformation()
        assert {int(v): int(n) for v, n in field(data, "ExtraordinaryCurves")} == curves, name
        assert proxy.NumberOfSingularNodes == nodes, name
        check_incidence(data, proxy.NumberOfBlocks)


def test_warnings_are_about_the_mesh():
    _, warnings = update(topology(grid((2, 2, 2), lambda i, j, k: (-i, j, k))))
    assert len(warnings) == 1 and "left-handed" in warnings[0]
    # One block over two of unequal extent: cut, which is no reason to warn.
    proxy = topology(collection([grid((4, 2, 2), lambda i, j, k: (i, j, k)),
                                 grid((1, 2, 2), lambda i, j, k: (i, j, k + 2)),
                                 grid((3, 2, 2), lambda i, j, k: (i + 1, j, k + 2))]))
    _, warnings = update(proxy)
    proxy.UpdatePropertyInformation()
    assert not warnings and "1 block was split" in proxy.Report


def test_errors():
    assert "Match Tolerance 0.5 is not" in failure(topology(regular_mesh(1, 1), MatchTolerance=0.5))
    moved = collection([grid((2, 2, 2), lambda i, j, k: (i, j, k)),
                        grid((2, 2, 2), lambda i, j, k: (i, j + 0.3 * (j == 1 and i == 2), k), (2, 0, 0))])
    assert "block" in failure(topology(moved)).lower()
    nan = grid((2, 2, 2), lambda i, j, k: (i, j, float("nan") if i + j + k == 6 else k))
    assert "block" in failure(topology(nan)).lower()


def apart(gap):
    """Two boxes of 2^3 cells whose faces are `gap` apart."""
    return collection([grid((2, 2, 2), lambda i, j, k: (i, j, k)),
                       grid((2, 2, 2), lambda i, j, k: (i + gap, j, k), (2, 0, 0))])


def test_near_misses_are_found():
    proxy = topology(apart(0.25))
    _, warnings = update(proxy)
    assert len(warnings) == 1 and "nearly face each other" in warnings[0] and "Match Tolerance" in warnings[0], warnings
    table = client(proxy).GetOutputDataObject(2)
    row = {table.GetColumnName(c): table.GetValue(0, c) for c in range(table.GetNumberOfColumns())}
    assert row["Finding"].ToString() == "NearMiss" and row["Suspicious"].ToInt() == 1
    assert [row[name].ToInt() for name in ("BlockA", "FaceA", "BlockB", "FaceB", "Quads")] == [0, 1, 1, 0, 8]
    for name, value in (("Distance", 0.25), ("Fraction", 0.25), ("GlueTolerance", 0.25), ("X", 2.125)):
        assert abs(row[name].ToDouble() - value) < 1e-12, (name, row[name].ToDouble())
    surface = client(proxy).GetOutputDataObject(1)
    found = values(surface.GetCellData().GetArray("Finding"))
    assert len(found) == 2 * 24 and found.count(1) == 8 and found.count(0) == 40
    assert field(surface, "FindingNames")[1] == "NearMiss"
    for c in range(surface.GetNumberOfCells()):
        if found[c]:
            x = [surface.GetPoint(surface.GetCell(c).GetPointId(p))[0] for p in range(4)]
            assert set(x) in ({2.0}, {2.25})
            assert surface.GetCellData().GetArray("FindingId").GetTuple1(c) == 0
    proxy.UpdatePropertyInformation()
    assert (proxy.NumberOfSuspiciousFindings, proxy.NumberOfComponents) == (1, 2)
    # The tolerance told glues them.
    proxy = topology(apart(0.25), MatchTolerance=0.2501)
    _, warnings = update(proxy)
    proxy.UpdatePropertyInformation()
    assert not warnings and (proxy.NumberOfFindings, proxy.NumberOfComponents) == (0, 1)


def test_conversion_refuses_near_misses():
    error = failure(simple.CatmullClarkToBSplineVolume(Input=producer(apart(0.25))))
    assert "nearly face each other" in error and "face 0 (i=0)" in error and "Allow Open Interior" in error, error
    proxy = simple.CatmullClarkToBSplineVolume(Input=producer(apart(0.25)), AllowOpenInterior=1)
    _, warnings = update(proxy)
    assert len(warnings) == 1 and "nearly face each other" in warnings[0]
    # One moved point of the shared face.
    moved = collection([grid((4, 4, 4), lambda i, j, k: (i, j, k)),
                        grid((4, 4, 4), lambda i, j, k: (i + 0.3 * (i == 4 and j == 2 and k == 1), j, k), (4, 0, 0))])
    error = failure(simple.CatmullClarkToBSplineVolume(Input=producer(moved)))
    assert "would meet but for one point" in error, error
    # Apart for good, or over each other.
    update(simple.CatmullClarkToBSplineVolume(Input=producer(apart(3.0))))
    assert "lies in block" in failure(simple.CatmullClarkToBSplineVolume(Input=producer(apart(-1.2))))


def test_empty():
    assert "has no hexahedra" in failure(topology(vtk.vtkPartitionedDataSetCollection()))


if __name__ == "__main__":
    main(globals())
