"""Names from elsewhere as names of a task, a file or Python: fewer characters are allowed, each once; and literals."""

from __future__ import annotations

import builtins
import keyword
import math
import re
from collections.abc import Collection, Iterable

_WRONG = re.compile(r"[^A-Za-z0-9_ -]+")


def node_name(text: str) -> str:
    """Return the name itself where a task may have it, else the nearest one."""
    name = _WRONG.sub("_", text)
    name = name if name == text else name.strip("_")
    return name if re.match(r"[A-Za-z_]", name) else f"n_{name}".rstrip("_")


def free(name: str, taken: Collection[str]) -> str:
    """Return the name, or the first of `name_2`, `name_3` ... that isn't taken."""
    unique, number = name, 2
    while unique in taken:
        unique, number = f"{name}_{number}", number + 1
    return unique


def distinct(names: Iterable[str]) -> list[str]:
    """Return names of siblings, in order; a repeated one gets a number, and a name that a task may have is kept."""
    given = list(names)
    kept: dict[str, int] = {}
    for index, name in enumerate(given):
        if node_name(name) == name:
            kept.setdefault(name, index)
    taken, result = set(kept), []
    for index, name in enumerate(given):
        unique = name if kept.get(name) == index else free(node_name(name), taken)
        taken.add(unique)
        result.append(unique)
    return result


def key_of(label: str) -> str:
    """Return a name of a group, sensor or component as a key: lower case, words joined by `_`."""
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", label)
    key = re.sub(r"[^A-Za-z0-9]+", "_", words).strip("_").lower()
    return key if key[:1].isalpha() else f"the_{key}".rstrip("_")


def is_literal(value: object) -> bool:
    """Tell whether a document can hold a value: what JSON holds, of no classes of their own, in bounds."""
    if type(value) is list:
        return all(map(is_literal, value))
    if type(value) is dict:
        return all(type(key) is str and is_literal(item) for key, item in value.items())
    if type(value) is int:
        return abs(value) < 2**63
    return value is None or type(value) in (bool, str) or (type(value) is float and math.isfinite(value))


class Identifiers:
    """Hands out names for Python code, each once; none of those that are taken."""

    def __init__(self, taken: Iterable[str] = ()):
        self._taken = {*taken, *keyword.kwlist, *keyword.softkwlist, *dir(builtins)}

    def take(self, *candidates: str) -> str:
        """Return the first candidate that is free, else the last one with a number; no two calls return the same."""
        words = [_word(candidate) for candidate in candidates]
        word = next((word for word in words if word not in self._taken), "") or free(words[-1], self._taken)
        self._taken.add(word)
        return word


def _word(text: str) -> str:
    word = re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_")
    word = word if text[:1].isupper() and "/" not in text and " " not in text else word.lower()
    return word if word and not word[0].isdigit() else f"node_{word}".rstrip("_")
