# SPDX-License-Identifier: BSD-3-Clause
"""An installed folder that was moved afterwards still loads, with nothing taken from the build folder, also on its own by the
variable PV_PLUGIN_PATH; where it cannot be loaded it says for which ParaView it was built.

Arguments: cmake, the build folder, the plugin's folder below the prefix.
"""
import os
import re
import subprocess
import sys
import tempfile

from paraview import simple

VERSION = (simple.GetParaViewVersion().major, simple.GetParaViewVersion().minor)
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

BY_ITSELF = """
from paraview import simple
assert simple.HexBlockMeshReader().GetClientSideObject().GetClassName() == "vtkHexBlockMeshReader"
"""

REFUSED = """
import sys
from paraview import simple
try:
    simple.LoadPlugin(sys.argv[1] + "/BSplineVolume.so", remote=False)
except RuntimeError:
    sys.exit(0)
sys.exit("a plugin without its library was loaded")
"""


def main(cmake, build, plugin_folder):
    with tempfile.TemporaryDirectory() as folder:
        installed, moved = os.path.join(folder, "installed"), os.path.join(os.path.realpath(folder), "moved")
        subprocess.run([cmake, "--install", build, "--prefix", installed], check=True, stdout=subprocess.DEVNULL)
        os.rename(installed, moved)
        place = os.path.join(moved, plugin_folder)

        def pvpython(text, **environment):
            script = os.path.join(folder, "check.py")
            with open(script, "w") as out:
                out.write(text)
            return subprocess.run(["pvpython", script, place], check=True, stderr=subprocess.PIPE, text=True,
                                  env=dict(os.environ, **environment)).stderr

        pvpython(CHECK, PYTHONPATH=place)
        pvpython(BY_ITSELF, PV_PLUGIN_PATH=place)
        # The command finds its package from where it lies.
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        command = subprocess.run([os.path.join(moved, "bin", "bsplinevolume"), "formats"], check=True, env=environment,
                                 stdout=subprocess.PIPE, text=True)
        assert ".qfmb" in command.stdout, command.stdout
        # As in another ParaView, the plugin itself cannot be opened.
        for name in os.listdir(place):
            if name.startswith("BSplineVolume.pv"):
                os.remove(os.path.join(place, name))
        said = [line for line in pvpython(REFUSED).splitlines() if line.startswith("BSplineVolume ")]
        version = re.search(r"built for ParaView (\d+\.\d+)", "".join(said))
        assert len(said) == 1 and version and version[1] == "%d.%d" % VERSION, said


if __name__ == "__main__":
    main(*sys.argv[1:])
