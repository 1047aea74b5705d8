# SPDX-License-Identifier: BSD-3-Clause
"""Strong scaling of the conversion over threads and ranks, as a table in Markdown.

    python3 Testing/Benchmark/scaling.py build [--resolution 77] [--blocks 22] [--cells 16] [--ranks 1,2,3,4]

build: a build folder with the plugin. Every case runs in a pvbatch of its own for each number of ranks, on one and on two
threads each; speedup is against one rank on one thread in the same run. All results must be the same bits, or it ends with
an error. Received bytes are those of the rank that receives most; memory is the peak beyond what stays (input
and output), of all ranks together by the input.
"""
import argparse
import glob
import json
import os
import subprocess
import sys


def measure(build, arguments, ranks, threads):
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "measure_ranks.py")
    package = os.path.dirname(glob.glob(os.path.join(build, "lib*", "**", "BSplineVolume.so"), recursive=True)[0])
    environment = dict(os.environ, PYTHONPATH=package, VTK_SMP_BACKEND_IN_USE="STDThread",
                       VTK_SMP_MAX_THREADS=str(threads), OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    done = subprocess.run(
        ["mpiexec", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), "pvbatch", "--sym", script] + arguments,
        stdout=subprocess.PIPE, text=True, check=True, env=environment)
    return json.loads(next(line for line in done.stdout.split("\n") if line.startswith("{")))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build")
    parser.add_argument("--resolution", type=int, default=77, help="of the wing case, default 77: 50 million points")
    parser.add_argument("--blocks", type=int, default=22, help="blocks per direction of the box, default 22: 10,648")
    parser.add_argument("--cells", type=int, default=16, help="cells per direction of each of these, default 16")
    parser.add_argument("--ranks", default="1,2,3,4")
    options = parser.parse_args()
    print("| case | points | ranks | threads each | source, s | conversion, s | speedup | received MB, most | memory | result |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for arguments in (["wing", str(options.resolution)], ["blocks", str(options.blocks), str(options.cells)]):
        first = None
        for ranks in map(int, options.ranks.split(",")):
            for threads in (1, 2):
                result = measure(options.build, arguments, ranks, threads)
                first = first or result
                print("| %s, %d blocks | %d | %d | %d | %.2f | %.2f | %.2f | %.2f | %.1f %% | %s |" % (
                    arguments[0], result["blocks"], result["points"], ranks, threads, result["source_seconds"],
                    result["seconds"], first["seconds"] / result["seconds"], max(result["received_bytes"]) / 1e6,
                    100 * sum(result["extra_bytes"]) / sum(result["input_bytes"]), result["result"][:16]), flush=True)
                if result["result"] != first["result"]:
                    sys.exit("the result differs from that of one rank and one thread")


if __name__ == "__main__":
    main()
