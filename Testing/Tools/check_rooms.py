# SPDX-License-Identifier: BSD-3-Clause
"""Checks the rooms of Filters/Core (docs/architecture.md): every file lies in one, an include names its room, and goes
to a room on a lower floor or to the same room.

    python3 Testing/Tools/check_rooms.py

Prints the number of rooms, of includes between rooms, and those that are not allowed; exits with 1 if there are any.
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
    for error in errors:
        print(error)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
