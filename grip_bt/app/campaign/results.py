"""The file of a campaign's results, a head and a line for each trial that is over; and with what trials were made."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib.metadata import PackageNotFoundError, version
from itertools import zip_longest
from pathlib import Path
from typing import Any, TypedDict

from grip_bt.app.campaign.file import Campaign, Plain
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import CampaignError, NotWritableError
from grip_bt.base.files import replace_text
from grip_bt.base.types import JsonObject
from grip_bt.base.value_codec import encode
from grip_bt.base.values import Plan
from grip_bt.runtime import JournalReader

_FORMAT = 1


class TrialRow(TypedDict, total=False):
    """A trial, and what came of it; `_trial` and `judged` say what each is."""

    trial: str
    variant: str
    levels: Mapping[str, str]
    seed: int
    status: str
    outcome: str | None
    code: str | None
    message: str
    duration: float | None
    wall: float
    run: str | None
    truth: Mapping[str, str] | None
    contradicted: bool
    judged: dict[str, bool]
    unconfirmed: str
    counts: dict[str, int]
    measures: dict[str, Plain]
    success: bool
    unclear: dict[str, str]
    repeated: str
    provenance: Mapping[str, str]


def pictures_of(results: Path) -> Path:
    """Return the folder of the pictures that were taken of trials, beside their results."""
    return results.with_suffix(".pictures")


def picture_of(trial: str) -> str:
    """Return the name of a trial's picture."""
    return f"{trial.replace('/', '+')}.jpg"


@dataclass
class Results:
    """A file of results: its head (`name`, `doc`, `variants`: name -> settings), and trials in order of their ends."""

    path: Path
    head: JsonObject
    rows: list[TrialRow] = field(default_factory=list)

    @property
    def done(self) -> set[tuple[str, int]]:
        """The trials that are there."""
        return {(row["variant"], row["seed"]) for row in self.rows}

    def add(self, row: TrialRow) -> None:
        """Write a trial; it is on disk when this returns. Raises NotWritableError where it can't be written."""
        _append(self.path, row)
        self.rows.append(row)


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Keep others from adding to these results meanwhile.

    Raises:
        CampaignError: somebody does it already.
        NotWritableError: it can't be written there.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = path.with_suffix(".lock").open("a")
    except OSError as error:
        raise NotWritableError(path, error, "give another file with -o") from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise CampaignError(str(path), "another `grip bench` is at work on these results") from None
        yield


def begin(path: Path, head: JsonObject, resume: bool) -> Results:
    """Open a file of results, written under this head, for more trials; with `resume`, those that are there stay.

    Raises:
        CampaignError: it is there, and `resume` isn't asked; or it was made with other settings, which are named.
        NotWritableError: it can't be written.
    """
    results = read(path) if path.exists() else Results(path, head)
    if not results.rows:  # it went no further than its head
        path.unlink(missing_ok=True)
        _append(path, {"campaign": _FORMAT, **head})
        return Results(path, head)
    if not resume:
        advice = "continue them with --resume, remove the file, or choose another one with -o"
        raise CampaignError(str(path), f"there are results already: {advice}")
    for variant, now in head["variants"].items():
        before = results.head["variants"].get(variant)
        changed = [] if before in (None, now) else [key for key in now if now[key] != before.get(key)]
        if changed:
            text = f"{variant!r} isn't what it was when these trials ran (changed: {', '.join(changed)})"
            advice = "results of different settings aren't mixed: start a new file with -o FILE"
            raise CampaignError(str(path), f"{text}; {advice}")
    added = {name: one for name, one in head["variants"].items() if name not in results.head["variants"]}
    results.head = {**results.head, "variants": {**results.head["variants"], **added}}
    written = path.read_text()
    _, _, rows = written.partition("\n")
    whole = json.dumps(results.head, default=str) + "\n" + rows[: rows.rfind("\n") + 1]  # a crash cuts off a line
    if whole != written:
        replace_text(path, whole)
    return results


def read(path: Path) -> Results:
    """Read results, without a last line that was cut off. Raises CampaignError where it isn't such a file."""
    try:
        lines = path.read_text().split("\n")
        rows = [json.loads(line) for line in lines[:-1] if line]
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        text = f"can't be read as results of a campaign: {why}; `grip bench CAMPAIGN` writes them"
        raise CampaignError(str(path), text) from error
    if not rows or not isinstance(rows[0], dict) or rows[0].get("campaign") != _FORMAT:
        raise CampaignError(str(path), "these aren't results of a campaign: `grip bench CAMPAIGN` writes them")
    return Results(path, rows[0], rows[1:])


def _append(path: Path, row: Mapping[str, object] | TrialRow) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a") as file:
            file.write(json.dumps(row, default=str) + "\n")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise NotWritableError(path, error, "give another file with -o") from error


PACKAGES = ("grip-bt", "numpy", "sapien", "pin", "coal", "ompl", "toppra", "opencv-python", "py-trees")
"""Packages whose versions are recorded: those that results depend on."""
MEASURED = ("run_started", "state")
"""Events that tell of the process and not of the run."""


def provenance(campaign: Campaign, variant: str) -> Mapping[str, str]:
    """Return what a variant's trials are made with, as name -> words: `python`, packages, `machine`, digests."""
    versions = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    machine = f"{platform.node()}, {platform.platform()}, {os.cpu_count()} x {_processor()}"
    task = campaign.task(variant)
    digests = {"campaign": campaign.path, "task": task, "project": find_project(task).folder}
    return {**versions, "machine": machine, **{f"{name} sha256": digest_of(path) for name, path in digests.items()}}


def digest_of(path: Path) -> str:
    """Return a digest of a file, or of the files of a folder that aren't hidden, with their names."""
    whole = hashlib.sha256()
    for file in files_of(path) if path.is_dir() else [path]:
        whole.update(f"{file.relative_to(path)}\0".encode() + hashlib.sha256(file.read_bytes()).digest())
    return whole.hexdigest()[:16]


def files_of(folder: Path) -> Iterator[Path]:
    """Yield the files of a folder that aren't hidden, in an order that is the same everywhere."""
    for at, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if name[0] != "." and name != "__pycache__")
        yield from (Path(at, name) for name in sorted(names) if name[0] != ".")


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.machine()


def difference(journal: Path, one: str | None, two: str | None) -> str:
    """Return the first thing in which two runs of a journal differ, in words; nothing where they are the same.

    Compared bit by bit are the events in order, their times on the run's clock, and every value and state, without what
    tells of the process and how long planning took.
    """
    if one is None or two is None:
        return "one of them never began"
    with JournalReader(journal) as reader:
        for number, (first, second) in enumerate(zip_longest(_said(reader, one), _said(reader, two)), 1):
            if first != second:
                shown = " and ".join(
                    "nothing" if each is None else f"{each[2]} {each[1]} at {each[0]:.6f} s" for each in (first, second)
                )
                return f"event {number} of runs {one} and {two}: {shown}"
    return ""


def _said(reader: JournalReader, run: str) -> Iterator[tuple[Any, ...]]:
    for event in reader.iterate(run):
        data = {} if event.event in MEASURED else {k: v for k, v in event.data.items() if k != "preview"}
        if data.get("type") == "Plan" and isinstance(plan := reader.value(event), Plan):
            data["hash"] = encode(replace(plan, planning_time=0.0))
        yield event.t, event.path, event.event, event.outcome, event.code, data
