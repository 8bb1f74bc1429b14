#!/usr/bin/env bash
# The page in a real Chromium. Installs Debian's where that is allowed; otherwise the tests are NOT RUN, and it says so.
set -euo pipefail
cd "$(dirname "$0")/.."
if ! reason=$(bash tools/node_packages.sh gui/e2e); then
    echo "NOT RUN: browser tests ($reason)"
    exit 0
fi
chromium=$(command -v "${CHROMIUM:-chromium}" || true)
if [ -z "$chromium" ] && command -v apt-get >/dev/null && [ "$(id -u)" = 0 ]; then
    apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium >/dev/null || true
    chromium=$(command -v chromium || true)
fi
if [ -z "$chromium" ]; then
    echo "NOT RUN: browser tests (no Chromium; sudo apt-get install chromium)"
    exit 0
fi
CHROMIUM="$chromium" bash tools/run_tests.sh "browser tests" -n 3 --dist worksteal -m e2e tests/gui
