"""Words that several rules share."""

from __future__ import annotations


def take_hint(hint: str, otherwise: str) -> str:
    """Return a fix: the word that `grip_bt.errors.nearest` has found, or `otherwise` when it found none."""
    return f"write {hint.split(chr(39))[1]!r}" if hint else otherwise
