"""What was recorded: how a run has moved, and values that an input of a component can be tried with."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.motion_record import motion_file
from grip_bt.base.errors import GripError
from grip_bt.base.message_store import STANDARD, MessageLibrary
from grip_bt.runtime import JournalReader
from grip_gui.wire.live import ComponentForm, MotionSample, MotionView, RequestPort, Sample

MOST = 1 << 20  # most that is read at once [bytes]


def motion_of(journal: Path, run: str, after: int) -> MotionView:
    """Return the next piece of the record of a journal's run, after where the last one ended; empty where none is."""
    file = motion_file(journal, run)
    if not file.is_file():
        return MotionView(samples=[], next=0)
    with file.open("rb") as record:
        record.seek(after)
        piece = record.read(MOST)
    whole = piece[: piece.rfind(b"\n") + 1]  # the last line may be being written
    parts: dict[str, list[str]] = {}
    bodies: dict[str, Any] = {}
    samples = []
    for line in whole.splitlines():
        data: dict[str, Any] = json.loads(line)
        if "parts" in data:
            parts = data["parts"]
        else:
            bodies |= data.pop("bodies", {})
            samples.append(MotionSample(**data))
    return MotionView(parts=parts, bodies=bodies, samples=samples, next=after + len(whole))


def last_state(journal: Path, run: str, part: str) -> dict[str, float]:
    """Return where a part was measured last: joint -> position [rad or m]; empty where it never was."""
    joints: list[str] = []
    positions: list[float] = []
    after, piece = 0, None
    while piece is None or piece.next > after:
        after = 0 if piece is None else piece.next
        piece = motion_of(journal, run, after)
        joints = piece.parts.get(part, joints)
        positions = next((s.q[part] for s in reversed(piece.samples) if part in s.q), positions)
    return dict(zip(joints, positions, strict=False))


RUNS, EACH = 10, 12
"""Runs that are looked through, the latest ones, and samples of a port."""


def form_of(folder: Path, home: Path) -> ComponentForm:
    """Return the inputs of the component in a project's folder `home`, and what was recorded for them."""
    try:
        project = find_project(folder)
        name = next((name for name, place in project.component_folders().items() if place == home), home.name)
        manifest = catalogue_of(project).get(f"component/{name}")
    except GripError as error:
        return ComponentForm(name=home.name, error=f"Generate its node first. {error}")
    recorded = list(_written(project.journal))
    inputs = [
        RequestPort(name=port, type=face.type, doc=face.doc, samples=_fitting(face.type, recorded, folder))
        for port, face in manifest.inputs.items()
    ]
    return ComponentForm(name=name, inputs=inputs)


def source_of(sample: str) -> dict[str, Any]:
    """Return where a sample is: `{run, seq}` or `{store, name}`."""
    kind, _, rest = sample.partition(":")
    first, _, second = rest.partition("/")
    if kind == "run" and second.isdigit():
        return {"run": first, "seq": int(second)}
    if kind == "messages" and second:
        return {"store": first, "name": second}
    raise GripError(f"{sample!r} is no sample; there are run:RUN/SEQ and messages:STORE/NAME")


def _written(journal: Path) -> Iterable[tuple[str, Sample]]:
    if not journal.is_file():
        return
    try:
        with JournalReader(journal) as reader:
            for run in reader.runs()[:RUNS]:
                for variable, event in reader.variables(run.id).items():
                    type_name = str(event.data.get("type", ""))
                    title = f"{variable} of {run.task_name}, run {run.id[-6:]}"
                    yield type_name, Sample(source=f"run:{run.id}/{event.seq}", title=title, type=type_name)
    except GripError:
        return  # a journal that can't be read has no samples; runs tell why


def _fitting(type_name: str, recorded: Iterable[tuple[str, Sample]], folder: Path) -> list[Sample]:
    found = [sample for written, sample in recorded if written == type_name][:EACH]
    store = next((name for name, held in STANDARD.items() if held == type_name), None)
    if store is not None and (folder / "messages").is_dir():
        try:
            names = MessageLibrary(folder / "messages").store(store).names()
        except GripError:
            names = ()
        found += [
            Sample(source=f"messages:{store}/{name}", title=f"{name} of {store}", type=type_name) for name in names
        ]
    return found
