"""Going on with a run whose process died, or from any event of a run as another one: what it takes besides the task."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from grip_bt.base.errors import GripError, ResumeError, UnknownNameError, WrongTypeError
from grip_bt.base.ports import Clock
from grip_bt.compilers import CompiledMachine, CompiledTree
from grip_bt.compilers.binding import parts_of
from grip_bt.nodes.mock import MockLeaf
from grip_bt.runtime import Event, Journal, JournalReader, ReExecution, RunLog, WallClock
from grip_bt.runtime.journal import DetailedEvent
from grip_bt.runtime.observers import SideState
from grip_bt.runtime.value_codec import snapshot
from grip_bt.task.catalog import Manifest, check_value

from .saved_state import RestoredState, restore_state


@dataclass(frozen=True)
class ResumeRequest:
    """What is gone on with, and how.

    Attributes:
        run: its id.
        at: the last event that happens again, in a new run; None to go on with the run itself.
        results: leaf -> (outcome, code) of its next end, in place of its work.
        values: variable -> value from then on.
        agreed: whether a part beside the task that can't be brought back may begin as in a new run.
    """

    run: str
    at: int | None = None
    results: Mapping[str, Sequence[str]] = field(default_factory=dict)
    values: Mapping[str, Any] = field(default_factory=dict)
    agreed: bool = False


def policy_of(manifest: Manifest) -> str:
    """Return `resume`, `restart` or `ask`: what is done about a node that was active when its process died.

    A manifest says so, or else: nodes that move something or ask somebody else, and nodes of projects, are asked about.
    """
    if manifest.resume is not None:
        return manifest.resume
    return "ask" if manifest.outside else "restart"


def start_resumed(
    journal: Journal,
    compiled: CompiledTree | CompiledMachine,
    resume: ResumeRequest,
    clock: Clock | None,
    seed: int,
    kept: Mapping[str, SideState],
) -> tuple[RunLog, ReExecution, RestoredState]:
    """Return the log that is written on, the run that happens again first, and what became of `kept` parts.

    Args:
        clock: of the run from then on; None for the wall's.

    Raises:
        ResumeError: a value that the run needs, or a part, can't be restored.
        UnknownNameError, WrongTypeError: a variable that is to be set isn't there, or of another type.
    """
    reader = JournalReader(journal.file)
    record = reader.run(resume.run)
    events = reader.events(resume.run, limit=resume.at)
    _check_values(reader, events)
    back = restore_state(kept, reader, events, resume.agreed)
    if resume.at is None:
        log = journal.go_on(record.id)
    else:
        log = journal.begin(record.task_name, record.task_path, record.task_text, compiled.target, seed)
        origin = {"run": record.id, "at": resume.at}
        for event in events:  # with the times of that run
            data = {**event.data, "forked_from": origin} if event.event == "run_started" else event.data
            log.note(event.t, event.path, DetailedEvent(event.event, event.outcome, event.code, dict(data) or None))
    if resume.values:
        events += _set_values(log, compiled, resume.values, events)
    parts = parts_of(compiled)
    manifests = {path: part.manifest for path, part in parts.items() if part.manifest is not None}
    how: dict[str, Any] = {
        path: "resume"
        for path, leaf in compiled.leaves.items()
        if isinstance(leaf, MockLeaf) or policy_of(manifests[path]) == "resume"
    }
    values = dict(resume.values)

    def value(event: Event) -> Any:
        return values[event.data["variable"]] if event.data.get("set") == "now" else reader.value(event)

    return log, ReExecution(compiled, events, value, clock or WallClock(), how=how, results=resume.results), back


def _check_values(reader: JournalReader, events: Iterable[Event]) -> None:
    """Refuse a run with a value that isn't there any more, before anything is started."""
    for event in events:
        if event.event == "write":
            try:
                reader.value(event)
            except GripError as error:
                variable = event.data.get("variable")
                raise ResumeError(
                    f"cannot resume from here: variable {variable!r}, which {event.path} wrote at event "
                    f"{event.seq}: {error}. Fork it at an event before that"
                ) from error


def _set_values(
    log: RunLog, compiled: CompiledTree | CompiledMachine, values: Mapping[str, object], events: Sequence[Event]
) -> list[Event]:
    """Write that variables were set by hand; return these events as they happen again."""
    scopes = compiled.data
    t = events[-1].t if events else 0.0
    made: list[Event] = []
    for name, value in values.items():
        found = [scope for scope in scopes if name in scope.cells]
        if not found:
            raise UnknownNameError("variable", name, {n for scope in scopes for n in scope.cells}, "--set")
        cell = found[0].cells[name]  # the outermost one of this name
        wrong = check_value(cell.parsed, value)
        if wrong is not None:
            raise WrongTypeError("--set", name, cell.type, wrong)
        data = {"variable": name, "type": cell.type, "scope": found[0].path, "set": "by hand"}
        log.note(t, "/", DetailedEvent("write", data=data, written=(snapshot(value),)))
        made.append(Event(len(events) + len(made) + 1, t, 0.0, "/", "write", None, None, {**data, "set": "now"}))
    return made
