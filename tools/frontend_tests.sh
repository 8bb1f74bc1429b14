#!/usr/bin/env bash
# Types and unit tests of the page. (That its committed build is fresh is one of the Python tests.)
set -euo pipefail
cd "$(dirname "$0")/.."
if ! reason=$(bash tools/node_packages.sh gui/frontend); then
    echo "NOT RUN: frontend tests ($reason)"
    exit 0
fi
cd gui/frontend
npm run --silent typecheck
npm run --silent test
