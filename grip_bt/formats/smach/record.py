"""What goes between an import and its recording processes."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel, JsonValue

from .facts import StateFacts


class Job(BaseModel):
    """A file to record; `given`: class or function, or empty for all -> parameter -> value."""

    file: str
    root: str | None = None
    given: dict[str, dict[str, JsonValue]] = {}


class Built(BaseModel):
    """An outermost machine as one run has built it.

    Attributes:
        key: where it is made, and the how many-th there: `file:line#0`.
        returned: whether the builder returned it; `variable`: the module's name for it.
    """

    key: str
    number: int
    state: StateFacts
    returned: bool = False
    variable: str = ""


class Told(BaseModel):
    """Something that code goes by; `value` is what it was taken for, where that is known."""

    what: str
    value: str | None = None
    line: int = 0
    file: str = ""


class Run(BaseModel):
    """What one builder did, with one way of answering.

    Attributes:
        builder: `import`, `__main__`, or a name in the module.
        answers: to the questions with two answers, in their order, and `asked` what these were.
        told: what else the code went by.
        missing: parameters of the builder that a stand-in was given for.
        unfinished: whether there are answers that weren't tried.
    """

    builder: str
    machines: list[Built] = []
    answers: list[bool] = []
    asked: list[Told] = []
    told: list[Told] = []
    error: str = ""
    missing: list[str] = []
    caught: bool = False
    unfinished: bool = False
    stopped: bool = False


class Record(BaseModel):
    """What became of a file: all runs, each after an import that was answered in one way."""

    runs: list[Run] = []
    packages: list[str] = []
    read: list[str] = []
    error: str = ""
    compiled: list[Path] = []
