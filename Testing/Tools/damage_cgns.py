# SPDX-License-Identifier: BSD-3-Clause
"""Reads thousands of damaged CGNS files with the Hex Block Mesh Reader in one process, and counts what came of them.

    pvpython damage_cgns.py PLUGIN.so MESH.cgns [cuts and flips per file] [library of CGNS]

Of MESH.cgns, copied into ADF and into HDF5, every node gets every data type in turn; then the file is cut and bits of it
are flipped. Each read must end in a mesh or in one error of valid UTF-8, and leave no descriptor and no process behind.
"""
import ctypes
import glob
import os
import random
import shutil
import sys
import tempfile

from paraview import simple

TYPES = ("MT", "C1", "B1", "I1", "U1", "I4", "U4", "I8", "U8", "R4", "R8", "X4", "X8")


class Library:
    """The input and output part of the CGNS library that ParaView brings, by its C functions."""

    def __init__(self, path):
        self.lib = ctypes.CDLL(path)

    def __call__(self, name, *arguments):
        function = getattr(self.lib, "vtkcgns_" + name, None) or getattr(self.lib, name)
        return function(*arguments)


def nodes_of(cgio, file, parent):
    """Ids of all nodes below a node."""
    count = ctypes.c_int()
    cgio("cgio_number_children", file, parent, ctypes.byref(count))
    ids = (ctypes.c_double * max(count.value, 1))()
    found = ctypes.c_int()
    if count.value:
        cgio("cgio_children_ids", file, parent, 1, count.value, ctypes.byref(found), ids)
    result = []
    for n in range(found.value):
        result.append(ids[n])
        result += nodes_of(cgio, file, ctypes.c_double(ids[n]))
    return result


def open_file(cgio, path):
    file, root = ctypes.c_int(), ctypes.c_double()
    assert cgio("cgio_open_file", path.encode(), 2, 0, ctypes.byref(file)) == 0
    cgio("cgio_get_root_id", file, ctypes.byref(root))
    return file, root


def copied(cgio, mesh, path, kind):
    """The mesh in a file of another kind."""
    file, output = ctypes.c_int(), ctypes.c_int()
    assert cgio("cgio_open_file", mesh.encode(), 0, 0, ctypes.byref(file)) == 0
    assert cgio("cgio_open_file", path.encode(), 1, kind, ctypes.byref(output)) == 0
    assert cgio("cgio_copy_file", file, output, 0) == 0
    cgio("cgio_close_file", file)
    cgio("cgio_close_file", output)
    return path


def children():
    """Processes of this one."""
    with open("/proc/self/task/%d/children" % os.getpid()) as stream:
        return stream.read().split()


def node_variants(cgio, mesh, path):
    """Writes `path` once for every node and type; yields a label."""
    shutil.copyfile(mesh, path)
    file, root = open_file(cgio, path)
    count = len(nodes_of(cgio, file, root))
    cgio("cgio_close_file", file)
    for n in range(count):
        for kind in TYPES:
            shutil.copyfile(mesh, path)
            file, root = open_file(cgio, path)
            node = ctypes.c_double(nodes_of(cgio, file, root)[n])
            dims = (ctypes.c_int64 * 12)()
            dimensions = ctypes.c_int()
            cgio("cgio_get_dimensions", file, node, ctypes.byref(dimensions), dims)
            size = 1
            for d in range(dimensions.value):
                size *= dims[d]
            cgio("cgio_set_dimensions", file, node, kind.encode(), dimensions.value if kind != "MT" else 0, dims)
            if kind != "MT" and dimensions.value:
                cgio("cgio_write_all_data", file, node, ctypes.create_string_buffer(16 * size))
            cgio("cgio_close_file", file)
            yield "node %d as %s" % (n, kind)


def byte_variants(mesh, path, count):
    """Cuts the file and flips its bits; yields a label."""
    with open(mesh, "rb") as stream:
        whole = stream.read()
    choice = random.Random(1)
    for n in range(count):
        with open(path, "wb") as stream:
            stream.write(whole[:len(whole) * n // count])
        yield "cut %d" % n
        data = bytearray(whole)
        for _ in range(choice.choice((1, 1, 2, 8, 64))):
            data[choice.randrange(len(data))] ^= 1 << choice.randrange(8)
        with open(path, "wb") as stream:
            stream.write(data)
        yield "flip %d" % n


def main():
    plugin, mesh = sys.argv[1:3]
    count = int(sys.argv[3]) if len(sys.argv) > 3 else 500
    library = sys.argv[4] if len(sys.argv) > 4 else sorted(glob.glob("/usr/lib/*/libvtkcgns*.so*"))[0]
    simple.LoadPlugin(os.path.abspath(plugin), remote=False, ns=simple.__dict__)
    cgio = Library(library)
    folder = tempfile.mkdtemp()
    for kind, name in ((1, "ADF"), (2, "HDF5")):
        damage(cgio, copied(cgio, mesh, os.path.join(folder, name + ".cgns"), kind), name, count, folder)
    shutil.rmtree(folder)


def damage(cgio, mesh, name, count, folder):
    path = os.path.join(folder, "damaged.cgns")
    texts = []

    def observe(_object, _event, text):
        texts.append(text)
    observe.CallDataType = "string0"

    whole = simple.HexBlockMeshReader(FileName=mesh)
    whole.UpdatePipeline()
    assert whole.GetDataInformation().GetNumberOfPoints() > 0, mesh + " cannot be read before it is damaged"
    simple.Delete(whole)
    before = None
    others = children()  # MPI's
    total = refused = stopped = 0
    worst = {}
    for label in variants(cgio, mesh, path, count):
        reader = simple.HexBlockMeshReader(FileName=path)
        client = reader.SMProxy.GetClientSideObject()
        client.AddObserver("ErrorEvent", observe)
        client.AddObserver("WarningEvent", lambda *_: None)
        client.GetExecutive().AddObserver("ErrorEvent", lambda *_: None)
        del texts[:]
        reader.UpdatePipeline()
        assert len(texts) <= 1, (label, texts)
        assert texts or client.GetOutputDataObject(0).GetNumberOfPoints() > 0, label + ": nothing, and no error"
        total += 1
        refused += len(texts)
        if texts and "the library that reads it failed" in texts[0]:
            stopped += 1
            worst[texts[0].split("failed", 1)[1].strip()] = label
        simple.Delete(reader)
        open_now = len(os.listdir("/proc/self/fd"))
        before = before or open_now
        assert open_now <= before and children() == others, label
    print("%s: %d damaged files, %d refused, %d of them ended the process that read them, %d read; descriptors: %d" %
          (name, total, refused, stopped, total - refused, before), flush=True)
    for text, label in worst.items():
        print("    %s (%s)" % (text, label))


def variants(cgio, mesh, path, count):
    yield from node_variants(cgio, mesh, path)
    yield from byte_variants(mesh, path, count)


if __name__ == "__main__":
    main()
