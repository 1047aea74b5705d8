#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Installs those packages of a list in this folder, debian-packages.txt unless an argument names another, that are missing;
# does nothing if there are none.
set -eu

# Debian's testing has no number.
release=$(. /etc/os-release && echo "${VERSION_ID:-testing}")
packages=$(sed 's/#.*//' "$(dirname "$0")/${1:-debian-packages.txt}" | awk -F: -v release="$release" '
  NF == 1 { print }
  NF == 2 && index(" " $1 " ", " " release " ") { print $2 }')
missing=
for package in $packages; do
  case $(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true) in
    installed) ;;
    *) missing="$missing $package" ;;
  esac
done
if [ -z "$missing" ]; then
  exit 0
fi

echo "Installing Debian packages:$missing"
sudo=
if [ "$(id -u)" -ne 0 ]; then
  sudo=sudo
fi
$sudo apt-get -q update
# shellcheck disable=SC2086 # one word per package
$sudo env DEBIAN_FRONTEND=noninteractive apt-get -q -y install --no-install-recommends $missing
