# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of ParaView's window, 1600 x 1000, after one Apply of each source and filter with default properties.

    pvpython Testing/GUI/Screenshots.py paraview build/lib/BSplineVolume docs/gui [--data folder] [name ...]
    pvpython Testing/GUI/Screenshots.py paraview build/lib/BSplineVolume docs/gui --panels

The second one makes panels.png, the panels of all sources, readers and filters side by side, 400 pixels wide each, and
fails if one of them has a horizontal scroll bar.

Needs Xvfb, whose picture of the screen it reads. Pictures of real meshes are made only with --data, the folder that has
them. Look at every picture: the question is what one sees in three seconds.
"""
import argparse
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib

from paraview import servermanager
import numpy as np

MENU = "pqClientMainWindow/menubar"
APPLY = ("pqClientMainWindow/propertiesDock/propertiesPanel/Accept", "activate", "")
BROWSER = "pqClientMainWindow/pipelineBrowserDock/pipelineBrowser"
SETTINGS = """[General]
GeneralSettings.ShowWelcomeDialog=false

[MainWindow]
Size=@Size(1600 1000)
Position=@Point(0 0)
"""


def menu(name, *path):
    """Clicks in a menu of the menu bar."""
    events = [(MENU, "activate", name)]
    place = MENU + "/" + name
    for entry in path:
        events.append((place, "activate", entry))
        place += "/" + entry
    return events


def source(name):
    return menu("menuSources", "BSplineVolume", name) + [APPLY]


def chosen_filter(name):
    return menu("menuFilters", "BSplineVolume", name)


def filtered(name):
    return chosen_filter(name) + [APPLY]


def opened(path, readers=1):
    """Opens a file and applies. @param readers how many readers ask to be chosen; ours comes first"""
    events = menu("menu_File", "actionFileOpen") + [("pqClientMainWindow/FileOpenDialog", "filesSelected", path)]
    if readers > 1:
        events += [("pqClientMainWindow/pqSelectReaderDialog/listWidget", "setCurrent", "0.0"),
                   ("pqClientMainWindow/pqSelectReaderDialog/okButton", "activate", "")]
    return events + [APPLY]


def selected(place):
    return [(BROWSER, "currentChanged", place)]


def own_menu(name):
    """The menu of the plugin in the menu bar."""
    return [(MENU, "activate", "BSplineVolume"), ("pqClientMainWindow/BSplineVolume", "activate", name)]


WING = source("WingFuselageSource")
# The body is that of the source, the only one there is.
CONVERTED = WING + filtered("CatmullClarkToBSplineVolume")
TWO = CONVERTED + selected("/0/0|0") + chosen_filter("CatmullClarkToBSplineVolume") + [
    ("pqClientMainWindow/propertiesDock/propertiesPanel/scrollArea/qt_scrollarea_viewport/scrollAreaWidgetContents/"
     "PropertiesFrame/ProxyPanel/Twist/ComboBox", "set_string", "Literal"), APPLY]
SHOTS = {
    "wing_mesh": WING,
    "wing_volume": CONVERTED,
    "topology": WING + filtered("HexBlockTopology"),
    "wall_spacing": WING + filtered("WallSpacing"),
    "mirror": WING + filtered("MirrorHexBlocks"),
    "hex_mesh": WING + menu("menuFilters", "Alphabetical", "MergeBlocks") + [APPLY] + filtered("HexMeshToBlocks"),
    "quality": CONVERTED + filtered("BSplineVolumeQuality"),
    "smoothness": CONVERTED + filtered("BSplineVolumeSmoothness"),
    "sampler": CONVERTED + filtered("BSplineVolumeSampler"),
    "bezier": CONVERTED + filtered("BSplineVolumeToBezierCells"),
    "deviation": CONVERTED + filtered("BodyDeviation"),
    "before_and_after": CONVERTED + own_menu("bsvBeforeAndAfter"),
    "control_points": CONVERTED + own_menu("bsvControlPoints"),
    "difference": TWO + own_menu("bsvCompare"),
}


PANELS = {
    "WingFuselageSource": WING,
    "CatmullClarkToBSplineVolume": CONVERTED,
    **{name: WING + filtered(name) for name in ("HexBlockTopology", "WallSpacing", "MirrorHexBlocks")},
    "HexMeshToBlocks": SHOTS["hex_mesh"],
    **{name: CONVERTED + filtered(name) for name in (
        "BSplineVolumeQuality", "BSplineVolumeSmoothness", "BodyDeviation", "BSplineVolumeSampler",
        "BSplineVolumeToBezierCells", "BSplineVolumeIsoparametric")},
    "BSplineVolumeDifference": TWO + own_menu("bsvCompare"),
}
SCROLL_BAR = "pqClientMainWindow/propertiesDock/propertiesPanel/scrollArea/qt_scrollarea_hcontainer"


def file_panels(folder):
    """Panels of readers, whose files are made here."""
    import make_body_case
    import make_demo_mesh
    mesh = make_demo_mesh.write_demo(folder, 4)
    make_body_case.write_case(folder, 4)
    import bsplinevolume
    volume = bsplinevolume.convert(mesh)
    for name in ("volume.qfmb", "volume.mesh"):
        volume.write(os.path.join(folder, name))
    return {
        "HexBlockMeshReader": opened(mesh, 2),
        "NURBSSurfaceReader": opened(os.path.join(folder, "ellipsoid.g2"), 2),
        "BSplineVolumeReader": opened(os.path.join(folder, "volume.mesh"), 2),
        "QuadflowReader": opened(os.path.join(folder, "volume.qfmb")),
    }


def real_shots(data):
    near_tip = opened(os.path.join(data, "structured/near_tip_vol.xyz"), 2)
    body = opened(os.path.join(data, "surfaces/onera_m6_machaero.igs"))
    return {
        "near_tip": near_tip,
        "near_tip_body": near_tip + body + selected("/0/0|0") + filtered("CatmullClarkToBSplineVolume"),
        "717": opened(os.path.join(data, "structured/717_wl_L2.cgns"), 2),
        "t_joint": opened(os.path.join(data, "structured/t_joint.xyz"), 2),
    }


def write_events(path, events, mark):
    """The recording; the file `mark`, a saved state, tells that it is over."""
    events = events + menu("menu_File", "actionFileSaveServerState") + [
        ("pqClientMainWindow/FileSaveServerStateDialog", "filesSelected", mark)]
    with open(path, "w") as file:
        file.write('<?xml version="1.0" ?>\n<pqevents>\n')
        for name, command, arguments in events:
            file.write('  <pqevent object="%s" command="%s" arguments="%s" />\n' % (name, command, arguments))
        file.write("</pqevents>\n")


def screen(framebuffer):
    """Rows of the picture that Xvfb keeps as an XWD file, the lowest first, RGB."""
    with open(framebuffer, "rb") as file:
        raw = file.read()
    header = struct.unpack(">25I", raw[:100])
    width, height, line, colors = header[4], header[5], header[12], header[19]
    pixels = np.frombuffer(raw, np.uint8, count=line * height, offset=header[0] + 12 * colors)
    return np.ascontiguousarray(pixels.reshape(height, line // 4, 4)[::-1, :width, 2::-1])


def write_png(path, pixels):
    """With a palette of 256 colours, which makes it small."""
    # Colours are told apart by five bits per channel; the most frequent stand for the others.
    codes = (pixels[::-1].astype(np.int64) >> 3) @ np.array([1024, 32, 1])
    kinds, place, counts = np.unique(codes.ravel(), return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(place, pixels[::-1, :, c].ravel()) / counts for c in range(3)], axis=1)
    colors = means[np.argsort(-counts)[:256]]
    nearest = ((means[:, None, :] - colors[None]) ** 2).sum(axis=2).argmin(axis=1)
    rows = nearest[place].reshape(codes.shape)
    # Every row begins with the number of its filter: none.
    lines = np.hstack([np.zeros((rows.shape[0], 1), np.uint8), rows.astype(np.uint8)])

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    table = np.zeros((256, 3), np.uint8)
    table[:len(colors)] = colors.round()
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        file.write(chunk(b"IHDR", struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 8, 3, 0, 0, 0)))
        file.write(chunk(b"PLTE", table.tobytes()))
        file.write(chunk(b"IDAT", zlib.compress(lines.tobytes(), 9)))
        file.write(chunk(b"IEND", b""))


def shoot(paraview, plugin, name, events, folder, display, framebuffer, patience=240):
    home = os.path.join(folder, name)
    os.makedirs(os.path.join(home, ".config", "ParaView"))
    manager = servermanager.vtkSMProxyManager
    number = "%d.%d.%d" % (manager.GetVersionMajor(), manager.GetVersionMinor(), manager.GetVersionPatch())
    with open(os.path.join(home, ".config", "ParaView", "ParaView%s.ini" % number), "w") as file:
        file.write(SETTINGS)
    mark = os.path.join(home, "done.pvsm")
    script = os.path.join(home, "events.xml")
    write_events(script, events, mark)
    process = subprocess.Popen(
        [paraview, "--plugin-search-paths=" + plugin, "--plugins=BSplineVolume", "--test-directory=" + home,
         "--test-script=" + script], env=dict(os.environ, HOME=home, XDG_RUNTIME_DIR=home, DISPLAY=display),
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    start = time.time()
    while not os.path.exists(mark) and process.poll() is None and time.time() - start < patience:
        time.sleep(0.5)
    time.sleep(3)  # the window is drawn once more
    pixels = screen(framebuffer)
    process.kill()
    process.wait()
    return pixels if os.path.exists(mark) else None


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("paraview")
    parser.add_argument("plugin")
    parser.add_argument("output")
    parser.add_argument("--data", help="folder with real meshes")
    parser.add_argument("names", nargs="*", help="only these pictures")
    arguments = parser.parse_args()
    shots = dict(SHOTS, **(real_shots(arguments.data) if arguments.data else {}))
    os.makedirs(arguments.output, exist_ok=True)
    folder = tempfile.mkdtemp()
    display = ":%d" % (200 + os.getpid() % 500)
    server = subprocess.Popen(["Xvfb", display, "-screen", "0", "1600x1000x24", "-noreset", "-fbdir", folder],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    failed = []
    try:
        time.sleep(2)
        for name in arguments.names or shots:
            pixels = shoot(shutil.which(arguments.paraview) or arguments.paraview, os.path.abspath(arguments.plugin),
                           name, shots[name], folder, display, os.path.join(folder, "Xvfb_screen0"))
            if pixels is None:
                failed.append(name)
                continue
            write_png(os.path.join(arguments.output, name + ".png"), pixels)
            print("Picture written: %s.png" % name, flush=True)
    finally:
        server.terminate()
        server.wait()
        shutil.rmtree(folder, ignore_errors=True)
    if failed:
        sys.exit("No picture of " + ", ".join(failed))


if __name__ == "__main__":
    main()
