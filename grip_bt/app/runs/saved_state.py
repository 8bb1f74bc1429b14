"""What comes back besides the task when a run is gone on with: scene, messages, simulated world, fakes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from grip_bt.base.errors import GripError, ResumeError
from grip_bt.base.message_store import LocalMessages
from grip_bt.base.message_store.store import Entry
from grip_bt.base.ports import Scene
from grip_bt.runtime import Event, JournalReader
from grip_bt.runtime.keeping import KEPT, Kept
from grip_bt.runtime.value_codec import encode

from ..wiring.parts import FakeState, Resources

SCENE, MESSAGES, WORLD, FAKES = "scene", "messages", "world", "fakes"
CHANGED_BY = {
    "arm": (WORLD, SCENE, FAKES),
    "hand": (WORLD, SCENE, FAKES),
    "component": (WORLD, FAKES),
    "scene": (SCENE,),
    "grasp": (SCENE,),
    "messages": (MESSAGES,),
}
"""First part of a node's id -> what its work may change; nodes of projects may change everything."""
EVERYTHING = (SCENE, MESSAGES, WORLD, FAKES)


def changes(node: str, implementation: str) -> tuple[str, ...]:
    """Return which parts a node's work may change.

    Args:
        node: its id.
        implementation: as its manifest has it.
    """
    if not implementation.startswith("grip_bt."):
        return EVERYTHING
    return CHANGED_BY.get(node.partition("/")[0], ())


class KeptScene:
    """The planning scene. Every state of it is a value, so that a look is enough to see whether it is another one."""

    def __init__(self, scene: Scene):
        self._scene, self._last = scene, scene.snapshot()

    def changed(self) -> Any:
        """Return its state, where it is another one."""
        now = self._scene.snapshot()
        if now is self._last:
            return None
        self._last = now
        return now

    def restore(self, state: Any) -> None:
        """Go back to it."""
        self._scene.restore(state)
        self._last = self._scene.snapshot()


class KeptMessages:
    """The named values of this process."""

    def __init__(self, messages: LocalMessages):
        self._library = messages.library
        self._last = self._revisions()

    def _revisions(self) -> dict[str, int]:
        return {name: store.revision for name, store in self._library.stores().items()}

    def changed(self) -> Any:
        """Return all entries and queues, where one was changed."""
        now = self._revisions()
        if now == self._last:
            return None
        self._last = now
        return {
            name: [[e.name, e.value, e.time, e.provenance] for e in (*store.entries(), *store.queue())]
            for name, store in self._library.stores().items()
        }

    def restore(self, state: Any) -> None:
        """Have these entries, and no others."""
        made = {name: [Entry(*entry) for entry in entries] for name, entries in state.items()}
        for store in self._library.stores().values():
            store.clear()
        for name, entries in made.items():
            store = self._library.store(name, make=True)
            for entry in entries:
                store.restore(entry)
        self._last = self._revisions()


class KeptWorld:
    """A simulated world: joints, drives, and objects. Its state is another one where simulated time has passed."""

    def __init__(self, simulation: Any):
        self._simulation = simulation
        self._seen = simulation.clock.simulated

    def changed(self) -> Any:
        """Return it, where time has passed."""
        now = self._simulation.clock.simulated
        if now == self._seen:
            return None
        self._seen = now
        return self._simulation.kept()

    def restore(self, state: Any) -> None:
        """Bring everything that moves to where it was."""
        self._simulation.put_back(state)
        self._seen = self._simulation.clock.simulated


class KeptFakes:
    """Fake arms, hands and components."""

    def __init__(self, fakes: FakeState):
        self._fakes, self._last = fakes, encode(fakes.kept())

    def changed(self) -> Any:
        """Return their state, where it is another one."""
        state = self._fakes.kept()
        now = encode(state)
        if now == self._last:
            return None
        self._last = now
        return state

    def restore(self, state: Any) -> None:
        """Have them as they were."""
        self._fakes.put_back(state)
        self._last = encode(self._fakes.kept())


def kept_parts(resources: Resources) -> dict[str, Kept]:
    """Return those parts of a run that can be kept."""
    parts: dict[str, Kept] = {}
    if resources.scene is not None:
        parts[SCENE] = KeptScene(resources.scene)
    if isinstance(resources.messages, LocalMessages):
        parts[MESSAGES] = KeptMessages(resources.messages)
    if resources.world is not None:
        parts[WORLD] = KeptWorld(resources.world)
    if resources.fakes is not None:
        parts[FAKES] = KeptFakes(resources.fakes)
    return parts


def last_kept(events: Iterable[Event]) -> dict[str, Event]:
    """Return the last state of each part that a run's events tell of."""
    return {event.data["part"]: event for event in events if event.event == KEPT}


def parts_lost(nodes: Mapping[str, tuple[str, str]], events: Sequence[Event], robot: str, stays: str = "") -> list[str]:
    """Say what nodes that have ended may have changed and that doesn't come back when the run is gone on with.

    Args:
        nodes: leaf -> (id, implementation).
        events: of the run.
        robot: with which it goes on: `sim`, `fake` or `ros`; a real one stays as it is.
        stays: a part that outlives the run's process.
    """
    begun = [e.data for e in events if e.event in ("run_started", "run_resumed")]
    keeps = set().union(*(data.get("keeps", ()) for data in begun))
    moved = robot == "ros" or (FAKES if robot == "fake" else WORLD) in keeps
    gone = ({SCENE, MESSAGES} - keeps - {stays}) | (set() if moved else {WORLD})
    ended = {event.path for event in events if event.event == "exit"}
    found = []
    for part in [part for part in _LOST_WORDS if part in gone]:
        paths = sorted(path for path, (node, _) in nodes.items() if path in ended and part in _surely(node))
        if paths:
            found.append(f"{', '.join(paths[:3])}{' ...' if len(paths) > 3 else ''} had ended, and {_LOST_WORDS[part]}")
    return found


_LOST_WORDS = {
    SCENE: "what they changed in the planning scene isn't there",
    MESSAGES: "what they changed in message stores isn't there",
    WORLD: "the robot, and what it moved, is where it was at first",
}


def _surely(node: str) -> tuple[str, ...]:
    kind = node.partition("/")[0]
    return CHANGED_BY.get(kind, ()) if kind not in ("component", "grasp") else ()


def unreadable(reader: JournalReader, events: Sequence[Event], robot: str, stays: str = "") -> dict[str, str]:
    """Return which parts can't be brought back since the journal hasn't got their states any more, and why.

    Args:
        reader: of the journal.
        events: that happen again.
        robot: with which the run goes on.
        stays: a part that outlives the run's process.
    """
    others = {stays, *({WORLD} if robot != "sim" else ()), *({FAKES} if robot != "fake" else ())}
    found = {}
    for name, event in last_kept(events).items():
        if name not in others:
            try:
                reader.value(event)
            except GripError as error:
                found[name] = _not_back(event, error)
    return found


@dataclass
class BroughtBack:
    """What became of the parts beside the task.

    Attributes:
        restored: part -> the event whose state it has.
        anew: part that begins as in a new run -> why.
    """

    restored: dict[str, int] = field(default_factory=dict)
    anew: dict[str, str] = field(default_factory=dict)


def bring_back(
    parts: Mapping[str, Kept], reader: JournalReader, events: Sequence[Event], agreed: bool = False
) -> BroughtBack:
    """Bring parts into the state that they had at the last of `events`.

    Args:
        parts: that this run has.
        reader: of the journal.
        events: that happen again.
        agreed: whether a part that can't be brought there may begin as in a new run.

    Raises:
        ResumeError: one can't be brought there.
    """
    found = BroughtBack()
    for name, event in last_kept(events).items():
        if name in parts:
            try:
                parts[name].restore(reader.value(event))
            except (GripError, LookupError, TypeError, ValueError) as error:
                why = _not_back(event, error)
                if not agreed:
                    raise ResumeError(f"{WORDS[name]} {why}; with --yes, {ANEW}") from error
                found.anew[name] = why
            else:
                found.restored[name] = event.seq
    return found


WORDS = {SCENE: "the scene", MESSAGES: "the messages", WORLD: "the simulated world", FAKES: "the fake robot"}
ANEW = "that begins as in a new run"


def _not_back(event: Event, error: Exception) -> str:
    return f"can't be brought back to what it was at event {event.seq} ({event.path}): {error}"
