# SPDX-License-Identifier: BSD-3-Clause
"""vtkBSplineVolumeWriter: what its files say, read here on its own or by ParaView's and our readers, is the volume to
1e-14 of its size; names, contacts, cuts, errors."""
import itertools
import math
import os
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import (simple, vtk, blocks, cgrid, client, collection, coordinates, creased_mesh, demo_mesh,
                         dimensions, field, folded_ring, grid, half_turn_ring, main, messages, names, producer, update,
                         values)
from paraview import servermanager


def ogrid(turned=False):
    """Control points of one block around the z axis that meets itself."""
    n = (12, 3, 2)

    def place(i, j, k):
        angle = 2 * math.pi * (i % n[0]) / n[0] * (-1 if turned else 1)
        radius = 1 + 0.5 * j
        return radius * math.cos(angle), radius * math.sin(angle), 0.4 * k
    return simple.CatmullClarkToBSplineVolume(Input=producer(collection([grid(n, place)])))


CASES = {"demo": simple.CatmullClarkToBSplineVolume(Input=demo_mesh(4), UseCreaseAngle=1),
         "knots": simple.CatmullClarkToBSplineVolume(Input=producer(creased_mesh()),
                                                     CreasesInsideBlocks="RepeatedKnots"),
         "ogrid": ogrid(), "left-handed": ogrid(turned=True),
         # The wake is glued: the conversion cuts the blocks at the trailing edge and at the fold.
         "c-grid": simple.CatmullClarkToBSplineVolume(Input=producer(cgrid())),
         "two blocks": simple.CatmullClarkToBSplineVolume(Input=producer(cgrid(10))),
         "half turn": simple.CatmullClarkToBSplineVolume(Input=producer(half_turn_ring())),
         "folded": simple.CatmullClarkToBSplineVolume(Input=producer(folded_ring()))}
# Patches of MFEM meshes, in which each face has vertices of its own.
MFEM_PATCHES = {"ogrid": (3, 1), "left-handed": (3, 1), "c-grid": (5, 3), "two blocks": (5, 4),
                "folded": (4, 2)}


def basis(knots, degree, u):
    """Index and values of the B-splines that are not zero, by their recursion alone."""
    last = len(knots) - degree - 2
    span = max(n for n in range(degree, last + 1) if knots[n] <= u and knots[n] < knots[n + 1])
    values_ = [1.0]
    for p in range(1, degree + 1):
        following = [0.0] * (p + 1)
        for n, value in enumerate(values_):
            i = span - p + 1 + n
            share = (u - knots[i]) / (knots[i + p] - knots[i])
            following[n] += (1 - share) * value
            following[n + 1] += share * value
        values_ = following
    return span - degree, values_


class Patch:
    """A volume block: knots, points, weights; i fastest."""

    def __init__(self, knots, points, weights=None):
        self.knots, self.points, self.weights = knots, points, weights or [1.0] * len(points)
        self.degree = [3, 3, 3]
        self.counts = [len(knots[d]) - 4 for d in range(3)]

    def at(self, t):
        """Value at t in [0, 1]^3."""
        parts = [basis(self.knots[d], 3, self.knots[d][0] + t[d] * (self.knots[d][-1] - self.knots[d][0]))
                 for d in range(3)]
        total, weight = [0.0] * 3, 0.0
        for k, c in enumerate(parts[2][1]):
            for j, b in enumerate(parts[1][1]):
                for i, a in enumerate(parts[0][1]):
                    n = parts[0][0] + i + self.counts[0] * (parts[1][0] + j + self.counts[1] * (parts[2][0] + k))
                    w = a * b * c * self.weights[n]
                    weight += w
                    for d in range(3):
                        total[d] += w * self.points[n][d]
        return [x / weight for x in total]


def patches(data):
    return [Patch([field(block, name) for name in ("KnotsU", "KnotsV", "KnotsW")], values(coordinates(block)))
            for block in blocks(data)]


def size(data):
    bounds = [0.0] * 6
    data.GetBounds(bounds)
    return math.dist(bounds[::2], bounds[1::2])


PLACES = list(itertools.product((0.0, 0.37, 1.0), (0.0, 0.81), (0.5, 1.0)))


def same(found, expected, tolerance, places=PLACES):
    for a, b in zip(found, expected):
        for t in places:
            assert math.dist(a.at(t), b.at(t)) <= tolerance, (t, a.at(t), b.at(t))


def write(source, path, **properties):
    proxy = simple.servermanager.writers.BSplineVolumeWriter(Input=source, FileName=path, **properties)
    source.UpdatePipeline()
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert not caught["errors"], caught["errors"]
    return caught["warnings"]


def numbers(element):
    return [float(word) for word in element.text.split()]


def contacts(data):
    return sorted(tuple(sorted(((int(r[0]), int(r[1])), (int(r[2]), int(r[3]))))) for r in field(data, "Interfaces"))


def test_gismo():
    """The XML, read here."""
    for source in CASES.values():
        data, _ = update(source)
        expected = patches(data)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.xml")
            write(source, path)
            root = ElementTree.parse(path).getroot()
        found, ids = [], {}
        for geometry in root.findall("Geometry"):
            ids[int(geometry.get("id"))] = len(found)
            knots = [numbers(part.find("KnotVector")) for part in geometry.find("Basis").findall("Basis")]
            flat = numbers(geometry.find("coefs"))
            found.append(Patch(knots, [flat[n:n + 3] for n in range(0, len(flat), 3)]))
        assert len(found) == len(expected)
        same(found, expected, 1e-14 * size(data))
        topology = root.find("MultiPatch")
        rows = numbers(topology.find("interfaces"))
        pairs = []
        for n in range(0, len(rows), 10):
            p1, s1, p2, s2, *maps = (int(x) for x in rows[n:n + 10])
            pairs.append(tuple(sorted(((ids[p1], s1 - 1), (ids[p2], s2 - 1)))))
            a, b = found[ids[p1]], found[ids[p2]]
            # A point of the first side is the same point of the second.
            t = [0.23, 0.61, 0.42]
            t[(s1 - 1) // 2] = float((s1 - 1) % 2)
            u = [0.0] * 3
            for d in range(3):
                u[maps[d]] = t[d] if maps[3 + d] else 1 - t[d]
            u[(s2 - 1) // 2] = float((s2 - 1) % 2)
            assert math.dist(a.at(t), b.at(u)) <= 1e-13 * size(data)
        if data.GetFieldData().GetAbstractArray("Interfaces"):
            assert sorted(pairs) == contacts(data)
        labels = {part.get("name"): len(part.text.split()) // 2 for part in topology.findall("boundary")}
        assert sum(labels.values()) == 6 * len(found) - 2 * len(pairs)
        if data.GetFieldData().GetAbstractArray("BoundaryNames"):
            assert set(labels) == set(field(data, "BoundaryNames"))


def test_mfem_and_g2():
    for name, source in CASES.items():
        if name == "half turn":
            continue  # refused
        data, _ = update(source)
        with tempfile.TemporaryDirectory() as folder:
            said = write(source, os.path.join(folder, "a.mesh"))
            back, _ = update(simple.BSplineVolumeReader(FileName=os.path.join(folder, "a.mesh")))
            write(source, os.path.join(folder, "a.g2"))
            plain, _ = update(simple.BSplineVolumeReader(FileName=os.path.join(folder, "a.g2")))
            with open(os.path.join(folder, "a.mesh")) as file:
                text = file.read()
            with open(os.path.join(folder, "b.mesh"), "w") as file:
                file.write(text.replace("mesh v1.0", "mesh v1.1"))
            newer, _ = update(simple.BSplineVolumeReader(FileName=os.path.join(folder, "b.mesh")))
        assert [values(coordinates(b)) for b in blocks(newer)] == [values(coordinates(b)) for b in blocks(back)]
        assert [values(coordinates(b)) for b in blocks(plain)] == [values(coordinates(b)) for b in blocks(data)]
        if name not in MFEM_PATCHES:
            assert not said and contacts(back) == contacts(data)
            assert names(back) == names(data) and field(back, "BoundaryNames") == field(data, "BoundaryNames")
            assert sorted(map(tuple, field(back, "Boundaries"))) == sorted(map(tuple, field(data, "Boundaries")))
        else:
            # Cut until every face has vertices of its own; a ring needs three blocks.
            assert any("%d patches for %d blocks" % MFEM_PATCHES[name] in text for text in said), said
            assert sum(len(blocks(d)) for d in (back, data)) == sum(MFEM_PATCHES[name])
            outside = 6 * len(blocks(back)) - 2 * len(contacts(back))
            assert len(field(back, "Boundaries")) == outside
        # The parts of a block follow each other; u may be reversed.
        whole = patches(data)
        for patch in patches(back):
            corner = patch.at((0.31, 0.4, 0.7))
            assert min(distance(corner, block) for block in whole) <= 1e-14 * size(data)
            assert determinant(patch) > 0


def determinant(patch):
    h = 1e-5
    t = (0.4, 0.4, 0.4)
    rows = []
    for d in range(3):
        up = list(t)
        up[d] += h
        rows.append([(a - b) / h for a, b in zip(patch.at(up), patch.at(t))])
    a, b, c = rows
    return sum(a[n] * (b[(n + 1) % 3] * c[(n + 2) % 3] - b[(n + 2) % 3] * c[(n + 1) % 3]) for n in range(3))


def distance(point, patch):
    """Of a point from a volume that contains it: Newton's method."""
    best = min(itertools.product([n / 8 for n in range(9)], repeat=3), key=lambda t: math.dist(patch.at(t), point))
    t = list(best)
    for _ in range(20):
        x = patch.at(t)
        residual = [a - b for a, b in zip(point, x)]
        h = 1e-6
        columns = []
        for d in range(3):
            step = h if t[d] < 0.5 else -h
            moved = list(t)
            moved[d] += step
            columns.append([(a - b) / step for a, b in zip(patch.at(moved), x)])
        det = det3(columns)
        if det == 0:
            break  # folded there: no place of this block
        for d in range(3):
            changed = list(columns)
            changed[d] = residual
            t[d] = min(1.0, max(0.0, t[d] + det3(changed) / det))
    return math.dist(patch.at(t), point)


def det3(c):
    return (c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) - c[1][0] * (c[0][1] * c[2][2] - c[0][2] * c[2][1]) +
            c[2][0] * (c[0][1] * c[1][2] - c[0][2] * c[1][1]))


def gmsh_cells(path):
    """Nodes of the hexahedra, and physical names with the number of their quadrilaterals, of a file of either version."""
    with open(path) as file:
        lines = file.read().splitlines()

    def section(name):
        start = lines.index("$" + name)
        return lines[start + 1:lines.index("$End" + name)]
    physical = {(int(row.split()[0]), int(row.split()[1])): row.split('"')[1] for row in section("PhysicalNames")[1:]}
    nodes, cells, sides = {}, [], {name: 0 for (dim, _), name in physical.items() if dim == 2}
    if lines[1].startswith("2.2"):
        for row in section("Nodes")[1:]:
            tag, *x = row.split()
            nodes[tag] = [float(c) for c in x]
        for row in section("Elements")[1:]:
            words = row.split()
            if words[1] in ("12", "92"):
                cells.append(words[5:])
            else:
                sides[physical[2, int(words[3])]] += 1
    else:
        entities = section("Entities")
        surfaces = int(entities[0].split()[2])
        tags = {row.split()[0]: int(row.split()[8]) for row in entities[1:1 + surfaces]}
        rows = iter(section("Nodes")[1:])
        for head in rows:
            count = int(head.split()[3])
            own = [next(rows) for _ in range(count)]
            nodes.update((tag, [float(c) for c in next(rows).split()]) for tag in own)
        rows = iter(section("Elements")[1:])
        for head in rows:
            dim, entity, _, count = head.split()
            for _ in range(int(count)):
                words = next(rows).split()
                if dim == "3":
                    cells.append(words[1:])
                else:
                    sides[physical[2, tags[entity]]] += 1
    return [[nodes[tag] for tag in cell] for cell in cells], sides


def lagrange(order, corner_first, t):
    """Value at t in [0, 1]^3 of a cell whose nodes have these places in the lattice 0..order."""
    def factor(n, x):
        value = 1.0
        for m in range(order + 1):
            if m != n:
                value *= (x * order - m) / (n - m)
        return value
    total = [0.0] * 3
    for place, x in corner_first:
        weight = factor(place[0], t[0]) * factor(place[1], t[1]) * factor(place[2], t[2])
        for d in range(3):
            total[d] += weight * x[d]
    return total


CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]


def gmsh_places(order):
    """Gmsh's own order of the nodes, written from its documentation."""
    edges = [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)]
    faces = [(0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7)]
    corner = [tuple(order * c for c in place) for place in CORNERS]
    places = list(corner)
    for a, b in edges:
        for n in range(1, order):
            places.append(tuple(p + (q - p) * n // order for p, q in zip(corner[a], corner[b])))
    for face in faces:
        for c in range(4 if order == 3 else 1):
            # Next to the face's corner: two thirds of it, or the middle of all four.
            near = [corner[n] for n in face]
            if order == 2:
                places.append(tuple(sum(p[d] for p in near) // 4 for d in range(3)))
            else:
                p, q, r = near[c], near[c - 1], near[(c + 1) % 4]
                places.append(tuple(p[d] + (q[d] - p[d]) // 3 + (r[d] - p[d]) // 3 for d in range(3)))
    if order == 2:
        places.append((1, 1, 1))
    else:
        places += [tuple(1 + c for c in place) for place in CORNERS]
    assert len(set(places)) == (order + 1) ** 3
    return places


def test_gmsh():
    """Cells of order 3 are the spans: their middle, and any other place, lies on the volume. Both versions agree."""
    for name in ("demo", "knots", "c-grid", "two blocks"):
        source = CASES[name]
        data, _ = update(source)
        whole = patches(data)
        spans = [[len(set(k)) - 1 for k in patch.knots] for patch in whole]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.msh")
            assert not write(source, path, GmshVersion="2.2")
            old = gmsh_cells(path)
            assert not write(source, path)
            assert gmsh_cells(path) == old
            said = write(source, path, CellOrder=2)
            assert "not exact" in said[0]
            coarse = gmsh_cells(path)
        cells, sides = old
        assert len(cells) == sum(math.prod(count) for count in spans)
        assert sorted(sides) == sorted(field(data, "BoundaryNames")) and coarse[1] == sides
        expected = {name: 0 for name in sides}
        for block, face, tag in field(data, "Boundaries"):
            count = spans[int(block)]
            expected[field(data, "BoundaryNames")[int(tag)]] += math.prod(
                count[d] for d in range(3) if d != int(face) // 2)
        assert sides == expected
        at = iter(range(len(cells)))
        t = (0.3, 0.6, 0.2)
        for count, patch in zip(spans, whole):
            left = determinant(patch) < 0
            for k, j, i in itertools.product(*(range(n) for n in reversed(count))):
                n = next(at)
                local = (1 - t[0] if left else t[0], t[1], t[2])
                x = patch.at([(c + s) / m for c, s, m in zip((i, j, k), local, count)])
                cell = list(zip(gmsh_places(3), cells[n]))
                assert math.dist(lagrange(3, cell, t), x) <= 1e-14 * size(data)
                # Of order 2: nodes on the volume.
                middle = patch.at([(c + 0.5) / m for c, m in zip((i, j, k), count)])
                assert math.dist(coarse[0][n][26], middle) <= 1e-14 * size(data)


def leaves(node):
    if node is None:
        return []
    if node.IsA("vtkMultiBlockDataSet"):
        return [leaf for n in range(node.GetNumberOfBlocks()) for leaf in leaves(node.GetBlock(n))]
    return [node]


def test_cgns():
    """ParaView's reader makes cells whose nodes are where they belong on the spans."""
    source = CASES["demo"]
    data, _ = update(source)
    whole = patches(data)
    spans = [[len(set(k)) - 1 for k in patch.knots] for patch in whole]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "a.cgns")
        write(source, path)
        reader = simple.CGNSSeriesReader(FileNames=[path])
        reader.UpdatePipeline()
        mesh = leaves(client(reader).GetOutputDataObject(0))[0]
    assert mesh.GetNumberOfCells() == sum(math.prod(count) for count in spans)
    assert mesh.GetCellType(0) == vtk.VTK_LAGRANGE_HEXAHEDRON
    at = iter(range(mesh.GetNumberOfCells()))
    for count, patch in zip(spans, whole):
        left = determinant(patch) < 0
        for k, j, i in itertools.product(*(range(n) for n in reversed(count))):
            n = next(at)
            if n % 7:
                continue
            cell = mesh.GetCell(n)
            points = [cell.GetPoints().GetPoint(n) for n in range(64)]
            # ParaView 5.11 takes the edges at (1, 1) and (0, 1) along w for each other.
            if n == 0:
                places = list(cell.GetParametricCoords()[:192])
                exchanged = math.dist(points[28], place_of(patch, count, (i, j, k), places[84:87], left)) > 1e-6
            if exchanged:
                points[28:30], points[30:32] = points[30:32], points[28:30]
            for n in range(64):
                x = place_of(patch, count, (i, j, k), places[3 * n:3 * n + 3], left)
                assert math.dist(points[n], x) <= 1e-14 * size(data), (i, j, k, n)


def place_of(patch, count, cell, t, left):
    """Place on the volume of a place t in [0, 1]^3 of a cell."""
    local = (1 - t[0] if left else t[0], t[1], t[2])
    return patch.at([(c + s) / m for c, s, m in zip(cell, local, count)])


def test_hopr():
    """The HDF5 file: neighbours know each other, the flip pairs their nodes, every side has a boundary or a neighbour."""
    try:
        import h5py
    except ImportError:
        print("h5py is missing: the contents of HOPR files are not looked at")
        return
    corners = [(0, 3, 2, 1), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3), (4, 5, 6, 7)]
    for source in CASES.values():
        data, _ = update(source)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.h5")
            write(source, path)
            with h5py.File(path) as file:
                attributes = {name: file.attrs[name][0] for name in file.attrs}
                sides = file["SideInfo"][:].tolist()
                ids = file["GlobalNodeIDs"][:].tolist()
                points = file["NodeCoords"][:].tolist()
                conditions = [name.decode().strip() for name in file["BCNames"][:].tolist()]
        assert attributes["Ngeo"] == 3 and attributes["nSides"] == len(sides) == 6 * attributes["nElems"]
        assert attributes["nUniqueNodes"] == len(set(ids)) == max(ids)
        if data.GetFieldData().GetAbstractArray("BoundaryNames"):
            assert conditions == field(data, "BoundaryNames")
        place = {}
        for number, x in zip(ids, points):
            assert math.dist(place.setdefault(number, x), x) <= 1e-13 * size(data)
        assert {abs(side[1]) for side in sides} == set(range(1, attributes["nUniqueSides"] + 1))

        def nodes(element, side):
            return [ids[64 * element + 3 * c[0] + 12 * c[1] + 48 * c[2]] for c in (CORNERS[n] for n in corners[side])]
        for n, (kind, number, neighbour, code, condition) in enumerate(sides):
            assert kind == 24 and (neighbour == 0) == (1 <= condition <= len(conditions)) and (neighbour > 0) == (code > 0)
            if neighbour:
                other, flip = code // 10 - 1, code % 10
                back = sides[6 * (neighbour - 1) + other]
                assert back[1] == -number and back[2] == n // 6 + 1 and back[3] // 10 - 1 == n % 6
                mine, theirs = nodes(n // 6, n % 6), nodes(neighbour - 1, other)
                assert mine == [theirs[(flip - 1 - m) % 4] for m in range(4)]


def test_contacts_of_parts_of_faces():
    """The wake of a volume of one block cannot be joined: refused wherever a file says what meets what."""
    n = (20, 5, 5)
    wake = 7

    def place(i, j, k):
        at = min(i, n[0] - 1 - i)
        side = -1.0 if 2 * i < n[0] - 1 else 1.0
        y = 0.0 if at < wake else 0.3
        return 10.0 - at, side * (y + j), 1.0 * k
    block = grid([count - 1 for count in n], place)
    for name, count in zip(("KnotsU", "KnotsV", "KnotsW"), n):
        knots = vtk.vtkDoubleArray()
        knots.SetName(name)
        for value in [0] * 3 + list(range(count - 2)) + [count - 3] * 3:
            knots.InsertNextValue(value)
        block.GetFieldData().AddArray(knots)
    degree = vtk.vtkIntArray()
    degree.SetName("Degree")
    for _ in range(3):
        degree.InsertNextValue(3)
    block.GetFieldData().AddArray(degree)
    source = producer(collection([block]))
    with tempfile.TemporaryDirectory() as folder:
        write(source, os.path.join(folder, "a.g2"))
        for extension in ("cgns", "mesh", "xml", "msh", "h5"):
            error = write_error(source, os.path.join(folder, "a." + extension))
            assert "face 2, span (0, 0) and block 0 'block 0', face 2, span (16, 0) are the same (8 such" in error, error
        assert os.listdir(folder) == ["a.g2"]
        error = write_error(CASES["half turn"], os.path.join(folder, "a.mesh"))
        assert "meets itself turned round along v" in error, error


def test_wall_of_a_c_grid():
    """One face around the profile, sewn to itself at the trailing edge; its points are those of the volume."""
    source = CASES["c-grid"]
    data, _ = update(source)
    body = blocks(data)[1]
    nu, nv, _ = dimensions(body)
    wall = [x for n, x in enumerate(values(coordinates(body))) if n // nu % nv == 0]
    for extension in ("step", "igs", "g2"):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a." + extension)
            proxy = simple.servermanager.writers.NURBSSurfaceWriter(Input=source, FileName=path)
            with messages(proxy) as caught:
                proxy.UpdatePipeline()
            if any("OpenCASCADE" in text for text in caught["errors"]):
                print(extension, "skipped: built without OpenCASCADE")
                continue
            assert not caught["errors"] and not caught["warnings"], caught
            found = blocks(update(simple.NURBSSurfaceReader(FileName=path))[0])[0]
            assert sorted(values(coordinates(found))) == sorted(wall), extension
            if extension == "step":
                with open(path) as file:
                    text = file.read()
                # Three edges: both rims, and the trailing edge, where the face begins and ends.
                assert (text.count("ADVANCED_FACE("), text.count("EDGE_CURVE("), text.count("VERTEX_POINT(")) == (1, 3, 2)


def write_error(source, path):
    proxy = simple.servermanager.writers.BSplineVolumeWriter(Input=source, FileName=path)
    source.UpdatePipeline()
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    assert len(caught["errors"]) == 1 and client(proxy).GetErrorCode() != 0, caught
    return caught["errors"][0]


def test_offered_and_refused():
    source = CASES["demo"]
    source.UpdatePipeline()
    factory = servermanager.vtkSMProxyManager.GetProxyManager().GetWriterFactory()
    for extension in ("mesh", "xml", "g2", "msh", "h5"):
        proxy = factory.CreateWriter("a." + extension, source.SMProxy, 0)
        assert proxy.GetXMLName() == "BSplineVolumeWriter"
        proxy.UnRegister(None)

    with tempfile.TemporaryDirectory() as folder:
        assert "extension must be" in write_error(source, os.path.join(folder, "a.step"))
        assert "is no B-spline volume" in write_error(demo_mesh(4), os.path.join(folder, "a.mesh"))
        assert os.listdir(folder) == []
        # A body of surfaces is written as such.
        wing = simple.WingFuselageSource(Resolution=3)
        body = simple.OutputPort(wing, 1)
        proxy = simple.servermanager.writers.BSplineVolumeWriter(Input=body, FileName=os.path.join(folder, "b.g2"))
        proxy.UpdatePipeline()
        with open(os.path.join(folder, "b.g2")) as file:
            assert file.read().startswith("200 ")


if __name__ == "__main__":
    main(globals())
