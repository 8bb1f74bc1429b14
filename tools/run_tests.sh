#!/usr/bin/env bash
# Runs a part of the suite: tools/run_tests.sh NAME PYTEST-ARGUMENTS. Up to three tests that fail are run once more, alone
# on the machine and in new processes: what is wrong fails again, and what only other tests beside it made fail is told
# by name. Nothing that failed is passed over in silence.
set -uo pipefail
cd "$(dirname "$0")/.."
name=$1
shift
cache=$(mktemp -d)
trap 'rm -rf "$cache"' EXIT
# After a worker's death xdist may wait for ever; an interrupt has pytest say what it has seen until then.
timeout --foreground --signal=INT --kill-after=60 50m .venv/bin/pytest -q -o cache_dir="$cache" "$@"
status=$?
failed=$cache/v/cache/lastfailed
[ $status -ne 124 ] || echo "$name: ended after 50 minutes, with tests not run"
if [ $status -ne 1 ] || [ ! -s "$failed" ]; then
    exit $status
fi
if [ "$(grep -c '^  "' "$failed")" -gt 3 ]; then
    echo "$name: more than three tests failed; they aren't run again"
    exit 1
fi
names=$(sed -n 's/^  "\(.*\)": true,\{0,1\}$/  \1/p' "$failed")
echo "$name: what failed is run once more, alone:"
echo "$names"
.venv/bin/pytest -q -o cache_dir="$cache" --lf --lfnf=none -p no:xdist tests || exit $?
echo "$name: PASSED ONLY WHEN RUN ALONE, please report with the failure above:"
echo "$names"
