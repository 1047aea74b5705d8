# SPDX-License-Identifier: BSD-3-Clause
"""Another project finds, compiles and links an installed and moved BSplineVolume, and its programs give the right results.

Arguments: cmake, the build folder, the external project, the generator, ON or OFF for the filters, the compiler's launcher or
nothing.
"""
import os
import subprocess
import sys
import tempfile


def main(cmake, build, project, generator, filters, launcher=""):
    with tempfile.TemporaryDirectory() as folder:
        installed, moved = os.path.join(folder, "installed"), os.path.join(os.path.realpath(folder), "moved")
        subprocess.run([cmake, "--install", build, "--prefix", installed], check=True, stdout=subprocess.DEVNULL)
        os.rename(installed, moved)
        own = os.path.join(folder, "build")
        subprocess.run([cmake, "-S", project, "-B", own, "-G", generator, "-DCMAKE_PREFIX_PATH=" + moved,
                        "-DWITH_FILTERS=" + filters, "-DCMAKE_CXX_COMPILER_LAUNCHER=" + launcher], check=True)
        subprocess.run([cmake, "--build", own], check=True)
        for program in ["uses_core"] + (["uses_filters"] if filters == "ON" else []):
            subprocess.run([os.path.join(own, program)], check=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
