# SPDX-License-Identifier: BSD-3-Clause
"""Checks sources with clang-tidy and the checks of .clang-tidy.

    python3 Testing/Tools/check_tidy.py CLANG_TIDY BUILD_FOLDER           a part of the sources, another one for each commit
    python3 Testing/Tools/check_tidy.py CLANG_TIDY BUILD_FOLDER --all     all of them, which takes 45 minutes of processor time

Prints the findings and exits with 1; exits with 77 where there is no clang-tidy of the version in VERSION, since others find
other things.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERSION = "14"
# So many commits until each file has been checked.
PARTS = 50


def number_of_commits():
    result = subprocess.run(["git", "-C", str(ROOT), "rev-list", "--count", "HEAD"], stdout=subprocess.PIPE,
                            stderr=subprocess.DEVNULL, text=True)
    return int(result.stdout or 0)


def main():
    program, build = sys.argv[1:3]
    if not shutil.which(program):
        print("skipped: there is no clang-tidy")
        return 77
    version = subprocess.run([program, "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout
    if not re.search(rf"version {VERSION}\b", version):
        print(f"skipped: the sources are free of findings of clang-tidy {VERSION}, this is {version.split('version ')[1].split()[0]}")
        return 77
    with open(os.path.join(build, "compile_commands.json")) as file:
        compiled = {pathlib.Path(entry["directory"], entry["file"]).resolve() for entry in json.load(file)}
    own = sorted(str(path.relative_to(ROOT)) for path in compiled
                 if ROOT in path.parents and pathlib.Path(build).resolve() not in path.parents)
    part = number_of_commits() % PARTS
    files = own if "--all" in sys.argv else [file for file in own if zlib.crc32(file.encode()) % PARTS == part]
    failed = 0

    def check(file):
        return subprocess.run([program, "--quiet", "-p", build, str(ROOT / file)], stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True)
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        for result in pool.map(check, files):
            failed += result.returncode != 0
            print(result.stdout, end="", flush=True)
    print(f"{len(files)} of {len(own)} files, {failed} with findings")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
