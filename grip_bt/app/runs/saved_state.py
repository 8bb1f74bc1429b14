"""What comes back besides the task when a run is resumed: scene, messages, simulated world, fakes."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from grip_bt.base.errors import GripError, ResumeError
from grip_bt.base.message_store import Entry, LocalMessages, MessageLibrary
from grip_bt.runtime import Event, JournalReader
from grip_bt.runtime.observers import KEPT, SideState
from grip_bt.runtime.value_codec import encode

from ..wiring.parts import Resources

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
_EVERYTHING = (SCENE, MESSAGES, WORLD, FAKES)


def changes(node: str, implementation: str) -> tuple[str, ...]:
    """Return which parts a node's work may change.

    Args:
        node: its id.
        implementation: as its manifest has it.
    """
    if not implementation.startswith("grip_bt."):
        return _EVERYTHING
    return _CHANGED_BY.get(node.partition("/")[0], ())


class _KeptState:
    """Implements `runtime.observers.SideState` for a part that tells by some value of its own whether it is as it was.

    Args:
        version: returns that value; a look at it takes microseconds.
        save: returns the part's state.
        restore: brings a state back.
        same: compares two versions.
    """

    def __init__(
        self,
        version: Callable[[], object],
        save: Callable[[], object],
        restore: Callable[[Any], None],
        same: Callable[[object, object], bool] = operator.eq,
    ):
        self._version, self._save, self._restore, self._same = version, save, restore, same
        self._last = version()

    def changed(self) -> object:
        """Return the state, where it is another one."""
        now = self._version()
        if self._same(now, self._last):
            return None
        self._last = now
        return self._save()

    def restore(self, state: object) -> None:
        """Have the part as it was."""
        self._restore(state)
        self._last = self._version()


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


def _last_kept(events: Iterable[Event]) -> dict[str, Event]:
    """Return the last state of each part that a run's events tell of."""
    return {event.data["part"]: event for event in events if event.event == KEPT}


def parts_lost(nodes: Mapping[str, tuple[str, str]], events: Sequence[Event], robot: str, stays: str = "") -> list[str]:
    """Say what nodes that have ended may have changed and that doesn't come back when the run is resumed.

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
    SCENE: "their changes to the planning scene are lost",
    MESSAGES: "their changes to message stores are lost",
    WORLD: "the robot and the objects it moved are back at their initial positions",
}


def _surely(node: str) -> tuple[str, ...]:
    kind = node.partition("/")[0]
    return _CHANGED_BY.get(kind, ()) if kind not in ("component", "grasp") else ()


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
    for name, event in _last_kept(events).items():
        if name not in others:
            try:
                reader.value(event)
            except GripError as error:
                found[name] = _not_back(event, error)
    return found


@dataclass
class RestoredState:
    """What became of the parts beside the task.

    Attributes:
        restored: part -> the event whose state it has.
        anew: part it starts from its initial state -> why.
    """

    restored: dict[str, int] = field(default_factory=dict)
    anew: dict[str, str] = field(default_factory=dict)


def restore_state(
    parts: Mapping[str, SideState], reader: JournalReader, events: Sequence[Event], agreed: bool = False
) -> RestoredState:
    """Bring parts into the state that they had at the last of `events`.

    Args:
        parts: that this run has.
        reader: of the journal.
        events: that happen again.
        agreed: whether a part that can't be brought there may begin as in a new run.

    Raises:
        ResumeError: one can't be brought there.
    """
    found = RestoredState()
    for name, event in _last_kept(events).items():
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
ANEW = "it starts from its initial state"


def _not_back(event: Event, error: Exception) -> str:
    return f"cannot be restored to its state at event {event.seq} ({event.path}): {error}"
