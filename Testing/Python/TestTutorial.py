# SPDX-License-Identifier: BSD-3-Clause
"""The Python of docs/tutorial.md, docs/python.md and the README runs as it stands, in the order of the page; files and pictures
that pages link to exist."""
import os
import re
import sys
import tempfile

import bsplinevolume as bsv
import paraview.simple  # noqa: F401  as the page has it

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DOCS = os.path.join(ROOT, "docs")


def blocks_of(path):
    with open(path, encoding="utf-8") as file:
        return re.findall(r"```python\n(.*?)```", file.read(), flags=re.S)


def run(path):
    blocks = blocks_of(path)
    assert blocks
    names = {"__name__": "tutorial"}
    for number, text in enumerate(blocks):
        exec(compile(text, "%s, block %d" % (os.path.basename(path), number + 1), "exec"), names)


def check_links(path):
    """Every relative link of a page leads to a file."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text)
    missing = [link for link in links if not os.path.exists(os.path.join(os.path.dirname(path), link))]
    assert not missing, "%s: no such files: %s" % (path, missing)


for page in ["README.md", "CONTRIBUTING.md"] + [os.path.join("docs", name) for name in sorted(os.listdir(DOCS))]:
    if page.endswith(".md"):
        check_links(os.path.join(ROOT, page))
for name in "tutorial.md", "python.md":
    run(os.path.join(DOCS, name))
# The README's reads wing.xyz and wing.igs, and takes the plugin from build/.
with tempfile.TemporaryDirectory() as folder:
    source = bsv.vtkWingFuselageSource()
    source.SetResolution(3)
    source.Update()
    bsv.pipeline.write(os.path.join(folder, "wing.xyz"), None, lambda: source.GetOutputDataObject(0), {})
    bsv.pipeline.write(os.path.join(folder, "wing.igs"), source.GetOutputDataObject(1), None, {})
    plugin = os.path.dirname(os.path.abspath(os.environ["BSV_PLUGIN"]))
    os.makedirs(os.path.join(folder, "build", "lib"))
    os.symlink(plugin, os.path.join(folder, "build", "lib", "BSplineVolume"))
    os.chdir(folder)
    run(os.path.join(ROOT, "README.md"))
    assert os.path.getsize("wing.qfmb") > 0
    os.chdir(ROOT)
sys.stdout.flush()
