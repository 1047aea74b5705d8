# SPDX-License-Identifier: BSD-3-Clause
"""The demonstration case of ./convert.sh gives the same bits everywhere: releases, compilers, optimisation, VTK versions.

A change of the method or of the file's syntax changes the hashes; then these are replaced, and CHANGELOG.md says why.
"""
import hashlib
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "Examples"))
import bsplinevolume as bsv
import make_demo_mesh

EXPECTED = {
    "mesh": "5fdd96dd75e2560a97d54df1bb7f9e7e5780fd2b96ede7d99128207edb23da10",
    "control points": "e4220b4aa81f4b3084d2b470a1ec1a50376032a9dcc49ce738f5f4aadd8bf8ec",
    # grep -v '^#' output/demo.qfmb | sha256sum
    "demo.qfmb without its comments": "51a87b44f8ce6a9a94575f956ca58c385f3e78a29fa24975ef870429472366b3",
}


def main():
    with tempfile.TemporaryDirectory() as folder:
        mesh = make_demo_mesh.write_demo(folder)
        volume = bsv.convert(mesh, UseCreaseAngle=True, CreaseAngle=30.0)
        written = os.path.join(folder, "demo.qfmb")
        volume.write(written)
        with open(mesh, "rb") as file:
            content = {"mesh": file.read()}
        content["control points"] = b"".join(block.points.tobytes() for block in volume.blocks)
        with open(written, "rb") as file:
            lines = file.readlines()
    assert b" BSplineVolume %s;" % bsv.__version__.encode() in lines[0], lines[0]
    content["demo.qfmb without its comments"] = b"".join(line for line in lines if not line.startswith(b"#"))
    found = {name: hashlib.sha256(data).hexdigest() for name, data in content.items()}
    assert found == EXPECTED, found


if __name__ == "__main__":
    main()
