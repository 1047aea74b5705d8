# SPDX-License-Identifier: BSD-3-Clause
"""One HTML file about a conversion: verdict, pictures as in ParaView's window, tables, settings."""
import base64
import contextlib
import html
import json
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

import bsplinevolume as bsv
from bsplinevolume.display import display

STYLE = """
body { font: 15px/1.45 sans-serif; color: #222; max-width: 1100px; margin: 2em auto; padding: 0 1em }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em; border-bottom: 1px solid #ccc }
table { border-collapse: collapse; margin: .5em 0 } td, th { padding: .15em .8em; border-bottom: 1px solid #ddd;
text-align: right } th { text-align: left; background: #f3f3f3 } td:first-child { text-align: left }
pre { background: #f6f6f6; padding: .8em; white-space: pre-wrap } img { width: 100%; border: 1px solid #ddd }
.good { color: #17692a } .bad { color: #a4161a } .verdict { font-size: 1.2em; font-weight: bold }
"""
WORST_JOINS = 15
BLOCKS_SHOWN = 200

#: Columns of the table of joins that a reader of the report needs, and their titles.
JOIN_COLUMNS = {"Class": "class", "Kind": "what", "NameA": "block", "NameB": "block", "Continuity": "continuity",
                "MaximumLayerJump": "kink of layers, degrees", "MaximumC1Jump": "C1 jump", "MaximumC2Jump": "C2 jump"}

#: Captions and files.
PICTURES = (("Control nets, before and after", "nets.png"),
            ("The volumes: wall, creases, extraordinary curves", "volume.png"),
            ("Validity: the wall as a ghost, spans that are not proven valid inside", "quality.png"),
            ("Smoothness: interfaces by the kink of their layers", "smoothness.png"),
            ("Distance of the wall from the body", "deviation.png"))

#: Role of the boundaries that are the wall, in the field data array BoundaryRoles.
BODY = 1

# Runs in ParaView's Python: mesh file, 1 if one of our readers reads it, body file or "-", folder, plugin, properties, the
# direction to look from.
DRAW = """
import json
import os
import sys
from paraview import simple
mesh_file, own, body_file, folder, plugin, properties, towards = sys.argv[1:]
simple.LoadPlugin(plugin, remote=False, ns=simple.__dict__)
mesh = simple.HexBlockMeshReader(FileName=mesh_file) if own == "1" else simple.OpenDataFile(mesh_file)
volume = simple.CatmullClarkToBSplineVolume(Input=mesh)
if body_file != "-":
    volume.Body = simple.NURBSSurfaceReader(FileName=body_file)
for name, value in json.loads(properties).items():
    setattr(volume, name, [n for pair in value for n in pair] if value and isinstance(value, list)
            and isinstance(value[0], list) else value)
shots = [("volume.png", volume), ("quality.png", simple.BSplineVolumeQuality(Input=volume)),
         ("smoothness.png", simple.BSplineVolumeSmoothness(Input=volume))]
if body_file != "-":
    shots.append(("deviation.png", simple.BodyDeviation(Input=volume)))
simple.LoadPalette("WhiteBackground")


def view_of(width):
    view = simple.CreateView("RenderView")
    view.ViewSize = [width, 700]
    return view


def look(view, zoom):
    simple.ResetCamera(view)
    view.CameraPosition = [f + d for f, d in zip(view.CameraFocalPoint, json.loads(towards))]
    view.CameraViewUp = [0.0, 0.0, 1.0]
    simple.ResetCamera(view)
    simple.GetActiveCamera().Zoom(zoom)


for name, source in shots:
    view = view_of(1100)
    display = simple.Show(source, view)
    if name == "quality.png":
        # The wall is what the spans that are not proven valid are seen against.
        findings = simple.Show(simple.OutputPort(source, 2), view)
        findings.Representation = "Surface"
        simple.ColorBy(display, None)
        display.Opacity = 0.35
    elif display.ColorArrayName[1]:
        display.RescaleTransferFunctionToDataRange(False, True)
        display.SetScalarBarVisibility(view, True)
    look(view, 1.4)
    simple.SaveScreenshot(os.path.join(folder, name), view, ImageResolution=[1100, 700])

layout = simple.CreateLayout()
layout.SetSize(1100, 700)
layout.SplitHorizontal(0, 0.5)
for source, cell in (mesh, 1), (volume, 2):
    view = view_of(550)
    simple.AssignViewToLayout(view, layout, cell)
    source.UpdatePipeline()
    simple.Show(source, view)
    look(view, 1.0)
simple.SaveScreenshot(os.path.join(folder, "nets.png"), layout, ImageResolution=[1100, 700])
"""


def _direction(volume):
    """Of eight directions to look from, the one from which most of the wall is seen: not from inside half a body."""
    data = volume.to_vtk().GetFieldData()
    roles, table = data.GetArray("BoundaryRoles"), data.GetArray("Boundaries")
    normals = [np.zeros((0, 3))]
    for row in vtk_to_numpy(table) if table and roles else []:
        block, face, tag = row[:3]
        if tag < 0 or roles.GetValue(tag) != BODY:
            continue
        net = volume.blocks[block].points
        wall, inner = (np.take(net, -1 - depth if face % 2 else depth, axis=2 - face // 2) for depth in (0, 1))
        across = np.cross(wall[1:, 1:] - wall[:-1, :-1], wall[1:, :-1] - wall[:-1, 1:])
        side = np.sum(across * (inner - wall)[:-1, :-1], axis=-1, keepdims=True)
        normals.append((across * np.sign(side)).reshape(-1, 3))
    normals = np.concatenate(normals)
    directions = [(x, y, 3.5) for y in (-5.0, 5.0) for x in (-4.0, 4.0)] + [(y, x, 3.5) for y in (-5.0, 5.0) for x in (-4.0, 4.0)]
    return max(directions, key=lambda towards: np.count_nonzero(normals @ towards > 0))


def _pictures(folder, mesh, body, volume, properties):
    """Draws with ParaView's Python, in an X server of its own where there is no display. Returns why not, or ""."""
    plugin = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "BSplineVolume.so")
    if not os.path.exists(plugin):
        return "there is no ParaView plugin beside this package"
    program = shutil.which("pvpython")
    if program is None:
        return "there is no pvpython"
    script = os.path.join(folder, "draw.py")
    with open(script, "w") as file:
        file.write(DRAW)
    own = any(getattr(bsv, name)().CanReadFile(mesh) for name in bsv.pipeline.MESH_READERS)
    command = [program, script, os.path.abspath(mesh), str(int(own)), os.path.abspath(body) if body else "-", folder, plugin,
               json.dumps(properties), json.dumps(_direction(volume))]
    try:
        with contextlib.nullcontext(dict(os.environ)) if os.environ.get("DISPLAY") else display() as environment:
            environment.pop("PYTHONHOME", None)
            result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
    except OSError as error:
        return "there is no display, and " + str(error)
    if result.returncode != 0:
        return "pvpython ended with status %d: %s" % (result.returncode, (result.stdout.strip().splitlines() or [""])[-1])
    return ""


def _table(head, rows):
    """Cells are texts or numbers."""
    def text(value):
        if isinstance(value, (float, np.floating)):
            return "%.4g" % value
        return html.escape(str(value))
    lines = ["<table><tr>" + "".join("<th>%s</th>" % html.escape(h) for h in head) + "</tr>"]
    lines += ["<tr>" + "".join("<td>%s</td>" % text(value) for value in row) + "</tr>" for row in rows]
    return "\n".join(lines + ["</table>"])


def _joins(volume):
    columns = volume.smoothness()
    count = len(columns["Class"])
    rows = [[columns[name][n] for name in JOIN_COLUMNS] + [" ".join("%.4g" % x for x in columns["Where"][n])]
            for n in range(min(count, WORST_JOINS))]
    return list(JOIN_COLUMNS.values()) + ["where"], rows, count


def _blocks(volume):
    quality = bsv.pipeline.filter_named("vtkBSplineVolumeQuality")
    bsv.pipeline.connect(quality.SetInputConnection, volume.to_vtk())
    bsv.pipeline.run(quality)
    data = quality.GetOutputDataObject(0).GetFieldData()
    columns = [vtk_to_numpy(data.GetArray(name)) for name in
               ("ValidSpans", "InvalidSpans", "UndecidedSpans", "MinimumScaledJacobian")]
    rows = [[block.name] + [column[n] for column in columns] for n, block in enumerate(volume.blocks)]
    return sorted(rows, key=lambda row: (-row[2] - row[3], row[4]))


def write(path, mesh, body, volume, properties):
    """Writes the report of a volume that convert() made of the files `mesh` and `body` (or None) with `properties`.

    Returns why pictures are missing, or "".
    """
    quality = volume.quality()
    good = quality["invalid"] == 0 and quality["undecided"] == 0
    parts = ["<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><title>%s</title><style>%s</style></head><body>"
             % (html.escape(os.path.basename(mesh)), STYLE),
             "<h1>%s</h1>" % html.escape(os.path.basename(mesh)),
             "<p class='verdict %s'>%s</p>" % ("good" if good else "bad", html.escape(quality["report"])),
             "<pre>%s</pre>" % html.escape(volume.report)]
    if volume.warnings:
        parts.append("<h2>Warnings</h2><ul>%s</ul>" % "".join("<li>%s</li>" % html.escape(w) for w in volume.warnings))
    with tempfile.TemporaryDirectory() as folder:
        missing = _pictures(folder, mesh, body, volume, properties)
        for caption, name in PICTURES:
            picture = os.path.join(folder, name)
            if os.path.exists(picture):
                with open(picture, "rb") as file:
                    data = base64.b64encode(file.read()).decode()
                parts.append("<h2>%s</h2><img alt='%s' src='data:image/png;base64,%s'>"
                             % (html.escape(caption), html.escape(caption), data))
    if missing:
        parts.append("<p>No pictures: %s.</p>" % html.escape(missing))
    names, rows, count = _joins(volume)
    parts.append("<h2>Joins, the worst first (%d of %d)</h2>" % (len(rows), count) + _table(names, rows))
    blocks = _blocks(volume)
    parts.append("<h2>Blocks, the worst first (%d of %d)</h2>" % (min(len(blocks), BLOCKS_SHOWN), len(blocks)) + _table(
        ["block", "valid spans", "invalid", "undecided", "smallest scaled Jacobian"], blocks[:BLOCKS_SHOWN]))
    settings = [["mesh", os.path.abspath(mesh)], ["body", os.path.abspath(body) if body else "none"]]
    settings += [[name, value] for name, value in properties.items()]
    settings += [["version", bsv.__version__], ["Python", sys.version.split()[0]]]
    parts.append("<h2>Settings</h2><p>All other properties have their defaults.</p>" + _table(["property", "value"], settings))
    parts.append("</body></html>")
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(parts))
    return missing
