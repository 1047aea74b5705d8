# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of ParaView's window, 1600 x 1000, after one Apply of each source and filter with default properties.

    pvpython Testing/GUI/Screenshots.py paraview build/lib/BSplineVolume docs/gui [--data folder] [name ...]
    pvpython Testing/GUI/Screenshots.py paraview build/lib/BSplineVolume docs/gui --panels

The second one makes panels.png, the panels of all sources, readers and filters side by side, 400 pixels wide each, and
fails if one of them has a horizontal scroll bar; and writers.png, the windows in which the writers ask how to write.

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

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "Examples"))

MENU = "pqClientMainWindow/menubar"
APPLY = ("pqClientMainWindow/propertiesDock/propertiesPanel/Accept", "activate", "")
BROWSER = "pqClientMainWindow/pipelineBrowserDock/pipelineBrowser"
# The window in which panels are taken is taller; of it the dock at the left, above the status bar.
PANEL_WINDOW = 1500
PANEL = (405, 900)
STATUS_BAR = 40
# A window that asks something comes in the middle: its rows, the lowest first, and columns.
DIALOG = slice(595, 985), slice(500, 1082)
SETTINGS = """[General]
GeneralSettings.ShowWelcomeDialog=false

[MainWindow]
Size=@Size(1600 %d)
Position=@Point(0 0)
"""


def menu(name, *path):
    """Clicks in a menu of the menu bar. Menus within are named, not clicked: ParaView 5.13 writes "B Spline Volume" on ours."""
    return [(MENU, "activate", name), ("/".join([MENU, name, *path[:-1]]), "activate", path[-1])]


def source(name):
    return menu("menuSources", "BSplineVolume", name) + [APPLY]


def chosen_filter(name):
    return menu("menuFilters", "BSplineVolume", name)


def filtered(name):
    return chosen_filter(name) + [APPLY]


def opened(path, row=None):
    """Opens a file and applies. @param row of our reader among those that ask to be chosen, or None: none asks"""
    events = menu("menu_File", "actionFileOpen") + [("pqClientMainWindow/FileOpenDialog", "filesSelected", path)]
    if row is not None:
        events += [("pqClientMainWindow/pqSelectReaderDialog/listWidget", "setCurrent", "%d.0" % row),
                   ("pqClientMainWindow/pqSelectReaderDialog/okButton", "activate", "")]
    return events + [APPLY]


def selected(place):
    return [(BROWSER, "currentChanged", place)]


def own_menu(name):
    """The menu of the plugin in the menu bar."""
    return [(MENU, "activate", "BSplineVolume"), ("pqClientMainWindow/BSplineVolume", "activate", name)]


def again(place):
    """Converts the mesh at a place of the Pipeline Browser once more, by another rule."""
    twist = ("pqClientMainWindow/propertiesDock/propertiesPanel/scrollArea/qt_scrollarea_viewport/"
             "scrollAreaWidgetContents/PropertiesFrame/ProxyPanel/Twist/ComboBox", "set_string", "Literal")
    return selected(place) + chosen_filter("CatmullClarkToBSplineVolume") + [twist, APPLY]


WING = source("WingFuselageSource")
# The body is that of the source, the only one there is.
CONVERTED = WING + filtered("CatmullClarkToBSplineVolume")
SHOTS = {
    "wing_mesh": WING,
    "wing_volume": CONVERTED,
    "topology": WING + filtered("HexBlockTopology"),
    "wall_spacing": WING + filtered("WallSpacing"),
    "mirror": WING + filtered("MirrorHexBlocks"),
    "quality": CONVERTED + filtered("BSplineVolumeQuality"),
    "smoothness": CONVERTED + filtered("BSplineVolumeSmoothness"),
    "sampler": CONVERTED + filtered("BSplineVolumeSampler"),
    "bezier": CONVERTED + filtered("BSplineVolumeToBezierCells"),
    "deviation": CONVERTED + filtered("BodyDeviation"),
    "before_and_after": CONVERTED + own_menu("bsvBeforeAndAfter"),
    "control_points": CONVERTED + own_menu("bsvControlPoints"),
    "difference": CONVERTED + again("/0/0|0") + own_menu("bsvCompare"),
}


SCROLL_BAR = "pqClientMainWindow/propertiesDock/propertiesPanel/scrollArea/qt_scrollarea_hcontainer"


def panels_of(folder, plugin):
    """Recordings that show the panel of each source, reader and filter, with small files that are made here. An event
    "snap" takes a picture."""
    import make_body_case
    import make_demo_mesh
    sys.path.insert(0, plugin)
    import bsplinevolume
    from vtkmodules.vtkFiltersCore import vtkAppendFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    def file(name):
        return os.path.join(folder, name)
    demo = make_demo_mesh.write_demo(folder, 4)
    make_body_case.write_case(folder, 4)
    volume = bsplinevolume.convert(demo)
    for name in ("volume.qfmb", "volume.mesh"):
        volume.write(file(name))
    body = bsplinevolume.vtkNURBSSurfaceReader()
    body.SetFileName(file("ellipsoid.g2"))
    writer = bsplinevolume.vtkNURBSSurfaceWriter()
    writer.SetInputConnection(body.GetOutputPort())
    writer.SetFileName(file("ellipsoid.igs"))
    writer.Write()
    mesh = bsplinevolume.vtkHexBlockMeshReader()
    mesh.SetFileName(demo)
    mesh.Update()
    hexahedra = vtkAppendFilter()
    hexahedra.MergePointsOn()
    for block in range(mesh.GetOutput().GetNumberOfPartitionedDataSets()):
        hexahedra.AddInputData(mesh.GetOutput().GetPartition(block, 0))
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputConnection(hexahedra.GetOutputPort())
    writer.SetFileName(file("hexahedra.vtu"))
    writer.Write()

    converted = own_menu("bsvConvertFiles") + [
        ("pqClientMainWindow/bsvMeshDialog", "filesSelected", file("ellipsoid.xyz")),
        ("pqClientMainWindow/bsvBodyDialog", "filesSelected", file("ellipsoid.g2")), APPLY]
    def shown(name):
        # Events "check" fail if the property has another value.
        return [(SCROLL_BAR, "check visible", "false"), (name, "snap", "")]

    def saved(place, writer, extension):
        """The window in which File > Save Data asks how to write."""
        dialog = "pqClientMainWindow/WriterSettingsDialog/"
        return selected(place) + menu("menu_File", "actionFileSaveData") + [
            ("pqClientMainWindow/FileSaveDialog", "filesSelected", file("saved." + extension)),
            (writer, "snap", ""), (dialog + "widget/OKButton", "activate", "")]

    def filters(place, names):
        return [event for name in names for event in selected(place) + filtered(name) + shown(name)]
    return [
        opened(demo, 0) + shown("HexBlockMeshReader") +
        filters("/0/0|0", ["HexBlockTopology", "WallSpacing", "MirrorHexBlocks"]),
        converted + saved("/0/0|0", "HexBlockMeshWriter", "xyz") + saved("/0/1|0", "NURBSSurfaceWriter", "step") +
        saved("/0/2|0", "BSplineVolumeWriter", "msh") + saved("/0/2|0", "QuadflowWriter", "qfmb") +
        selected("/0/2|0") + shown("CatmullClarkToBSplineVolume") +
        filters("/0/2|0", ["BSplineVolumeQuality", "BSplineVolumeSmoothness", "BodyDeviation", "BSplineVolumeSampler",
                           "BSplineVolumeToBezierCells", "BSplineVolumeIsoparametric"]) +
        again("/0/0|0") + own_menu("bsvCompare") + shown("BSplineVolumeDifference") +
        selected("/0/2|0") + chosen_filter("BSplineVolumeProbe") + shown("BSplineVolumeProbe"),
        source("WingFuselageSource") + shown("WingFuselageSource") +
        opened(file("ellipsoid.igs")) + shown("NURBSSurfaceReader") +
        opened(file("volume.mesh")) + shown("BSplineVolumeReader") +
        opened(file("volume.qfmb")) + shown("QuadflowReader") +
        opened(file("hexahedra.vtu")) + filtered("HexMeshToBlocks") + shown("HexMeshToBlocks"),
    ]


def real_shots(data):
    near_tip = opened(os.path.join(data, "structured/near_tip_vol.xyz"), 0)
    body = opened(os.path.join(data, "surfaces/onera_m6_machaero.igs"))
    return {
        "near_tip": near_tip,
        "near_tip_body": near_tip + body + selected("/0/0|0") + filtered("CatmullClarkToBSplineVolume"),
        "717": opened(os.path.join(data, "structured/717_wl_L2.cgns"), 1),
        "t_joint": opened(os.path.join(data, "structured/t_joint.xyz"), 0),
    }


def saved_state(path):
    return menu("menu_File", "actionFileSaveServerState") + [
        ("pqClientMainWindow/FileSaveServerStateDialog", "filesSelected", path)]


def write_events(path, events, folder):
    """The recording. A saved state tells that it has come to a picture; a second one gives time to take it."""
    with open(path, "w") as file:
        file.write('<?xml version="1.0" ?>\n<pqevents>\n')
        for event in events:
            mark = os.path.join(folder, event[0])
            steps = saved_state(mark + ".pvsm") + saved_state(mark + "_2.pvsm") if event[1] == "snap" else [event]
            for name, command, arguments in steps:
                kind = ("check", "property") if command.startswith("check ") else ("event", "command")
                file.write('  <pq%s object="%s" %s="%s" arguments="%s" />\n' % (
                    kind[0], name, kind[1], command.replace("check ", ""), arguments))
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


def contact_sheet(pictures, columns=6):
    """Pictures of one size side by side, the first at the upper left; rows of pixels are the lowest first."""
    blank = np.full_like(pictures[0], 255)
    pictures = pictures + [blank] * (-len(pictures) % columns)
    rows = [np.hstack(pictures[n:n + columns]) for n in range(0, len(pictures), columns)]
    return np.ascontiguousarray(np.vstack(rows[::-1]))


def shoot(paraview, plugin, name, events, folder, display, framebuffer, height, patience=240):
    """Plays a recording. @return pictures by their names, of as many events "snap" as were reached in time"""
    home = os.path.join(folder, name)
    os.makedirs(os.path.join(home, ".config", "ParaView"))
    manager = servermanager.vtkSMProxyManager
    number = "%d.%d.%d" % (manager.GetVersionMajor(), manager.GetVersionMinor(), manager.GetVersionPatch())
    for file_name in "ParaView%s.ini" % number, "ParaView.ini":  # until ParaView 5, from 6 on
        with open(os.path.join(home, ".config", "ParaView", file_name), "w") as file:
            file.write(SETTINGS % height)
    script = os.path.join(home, "events.xml")
    write_events(script, events, home)
    process = subprocess.Popen(
        [paraview, "--plugin-search-paths=" + plugin, "--plugins=BSplineVolume", "--test-directory=" + home,
         "--test-script=" + script], env=dict(os.environ, HOME=home, XDG_RUNTIME_DIR=home, DISPLAY=display),
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    snaps = [event[0] for event in events if event[1] == "snap"]
    pictures = {}
    for snap in snaps:
        start = time.time()
        mark = os.path.join(home, snap + ".pvsm")
        while not os.path.exists(mark) and process.poll() is None and time.time() - start < patience:
            time.sleep(0.1)
        if not os.path.exists(mark):
            break
        # The window is drawn once more.
        time.sleep(3 if snap == snaps[-1] else 0.2)
        pictures[snap] = screen(framebuffer)
    process.kill()
    process.wait()
    return pictures


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("paraview")
    parser.add_argument("plugin")
    parser.add_argument("output")
    parser.add_argument("--data", help="folder with real meshes")
    parser.add_argument("--panels", action="store_true", help="the panels instead")
    parser.add_argument("names", nargs="*", help="only these pictures")
    arguments = parser.parse_args()
    os.makedirs(arguments.output, exist_ok=True)
    folder = tempfile.mkdtemp()
    if arguments.panels:
        recordings = panels_of(folder, os.path.abspath(arguments.plugin))
    else:
        shots = dict(SHOTS, **(real_shots(arguments.data) if arguments.data else {}))
        recordings = [shots[name] + [(name, "snap", "")] for name in arguments.names or shots]
    height = PANEL_WINDOW if arguments.panels else 1000
    display = ":%d" % (200 + os.getpid() % 500)
    server = subprocess.Popen(["Xvfb", display, "-screen", "0", "1600x%dx24" % height, "-noreset", "-fbdir", folder],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    failed = []
    panels, dialogs = [], []
    try:
        time.sleep(2)
        for n, events in enumerate(recordings):
            pictures = shoot(shutil.which(arguments.paraview) or arguments.paraview, os.path.abspath(arguments.plugin),
                             "recording%d" % n, events, folder, display, os.path.join(folder, "Xvfb_screen0"), height)
            failed += [event[0] for event in events if event[1] == "snap" and event[0] not in pictures]
            for name, pixels in pictures.items():
                if arguments.panels and name.endswith("Writer"):
                    dialogs.append(pixels[DIALOG])
                elif arguments.panels:
                    # The lowest rows come first.
                    panels.append(pixels[STATUS_BAR:STATUS_BAR + PANEL[1], :PANEL[0]])
                else:
                    write_png(os.path.join(arguments.output, name + ".png"), pixels)
                print("Picture taken: " + name, flush=True)
    finally:
        server.terminate()
        server.wait()
        shutil.rmtree(folder, ignore_errors=True)
    if panels:
        write_png(os.path.join(arguments.output, "panels.png"), contact_sheet(panels))
        write_png(os.path.join(arguments.output, "writers.png"), contact_sheet(dialogs, 2))
    if failed:
        sys.exit("No picture of " + ", ".join(failed))


if __name__ == "__main__":
    main()
