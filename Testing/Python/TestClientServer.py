# SPDX-License-Identifier: BSD-3-Clause
"""The plugin works in a pvserver with the client in another process."""
import os
import socket
import subprocess
import sys
import tempfile
import time

from paraview import simple

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "Examples"))
import make_demo_mesh


def start_server(log, deadline):
    """A pvserver that waits for a client, and its port. Ports may be taken in between, so several are tried."""
    while time.time() < deadline:
        with socket.socket() as probe:
            probe.bind(("", 0))
            port = probe.getsockname()[1]
        with open(log, "w") as out:
            server = subprocess.Popen(["pvserver", "--server-port=%d" % port], stdout=out, stderr=subprocess.STDOUT)
        while time.time() < deadline and server.poll() is None:
            if "Accepting connection" in open(log).read():
                return server, port
            time.sleep(0.1)
        server.kill()
        server.wait()
    sys.exit("no pvserver in time: " + open(log).read())


def check_chain(folder):
    mesh = simple.HexBlockMeshReader(FileName=make_demo_mesh.write_demo(folder, 4))
    volume = simple.CatmullClarkToBSplineVolume(Input=mesh)
    samples = simple.BSplineVolumeSampler(Input=volume, Level=1)
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
    copy = simple.QuadflowReader(FileName=path)
    copy.UpdatePipeline()
    assert copy.GetDataInformation().GetNumberOfPoints() == after.GetNumberOfPoints()


def client(port):
    simple.Connect("127.0.0.1", port)
    for remote in (True, False):
        simple.LoadPlugin(os.environ["BSV_PLUGIN"], remote=remote, ns=simple.__dict__)
    with tempfile.TemporaryDirectory() as folder:
        check_chain(folder)


def main():
    """The client is a process of its own: the server ends, and says whether all went well, when the client has gone."""
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "pvserver.log")
        server, port = start_server(log, time.time() + 60)
        try:
            subprocess.run(["pvpython", __file__, str(port)], check=True, timeout=120)
            assert server.wait(timeout=60) == 0
        finally:
            if server.poll() is None:
                server.kill()
                server.wait()
            print(open(log).read())


if __name__ == "__main__":
    client(int(sys.argv[1])) if len(sys.argv) > 1 else main()
