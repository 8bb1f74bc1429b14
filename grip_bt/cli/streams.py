"""stdin, stdout and stderr as a command finds them: closed, full, cut off, or of another character set than UTF-8."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import TextIO


def ready() -> None:
    r"""Make the three streams ones that every text can be written to.

    A stream that the caller has closed becomes the null device, so that no file of ours gets its number. A character
    that a stream's character set doesn't have, or a byte of a file name that is no text, is written as `\u2192`.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))
        elif mode == "w" and hasattr(stream, "reconfigure") and (stream.errors == "strict" or not _has_all(stream)):
            stream.reconfigure(errors="backslashreplace")


def put(document: str) -> None:
    """Write a document to stdout: in UTF-8, as its files are, whatever the terminal's character set is."""
    if _has_all(sys.stdout) or not hasattr(sys.stdout, "buffer"):
        sys.stdout.write(document)
        return
    sys.stdout.flush()
    sys.stdout.buffer.write(document.encode())


def give_up() -> None:
    """Let nothing be written to stdout any more, also not what is still to be, which can't be."""
    with suppress(OSError, ValueError):  # a stand-in of a test has no number
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, sys.stdout.fileno())
        os.close(null)


def _has_all(stream: TextIO) -> bool:
    """Return whether a stream's character set has every character."""
    return (stream.encoding or "").lower().replace("-", "").replace("_", "").startswith("utf")


def progress(part: str, detail: str) -> None:
    """Say that a part starts, or came up: it may take a while."""
    print(f"  {part:<11} {detail}", file=sys.stderr, flush=True)
