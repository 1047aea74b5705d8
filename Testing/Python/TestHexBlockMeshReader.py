# SPDX-License-Identifier: BSD-3-Clause
"""The reader in ParaView, on files that no one here wrote: against a second reading of each file, in plain Python."""
import array
import os
import re
import struct
import sys

from bsv_support import blocks, client, coordinates, failure, field, names, simple, update

DATA = os.environ.get("BSV_SHARED_DATA", "")
FOLDER = os.path.join(DATA, "structured")


def fortran_records(data, order):
    """Contents of the records of a Fortran unformatted file."""
    records, at = [], 0
    while at < len(data):
        size, = struct.unpack_from(order + "i", data, at)
        assert struct.unpack_from(order + "i", data, at + 4 + size) == (size,)
        records.append(data[at + 4:at + 4 + size])
        at += 8 + size
    return records


def reals(data, order, code):
    values = array.array(code, data)
    if (order == ">") == (sys.byteorder == "little"):
        values.byteswap()
    return values


def read_fortran(name, order, code):
    with open(os.path.join(FOLDER, name), "rb") as file:
        records = fortran_records(file.read(), order)
    sizes = struct.unpack(order + "%di" % (len(records[1]) // 4), records[1])
    return [(sizes[3 * b:3 * b + 3], reals(record, order, code)) for b, record in enumerate(records[2:])]


def read_raw_single(name, order, code):
    with open(os.path.join(FOLDER, name), "rb") as file:
        data = file.read()
    return [(struct.unpack_from(order + "3i", data), reals(data[12:], order, code))]


def read_text(name):
    with open(os.path.join(FOLDER, name), encoding="ascii") as file:
        words = re.split(r"[\s,]+", file.read().strip())
    numbers = array.array("d")
    for word in words:
        count, star, value = word.rpartition("*")
        numbers.extend([float(value)] * (int(count) if star else 1))
    count = int(numbers[0])
    result, at = [], 1 + 3 * count
    for b in range(count):
        size = [int(n) for n in numbers[1 + 3 * b:4 + 3 * b]]
        values = 3 * size[0] * size[1] * size[2]
        result.append((size, numbers[at:at + values]))
        at += values
    assert at == len(numbers)
    return result


def points_of(data):
    """All x, then all y, then all z of a block."""
    flat = array.array("f" if data.GetPoints().GetDataType() == 10 else "d")
    flat.frombytes(bytes(memoryview(coordinates(data))))
    return flat[0::3] + flat[1::3] + flat[2::3]


def dimensions(data):
    size = [0, 0, 0]
    data.GetDimensions(size)
    return size


def reader(name):
    return simple.HexBlockMeshReader(FileName=os.path.join(FOLDER, name))


def check(name, layout, expected):
    proxy = reader(name)
    data, warnings = update(proxy)
    assert not warnings
    proxy.UpdatePropertyInformation()
    assert proxy.FileLayout == "PLOT3D, " + layout, name
    found = blocks(data)
    assert len(found) == len(expected), name
    for block, (size, values) in zip(found, expected):
        assert dimensions(block) == list(size), name
        assert points_of(block) == values, name
    assert names(data) == ["block %d" % (b + 1) for b in range(len(expected))]


def test_fortran():
    for name in ("bwb_vol.xyz", "even_sphere_vol.xyz", "mixer.xyz", "multi-bin.xyz", "near_tip_vol.xyz",
                 "sphere7ProjectedEdges.xyz", "t_joint.xyz", "torus.xyz"):
        check(name, "Fortran unformatted, little-endian, double, without iblank", read_fortran(name, "<", "d"))
    check("sduct.new.x.bin", "Fortran unformatted, big-endian, float, without iblank",
          read_fortran("sduct.new.x.bin", ">", "f"))


def test_raw_binary():
    check("combxyz.bin", "raw binary, big-endian, float, without iblank", read_raw_single("combxyz.bin", ">", "f"))


def test_text():
    for name in ("multi-ascii.xyz", "bumpgrd.fmt", "step_grdgen.fmt"):
        check(name, "ASCII, without iblank", read_text(name))


def test_surfaces_are_refused():
    error = failure(reader("bwb.fmt"))
    assert "bwb.fmt" in error and "block 1" in error and "33 x 9 x 1" in error
    error = failure(reader("near_tip.cgns"))
    assert "near_tip.cgns" in error and "surface" in error


def test_cgns():
    # The five blocks of the wing: eight contacts, and names for all other faces.
    data, _ = update(reader("717_wl_L2.cgns"))
    assert len(blocks(data)) == 5
    assert sum((n[0] - 1) * (n[1] - 1) * (n[2] - 1) for n in map(dimensions, blocks(data))) == 15120
    contacts = field(data, "Interfaces")
    boundaries = field(data, "Boundaries")
    faces = {(c[0], c[1]) for c in contacts} | {(c[2], c[3]) for c in contacts} | {(b[0], b[1]) for b in boundaries}
    assert len(faces) == 2 * len(contacts) + len(boundaries) == 30
    assert set(field(data, "BoundaryNames")) == {"wall", "Far", "Sym"}

    # One block that meets itself.
    data, _ = update(reader("n0012.cgns"))
    (contact,) = field(data, "Interfaces")
    assert contact[:4] == (0, 0, 0, 1)
    (block,) = blocks(data)
    ni, nj, nk = dimensions(block)
    for k in range(nk):
        for j in range(nj):
            first = ni * (j + nj * k)
            assert block.GetPoint(first) == block.GetPoint(first + ni - 1)


def test_opens_by_name():
    for name in ("t_joint.xyz", "bumpgrd.fmt", "sduct.new.x.bin"):
        proxy = simple.OpenDataFile(os.path.join(FOLDER, name))
        assert client(proxy).GetClassName() == "vtkHexBlockMeshReader", name


if __name__ == "__main__":
    if not os.path.isdir(FOLDER):
        print("no shared data, skipped")
        sys.exit(77)
    from bsv_support import main
    main(globals())
