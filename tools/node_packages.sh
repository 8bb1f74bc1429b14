#!/usr/bin/env bash
# node_packages.sh FOLDER: installs a folder's locked npm packages when they aren't there or the lock has changed.
# Status 1, with the reason, where that can't be done.
set -uo pipefail
cd "$1"
if ! command -v npm >/dev/null || ! node -e 'process.exit(Number(process.versions.node.split(".")[0] < 20))'; then
    echo "Node 20 or newer and npm are not installed"
    exit 1
fi
if [ ! -e node_modules/.installed ] || [ package-lock.json -nt node_modules/.installed ]; then
    if ! npm ci --no-audit --no-fund --loglevel=error >/dev/null; then
        echo "npm ci failed in $1: is there a network?"
        exit 1
    fi
    touch node_modules/.installed
fi
