"""With what a trial was made: versions, machine, digests of files; and whether another run of it was the same."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from itertools import zip_longest
from pathlib import Path
from typing import Any

from grip_bt.app.campaign.file import Campaign
from grip_bt.app.project.folder import find_project
from grip_bt.base.values import Plan
from grip_bt.runtime import JournalReader
from grip_bt.runtime.value_codec import encode

PACKAGES = ("grip-bt", "numpy", "sapien", "pin", "coal", "ompl", "toppra", "opencv-python", "py-trees")
"""Whose versions are told: what results depend on."""
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
