# SPDX-License-Identifier: BSD-3-Clause
"""The plugin works in a pvserver with the client in another process."""
import os
import select
import socket
import subprocess
import sys
import tempfile
import time

from paraview import simple

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "Examples"))
import make_demo_mesh


def start_server(deadline):
    """A pvserver that waits for a client, and its port. Ports may be taken in between, so several are tried."""
    while time.time() < deadline:
        with socket.socket() as probe:
            probe.bind(("", 0))
            port = probe.getsockname()[1]
        server = subprocess.Popen(["pvserver", "--server-port=%d" % port], stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT)
        told = b""
        while time.time() < deadline and server.poll() is None:
            if select.select([server.stdout], [], [], 0.2)[0]:
                told += os.read(server.stdout.fileno(), 4096)
                if b"Accepting connection" in told:
                    return server, port
        server.kill()
        server.wait()
    sys.exit("no pvserver in time: " + told.decode())


def main():
    server, port = start_server(time.time() + 60)
    try:
        simple.Connect("localhost", port)
        plugin = os.environ["BSV_PLUGIN"]
        simple.LoadPlugin(plugin, remote=True, ns=globals())
        simple.LoadPlugin(plugin, remote=False, ns=globals())
        with tempfile.TemporaryDirectory() as folder:
            mesh = HexBlockMeshReader(FileName=make_demo_mesh.write_demo(folder, 4))
            volume = CatmullClarkToBSplineVolume(Input=mesh)
            samples = BSplineVolumeSampler(Input=volume, Level=1)
            samples.UpdatePipeline()
            before, after = mesh.GetDataInformation(), volume.GetDataInformation()
            assert samples.SMProxy.GetClientSideObject() is None, "the filters must run in the server"
            assert before.GetNumberOfPoints() > 0
            assert after.GetNumberOfPoints() > before.GetNumberOfPoints()
            assert samples.GetDataInformation().GetNumberOfPoints() > before.GetNumberOfPoints()
            simple.Show(samples)
            simple.Render()

            path = os.path.join(folder, "demo.qfmb")
            simple.SaveData(path, proxy=volume)
            copy = QuadflowReader(FileName=path)
            copy.UpdatePipeline()
            assert copy.GetDataInformation().GetNumberOfPoints() == after.GetNumberOfPoints()
        simple.Disconnect()
        assert server.wait(timeout=60) == 0
    finally:
        if server.poll() is None:
            server.kill()
            server.wait()


if __name__ == "__main__":
    main()
