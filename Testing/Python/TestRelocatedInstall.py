# SPDX-License-Identifier: BSD-3-Clause
"""An installed folder that was moved afterwards still loads, with nothing taken from the build folder.

Arguments: cmake, the build folder, the plugin's folder below the prefix.
"""
import os
import subprocess
import sys
import tempfile

CHECK = """
import sys
import bsplinevolume
from paraview import simple
simple.LoadPlugin(sys.argv[1] + "/BSplineVolume.so", remote=False, ns=globals())
assert bsplinevolume.vtkCatmullClarkToBSplineVolume().GetClassName() == "vtkCatmullClarkToBSplineVolume"
assert HexBlockMeshReader().GetClientSideObject().GetClassName() == "vtkHexBlockMeshReader"
loaded = {line.split()[-1] for line in open("/proc/self/maps") if "BSplineVolume" in line}
assert len(loaded) >= 8, loaded
assert all(path.startswith(sys.argv[1] + "/") for path in loaded), loaded
"""


def main(cmake, build, plugin_folder):
    with tempfile.TemporaryDirectory() as folder:
        installed, moved = os.path.join(folder, "installed"), os.path.join(os.path.realpath(folder), "moved")
        subprocess.run([cmake, "--install", build, "--prefix", installed], check=True, stdout=subprocess.DEVNULL)
        os.rename(installed, moved)
        script = os.path.join(folder, "check.py")
        with open(script, "w") as out:
            out.write(CHECK)
        place = os.path.join(moved, plugin_folder)
        subprocess.run(["pvpython", script, place], check=True, env=dict(os.environ, PYTHONPATH=place))


if __name__ == "__main__":
    main(*sys.argv[1:])
