# SPDX-License-Identifier: BSD-3-Clause
"""Checks that all C++ sources are laid out as .clang-format says.

    python3 Testing/Tools/check_format.py [CLANG_FORMAT]

Names each file that is not and exits with 1; exits with 77 where there is no clang-format of the version in VERSION, since
others lay out differently.
"""
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERSION = "14"
FOLDERS = ("Filters", "Readers", "Writers", "Plugin", "Testing")


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "clang-format"
    if not shutil.which(program):
        print("skipped: there is no clang-format")
        return 77
    version = subprocess.run([program, "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout.strip()
    if not re.search(rf"version {VERSION}\b", version):
        print(f"skipped: the layout is that of clang-format {VERSION}, this is {version}")
        return 77
    files = [str(file) for folder in FOLDERS for file in sorted((ROOT / folder).rglob("*"))
             if file.suffix in (".h", ".cpp", ".cxx")]
    result = subprocess.run([program, "--dry-run", "-Werror", *files], stderr=subprocess.PIPE, text=True)
    bad = sorted({line.split(":")[0] for line in result.stderr.splitlines() if "[-Wclang-format-violations]" in line})
    print(f"{len(files)} files, {len(bad)} not formatted")
    for file in bad:
        print(file)
    return 1 if result.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
