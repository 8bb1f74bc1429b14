"""Which parts of a run a project's own nodes ask for, read in their source: parts are started before nodes are made."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

ROBOT = frozenset({"arm", "hand", "camera", "scene"})
_ASKED = re.compile(r"\.(arm|hand|camera|scene|messages)\(")


def parts_asked_for(implementations: Iterable[str]) -> frozenset[str]:
    """Return which parts the files of nodes ask their context for, such as `self.context.arm("")`.

    What a file does by way of another one isn't seen: a task that uses it needs a node that asks for the part itself.

    Args:
        implementations: `FILE.py:NAME`, as manifests have them; those in modules are left out.
    """
    files = {Path(where) for where, _, _ in (i.rpartition(":") for i in implementations) if where.endswith(".py")}
    found: set[str] = set()
    for file in files:
        if file.is_file():
            found.update(_ASKED.findall(file.read_text(encoding="utf-8", errors="replace")))
    return frozenset(found)
