# SPDX-License-Identifier: BSD-3-Clause
"""Third-party meshes through the whole pipeline: read, convert, sample, write, read back; prints a table.

Every mesh has a process of its own, whose peak memory is compared with that of ParaView with the plugin loaded and
nothing else. Skipped without the folder BSV_SHARED_DATA.
"""
import os
import resource
import subprocess
import sys
import tempfile
import time

CASES = ["near_tip_vol.xyz", "bwb_vol.xyz", "717_wl_L2.cgns", "t_joint.xyz", "torus.xyz", "sphere7ProjectedEdges.xyz",
         "even_sphere_vol.xyz", "n0012.cgns", "mixer.xyz", "multi-bin.xyz", "multi-ascii.xyz"]
SKIPPED = 77


def peak():
    """Most memory that this process has used, in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def run(path):
    """One mesh; prints a row of the table."""
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    from bsv_support import blocks, coordinates, field, names, simple, update
    before = peak()
    start = time.perf_counter()
    mesh = simple.HexBlockMeshReader(FileName=path)
    volume = simple.CatmullClarkToBSplineVolume(Input=mesh)
    samples = simple.BSplineVolumeSampler(Input=volume, Level=1)
    sampled, _ = update(samples)
    converted, _ = update(volume)
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "case.qfmb")
        simple.SaveData(file, proxy=volume)
        read, _ = update(simple.QuadflowReader(FileName=file))
        megabytes = os.path.getsize(file) / 1e6
    seconds = time.perf_counter() - start

    assert names(read) == names(converted)
    for old, new in zip(blocks(converted), blocks(read)):
        assert bytes(memoryview(coordinates(old))) == bytes(memoryview(coordinates(new)))
        for knots in ("KnotsU", "KnotsV", "KnotsW"):
            assert field(old, knots) == field(new, knots)
    for array in ("Interfaces", "Boundaries", "BoundaryNames"):
        if converted.GetFieldData().GetAbstractArray(array):
            assert field(read, array) == field(converted, array), array
    # Every span is cut in two: n spans of n + 3 control points give 2 n + 1 samples.
    for old, new in zip(blocks(converted), blocks(sampled)):
        extents = [extent[1::2] for extent in (old.GetExtent(), new.GetExtent())]
        assert [2 * (n + 1 - 3) for n in extents[0]] == list(extents[1])

    inputs, _ = update(mesh)
    report = simple.HexBlockTopology(Input=mesh)
    update(report)
    classes = report.SMProxy.GetClientSideObject()
    points = sum(block.GetNumberOfPoints() for block in blocks(converted))
    print("| %s | %d / %d | %d | %d | %d | %.1f | %.2f | %.0f |" % (
        os.path.basename(path), inputs.GetNumberOfPartitionedDataSets(), converted.GetNumberOfPartitionedDataSets(),
        points, classes.GetNumberOfExtraordinaryEdges(), classes.GetNumberOfSingularNodes(), megabytes, seconds,
        peak() - before))


def main():
    folder = os.path.join(os.environ.get("BSV_SHARED_DATA", ""), "structured")
    files = [os.path.join(folder, case) for case in CASES]
    files = [file for file in files if os.path.exists(file)]
    if not files:
        sys.exit(SKIPPED)
    print("| mesh | blocks in / out | control points | extraordinary edges | singular nodes | .qfmb MB | seconds "
          "| MB beyond ParaView |", flush=True)
    print("|---|---|---|---|---|---|---|---|", flush=True)
    for file in files:
        subprocess.run([sys.executable if "pvpython" in sys.executable else "pvpython", __file__, file], check=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        run(sys.argv[1])
    else:
        main()
