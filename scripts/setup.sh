#!/bin/sh
# Makes .venv in the checkout ready to use, and nothing else: finds a Python, installs the system libraries that are
# missing, creates the virtual environment, installs this checkout with its pinned dependencies, tries the imports.
# PYTHON=/path/to/python picks the interpreter.
set -eu
cd "$(dirname "$0")/.."

say() { printf '%s\n' "setup: $*"; }
fail() { printf '%s\n' "setup: $*" >&2; exit 1; }
new_enough() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }

# apt-get as root, through sudo, or a line that says what to type.
install_packages() {
    command -v apt-get >/dev/null || fail "these Debian/Ubuntu packages, or their like, are missing: $*"
    if [ "$(id -u)" -eq 0 ]; then
        root=''
    elif command -v sudo >/dev/null && { [ -t 0 ] || sudo -n true 2>/dev/null; }; then
        root='sudo'
    else
        fail "system packages are missing. Run this as root, then make again: apt-get update && apt-get install -y $*"
    fi
    say "installing $*"
    $root apt-get update -qq
    $root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null ||
        fail "apt-get could not install $*"
}

python=''
for candidate in ${PYTHON:-python3 python3.14 python3.13 python3.12 python3.11}; do
    if new_enough "$candidate"; then python=$candidate; break; fi
done
[ -n "$python" ] || fail "no Python 3.11 or newer among ${PYTHON:-python3 python3.14 python3.13 python3.12 python3.11}." \
    "Install one (Debian 12+, Ubuntu 24.04+: apt-get install python3), or name it: make PYTHON=/path/to/python3.12"

missing=$("$python" scripts/missing_system_packages.py)
# shellcheck disable=SC2086  # one package a word
[ -z "$missing" ] || install_packages $missing

here=$(pwd -P)
if ! new_enough .venv/bin/python || ! grep -qsF "$here/.venv" .venv/bin/activate ||
    ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
    say "creating .venv with $("$python" --version)"
    rm -rf .venv
    "$python" -m venv .venv
fi

say 'installing the pinned Python packages into .venv (the first time takes some minutes)'
export PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_ROOT_USER_ACTION=ignore
pip() { .venv/bin/python -m pip "$@" --quiet --constraint constraints.txt; }
rm -rf ./*.egg-info  # of an earlier build: its metadata would hide what is installed now
pip install setuptools                                     # pinned too, so the build needs no environment of its own
pip install --no-build-isolation --editable '.[dev,cluster,link]'
# What drives devices, and what stands in for them in the tests; some have no packages for some Pythons.
for device in omega franka,franka-emulator realsense arm; do
    pip install --no-build-isolation --editable ".[$device]" ||
        say "no packages for $device here: its tests are skipped (mmt-drake doctor says more)"
done

.venv/bin/python -c 'import pydrake.all, open3d, matplotlib.pyplot, numba, mmt_drake.hw, mmt_drake.diagrams' ||
    fail 'the installed packages cannot be imported; the lines above say which library is missing'
printf '%s\n' "$here" >.venv/.installed
say 'done'
