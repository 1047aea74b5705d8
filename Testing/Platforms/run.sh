#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Runs the README's two commands in a bare Debian of another release, and prints what came out: the ends of both, tests,
# skipped ones with their reasons, compiler warnings, the hash of the demonstration case. Needs root and debootstrap.
#
#   Testing/Platforms/run.sh RELEASE [FOLDER [ctest argument]...]
#
#   RELEASE    bookworm, trixie, testing
#   FOLDER     where the release lives (default: build/platforms/RELEASE); made once and used again, its sources are those
#              of the last commit each time
#
# Variables: BSV_CCACHE, a folder for ccache, makes further runs short; CMAKE_BUILD_PARALLEL_LEVEL is the number of compilers.
# All output is in FOLDER/convert.log and FOLDER/test.log.
set -eu

source=$(cd "$(dirname "$0")/../.." && pwd)
release=${1:?"usage: $0 RELEASE [FOLDER [ctest argument]...]"}
shift
folder=${1:-$source/build/platforms/$release}
[ $# -eq 0 ] || shift

. "$source/Testing/Platforms/root.sh"
make_root "$release" "$folder"
rm -rf "$folder/BSplineVolume"
mkdir "$folder/BSplineVolume"
git -C "$source" archive HEAD | tar -x -C "$folder/BSplineVolume"

if [ "${BSV_CCACHE:-}" ] && [ ! -e "$folder/usr/bin/ccache" ]; then
  inside "$folder" / sh -c 'apt-get -q update && apt-get -q -y install --no-install-recommends ccache' >"$folder/ccache.log" 2>&1
fi
status=0
inside "$folder" /BSplineVolume ./convert.sh >"$folder/convert.log" 2>&1 || status=$?
if [ $status -eq 0 ]; then
  inside "$folder" /BSplineVolume ./test.sh "$@" >"$folder/test.log" 2>&1 || status=$?
else
  : >"$folder/test.log"
fi

echo "== $release: end of ./convert.sh"
tail -n 25 "$folder/convert.log"
echo "== $release: end of ./test.sh"
tail -n 25 "$folder/test.log"
echo "== $release: skipped tests"
python3 - "$folder/test.log" "$folder/BSplineVolume/build/Testing/Temporary/LastTest.log" <<'PYTHON'
import os
import re
import sys

log, output = (open(name, errors="replace").read() if os.path.exists(name) else "" for name in sys.argv[1:])
sections = {}
for section in re.split(r"^\d+/\d+ Testing: ", output, flags=re.M)[1:]:
    text = re.split(r"^-{20,}\n", section, flags=re.M)[1]
    sections[section.split("\n")[0]] = [line.strip() for line in text.split("<end of output>")[0].split("\n") if line.strip()]
for name in re.findall(r"Test +#\d+: (\S+) \.*\**Skipped", log):
    lines = sections.get(name, [])
    # What a test says itself, or the line that GoogleTest prints after the place.
    reasons = [b for a, b in zip(lines, lines[1:]) if a.endswith(": Skipped")] or lines[-1:]
    print(name + ":", " ".join(reasons) or "no reason given")
PYTHON
echo "== $release: summary"
grep -E "tests passed|Total Test time" "$folder/test.log" || true
echo "compiler warnings: $(cat "$folder/convert.log" "$folder/test.log" | grep -c 'warning:' || true)"
echo "CMake warnings: $(cat "$folder/convert.log" "$folder/test.log" | grep -c 'CMake .*Warning' || true)"
echo "demo.qfmb without its comments: $(grep -av '^#' "$folder/BSplineVolume/output/demo.qfmb" | sha256sum)"
exit $status
