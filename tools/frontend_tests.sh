#!/usr/bin/env bash
# Types, unit tests and a reproducible build of the page. Without Node these are NOT RUN, and it says so.
set -euo pipefail
cd "$(dirname "$0")/../gui/frontend"
if ! command -v npm >/dev/null || ! node -e 'process.exit(+process.versions.node.split(".")[0] < 20)'; then
    echo "NOT RUN: frontend tests (Node 20 or newer and npm are not installed)"
    exit 0
fi
if [ ! -e node_modules/.installed ] || [ package-lock.json -nt node_modules/.installed ]; then
    if ! npm ci --no-audit --no-fund --loglevel=error; then
        echo "NOT RUN: frontend tests (npm ci failed: is there a network?)"
        exit 0
    fi
    touch node_modules/.installed
fi
npm run --silent typecheck
npm run --silent test
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
npm run --silent build -- --outDir "$scratch" --emptyOutDir >/dev/null
diff -r "$scratch" ../grip_gui/static >/dev/null || { echo "gui/grip_gui/static is stale: run 'make gui'"; exit 1; }
echo "frontend: types, unit tests and reproducible build ok"
