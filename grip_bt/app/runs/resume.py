"""Going on with a run whose process died, or from any event of a run as another one: what it takes besides the task."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from typing import Any

from grip_bt.base.errors import GripError, ResumeError, UnknownNameError, WrongTypeError
from grip_bt.base.ports import Clock
from grip_bt.compilers import CompiledMachine, CompiledTree
from grip_bt.compilers.probe import parts_of
from grip_bt.compilers.resolve import Part
from grip_bt.nodes.mock import MockLeaf
from grip_bt.runtime import (
    Event,
    Journal,
    JournalReader,
    Recording,
    Reliving,
    Result,
    RunLog,
    RunRecord,
    WallClock,
)
from grip_bt.runtime.breakpoints import node_path
from grip_bt.runtime.journal_events import DAMAGED
from grip_bt.runtime.keeping import KEPT, Kept
from grip_bt.runtime.run_log import Noted
from grip_bt.runtime.value_codec import snapshot
from grip_bt.task import model
from grip_bt.task.catalog import Manifest, check_value

from .replay import Until
from .saved_state import ANEW, WORDS, BroughtBack, bring_back, parts_lost

CLOSING = 10.0
"""How long [s] the process of a run that was cut off may take to close its parts."""
_NODES = ("enter", "exit", "interrupted", "write")


@dataclass(frozen=True)
class GoOn:
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


@dataclass(frozen=True)
class Question:
    """Something that a person has to agree to.

    Attributes:
        about: a node's path, or what else it is about.
        why: what isn't known.
        agreed: what is done if they do.
    """

    about: str
    why: str
    agreed: str

    def __str__(self) -> str:
        return f"{self.about}: {self.why}; {self.agreed}"


# --- which events ---


def undamaged(reader: JournalReader, run: str) -> list[Event]:
    """Return the events of a run up to the first one that can't be read."""
    return list(takewhile(lambda event: event.event != DAMAGED, reader.iterate(run)))


def recorded_options(events: Iterable[Event]) -> dict[str, Any]:
    """Return the options with which a run was started, as far as its journal has them."""
    started = next((event for event in events if event.event == "run_started"), None)
    return dict(started.data.get("options", {})) if started is not None else {}


def see_off(reader: JournalReader, run: str) -> None:
    """Wait until the process of a run that was cut off has closed its parts: two mustn't move one robot.

    Raises:
        ResumeError: it doesn't end.
    """
    deadline = time.monotonic() + CLOSING
    while reader.lives(run):
        if time.monotonic() > deadline:
            raise ResumeError(f"run {run} was cut off, and its process is still closing its parts; end that first")
        time.sleep(0.05)


def before_the_end(events: Sequence[Event]) -> int:
    """Return the last event that belongs to the task's own doing, before a stop or an error interrupted everything."""
    last = len(events)
    for event in events:
        stopping = event.event == "state" and event.data.get("state") == "stopping"
        if stopping or (event.event == "error" and not _died(event)):
            last = event.seq - 1
            break
    while (
        last > 0
        and last < len(events)
        and events[last - 1].event in ("interrupted", "state", "message", "zombie", KEPT)
    ):
        last -= 1
    return last


def _died(event: Event) -> bool:
    return event.event == "error" and event.data.get("type") == "ProcessDied"


def resumable(record: RunRecord, events: Sequence[Event]) -> None:
    """See whether a run can be gone on with.

    Raises:
        ResumeError: it has ended, or is under way; it says what can be done.
    """
    errors = [event for event in events if event.event == "error"]
    if record.status == "running":
        raise ResumeError(f"run {record.id} is under way in another process; stop it first")
    if not any(event.event in _NODES for event in events):
        raise ResumeError(f"run {record.id} died before it began; run the task anew: grip run {record.task_path}")
    if record.status in ("died", "lost") or (record.status == "error" and errors and _died(errors[-1])):
        return
    at = before_the_end(events)
    why = f"it has ended: {record.status}" + (f", {errors[-1].path} raised" if errors else "")
    raise ResumeError(
        f"run {record.id} can't be gone on with, since {why}. As a new run, from any event up to {at}: "
        f"grip run --fork {record.id} --at {at}"
    )


def place_in(record: RunRecord, events: Sequence[Event], text: str) -> int:
    """Return the event up to which a run is to happen again.

    Args:
        record: the run.
        events: all of it.
        text: a number, `NODE`, or `NODE:OUTCOME`.

    Raises:
        UnknownNameError: the run never comes there.
        ResumeError: it was stopped, or a node had raised, before that.
    """
    until = Until(text)
    at = next((event.seq for event in events if until.reached(event)), None)
    if at is None:
        there = {e.path for e in events if e.event in _NODES} if not text.isdigit() else [f"1 to {len(events)}"]
        raise UnknownNameError("place in the run", text, there, f"run {record.id}")
    if at > (last := before_the_end(events)):
        while last > 0 and events[last - 1].event not in _NODES:
            last -= 1
        ended = all(e.event not in _NODES for e in events[last:at])
        if not ended:
            raise ResumeError(
                f"run {record.id} was stopped, or broken by an error, after event {last}: --at {last} or less"
            )
    return at


# --- what has to be agreed to ---


def policy_of(manifest: Manifest) -> str:
    """Return `resume`, `restart` or `ask`: what is done about a node that was active when its process died.

    A manifest says so, or else: nodes that move something or ask somebody else, and nodes of projects, are asked about.
    """
    if manifest.resume is not None:
        return manifest.resume
    return "ask" if manifest.outside else "restart"


def questions(
    parts: Mapping[str, Part],
    events: Sequence[Event],
    go_on: GoOn,
    mocked: Iterable[str],
    robot: str = "sim",
    stays: str = "",
    anew: Mapping[str, str] | None = None,
) -> list[Question]:
    """Return what a person has to agree to before a run is gone on with.

    Args:
        parts: of the task.
        events: that happen again.
        go_on: how.
        mocked: nodes in whose place scripts are played.
        robot: with which it goes on.
        stays: a part beside the task that outlives the run's process; see `app.keeping`.
        anew: part beside the task -> why it can't be brought back.
    """
    found = []
    leaves = {path: part for path, part in parts.items() if part.manifest is not None and path not in set(mocked)}
    for path in Recording(events, leaves).under_way:
        manifest = leaves[path].manifest
        assert manifest is not None, "leaves have one"
        if path not in go_on.results and policy_of(manifest) == "ask":
            why = f"{manifest.id} was under way, and how far it came isn't known"
            found.append(
                Question(path, why, f"it is started again (or say how it ended: --set-outcome {path}=success)")
            )
    nodes = {p: (part.manifest.id, part.manifest.implementation) for p, part in leaves.items() if part.manifest}
    if go_on.at is None:
        found += [
            Question("the world", lost, "it goes on all the same") for lost in parts_lost(nodes, events, robot, stays)
        ]
    found += [Question(WORDS[part], why, ANEW) for part, why in (anew or {}).items()]
    foreign = [p for p, part in parts.items() if isinstance(part.node, model.Foreign) and p in {e.path for e in events}]
    if foreign:
        found.append(Question(", ".join(foreign), "behaviours of py_trees have run", "they are executed again"))
    return found


# --- going on ---


def read_results(parts: Mapping[str, Part], given: Iterable[str]) -> dict[str, tuple[str, str]]:
    """Return leaf -> (outcome, code) of texts such as `attempt/grasp=failure.no_ik`.

    Raises:
        UnknownNameError: there is no such leaf or outcome.
        ResumeError: a text can't be read, or names a container.
    """
    found = {}
    for text in given:
        node, there, said = text.partition("=")
        outcome, _, code = said.strip().partition(".")
        if not there or not outcome:
            raise ResumeError(f"--set-outcome {text!r} isn't NODE=OUTCOME, such as attempt/grasp=failure.no_ik")
        path = node_path(node)
        leaves = [p for p, part in parts.items() if part.manifest is not None]
        if path not in parts:
            raise UnknownNameError("leaf", path, leaves, "--set-outcome")
        if path not in leaves:
            below = ", ".join(p for p in leaves if path == "/" or p.startswith(f"{path}/"))
            raise ResumeError(f"--set-outcome {path}: how a container ends follows from its leaves; set one of {below}")
        if outcome not in parts[path].meaning:
            raise UnknownNameError("outcome", outcome, parts[path].meaning, f"--set-outcome {path}")
        found[path] = (outcome, code)
    return found


def begin_again(
    journal: Journal,
    compiled: CompiledTree | CompiledMachine,
    go_on: GoOn,
    clock: Clock | None,
    seed: int,
    kept: Mapping[str, Kept],
) -> tuple[RunLog, Reliving, BroughtBack]:
    """Return the log that is written on, the run that happens again first, and what became of parts beside the task.

    Args:
        journal: has the run.
        compiled: its task.
        go_on: which, and how.
        clock: of the run from then on; None for the wall's.
        seed: of the simulation, for the log of a new run.
        kept: parts beside the task, which are brought into the state that the journal has of them.

    Raises:
        ResumeError: a value that the run needs, or a part, can't be restored.
        UnknownNameError, WrongTypeError: a variable that is to be set isn't there, or of another type.
    """
    reader = JournalReader(journal.file)
    record = reader.run(go_on.run)
    events = reader.events(go_on.run, limit=go_on.at)
    _check_values(reader, events)
    back = bring_back(kept, reader, events, go_on.agreed)
    if go_on.at is None:
        log = journal.go_on(record.id)
    else:
        log = journal.begin(record.task_name, record.task_path, record.task_text, compiled.target, seed)
        _copy(log, events, {"run": record.id, "at": go_on.at})
    if go_on.values:
        events += _set_values(log, compiled, go_on.values, events)
    parts = parts_of(compiled)
    manifests = {path: part.manifest for path, part in parts.items() if part.manifest is not None}
    how: dict[str, Any] = {
        path: "resume"
        for path, leaf in compiled.leaves.items()
        if isinstance(leaf, MockLeaf) or policy_of(manifests[path]) == "resume"
    }
    results = {path: Result(outcome, code) for path, (outcome, code) in go_on.results.items()}
    values = dict(go_on.values)

    def value(event: Event) -> Any:
        return values[event.data["variable"]] if event.data.get("set") == "now" else reader.value(event)

    return log, Reliving(compiled, events, value, clock or WallClock(), how=how, results=results), back


def _check_values(reader: JournalReader, events: Iterable[Event]) -> None:
    """Refuse a run with a value that isn't there any more, before anything is started."""
    for event in events:
        if event.event == "write":
            try:
                reader.value(event)
            except GripError as error:
                variable = event.data.get("variable")
                raise ResumeError(
                    f"run can't be gone on with from here: variable {variable!r}, which {event.path} wrote at event "
                    f"{event.seq}: {error}. Fork it at an event before that"
                ) from error


def _copy(log: RunLog, events: Iterable[Event], origin: Mapping[str, Any]) -> None:
    """Write events of another run into a new one; its times are those of that run."""
    for event in events:
        data = {**event.data, "forked_from": dict(origin)} if event.event == "run_started" else event.data
        log.note(event.t, event.path, Noted(event.event, event.outcome, event.code, dict(data) or None))


def _set_values(
    log: RunLog, compiled: CompiledTree | CompiledMachine, values: Mapping[str, Any], events: Sequence[Event]
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
        log.note(t, "/", Noted("write", data=data, written=(snapshot(value),)))
        made.append(Event(len(events) + len(made) + 1, t, 0.0, "/", "write", None, None, {**data, "set": "now"}))
    return made


Ask = Callable[[Question], bool]
"""Asks a person whether they agree."""


def agree(asked: Sequence[Question], ask: Ask | None) -> None:
    """Have a person agree to everything.

    Args:
        asked: what to.
        ask: asks them; None where nobody can be asked.

    Raises:
        ResumeError: somebody doesn't agree, or can't be asked.
    """
    if ask is None and asked:
        lines = "\n".join(f"  {question}" for question in asked)
        raise ResumeError(f"this has to be agreed to; with --yes, it is:\n{lines}")
    for question in asked:
        if ask is not None and not ask(question):
            raise ResumeError(f"not gone on with, because of {question.about}")


def options_text(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return options as JSON for the journal."""
    kept = ("robot", "seed", "pace", "data", "rate", "watchdog", "mocks", "target")
    facts: dict[str, Any] = json.loads(json.dumps({k: options[k] for k in kept if k in options}, default=str))
    return facts
