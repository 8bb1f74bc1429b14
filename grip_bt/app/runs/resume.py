"""What it takes, besides the task, to go on with a run whose process died, or from an event of a run as another one."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from grip_bt.app.wiring.parts import Resources
from grip_bt.base.errors import GripError, ResumeError, UnknownNameError, WrongTypeError
from grip_bt.base.message_store import Entry, LocalMessages, MessageLibrary
from grip_bt.base.ports import Clock
from grip_bt.base.value_codec import encode, snapshot
from grip_bt.compilers import CompiledMachine, CompiledTree
from grip_bt.compilers.binding import parts_of
from grip_bt.nodes.mock import MockLeaf
from grip_bt.runtime import Event, Journal, JournalReader, ReExecution, RunLog, WallClock
from grip_bt.runtime.journal import DetailedEvent
from grip_bt.runtime.observers import KEPT, SideState
from grip_bt.task.catalog import Manifest, check_value

SCENE, MESSAGES, WORLD, FAKES = "scene", "messages", "world", "fakes"
_CHANGED_BY = {
    "arm": (WORLD, SCENE, FAKES),
    "hand": (WORLD, SCENE, FAKES),
    "component": (WORLD, FAKES),
    "scene": (SCENE,),
    "grasp": (SCENE,),
    "messages": (MESSAGES,),
}
"""First part of a node's id -> what its work may change; nodes of projects may change everything."""


def changes(manifest: Manifest) -> tuple[str, ...]:
    """Return which parts a node's work may change."""
    if not manifest.implementation.startswith("grip_bt."):
        return SCENE, MESSAGES, WORLD, FAKES
    return _CHANGED_BY.get(manifest.id.partition("/")[0], ())


@dataclass
class _KeptState:
    """Implements `SideState` for a part of which some value, quick to look at, tells whether it is as it was."""

    version: Callable[[], object]
    save: Callable[[], object]
    put_back: Callable[[Any], None]
    same: Callable[[object, object], bool] = operator.eq

    def __post_init__(self) -> None:
        self._last = self.version()

    def changed(self) -> object:
        """Return the state, where it is another one."""
        now = self.version()
        if self.same(now, self._last):
            return None
        self._last = now
        return self.save()

    def restore(self, state: object) -> None:
        """Have the part as it was."""
        self.put_back(state)
        self._last = self.version()


def kept_parts(resources: Resources) -> dict[str, SideState]:
    """Return those parts of a run that can be kept."""
    parts: dict[str, SideState] = {}
    if (scene := resources.scene) is not None:  # every state of it is a value
        parts[SCENE] = _KeptState(scene.snapshot, scene.snapshot, scene.restore, operator.is_)
    if isinstance(messages := resources.messages, LocalMessages):
        library = messages.library
        parts[MESSAGES] = _KeptState(
            lambda: {name: store.revision for name, store in library.stores().items()},
            lambda: {
                name: [[e.name, e.value, e.time, e.provenance] for e in (*store.entries(), *store.queue())]
                for name, store in library.stores().items()
            },
            partial(_set_entries, library),
        )
    if (world := resources.world) is not None:
        parts[WORLD] = _KeptState(lambda: world.clock.simulated, world.kept, world.put_back)
    if (fakes := resources.fakes) is not None:
        parts[FAKES] = _KeptState(lambda: encode(fakes.kept()), fakes.kept, fakes.put_back)
    return parts


def _set_entries(library: MessageLibrary, state: Mapping[str, Iterable[Iterable[Any]]]) -> None:
    made = {name: [Entry(*entry) for entry in entries] for name, entries in state.items()}
    for store in library.stores().values():
        store.clear()
    for name, entries in made.items():
        store = library.store(name, make=True)
        for entry in entries:
            store.restore(entry)


_WORDS = {SCENE: "the scene", MESSAGES: "the messages", WORLD: "the simulated world", FAKES: "the fake robot"}


def _restored(parts: Mapping[str, SideState], reader: JournalReader, events: Iterable[Event]) -> dict[str, int]:
    """Bring parts into the state that they had at the last of `events`; return the event that has it."""
    found = {}
    for name, event in {event.data["part"]: event for event in events if event.event == KEPT}.items():
        if name in parts:
            try:
                parts[name].restore(reader.value(event))
            except (GripError, LookupError, TypeError, ValueError) as error:
                why = f"cannot be restored to its state at event {event.seq} ({event.path}): {error}"
                raise ResumeError(f"{_WORDS[name]} {why}. Fork it at an event before that") from error
            found[name] = event.seq
    return found


@dataclass(frozen=True)
class ResumeRequest:
    """What is gone on with, and how.

    Attributes:
        at: the last event that happens again, in a new run; None to go on with the run itself.
        results: leaf -> (outcome, code) of its next end, in place of its work.
        values: variable -> value from then on.
    """

    run: str
    at: int | None = None
    results: Mapping[str, Sequence[str]] = field(default_factory=dict)
    values: Mapping[str, Any] = field(default_factory=dict)


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
) -> tuple[RunLog, ReExecution, dict[str, int]]:
    """Return the log that is written on, the run that happens again first, and which event parts of `kept` come from.

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
    back = _restored(kept, reader, events)
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
    manifests = {path: part.manifest for path, part in parts_of(compiled).items() if part.manifest is not None}
    how: dict[str, Any] = {
        path: "resume"
        for path, leaf in compiled.leaves.items()
        if isinstance(leaf, MockLeaf) or policy_of(manifests[path]) == "resume"
    }

    def value(event: Event) -> Any:
        return resume.values[event.data["variable"]] if event.data.get("set") == "now" else reader.value(event)

    return log, ReExecution(compiled, events, value, clock or WallClock(), how=how, results=resume.results), back


def _check_values(reader: JournalReader, events: Iterable[Event]) -> None:
    """Refuse a run with a value that isn't there any more, before anything is started."""
    for event in events:
        try:
            if event.event == "write":
                reader.value(event)
        except GripError as error:
            what = f"variable {event.data.get('variable')!r}, which {event.path} wrote at event {event.seq}"
            raise ResumeError(f"cannot resume from here: {what}: {error}. Fork it at an event before that") from error


def _set_values(
    log: RunLog, compiled: CompiledTree | CompiledMachine, values: Mapping[str, object], events: Sequence[Event]
) -> list[Event]:
    """Write that variables were set by hand; return these events as they happen again."""
    t, made = events[-1].t if events else 0.0, list[Event]()
    for name, value in values.items():
        scope = next((scope for scope in compiled.data if name in scope.cells), None)  # the outermost one that has it
        if scope is None:
            raise UnknownNameError("variable", name, {n for scope in compiled.data for n in scope.cells}, "--set")
        cell = scope.cells[name]
        wrong = check_value(cell.parsed, value)
        if wrong is not None:
            raise WrongTypeError("--set", name, cell.type, wrong)
        data = {"variable": name, "type": cell.type, "scope": scope.path, "set": "by hand"}
        log.note(t, "/", DetailedEvent("write", data=data, written=(snapshot(value),)))
        made.append(Event(len(events) + len(made) + 1, t, 0.0, "/", "write", None, None, {**data, "set": "now"}))
    return made
