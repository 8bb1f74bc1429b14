"""The terminal as a command finds it: its streams, whatever state they are in, and what is written there."""

from __future__ import annotations

import json
import os
import sys
import threading
from collections.abc import Iterable
from contextlib import suppress
from typing import Any, Self, TextIO

from . import INVALID


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


def tell(as_json: bool, data: object, lines: Iterable[str] | None = None) -> None:
    """Print data as JSON, or else what people are told of them, line by line: without `lines` the data, in YAML."""
    for line in [json.dumps(data)] if as_json else [_yaml_of(data)] if lines is None else lines:
        print(line)


def _yaml_of(data: object) -> str:
    """Return data in YAML, for people: numbers of six digits, and nothing of what is empty."""
    import yaml  # the list of verbs does without

    plain = json.loads(json.dumps(data), parse_float=lambda word: float(f"{float(word):.6g}"))
    text = yaml.safe_dump(_filled(plain), default_flow_style=None, sort_keys=False, width=120, allow_unicode=True)
    return str(text).rstrip()


def _filled(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _filled(value) for key, value in data.items() if value not in (None, "", [], {})}
    return [_filled(value) for value in data] if isinstance(data, list) else data


def give_up() -> None:
    """Let nothing be written to stdout any more, also not what is still to be, which can't be."""
    with suppress(OSError, ValueError):  # a stand-in of a test has no number
        to_nowhere(sys.stdout)


def to_nowhere(stream: TextIO) -> None:
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, stream.fileno())
    os.close(null)


def _has_all(stream: TextIO) -> bool:
    return (stream.encoding or "").lower().replace("-", "").replace("_", "").startswith("utf")


def complain(words: str, status: int = INVALID) -> int:
    """Say what is wrong, and return the exit status."""
    print(f"grip: {words}", file=sys.stderr, flush=True)
    return status


def counted(errors: int, warnings: int) -> str:
    """Return how many errors and warnings there are, in words; `ok` for none."""
    counts = [f"{n} {word}{'s' * (n > 1)}" for n, word in ((errors, "error"), (warnings, "warning")) if n]
    return ", ".join(counts) or "ok"


quiet = verbose = False
"""Whether nothing is said of what is under way; whether it is said where an error was raised."""


def progress(part: str, detail: str) -> None:
    """Say that a part starts, or came up: it may take a while."""
    if not quiet:
        print(f"  {part:<11} {detail}", file=sys.stderr, flush=True)


SOON = 2.0
"""After how long a bar comes up [s]."""


class Bar:
    """A line at the foot of a terminal that says how far something is, once it takes a while.

    Nothing is written where stderr isn't a terminal, or with `-q`. Use it as a context: the line goes with it.
    """

    def __init__(self, what: str):
        self._what = what

    def __enter__(self) -> Self:
        from rich.console import Console  # the list of verbs does without
        from rich.progress import MofNCompleteColumn, Progress, TextColumn

        columns = (*Progress.get_default_columns(), MofNCompleteColumn(), TextColumn("{task.fields[name]}"))
        console, off = Console(stderr=True), quiet or not sys.stderr.isatty()
        shared = sys.stdout.isatty()  # what is printed meanwhile comes above the bar
        self._bar = Progress(*columns, console=console, transient=True, redirect_stdout=shared, disable=off)
        self._part = self._bar.add_task(self._what, total=None, name="")
        self._soon = threading.Timer(SOON, self._bar.start)
        self._soon.daemon = True
        self._soon.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._soon.cancel()
        self._soon.join()
        self._bar.stop()

    def __call__(self, done: int, every: int, name: str = "") -> None:
        """Say how many of all are done, and what is under way."""
        self._bar.update(self._part, completed=done, total=every, name=name)
