"""Names of behaviours as names of nodes: a task allows fewer characters, and each name once among siblings."""

from __future__ import annotations

import re
from collections.abc import Iterable

_WRONG = re.compile(r"[^A-Za-z0-9_ -]+")


def node_name(text: str) -> str:
    """Return the name itself where a task may have it, else the nearest one."""
    name = _WRONG.sub("_", text)
    name = name if name == text else name.strip("_")
    return name if re.match(r"[A-Za-z_]", name) else f"n_{name}".rstrip("_")


def distinct(names: Iterable[str]) -> list[str]:
    """Return names of siblings, in order; a repeated one gets a number, and a name that a task may have is kept."""
    given = list(names)
    kept: dict[str, int] = {}
    for index, name in enumerate(given):
        if node_name(name) == name:
            kept.setdefault(name, index)
    taken, result = set(kept), []
    for index, name in enumerate(given):
        unique = base = node_name(name)
        number = 2
        while unique in taken and kept.get(name) != index:
            unique, number = f"{base}_{number}", number + 1
        taken.add(unique)
        result.append(unique)
    return result
