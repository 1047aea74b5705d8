# SPDX-License-Identifier: BSD-3-Clause
"""A whole job in a fresh pvpython: from reading a mesh to the written topology.

    python3 measure_job.py <BSplineVolume.so> [<pvpython>]

The mesh is six blocks of 16 x 16 x 8 cells around a sphere, 12,288 hexahedra in all, as PLOT3D. Prints one line of
JSON: seconds and peak memory of pvpython importing paraview.simple alone, and of the job beyond that, each the best of
five runs.
"""
import array
import json
import math
import os
import subprocess
import sys
import tempfile
import time

START = "from paraview import simple"
JOB = START + """
import sys
simple.LoadPlugin(sys.argv[1], remote=False, ns=globals())
mesh = HexBlockMeshReader(FileName=sys.argv[2])
volume = CatmullClarkToBSplineVolume(Input=mesh)
simple.SaveData(sys.argv[3], proxy=volume)
"""
RUNS = 5


def write_sphere(path, cells=16, layers=8):
    """Six blocks around the unit sphere, out to radius 3."""
    blocks = []
    for side in range(6):
        normal, sign = side // 2, 2 * (side % 2) - 1
        points = []
        for k in range(layers + 1):
            radius = 3.0 ** (k / layers)
            for j in range(cells + 1):
                for i in range(cells + 1):
                    x = [0.0, 0.0, 0.0]
                    x[normal] = float(sign)
                    # Integers keep shared points the same bits.
                    a, b = ((2 * n - cells) / cells for n in ((i, j) if sign > 0 else (j, i)))
                    x[(normal + 1) % 3], x[(normal + 2) % 3] = math.tan(a * math.pi / 4), math.tan(b * math.pi / 4)
                    if abs(a) == 1:
                        x[(normal + 1) % 3] = a
                    if abs(b) == 1:
                        x[(normal + 2) % 3] = b
                    scale = radius / math.sqrt(math.fsum(q * q for q in x))
                    points.append([scale * q for q in x])
        blocks.append(points)
    with open(path, "wb") as out:
        array.array("i", [6] + 6 * [cells + 1, cells + 1, layers + 1]).tofile(out)
        for points in blocks:
            for d in range(3):
                array.array("d", [p[d] for p in points]).tofile(out)


def best(command):
    """Least wall time and least peak memory in bytes of several runs."""
    times, peaks = [], []
    for _ in range(RUNS):
        start = time.perf_counter()
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        times.append(time.perf_counter() - start)
        peaks.append(1024 * usage.ru_maxrss)
        if status != 0:
            sys.exit("failed: " + " ".join(command))
    return min(times), min(peaks)


def main(plugin, pvpython="pvpython"):
    with tempfile.TemporaryDirectory() as folder:
        mesh, result = os.path.join(folder, "sphere.xyz"), os.path.join(folder, "sphere.qfmb")
        write_sphere(mesh)
        scripts = {}
        for name, text in (("start", START), ("job", JOB)):
            scripts[name] = os.path.join(folder, name + ".py")
            with open(scripts[name], "w") as out:
                out.write(text)
        start_seconds, start_bytes = best([pvpython, scripts["start"]])
        job_seconds, job_bytes = best([pvpython, scripts["job"], plugin, mesh, result])
        assert os.path.getsize(result) > 0
    print(json.dumps({
        "start_seconds": start_seconds, "start_bytes": start_bytes,
        "beyond_seconds": job_seconds - start_seconds, "beyond_bytes": job_bytes - start_bytes}))


if __name__ == "__main__":
    main(*sys.argv[1:])
