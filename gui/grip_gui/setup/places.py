"""Where something stands in a settings file, as the keys that lead to it: how a fault finds its field of the form."""

from __future__ import annotations

from grip_bt.base.yaml.tree import YamlValue, entries_of


def keys_at(tree: YamlValue, line: int, column: int) -> list[str]:
    """Return the keys on the way to the innermost entry that begins at a place; empty where none does.

    Args:
        tree: the file.
        line: 1-based.
        column: 1-based.
    """
    found: list[str] = []
    todo: list[tuple[YamlValue, list[str]]] = [(tree, [])]
    while todo:
        value, above = todo.pop()
        for number, entry in enumerate(entries_of(value)):
            keys = [*above, entry.key or str(number)]
            if (entry.line, entry.column) == (line, column) and len(keys) > len(found):
                found = keys
            todo.append((entry.value, keys))
    return found
