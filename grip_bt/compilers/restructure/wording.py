"""A restructured task as text: canonical YAML under a comment that says what it was made from and what stayed."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

from grip_bt.base.yaml.writer import WIDTH
from grip_bt.task import dumps

from .result import Restructured


def to_text(result: Restructured, form: str, source: str) -> str:
    """Return the file of a restructured task.

    Args:
        result: the task.
        form: what it was made into, such as `a behaviour tree`.
        source: name of the file that it was made from.
    """
    return "".join(f"{line}\n" for line in _header(result, form, source)) + dumps(result.task)


def _header(result: Restructured, form: str, source: str) -> Iterator[str]:
    if not result.notes:
        yield from _comment(f"{source} as {form}; nothing had to stay as it was.")
        return
    yield from _comment(f"{source} as {form}. What kept its kind, and why:")
    reasons: dict[str, list[str]] = {}
    for note in result.notes:
        reasons.setdefault(note.reason, []).append(f"{result.paths[note.path]} ({note.kind})")
    for reason, places in reasons.items():
        yield from _comment(f"{', '.join(places)}: {reason}.", "- ")


def _comment(text: str, mark: str = "") -> list[str]:
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=f"# {mark}",
        subsequent_indent="# " + " " * len(mark),
        break_long_words=False,
        break_on_hyphens=False,
    )
