#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
#
# Called by the Makefile.   setup.sh packages VENV   system packages, virtual environment, locked wheels
#                           setup.sh install VENV    hullrecon itself, with its native module
#                           setup.sh browser         for tests of the report's page only: a browser, where this system has one
#
# SKIP_SYSTEM_PACKAGES=1 leaves the system as it is: then the compiler and the libraries have to be there.
set -euo pipefail

# libegl1, libgl1 and libusb-1.0-0 are for open3d alone; libopenblas-dev keeps libceres-dev from choosing the slow ATLAS; Pango and
# libharfbuzz-subset0 are for report.pdf.
SYSTEM=(make g++ python3 python3-venv python3-dev libceres-dev libsuitesparse-dev libopenblas-dev doctest-dev
        libegl1 libgl1 libgomp1 libusb-1.0-0 libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0)

die() { echo "setup: $*" >&2; exit 1; }

missing_packages() {
    local name
    for name in "${SYSTEM[@]}"; do
        dpkg-query -W -f='${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed || echo "$name"
    done
}

announce() {
    echo "setup: running in ${SETUP_DELAY_S:-5} s: $1"
    echo "setup: Ctrl-C stops it; SKIP_SYSTEM_PACKAGES=1 goes on without"
    sleep "${SETUP_DELAY_S:-5}"
}

system_packages() {
    [ "${SKIP_SYSTEM_PACKAGES:-}" = 1 ] && return
    command -v dpkg-query >/dev/null || die "this is neither Debian nor Ubuntu: install the equals of: ${SYSTEM[*]}"
    local missing
    mapfile -t missing < <(missing_packages)
    [ ${#missing[@]} -eq 0 ] && return
    local line="apt-get install -y --no-install-recommends ${missing[*]}"
    echo "setup: these system packages are missing: ${missing[*]}"
    if [ "$(id -u)" -eq 0 ]; then
        announce "$line"
        apt-get update -q && DEBIAN_FRONTEND=noninteractive $line
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        announce "sudo $line"
        sudo apt-get update -q && sudo DEBIAN_FRONTEND=noninteractive $line
    else
        die "as root, run: apt-get update && $line (or set SKIP_SYSTEM_PACKAGES=1 if they are there in another way)"
    fi
}

# Nothing but tests needs a browser, so what cannot be had is said and left out: those tests are then skipped.
browser() {
    local name
    for name in chromium google-chrome-stable google-chrome; do
        dpkg-query -W -f='${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed && return
    done
    local line="apt-get install -y --no-install-recommends chromium"
    if [ "${SKIP_SYSTEM_PACKAGES:-}" = 1 ]; then
        echo "setup: no browser: tests of the report's page will be skipped (SKIP_SYSTEM_PACKAGES=1)"
    elif grep -qs '^ID=ubuntu' "${OS_RELEASE:-/etc/os-release}"; then
        echo "setup: no browser: tests of the report's page will be skipped (Ubuntu's chromium is a snap; install Google Chrome)"
    elif [ "$(id -u)" -ne 0 ] || ! command -v apt-get >/dev/null; then
        echo "setup: no browser: tests of the report's page will be skipped (as root: $line)"
    else
        announce "$line"
        apt-get update -q && DEBIAN_FRONTEND=noninteractive $line ||
            echo "setup: no browser could be installed: tests of the report's page will be skipped"
    fi
}

environment() {
    local venv=$1 python=${PYTHON:-python3}
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || die "Python 3.11 or later is needed ($python is older)"
    [ -x "$venv/bin/python" ] || "$python" -m venv "$venv" || { rm -rf "$venv"; die "could not make $venv with $python"; }
    # Wheels are not compiled here: of 136 MB of Python, scipy's tests and all, hullrecon imports a tenth (compile.py).
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-compile --require-hashes -r requirements.lock
}

install() {
    local venv
    venv=$(cd "$1" && pwd)
    PATH="$venv/bin:$PATH" "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps \
        --no-build-isolation --editable . ||
        die "hullrecon could not be built (see above); it needs these system packages: ${SYSTEM[*]}"
    "$venv/bin/python" -c 'import hullrecon._native' || die "the native module does not load"
    "$venv/bin/python" pipelines/compile.py hullrecon cli || die "a module that hullrecon imports does not load"
}

case "${1:-}" in
    packages) system_packages; environment "$2" ;;
    install) install "$2" ;;
    browser) browser ;;
    *) die "usage: setup.sh packages|install VENV, or setup.sh browser" ;;
esac
