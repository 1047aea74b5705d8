# SPDX-License-Identifier: BSD-3-Clause
"""The plugin works in a pvserver with the client in another process, and does there what it does in one process.

    pvpython TestClientServer.py [<command that starts a program on several ranks>...]
"""
import filecmp
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


def listens(port):
    """Whether a process of this machine waits for connections. What pvserver says of it stays in mpiexec's buffers."""
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        with open(table) as lines:
            for line in list(lines)[1:]:
                _, local, _, state = line.split()[:4]
                if state == "0A" and int(local.split(":")[1], 16) == port:
                    return True
    return False


def outside_mpi():
    """The environment without what pvpython, an MPI process itself, added to it: mpiexec does not start inside MPI."""
    return {key: value for key, value in os.environ.items()
            if not key.startswith(("PMIX_", "ORTE_", "OMPI_")) or key.startswith("OMPI_ALLOW")}


def start_server(launcher, log, deadline):
    """A pvserver that waits for a client, and its port. Ports may be taken in between, so several are tried."""
    while time.time() < deadline:
        with socket.socket() as probe:
            probe.bind(("", 0))
            port = probe.getsockname()[1]
        with open(log, "w") as out:
            server = subprocess.Popen(
                launcher + ["pvserver", "--server-port=%d" % port], stdout=out, stderr=subprocess.STDOUT,
                env=outside_mpi())
        while time.time() < deadline and server.poll() is None:
            if listens(port):
                return server, port
            time.sleep(0.1)
        server.kill()
        server.wait()
    sys.exit("no pvserver in time: " + open(log).read())


def write_volume(folder, name):
    """The file of the converted demonstration mesh, and the last filter of the chain."""
    mesh = simple.HexBlockMeshReader(FileName=make_demo_mesh.write_demo(folder, 4))
    volume = simple.CatmullClarkToBSplineVolume(Input=mesh)
    samples = simple.BSplineVolumeSampler(Input=volume, Level=1)
    samples.UpdatePipeline()
    before, after = mesh.GetDataInformation(), volume.GetDataInformation()
    assert before.GetNumberOfPoints() > 0
    assert after.GetNumberOfPoints() > before.GetNumberOfPoints()
    assert samples.GetDataInformation().GetNumberOfPoints() > before.GetNumberOfPoints()
    simple.Show(samples)
    simple.Render()
    path = os.path.join(folder, name)
    simple.SaveData(path, proxy=volume)
    copy = simple.QuadflowReader(FileName=path)
    copy.UpdatePipeline()
    assert copy.GetDataInformation().GetNumberOfPoints() == after.GetNumberOfPoints()
    return path, samples


def client(port):
    with tempfile.TemporaryDirectory() as folder:
        simple.LoadPlugin(os.environ["BSV_PLUGIN"], remote=False, ns=simple.__dict__)
        here, _ = write_volume(folder, "here.qfmb")
        simple.Connect("127.0.0.1", port)
        simple.LoadPlugin(os.environ["BSV_PLUGIN"], remote=True, ns=simple.__dict__)
        there, samples = write_volume(folder, "there.qfmb")
        assert samples.SMProxy.GetClientSideObject() is None, "the filters must run in the server"
        assert filecmp.cmp(here, there, shallow=False)


def main(launcher):
    """The client is a process of its own: the server ends, and says whether all went well, when the client has gone."""
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "pvserver.log")
        server, port = start_server(launcher, log, time.time() + 60)
        try:
            subprocess.run(["pvpython", __file__, "--client", str(port)], check=True, timeout=120)
            assert server.wait(timeout=60) == 0
        finally:
            if server.poll() is None:
                server.kill()
                server.wait()
            print(open(log).read())


if __name__ == "__main__":
    client(int(sys.argv[2])) if sys.argv[1:2] == ["--client"] else main(sys.argv[1:])
