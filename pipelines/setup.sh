#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
#
# Called by the Makefile.   setup.sh packages VENV   system packages, virtual environment, locked wheels
#                           setup.sh install VENV    hullrecon itself, with its native module
set -euo pipefail

# libegl1, libgl1 and libusb-1.0-0 are for open3d alone; libopenblas-dev keeps libceres-dev from choosing the slow ATLAS.
SYSTEM=(make g++ python3 python3-venv python3-dev libceres-dev libsuitesparse-dev libopenblas-dev doctest-dev
        libegl1 libgl1 libgomp1 libusb-1.0-0)

die() { echo "setup: $*" >&2; exit 1; }

missing_packages() {
    local name
    for name in "${SYSTEM[@]}"; do
        dpkg-query -W -f='${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed || echo "$name"
    done
}

system_packages() {
    command -v dpkg-query >/dev/null || die "this is neither Debian nor Ubuntu: install the equals of: ${SYSTEM[*]}"
    local missing
    mapfile -t missing < <(missing_packages)
    [ ${#missing[@]} -eq 0 ] && return
    local line="apt-get install -y --no-install-recommends ${missing[*]}"
    if [ "$(id -u)" -eq 0 ]; then
        apt-get update -q && DEBIAN_FRONTEND=noninteractive $line
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        sudo apt-get update -q && sudo DEBIAN_FRONTEND=noninteractive $line
    else
        die "system packages are missing; as root, run: apt-get update && $line"
    fi
}

environment() {
    local venv=$1 python=${PYTHON:-python3}
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || die "Python 3.11 or later is needed ($python is older)"
    [ -x "$venv/bin/python" ] || "$python" -m venv "$venv" || { rm -rf "$venv"; die "could not make $venv with $python"; }
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
}

install() {
    local venv
    venv=$(cd "$1" && pwd)
    PATH="$venv/bin:$PATH" "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps \
        --no-build-isolation --editable .
    "$venv/bin/python" -c 'import hullrecon._native' || die "the native module does not load"
}

case "${1:-}" in
    packages) system_packages; environment "$2" ;;
    install) install "$2" ;;
    *) die "usage: setup.sh packages|install VENV" ;;
esac
