"""What has to be known and agreed to before a run is resumed, or forked from one of its events: nothing is started."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from grip_bt.app.runs.execute import RunOptions, Target, check_task
from grip_bt.app.runs.mocks import apply_mocks
from grip_bt.app.runs.replay import Until, find_run
from grip_bt.app.runs.resume import ResumeRequest, policy_of
from grip_bt.base.errors import ResumeError, UnknownNameError
from grip_bt.compilers.resolve import Part, resolve
from grip_bt.runtime import Event, JournalError, JournalReader, Recording, RunRecord
from grip_bt.runtime.debugger import node_path
from grip_bt.runtime.observers import KEPT
from grip_bt.task import model

_CLOSING = 10.0
"""How long [s] the process of a run that was cut off may take to close its parts."""

_NODES = ("enter", "exit", "interrupted", "write")


def _last_task_event(events: Sequence[Event]) -> int:
    """Return the last event that belongs to the task's own doing, before a stop or an error interrupted everything."""
    broken = (
        event.seq - 1
        for event in events
        if (event.event == "state" and event.data.get("state") == "stopping")
        or (event.event == "error" and not _died(event))
    )
    last = next(broken, len(events))
    while 0 < last < len(events) and events[last - 1].event in ("interrupted", "state", "message", "zombie", KEPT):
        last -= 1
    return last


def _died(event: Event) -> bool:
    return event.event == "error" and event.data.get("type") == "ProcessDied"


def _check_resumable(record: RunRecord, events: Sequence[Event]) -> None:
    """Refuse a run that has ended, or is under way, and say what can be done."""
    errors = [event for event in events if event.event == "error"]
    if record.status == "running":
        raise ResumeError(f"run {record.id} is under way in another process; stop it first")
    if not any(event.event in _NODES for event in events):
        raise ResumeError(f"run {record.id} died before it began; start the task again: grip run {record.task_path}")
    if record.status in ("died", "lost") or (record.status == "error" and errors and _died(errors[-1])):
        return
    why = f"it has ended: {record.status}" + (f", {errors[-1].path} raised" if errors else "")
    raise _only_forked(record, why, _last_task_event(events))


def _only_forked(record: RunRecord, why: str, at: int) -> ResumeError:
    how = f"As a new run, from any event up to {at}: grip run --fork {record.id} --at {at}"
    return ResumeError(f"run {record.id} cannot be resumed: {why}. {how}")


def _event_at(record: RunRecord, events: Sequence[Event], text: str) -> int:
    """Return the event up to which a run is to happen again, of a number, `NODE`, or `NODE:OUTCOME`."""
    at = Until(text).place(events, record.id)
    if at > (last := _last_task_event(events)):
        while last > 0 and events[last - 1].event not in _NODES:
            last -= 1
        if any(e.event in _NODES for e in events[last:at]):
            why = f"was stopped, or broken by an error, after event {last}: --at {last} or less"
            raise ResumeError(f"run {record.id} {why}")
    return at


def _questions(
    parts: Mapping[str, Part],
    events: Sequence[Event],
    resume: ResumeRequest,
    options: RunOptions,
) -> list[str]:
    """Return what a person has to agree to."""
    found = []
    faces = {p: part.manifest for p, part in parts.items() if part.manifest is not None}
    leaves = {p: face for p, face in faces.items() if not {p, face.id} & {*options.mocks}}
    for path in Recording(events, leaves).under_way:
        if path not in resume.results and policy_of(leaves[path]) == "ask":
            again = f"it is started again (or say how it ended: --set-outcome {path}=success)"
            found.append(f"{path}: {leaves[path].id} was under way, and its progress is unknown; {again}")
    foreign = [p for p, part in parts.items() if isinstance(part.node, model.Foreign) and p in {e.path for e in events}]
    if foreign:
        found.append(f"{', '.join(foreign)}: py_trees behaviours ran; they will run again")
    return found


def _read_results(parts: Mapping[str, Part], given: Iterable[str]) -> dict[str, tuple[str, str]]:
    """Return leaf -> (outcome, code) of texts such as `attempt/grasp=failure.no_ik`."""
    found, leaves = {}, [p for p, part in parts.items() if part.manifest is not None]
    for text in given:
        node, _, said = text.partition("=")
        outcome, _, code = said.strip().partition(".")
        if not outcome:
            raise ResumeError(f"--set-outcome {text!r} isn't NODE=OUTCOME, such as attempt/grasp=failure.no_ik")
        path = node_path(node)
        if path not in parts:
            raise UnknownNameError("leaf", path, leaves, "--set-outcome")
        if path not in leaves:
            below = ", ".join(p for p in leaves if path == "/" or p.startswith(f"{path}/"))
            raise ResumeError(f"--set-outcome {path}: how a container ends follows from its leaves; set one of {below}")
        if outcome not in parts[path].meaning:
            raise UnknownNameError("outcome", outcome, parts[path].meaning, f"--set-outcome {path}")
        found[path] = (outcome, code)
    return found


def agree(asked: Sequence[str], ask: Callable[[str], bool] | None) -> None:
    """Have a person agree to everything, by `ask` if there is one. Raises ResumeError where they don't or can't."""
    if ask is None and asked:
        raise ResumeError("\n  ".join(("resuming needs your confirmation (or pass --yes):", *asked)))
    for question in asked:
        if ask is not None and not ask(question):
            raise ResumeError(f"not resumed: {question.partition(':')[0]}")


@dataclass(frozen=True)
class ResumePlan:
    """A run that can be resumed or forked, and what a person is asked, or told, before."""

    task: Path
    options: RunOptions
    questions: Sequence[str]
    notes: Sequence[str] = ()


def plan_resume(
    journal: Path,
    run: str,
    options: RunOptions,
    given: Collection[str] = (),
    *,
    at: str | None = None,
    task: Path | None = None,
    outcomes: Iterable[str] = (),
) -> ResumePlan:
    """Look at a run, and say how it can be resumed.

    Args:
        run: its id, the beginning of it, or `last`.
        given: names of those that they really gave; for others, those of the run are taken.
        at: the place from which a new run goes on; None for the run itself.
        outcomes: texts such as `attempt/grasp=failure.no_ik`.

    Raises:
        UnknownNameError: there is no such run, place, node or outcome.
        ResumeError: it can't be resumed; it says what can be done.
    """
    with JournalReader(journal) as reader:
        record = reader.run(find_run(reader, run))
        events: list[Event] = []
        try:
            events.extend(reader.iterate(record.id))
        except JournalError as error:  # from what is before the damage, a new run goes on
            if at is None:
                raise _only_forked(record, f"it is damaged: {error}", len(events)) from error
        if at is None:
            _check_resumable(record, events)
            deadline = time.monotonic() + _CLOSING
            while record.status == "died" and reader.lives(record.id):
                if time.monotonic() > deadline:
                    still = "was interrupted, and its process is still shutting down; stop it first"
                    raise ResumeError(f"run {record.id} {still}")
                time.sleep(0.05)
    until = None if at is None else _event_at(record, events, at)
    file = task if task is not None else _recorded_file(record.task_path, journal)
    started = next((event for event in events if event.event == "run_started"), None)
    was = dict(started.data.get("options", {})) if started is not None else {}
    values = dict(options.data)
    options = replace(options, **{k: was[k] for k in was.keys() - set(given) if hasattr(options, k)})
    target: Target = "sm" if record.target == "sm" else "bt"
    options = replace(options, data=was.get("data", {}), target=target, journal=journal.absolute())
    _, document, _, catalog = check_task(file, record.task_text)
    changed = file.is_file() and file.read_text(encoding="utf-8") != record.task_text
    model = document.task
    if options.mocks:
        model, catalog, _ = apply_mocks(model, catalog, options.mocks)
    parts = {part.path: part for part in resolve(model, catalog).root.walk()}
    happened = events if until is None else events[:until]
    request = ResumeRequest(record.id, until, _read_results(parts, outcomes), values)
    asked = _questions(parts, happened, request, options)
    notes = [f"{file} has changed since; the run continues with the recorded task"] if changed else []
    return ResumePlan(file, replace(options, resume=request), asked, notes)


def _recorded_file(recorded: str, journal: Path) -> Path:
    """Return the task's file as recorded, from here or from the project's folder."""
    path = Path(recorded)
    folder = journal.absolute().parent.parent if journal.parent.name == ".grip" else Path.cwd()
    for candidate in (path, folder / path, folder / "tasks" / path.name, folder / path.name):
        if candidate.is_file():
            return candidate
    if path.absolute().parent.is_dir():
        return path
    raise ResumeError(f"the run's task file {recorded!r} isn't here; name it too: grip run FILE --resume ...")
