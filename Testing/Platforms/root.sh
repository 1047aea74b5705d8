# SPDX-License-Identifier: BSD-3-Clause
# Functions for the scripts beside: a bare Debian of another release in a folder, and commands inside it. Need root.

# make_root RELEASE FOLDER: once, with the mirror that this machine itself uses.
make_root() {
  if [ ! -e "$2/made" ]; then
    mkdir -p "$2"
    debootstrap --variant=minbase "$1" "$2" "$(apt-get indextargets --format '$(REPO_URI)' \
      'Created-By: Packages' 'Origin: Debian' 'Label: Debian' | sort | head -n 1)"
    # A root that can be made again need not survive a power failure.
    echo force-unsafe-io >"$2/etc/dpkg/dpkg.cfg.d/force-unsafe-io"
    # The mirror may be one of a past day.
    echo 'Acquire::Check-Valid-Until "false";' >"$2/etc/apt/apt.conf.d/past-mirror"
    touch "$2/made"
  fi
}

# inside FOLDER WORKING_FOLDER COMMAND...: no display, no variable of this session; its mounts end with it.
inside() {
  bsv_root=$1 bsv_place=$2
  shift 2
  unshare --mount --pid --fork --kill-child sh -eu -c '
    root=$1 place=$2 ccache=$3 jobs=$4
    shift 4
    mount -t proc proc "$root/proc"
    mount -t sysfs -o ro sysfs "$root/sys"
    mkdir -p "$root/dev/shm"
    mount -t tmpfs tmpfs "$root/dev/shm"
    set -- CI=true HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin ${jobs:+CMAKE_BUILD_PARALLEL_LEVEL=$jobs} "$@"
    if [ "$ccache" ] && [ -e "$root/usr/bin/ccache" ]; then
      mkdir -p "$root/ccache"
      mount --bind "$ccache" "$root/ccache"
      set -- CCACHE_DIR=/ccache CCACHE_COMPILERCHECK=content CCACHE_SLOPPINESS=time_macros,include_file_mtime,pch_defines \
        CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache "$@"
    fi
    exec chroot "$root" /usr/bin/env -i -C "$place" "$@" </dev/null' \
    inside "$bsv_root" "$bsv_place" "${BSV_CCACHE:-}" "${CMAKE_BUILD_PARALLEL_LEVEL:-}" "$@"
}
