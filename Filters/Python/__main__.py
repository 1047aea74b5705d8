# SPDX-License-Identifier: BSD-3-Clause
"""The command bsplinevolume convert|check|report|levels|formats ...; the same as python3 -m bsplinevolume."""
import argparse
import os
import sys

from vtkmodules.vtkCommonCore import vtkSMPTools

import bsplinevolume as bsv
from bsplinevolume import pipeline, report as html_report


def progress_bar(fraction):
    if sys.stderr.isatty():
        sys.stderr.write("\r[" + "#" * int(40 * fraction) + "." * (40 - int(40 * fraction)) + "]")
        sys.stderr.flush()
        if fraction >= 1.0:
            sys.stderr.write("\n")


def conversion_arguments(parser):
    parser.add_argument("mesh", help="PLOT3D, CGNS, VTK or Exodus file: blocks, or unstructured hexahedra")
    parser.add_argument("--body-file", help="IGES, STEP, BREP or .g2 file of the body")
    parser.add_argument("--body", help="names of the boundaries that form the body, with * and ?, separated by commas")
    parser.add_argument("--body-faces", help="block and face numbers of the body, for meshes without names: 0,4,1,4")
    parser.add_argument("--crease-angle", type=float, help="surface edges that turn by more are creases; degrees")
    parser.add_argument("--set", action="append", default=[], metavar="PROPERTY=VALUE",
                        help="any other property of the conversion, as in Continuity=ExactG1 or WallSpacing=0.5; "
                             "may be repeated")


def value_of(text):
    """A number, a truth value, a list of such, or the text itself."""
    if "," in text:
        return [value_of(part) for part in text.split(",")]
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


def properties_of(arguments):
    properties = {"CheckJoins": True}
    if arguments.body:
        properties["BodyBoundaries"] = arguments.body.split(",")
    if arguments.body_faces:
        numbers = [int(n) if n.strip().isdecimal() else None for n in arguments.body_faces.split(",")]
        if len(numbers) % 2 or None in numbers:
            raise bsv.Error(f"--body-faces {arguments.body_faces}: pairs of block and face are wanted, such as 0,4,1,4")
        properties["BodyFaces"] = list(zip(numbers[::2], numbers[1::2]))
    if arguments.crease_angle is not None:
        properties.update(UseCreaseAngle=True, CreaseAngle=arguments.crease_angle)
    for setting in arguments.set:
        name, equals, value = setting.partition("=")
        if not equals:
            raise bsv.Error(f"--set {setting}: PROPERTY=VALUE is wanted")
        properties[name] = value_of(value)
    return properties


def converted(arguments):
    try:
        volume = bsv.convert(
            arguments.mesh, body=arguments.body_file, progress=progress_bar, **properties_of(arguments))
    except TypeError as error:
        raise bsv.Error(str(error)) from None
    for warning in volume.warnings:
        print("warning:", warning, file=sys.stderr)
    return volume


def is_folder(path):
    return path.endswith(os.sep) or os.path.isdir(path)


def require_other_file(path, arguments):
    """An output that replaces an input would be the end of it."""
    inputs = pipeline.files_of_mesh(arguments.mesh) + ([arguments.body_file] if arguments.body_file else [])
    is_mesh = os.path.splitext(path)[1].lower() in pipeline.WRITERS and not pipeline.writer_of(path)[1]
    for file in pipeline.files_of_mesh(path) if is_mesh else [path]:
        for one in inputs:
            if os.path.exists(file) and os.path.exists(one) and os.path.samefile(file, one):
                raise bsv.Error(f"{path}: writing it would replace the input {one}; choose another name")


def convert(arguments):
    for path in arguments.output:  # not to fail after the work
        if is_folder(path):
            os.makedirs(path, exist_ok=True)
        else:
            pipeline.writer_of(path)
            require_other_file(path, arguments)
    volume = converted(arguments)
    print(volume.report)
    for path in arguments.output:
        if is_folder(path):
            write_folder(path, volume, arguments)
        else:
            volume.write(path, level=arguments.level)
            print("written:", path)
    return 0


def write_folder(folder, volume, arguments):
    """What one looks at first: the topology, control nets before and after and samples for ParaView, the report."""
    name = os.path.join(folder, os.path.splitext(os.path.basename(arguments.mesh))[0])
    volume.write(name + ".qfmb")
    print("written:", name + ".qfmb")
    mesh = pipeline.source_of(arguments.mesh, pipeline.MESH_READERS)
    mesh.Update()
    for part, data in (("before", mesh.GetOutputDataObject(0)), ("after", volume.to_vtk()),
                       ("samples", volume.sampled(arguments.level))):
        if data.IsA("vtkPartitionedDataSetCollection"):  # else the mesh is a file of VTK already
            path = f"{name}_{part}.vtpc"
            pipeline.write(path, data, None, {})
            print("written:", path)
    write_report(name + ".html", volume, arguments)


def write_report(path, volume, arguments):
    missing = html_report.write(path, arguments.mesh, arguments.body_file, volume, properties_of(arguments))
    if missing:
        print("warning: no pictures:", missing, file=sys.stderr)
    print("written:", path)


def check(arguments):
    """Exit status 0: all spans proven valid; 1: some are invalid; 2: some are undecided."""
    is_volume = os.path.exists(arguments.mesh) and (pipeline.is_volume_of_vtk(arguments.mesh) or any(
        getattr(bsv, name)().CanReadFile(arguments.mesh) for name in pipeline.VOLUME_READERS))
    volume = bsv.read(arguments.mesh) if is_volume else converted(arguments)
    quality = volume.quality()
    print(quality["report"])
    return 1 if quality["invalid"] else 2 if quality["undecided"] else 0


def report(arguments):
    pipeline.require_folder(arguments.output)
    require_other_file(arguments.output, arguments)
    write_report(arguments.output, converted(arguments), arguments)
    return 0


def levels(arguments):
    if pipeline.writer_of(arguments.output)[1]:
        raise bsv.Error(f"{arguments.output}: the file would be the exact volume, which has no levels")
    name, ending = os.path.splitext(arguments.output)
    paths = [f"{name}_L{level}{ending}" for level in range(arguments.levels + 1)]
    if ending.lower() == ".foam":  # a case is a folder
        paths = [os.path.join(os.path.splitext(path)[0], os.path.basename(path)) for path in paths]
    for path in paths:
        require_other_file(path, arguments)
    volume = converted(arguments)
    for level, path in enumerate(paths):
        cells = sum((s.shape[0] - 1) * (s.shape[1] - 1) * (s.shape[2] - 1) for s in volume.sample(level))
        volume.write(path, level=level)
        print(f"level {level}: {cells} cells, {path}")
    return 0


def formats(_arguments):
    for ending, (writer, exact) in sorted(pipeline.WRITERS.items()):
        print(f"{ending:7s} {'exact volume' if exact else 'sampled mesh'}, {writer[3:]}")
    return 0


def main(words=None):
    parser = argparse.ArgumentParser(prog="bsplinevolume", description=bsv.__doc__)
    parser.add_argument("--version", action="version", version=bsv.__version__)
    commands = parser.add_subparsers(required=True)
    one = commands.add_parser("convert", help="convert a mesh, print the report, write files")
    conversion_arguments(one)
    one.add_argument("--output", action="append", default=[], metavar="FILE",
                     help="file to write, by its ending (see formats), or a folder, FOLDER/, for all that one looks at "
                          "first: .qfmb, .vtpc files for ParaView and a report; may be repeated")
    one.add_argument("--level", type=int, default=1, choices=range(9), metavar="0..8", help="level of sampled meshes (1)")
    one.set_defaults(run=convert)
    one = commands.add_parser("check", help="validity of all spans; status 0 valid, 1 invalid, 2 undecided, 3 error",
                              description=check.__doc__)
    conversion_arguments(one)
    one.set_defaults(run=check)
    one = commands.add_parser("report", help="one HTML file: verdict, pictures, tables, settings")
    conversion_arguments(one)
    one.add_argument("--output", default="report.html", help="the file (report.html)")
    one.set_defaults(run=report)
    one = commands.add_parser("levels", help="a nested family of meshes")
    conversion_arguments(one)
    one.add_argument("output", help="file; its name gets _L0, _L1, ...")
    one.add_argument("--levels", type=int, default=2, choices=range(9), metavar="0..8",
                     help="the finest level (2)")
    one.set_defaults(run=levels)
    one = commands.add_parser("formats", help="the endings of files that can be written")
    one.set_defaults(run=formats)
    arguments = parser.parse_args(words)
    # VTK runs on one core unless it is told otherwise.
    if "VTK_SMP_BACKEND_IN_USE" not in os.environ:
        os.environ["VTK_SMP_BACKEND_IN_USE"] = "STDThread"  # of the program that draws
        vtkSMPTools.SetBackend("STDThread")
    try:
        return arguments.run(arguments)
    except (bsv.Error, OSError) as error:
        print("error:", error, file=sys.stderr)
        return 3


if __name__ == "__main__":
    sys.exit(main())
