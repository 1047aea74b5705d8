#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Runs all tests; installs and builds what is missing before. Arguments go to ctest, e.g. ./test.sh -R Python
set -eu

root=$(cd "$(dirname "$0")" && pwd)
"$root/CMake/install-packages.sh"
cmake -S "$root" -B "$root/build" -G Ninja -DBUILD_TESTING=ON -DBSPLINEVOLUME_BUILD_BENCHMARKS=ON
cmake --build "$root/build"
exec ctest --test-dir "$root/build" --output-on-failure --parallel "$(nproc)" "$@"
