# SPDX-License-Identifier: BSD-3-Clause
"""Checks the rooms of Filters/Core (docs/architecture.md): every file lies in one, an include names its room, and goes
to a room on a lower floor or to the same room.

    python3 Testing/Tools/check_rooms.py [--picture docs/rooms.svg]

Prints the number of rooms, of arrows between rooms, the largest files, and what is not allowed; exits with 1 if there is any.
With --picture it draws the rooms on their floors, and the includes between them.
"""
import pathlib
import re
import sys

FLOORS = [
    ["Base"],
    ["Ranks"],
    ["Mesh", "IO"],
    ["Complex", "Volume"],
    ["Body", "Quality", "Quadflow"],
    ["Conversion"],
    ["Wall"],
    ["WingFuselage"],
]
CORE = pathlib.Path(__file__).resolve().parents[2] / "Filters" / "Core"


def picture(arrows):
    """The rooms on their floors, floor 1 at the bottom; an arrow goes from a room to one that it includes."""
    width, height, gap = 150, 44, 40
    wide = max(len(rooms) for rooms in FLOORS) * (width + gap) + gap
    tall = len(FLOORS) * (height + gap) + gap
    place = {}
    for number, rooms in enumerate(FLOORS):
        left = (wide - len(rooms) * width - (len(rooms) - 1) * gap) / 2
        for n, room in enumerate(rooms):
            place[room] = (left + n * (width + gap), tall - (number + 1) * (height + gap))
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{tall}" font-family="sans-serif" '
             'font-size="14">', f'<rect width="{wide}" height="{tall}" fill="white"/>']
    for source, target in sorted(arrows):
        (x, y), (u, v) = place[source], place[target]
        lines.append(f'<line x1="{x + width / 2:g}" y1="{y + height:g}" x2="{u + width / 2:g}" y2="{v:g}" '
                     'stroke="#9ab" stroke-width="1"/>')
    for room, (x, y) in sorted(place.items()):
        lines.append(f'<rect x="{x:g}" y="{y:g}" width="{width}" height="{height}" rx="4" fill="#eef3f8" stroke="#357"/>')
        lines.append(f'<text x="{x + width / 2:g}" y="{y + height / 2 + 5:g}" text-anchor="middle">{room}</text>')
    return "\n".join(lines + ["</svg>", ""])


def main():
    floor = {room: number for number, rooms in enumerate(FLOORS, 1) for room in rooms}
    errors = []
    arrows = set()
    for file in sorted(CORE.rglob("*")):
        if file.suffix not in (".h", ".cpp"):
            continue
        name = file.relative_to(CORE)
        if len(name.parts) != 2 or name.parts[0] not in floor:
            errors.append(f"{name} lies in no room")
            continue
        room = name.parts[0]
        if not (CORE / room / "README.md").is_file():
            errors.append(f"{room} has no README.md")
        for included in re.findall(r'^#include "([^"]+)"', file.read_text(encoding="utf-8"), re.MULTILINE):
            target = included.split("/")[0]
            if "/" not in included or target not in floor:
                errors.append(f'{name} includes "{included}", which names no room')
            elif not (CORE / included).is_file():
                errors.append(f'{name} includes "{included}", which does not exist')
            elif target != room:
                arrows.add((room, target))
                if floor[target] >= floor[room]:
                    errors.append(f'{name} on floor {floor[room]} includes "{included}" on floor {floor[target]}')
    upwards = sum(floor[target] >= floor[room] for room, target in arrows)
    print(f"{len(floor)} rooms on {len(FLOORS)} floors, {len(arrows)} arrows between rooms, {upwards} not downwards")
    sizes = sorted(((len(file.read_text(encoding="utf-8").splitlines()), file) for file in CORE.rglob("*")
                    if file.suffix in (".h", ".cpp")), reverse=True)
    print(f"{len(sizes)} files, {sum(size for size, _ in sizes)} lines, the largest "
          + ", ".join(f"{file.relative_to(CORE)} {size}" for size, file in sizes[:3]))
    for error in errors:
        print(error)
    if "--picture" in sys.argv:
        pathlib.Path(sys.argv[sys.argv.index("--picture") + 1]).write_text(picture(arrows), encoding="utf-8")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
