#!/bin/sh
# Finds what Python wheels can't bring and installs it where that is allowed: as root, or by sudo without a password.
# Otherwise prints the exact line to run. Prints nothing when all is there.
set -u

python=$(command -v "${PYTHON:-python3}" || true)
missing=""

need() { missing="$missing $1"; }

"$python" -c 'import ensurepip, venv' 2>/dev/null || need python3-venv
"$python" - 2>/dev/null <<'PY' || need python3-dev
import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))
PY
command -v g++ >/dev/null || need g++
# SAPIEN's library is linked against libX11, also when nothing is displayed.
"$python" -c 'import ctypes; ctypes.CDLL("libX11.so.6")' 2>/dev/null || need libx11-6

[ -z "$missing" ] && exit 0

line="apt-get install -y --no-install-recommends$missing"
if ! command -v apt-get >/dev/null; then
    echo "These system packages are missing (Debian's names):$missing" >&2
    exit 1
fi
if [ "$(id -u)" = 0 ]; then
    run=""
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    run="sudo -n"
else
    echo "System packages are missing. Please run:" >&2
    echo "    sudo apt-get update && sudo $line" >&2
    exit 1
fi
echo "Installing system packages:$missing"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { $run apt-get update -qq && $run env DEBIAN_FRONTEND=noninteractive $line -qq; } >"$log" 2>&1; then
    cat "$log" >&2
    exit 1
fi
