# SPDX-License-Identifier: BSD-3-Clause
"""Runs the benchmarks and prints one table in Markdown.

    python3 Testing/Benchmark/table.py build [--most 1e7] [--only Conversion,Topology] [--jobs]

build: a build folder that was configured with -DBSPLINEVOLUME_BUILD_BENCHMARKS=ON.

Every row is one benchmark at one size: time per point on one thread, the time of a memcpy of the result's bytes divided
by it, parallel efficiency (time on one thread by twice that on two), and the exponent p of time ~ points^p over all
sizes of the benchmark. Memory is the peak beyond input and output, by the bytes of the result. Files are compared with
a copy to the disk, or with reading from it. --jobs adds what pvpython does as a whole.
"""
import argparse
import glob
import json
import math
import os
import re
import subprocess
import sys

NAME = re.compile(r"^(?P<name>.+)/points:(?P<points>\d+)/threads:(?P<threads>\d+)")


def run(executable, most):
    """The results of one executable by (benchmark, points), then by threads."""
    listed = subprocess.run([executable, "--benchmark_list_tests"], capture_output=True, text=True, check=True)
    sizes = {int(NAME.match(line)["points"]) for line in listed.stdout.split("\n") if NAME.match(line)}
    wanted = "points:(%s)/" % "|".join(str(n) for n in sorted(sizes) if n <= most)
    done = subprocess.run([executable, "--benchmark_format=json", "--benchmark_filter=" + wanted],
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True)
    results = {}
    for result in json.loads(done.stdout)["benchmarks"]:
        if result.get("error_occurred"):
            continue
        match = NAME.match(result["name"])
        key = match["name"], int(match["points"])
        results.setdefault(key, {})[int(match["threads"])] = result
    return results


def exponent(times):
    """Slope of log(time) over log(points), by least squares."""
    x = [math.log(points) for points, _ in times]
    y = [math.log(seconds) for _, seconds in times]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def rows(results):
    for name in dict.fromkeys(name for name, _ in results):
        one = {points: threads for (other, points), threads in results.items() if other == name}
        for threads in one.values():
            for result in threads.values():
                result.setdefault("seconds", 1e-3 * result["real_time"])  # all report milliseconds
        times = [(t[1].get("points", points), t[1]["seconds"]) for points, t in sorted(one.items())]
        power = "%.2f" % exponent(times) if len(times) > 1 else ""
        for points, threads in sorted(one.items()):
            first = threads[1]
            count = first.get("points", points)
            seconds = first["seconds"]
            yield [
                name.replace("_", " "), "%.0e" % points, "%.3g" % (1e3 * seconds), "%.3g" % (1e9 * seconds / count),
                "%.3g" % (1e-6 * first["bytes"] / seconds) if "bytes" in first else "",
                "%.2g" % first["memcpy"] if "memcpy" in first else "",
                "%.0f %%" % (50 * seconds / threads[2]["seconds"]) if 2 in threads else "",
                "%.1f %%" % (100 * first["extra_bytes"] / first["bytes"]) if "extra_bytes" in first else "",
                "%.2f" % first["disk"] if "disk" in first else "", power]
            power = ""


def print_table(header, lines):
    print("| " + " | ".join(header) + " |")
    print("|" + "---|" * len(header))
    for line in lines:
        print("| " + " | ".join(line) + " |", flush=True)
    print()


def jobs(build):
    folder = os.path.dirname(os.path.abspath(__file__))
    plugin = glob.glob(os.path.join(build, "lib*", "**", "BSplineVolume.so"), recursive=True)[0]
    for kind, joins in (("double", []), ("double", ["joins"]), ("float", [])):
        for threads in (1, 2):
            environment = dict(os.environ, VTK_SMP_BACKEND_IN_USE="STDThread", VTK_SMP_MAX_THREADS=str(threads))
            command = ["pvpython", os.path.join(folder, "measure_filter.py"), plugin, "10000000", kind] + joins
            done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, env=environment)
            result = json.loads(done.stdout)
            yield ["conversion filter%s, %s, %.0e points, %d threads" % (
                       " with Check Joins" if joins else "", kind, result["points"], threads),
                   "%.2f s" % result["filter_seconds"], "%.1f times a copy" % result["ratio"],
                   "memory beyond input and output: %.1f %% of the input" % (100 * result["extra_memory"])]
    done = subprocess.run([sys.executable, os.path.join(folder, "measure_job.py"), plugin],
                          stdout=subprocess.PIPE, text=True, check=True)
    result = json.loads(done.stdout)
    yield ["PLOT3D to .qfmb, 12,288 hexahedra", "%.2f s" % result["beyond_seconds"],
           "beyond ParaView's own %.2f s" % result["start_seconds"],
           "%.0f MB beyond its own %.0f MB" % (result["beyond_bytes"] / 1e6, result["start_bytes"] / 1e6)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build")
    parser.add_argument("--most", type=float, default=1e7, help="largest number of points, default 1e7")
    parser.add_argument("--only", default="", help="names of executables without Benchmark, by commas; default all")
    parser.add_argument("--jobs", action="store_true", help="also measure pvpython as a whole")
    arguments = parser.parse_args()
    only = arguments.only.split(",") if arguments.only else None

    lines = []
    for executable in sorted(glob.glob(os.path.join(arguments.build, "bin", "Benchmark*"))):
        if only is None or os.path.basename(executable)[len("Benchmark"):] in only:
            lines += rows(run(executable, arguments.most))
    print_table(["benchmark", "points", "ms", "ns/point", "MB/s", "of memcpy", "efficiency, 2 threads", "memory",
                 "of disk", "exponent"], lines)
    if arguments.jobs:
        print_table(["job", "time", "", "memory"], jobs(arguments.build))


if __name__ == "__main__":
    main()
