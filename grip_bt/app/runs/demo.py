"""The packaged demonstrations: tasks of the example project, and their attempts as a referee sees them."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np

import grip_bt
from grip_bt.base.errors import MissingPartError, NotWritableError
from grip_bt.base.values import Failure, Grasp
from grip_bt.nodes.node import Observer
from grip_sim.referee import ObjectTruth

_UNWANTED = frozenset({".grip", "__pycache__"})


@dataclass(frozen=True)
class Demo:
    """A demonstration.

    Attributes:
        task: its file's name without `.yaml`.
        doc: a sentence for people.
        check: path of the leaf that checks whether something is held, below `ATTEMPT`.
    """

    task: str
    doc: str
    check: str


ATTEMPT = "next_object/attempt"
"""Path of the node that is one attempt, in every demonstration."""
DEMOS = {
    "clear_table": Demo(
        "reactive_pick",
        "A Panda arm with an Allegro hand clears a table: look, choose a grasp, take, check by all evidence, place.",
        "check/held",
    ),
    "reactive": Demo(
        "reactive",
        "Placing only after a component's image difference says that the object was taken; else another pose is drawn.",
        "check/grasped",
    ),
}


def demo_task(name: str = "clear_table") -> Path:
    """Return a demonstration's task file.

    Raises:
        MissingPartError: this installation has no examples.
    """
    return examples_folder() / "tasks" / f"{DEMOS[name].task}.yaml"


def examples_folder() -> Path:
    """Return the folder of the example project, writable: the clone's own, or a copy of what is installed.

    Raises:
        MissingPartError: this installation has no examples.
        NotWritableError: there is no room for a copy.
    """
    package = Path(grip_bt.__file__).resolve().parent
    own, installed = package.parent / "examples", package / "_examples"
    if (own / "grip.yaml").is_file() and os.access(own, os.W_OK):
        return own
    for folder in (own, installed):
        if (folder / "grip.yaml").is_file():
            return _copied(folder)
    raise MissingPartError("the example project", "clone the repository, or reinstall the wheel")


def _copied(folder: Path) -> Path:
    """Return a copy in the user's data directory, made once for what is there now: what was changed in it stays."""
    files = [file for file in sorted(folder.rglob("*")) if file.is_file() and _UNWANTED.isdisjoint(file.parts)]
    digest = hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:8]
    base = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "grip"
    copy = base / f"examples-{grip_bt.__version__}-{digest}"
    if copy.is_dir():
        return copy
    try:
        base.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=base) as half:
            shutil.copytree(folder, Path(half) / "examples", ignore=shutil.ignore_patterns(*_UNWANTED))
            (Path(half) / "examples").rename(copy)
    except OSError as error:
        if copy.is_dir():  # another process was quicker
            return copy
        advice = "the example project is copied there; set XDG_DATA_HOME to a folder of yours"
        raise NotWritableError(copy, error, advice) from error
    return copy


_Truth = Callable[[], Mapping[str, ObjectTruth]]
"""Asks the referee."""


@dataclass
class Attempt:
    """One turn of the task's attempt node.

    Attributes:
        number: counted from 1.
        target: the object nearest to the chosen grasp, None while none was chosen.
        steps: leaf -> outcome (and failure code), in order of their ends.
        outcome: how the attempt node ended; None when it was interrupted.
        failure: why.
        where: path of the leaf that failed first.
        held: objects that the referee saw in the hand when the task checked.
        said: how the leaf ended that checks it; empty while it wasn't reached.
        duration: on the run's clock [s].
    """

    number: int
    target: str | None = None
    steps: list[tuple[str, str]] = field(default_factory=list)
    outcome: str | None = None
    failure: Failure | None = None
    where: str = ""
    held: tuple[str, ...] = ()
    said: str = ""
    duration: float = 0.0


class AttemptRecorder(Observer):
    """An observer that gathers attempts.

    Args:
        check: path of the leaf before which the referee is asked what is held.
        on_end: called with each attempt that ended.
    """

    def __init__(
        self,
        attempt: str,
        check: str,
        clock: Callable[[], float],
        truth: _Truth | None = None,
        on_end: Callable[[Attempt], None] = lambda attempt: None,
        meaning: Mapping[str, str] = MappingProxyType({"failure": "failure"}),
    ):
        self._path, self._check, self._clock, self._truth, self._on_end = attempt, check, clock, truth, on_end
        self.attempts: list[Attempt] = []
        self._meaning = meaning
        self._began = 0.0
        self._first: Failure | None = None

    def entered(self, path: str) -> None:
        """Begin an attempt, or ask what is held before the task checks it."""
        if path == self._path:
            self._began, self._first = self._clock(), None
            self.attempts.append(Attempt(len(self.attempts) + 1))
        elif path == self._check and self.attempts:
            truth = {} if self._truth is None else self._truth()
            self.attempts[-1].held = tuple(sorted(name for name, seen in truth.items() if seen.status == "held"))

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        """Take note of which object a chosen grasp is for."""
        if isinstance(value, Grasp) and self._truth is not None and self.attempts:
            truth = self._truth()
            point = value.pose.position + value.pose.rotation()[:, 2] * 0.04
            flat = {n: float(np.linalg.norm(t.pose.position[:2] - point[:2])) for n, t in truth.items()}
            self.attempts[-1].target = min(flat, key=flat.__getitem__, default=None)

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Record a step, or end the attempt."""
        if path == self._path:
            self._end(outcome, failure)
        elif path.startswith(self._path + "/") and self.attempts:
            if path == self._check:
                self.attempts[-1].said = outcome
            attempt, step = self.attempts[-1], path.removeprefix(self._path + "/")
            attempt.steps.append((step, outcome if failure is None else f"{outcome}.{failure.code}"))
            if outcome == "success" and attempt.where.startswith(step + "/"):
                attempt.where, self._first = "", None  # it has been dealt with, as by an `invert`
            if failure is not None and not attempt.where:
                attempt.where, self._first = step, failure

    def interrupted(self, path: str) -> None:
        """End the attempt without an outcome."""
        if path == self._path:
            self._end(None, None)

    def _end(self, outcome: str | None, failure: Failure | None) -> None:
        attempt = self.attempts[-1]
        attempt.outcome = outcome
        # A recovery that succeeded leaves a failed attempt without a reason of its own: what it recovered from is it.
        attempt.failure = failure or (self._first if self._meaning.get(outcome or "") == "failure" else None)
        attempt.duration = self._clock() - self._began
        self._on_end(attempt)


def attempt_line(attempt: Attempt) -> str:
    """Return one attempt in a line."""
    what = attempt.target or ("nothing left" if attempt.outcome == "nothing_left" else "no object")
    if attempt.outcome is None:
        how = "stopped"
    elif attempt.failure is not None:
        how = f"failed at {attempt.where or 'the task'}: {attempt.failure}"
    elif attempt.outcome == "success":
        how = (
            "held, and put into the crate" if attempt.held else "put into the crate, says the task; the hand was empty"
        )
    elif attempt.said:
        how = f"not placed: the check says {attempt.said}, the hand {'held' if attempt.held else 'held nothing'}"
        how += f" {attempt.target}" if attempt.target in attempt.held else ""
    else:
        how = attempt.outcome.replace("_", " ")
    return f"attempt {attempt.number:<2} {attempt.duration:6.1f} s  {what:<12} {how}"


def object_table(truth: Mapping[str, ObjectTruth], attempts: Sequence[Attempt]) -> list[str]:
    """Return a line per object: attempts, why they failed, and what the referee says."""
    rows = [("object", "attempts", "held", "placed", "time [s]", "why attempts failed")]
    for name, state in truth.items():
        mine = [a for a in attempts if a.target == name]
        why = "; ".join(f"{a.where}: {a.failure.code}" for a in mine if a.failure is not None) or "-"
        held = "yes" if any(name in a.held for a in mine) else "no"
        placed = "yes" if state.status == "placed" else f"no ({state.status})"
        rows.append((name, str(len(mine)), held, placed, f"{sum(a.duration for a in mine):.1f}", why))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]
    return ["  ".join([*(c.ljust(w) for c, w in zip(row[:-1], widths, strict=True)), row[-1]]) for row in rows]
