"""Canonical form of a person's text: comments and single blank lines stay."""

from __future__ import annotations

from .canonical import write_canonical
from .comments import attach_comments
from .document import read_text


def fmt(text: str, source: str = "") -> str:
    """Return the canonical form of a task's text, with its comments; of an older format, in the one that is read.

    Formatting twice changes nothing more, and the task stays equal.

    Raises:
        DocumentError: the text isn't a task.
    """
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    document = read_text(text, source)
    header = attach_comments(document.tree, document.text)
    return write_canonical(document.tree, header)
