"""Python names for the nodes and variables of a task, each once."""

from __future__ import annotations

import builtins
import keyword
import re
from collections.abc import Iterable


class Identifiers:
    """Hands out names that are free.

    Args:
        taken: names that the file uses already.
    """

    def __init__(self, taken: Iterable[str] = ()):
        self._taken = {*taken, *keyword.kwlist, *keyword.softkwlist, *dir(builtins)}

    def take(self, *candidates: str) -> str:
        """Return the first candidate that is free, else the last one with a number; no two calls return the same."""
        words = [_word(candidate) for candidate in candidates]
        number = 2
        for word in words:
            if word not in self._taken:
                break
        else:
            base = words[-1]
            while (word := f"{base}_{number}") in self._taken:
                number += 1
        self._taken.add(word)
        return word


def _word(text: str) -> str:
    word = re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_")
    word = word if text[:1].isupper() and "/" not in text and " " not in text else word.lower()
    return word if word and not word[0].isdigit() else f"node_{word}".rstrip("_")
