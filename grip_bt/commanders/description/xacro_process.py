"""Expands one xacro file, in a process of its own: `python -m grip_bt.commanders.description.xacro_process`.

A xacro file computes; one that never ends, or fills the memory, ends this process and nothing else. It reads a JSON
object `{"file", "arguments", "packages"}` from stdin and writes `{"text", "files"}` or `{"error"}` to stdout; `files`
are those that it read. `$(find NAME)`
looks where `package://` does; the xacro package itself would ask ROS. Expressions of the file compute and do nothing
else: `xacro_guard` sees to it.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import sys
from pathlib import Path

MEMORY = 1024**3
SECONDS = 20
DEEPEST = 600
"""Of Python's recursion: beyond it, macros that call one another end in an error instead of a crash."""


def main() -> None:
    """Answer the one request."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    request = json.loads(sys.stdin.read())
    with contextlib.redirect_stdout(sys.stderr):
        reply = _expanded(request["file"], request["arguments"], request["packages"])
    sys.stdout.write(json.dumps(reply))


def _expanded(file: str, arguments: dict[str, str], packages: dict[str, str]) -> dict[str, str | list[str]]:
    import xacro
    from xacro import substitution_args

    from grip_bt.base.errors import GripError

    from .packages import Packages
    from .xacro_guard import UnsafeExpressionError, forbid_acts, guard

    guard(xacro)
    known = Packages({name: Path(folder) for name, folder in packages.items()}, (Path(file),))
    substitution_args._eval_find = lambda name: str(known.find(name))
    sys.setrecursionlimit(DEEPEST)
    sys.dont_write_bytecode = True
    forbid_acts()
    try:
        text = xacro.process_file(file, mappings=arguments).toxml()
        return {"text": text, "files": sorted({file, *map(os.path.abspath, xacro.all_includes)})}
    except (GripError, UnsafeExpressionError) as error:
        return {"error": str(error)}
    except RecursionError:
        return {"error": "macros, properties or includes call themselves without end"}
    except MemoryError:
        return {"error": f"it takes more than {MEMORY // 2**20} MiB to expand"}
    except Exception as error:  # noqa: BLE001 - the file's own expressions raise whatever they like
        return {"error": " ".join(f"{type(error).__name__}: {error}".split())}


if __name__ == "__main__":
    main()
