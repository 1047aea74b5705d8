# SPDX-License-Identifier: BSD-3-Clause
"""Writes the demonstration mesh: half of a sharp-rimmed fairing in a box, as PLOT3D with a neutral map file.

Sample runs:
    pvpython Examples/make_demo_mesh.py
    pvpython Examples/make_demo_mesh.py demo 16

What the mesh holds, so that every part of the conversion has something to do:
  * a body that is no sphere, with a sharp rim (crease) in the plane z = 0; the rim runs along a block border at the
    body's tip and inside block faces at nose and tail, where the blocks have to be split;
  * a symmetry plane y = 0 and a box as far field, planar on all sides;
  * the blocks of a halved cubed sphere: four extraordinary edges of valence 3 run from the body to the far field,
    across a border between stacked blocks;
  * interfaces that cover only part of a face: one far block lies over two near blocks;
  * layers that grow from about a tenth of the local edge length, and randomly oriented and numbered blocks.

Steps:
  1. number the points of a halved cube surface (a, b, c) and of the layers k around it by integers;
  2. cut it into blocks and turn each of them at random;
  3. find interfaces and boundaries from the integers, which is exact;
  4. map the integers to space and write the files.
"""
import array
import itertools
import math
import os
import random
import sys

# Half axes of the body in x and y, its half thickness above and below the rim, and the width of the fluid around it.
LENGTH, WIDTH, TOP, BOTTOM = 1.6, 1.0, 0.75, 0.5
GAP = 1.7
GROWTH = 1.2  # of the layers, for eight cells an edge

# Even permutations with an even number of flips, and odd ones with an odd number: the 24 turns of a block.
TURNS = [(axes, flips) for axes in itertools.permutations(range(3)) for flips in itertools.product((0, 1), repeat=3)
         if (sum(axes[i] > axes[j] for i in range(3) for j in range(i + 1, 3)) + sum(flips)) % 2 == 0]


def body_point(x, y, z):
    """Point of the body that the point (x, y, z) of the cube's surface is projected to.

    The body is (X/LENGTH)^2 + (Y/WIDTH)^2 + |Z|/h = 1, solved along the ray; h differs above and below the rim.
    """
    x, y, z = LENGTH * x, WIDTH * y, 0.5 * (TOP + BOTTOM) * z
    length = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    height = (TOP if z > 0 else BOTTOM) * (1.0 - 0.25 * x)
    square = (x / LENGTH) ** 2 + (y / WIDTH) ** 2
    linear = abs(z) / height
    r = 2.0 / (linear + math.sqrt(linear * linear + 4.0 * square))
    return r * x, r * y, r * z


def box_point(x, y, z):
    """Point of the far field for the point (x, y, z) of the cube's surface."""
    return (LENGTH + GAP) * x, (WIDTH + GAP) * y, (0.5 * (TOP + BOTTOM) + GAP) * z


def mesh_point(key, half, layers):
    """Position of the point (a, b, c, k): straight lines from the body (k = 0) to the box (k = layers)."""
    a, b, c, k = key
    growth = GROWTH ** (8.0 / (2 * half))
    t = (growth ** k - 1.0) / (growth ** layers - 1.0)
    # Equal angles on the body, equal lengths on the box.
    inner = body_point(*(math.tan(0.25 * math.pi * q / half) for q in (a, b, c)))
    outer = box_point(a / half, b / half, c / half)
    return tuple((1.0 - t) * p + t * q for p, q in zip(inner, outer))


class Block:
    """Integer points of a block: a box in the axes (first, second, layer) of one side of the cube, then turned."""

    def __init__(self, side, first, second, layers, turn):
        direction, sign = side
        rest = [d for d in range(3) if d != direction]
        # Right-handed before the turn: the layers grow outwards.
        if (direction == 1) == (sign > 0):
            rest, first, second = rest[::-1], second, first
        self.side, self.sign, self.rest = direction, sign, rest
        self.start = (first[0], second[0], layers[0])
        unturned = (first[1] - first[0], second[1] - second[0], layers[1] - layers[0])
        self.axes, self.flips = turn
        self.cells = tuple(unturned[axis] for axis in self.axes)

    def key(self, ijk, half):
        """The integers (a, b, c, k) of point (i, j, k) of the block."""
        position = [0, 0, 0]
        for d in range(3):
            position[self.axes[d]] = self.cells[d] - ijk[d] if self.flips[d] else ijk[d]
        key = [0, 0, 0, self.start[2] + position[2]]
        key[self.side] = self.sign * half
        key[self.rest[0]] = self.start[0] + position[0]
        key[self.rest[1]] = self.start[1] + position[1]
        return tuple(key)

    def keys(self, half):
        """All points, i fastest."""
        i, j, k = (range(n + 1) for n in self.cells)
        return [self.key((a, b, c), half) for c in k for b in j for a in i]

    def face_quads(self, face, half):
        """The quadrilaterals ((s, t), four keys) of a face; faces 0..5 = i, j, k minimum and maximum in turn.

        The axes (s, t) of a face are cyclic, as neutral map files want them: (j,k), (k,i), (i,j).
        """
        normal = face // 2
        u, v = (normal + 1) % 3, (normal + 2) % 3
        ijk = [0, 0, 0]
        ijk[normal] = self.cells[normal] if face % 2 else 0
        for s in range(self.cells[u]):
            for t in range(self.cells[v]):
                corners = []
                for ds, dt in ((0, 0), (1, 0), (0, 1), (1, 1)):
                    ijk[u], ijk[v] = s + ds, t + dt
                    corners.append(self.key(ijk, half))
                yield (s, t), corners


def make_blocks(half, layers):
    """The eleven blocks, in random order and orientation. `layers` cells lie around the body, half of them near it."""
    shuffle = random.Random(2)
    full, left, right, upper = (-half, half), (-half, 0), (0, half), (0, half)
    near, far = (0, layers // 2), (layers // 2, layers)
    plan = []
    for reach in (near, far):
        plan += [((0, sign), upper, full, reach) for sign in (-1, 1)]  # nose and tail: (b, c)
        plan += [((2, sign), full, upper, reach) for sign in (-1, 1)]  # below and above: (a, b)
    plan += [((1, 1), full, left, near), ((1, 1), full, right, near), ((1, 1), full, full, far)]  # the tip: (a, c)
    shuffle.shuffle(plan)
    return [Block(*box, turn=shuffle.choice(TURNS)) for box in plan]


def find_contacts(blocks, half, layers):
    """Interfaces and boundaries, as the fields of a neutral map file without the type."""
    seen, contacts, boundaries = {}, {}, {}
    for b, block in enumerate(blocks):
        for face in range(6):
            for place, corners in block.face_quads(face, half):
                seen.setdefault(frozenset(corners), []).append((b, face, place, corners))
    for uses in seen.values():
        if len(uses) == 2:
            (b1, f1, place1, corners1), (b2, f2, place2, corners2) = uses
            contacts.setdefault((b1, f1, b2, f2), []).append((place1, place2, corners1, corners2))
        else:
            b, face, place, corners = uses[0]
            if all(key[3] == 0 for key in corners):
                name = "WALL"
            elif all(key[3] == layers for key in corners):
                name = "FARFIELD"
            else:
                name = "SYMMETRY"
            boundaries.setdefault((name, b, face), []).append(place)

    def ranges(places):
        lo = [min(p[d] for p in places) + 1 for d in (0, 1)]
        hi = [max(p[d] for p in places) + 2 for d in (0, 1)]
        assert len(places) == (hi[0] - lo[0]) * (hi[1] - lo[1]), "not a rectangle"
        return [lo[0], hi[0], lo[1], hi[1]]

    for (b1, f1, b2, f2), quads in contacts.items():
        range1, range2 = ranges([q[0] for q in quads]), ranges([q[1] for q in quads])
        # Where the corners (1, 0) and (0, 1) of a quadrilateral are found on the other side tells how the axes run.
        corners1, corners2 = quads[0][2], quads[0][3]
        origin, along = corners2.index(corners1[0]), corners2.index(corners1[1])
        swap = (origin ^ along) == 2
        if origin & 1:
            range2[0], range2[1] = range2[1], range2[0]
        if origin & 2:
            range2[2], range2[3] = range2[3], range2[2]
        yield "ONE_TO_ONE", b1, f1, range1, b2, f2, range2, swap
    for (name, b, face), places in boundaries.items():
        yield name, b, face, ranges(places)


def write_demo(folder, cells=8):
    """Writes demo.xyz (PLOT3D, binary, double precision) and demo.nmf into `folder` and returns the path of demo.xyz.

    cells: cells along an edge of the cubed sphere, even and at least 4. The mesh has 6 cells^3 cells.
    """
    if cells < 4 or cells % 2:
        raise ValueError("cells must be even and at least 4, not %r" % (cells,))
    half, layers = cells // 2, 2 * cells
    blocks = make_blocks(half, layers)

    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, "demo.xyz")
    cache = {}
    with open(path, "wb") as out:
        def write(kind, values):
            data = array.array(kind, values)
            if sys.byteorder != "little":
                data.byteswap()
            data.tofile(out)

        write("i", [len(blocks)])
        for block in blocks:
            write("i", [n + 1 for n in block.cells])
        for block in blocks:
            keys = block.keys(half)
            for key in keys:
                if key not in cache:
                    cache[key] = mesh_point(key, half, layers)
            for d in range(3):
                write("d", [cache[key][d] for key in keys])

    # Neutral map files number the faces k, i, j minimum and maximum.
    number = {0: 3, 1: 4, 2: 5, 3: 6, 4: 1, 5: 2}
    with open(os.path.join(folder, "demo.nmf"), "w") as out:
        out.write("# Half of a sharp-rimmed fairing in a box\n# Block  IDIM  JDIM  KDIM\n%d\n" % len(blocks))
        for b, block in enumerate(blocks):
            out.write("%d %d %d %d\n" % (b + 1, *(n + 1 for n in block.cells)))
        out.write("# Type  B1 F1  S1 E1 S2 E2  B2 F2  S1 E1 S2 E2  Swap\n")
        for contact in find_contacts(blocks, half, layers):
            name, b1, f1, range1 = contact[:4]
            out.write("'%s' %d %d  %d %d %d %d" % (name, b1 + 1, number[f1], *range1))
            if name == "ONE_TO_ONE":
                b2, f2, range2, swap = contact[4:]
                out.write("  %d %d  %d %d %d %d  %s" % (b2 + 1, number[f2], *range2, "TRUE" if swap else "FALSE"))
            out.write("\n")
    return path


if __name__ == "__main__":
    print(write_demo(sys.argv[1] if len(sys.argv) > 1 else ".", int(sys.argv[2]) if len(sys.argv) > 2 else 8))
