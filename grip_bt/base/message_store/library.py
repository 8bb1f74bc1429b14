"""All stores of a project, and the port `Messages` behind which tasks and scripts use them without a server."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import ExpectedError, NoEntryError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState

from .files import read_joint_states, read_poses, read_trajectories
from .store import Entry, MessageStore

T = TypeVar("T")
STANDARD: dict[str, str] = {
    "joint_states": "JointState",
    "poses": "Pose",
    "robot_poses": "dict[str, Pose]",
    "trajectories": "Trajectory",
    "plans": "Plan",
    "grasps": "Grasp",
    "clouds": "PointCloud",
    "images": "Image",
}
"""Stores that are always there, and what they hold; any other holds anything."""
JOINT_STATES, POSES, TRAJECTORIES = "joint_states.yaml", "poses.yaml", "trajectories.yaml"
"""Files in a project's folder of messages."""


class MessageLibrary:
    """Named stores.

    Args:
        folder: holds `joint_states.yaml`, `poses.yaml` (poses and robot poses) and `trajectories.yaml`, each where
            there are any; None for none.

    Raises:
        DocumentError: a file is wrong.
    """

    def __init__(self, folder: Path | str | None = None):
        self._folder = None if folder is None else Path(folder)
        self._lock = threading.RLock()
        self._stores: dict[str, MessageStore[object]] = {n: MessageStore(n, type_) for n, type_ in STANDARD.items()}
        self.reset()

    def store(self, name: str, make: bool = False) -> MessageStore[object]:
        """Return a store.

        Args:
            make: whether one of a new name is made, which holds anything.

        Raises:
            UnknownNameError: there is none of this name.
        """
        with self._lock:
            if name not in self._stores:
                if not make or not name:
                    raise UnknownNameError("store", name, self._stores)
                self._stores[name] = MessageStore(name, "Any")
            return self._stores[name]

    def stores(self) -> Mapping[str, MessageStore[object]]:
        """Return all stores by name."""
        with self._lock:
            return dict(self._stores)

    def reset(self, name: str = "") -> None:
        """Empty a store, or all, and read again what the files hold.

        Raises:
            DocumentError: a file is wrong; nothing was changed.
            UnknownNameError: there is no such store.
        """
        from_files = self._from_files()
        chosen = {name: self.store(name)} if name else self.stores()
        for key, store in chosen.items():
            store.clear()
            for entry, (value, source) in from_files.get(key, {}).items():
                store.put(entry, value, source)

    def _from_files(self) -> dict[str, dict[str, tuple[object, str]]]:
        if self._folder is None:
            return {}
        found: dict[str, dict[str, tuple[object, str]]] = {}

        def add(store: str, file: Path, values: Mapping[str, object]) -> None:
            found[store] = {name: (value, str(file)) for name, value in values.items()}

        states: Mapping[str, JointState] = {}
        if (file := self._folder / JOINT_STATES).is_file():
            states = read_joint_states(file)
            add("joint_states", file, states)
        if (file := self._folder / POSES).is_file():
            poses, several = read_poses(file)
            add("poses", file, poses)
            add("robot_poses", file, several)
        if (file := self._folder / TRAJECTORIES).is_file():
            add("trajectories", file, read_trajectories(file, states))
        return found


class LocalMessages:
    """Implements `grip_bt.base.ports.Messages` within this process.

    Args:
        saved: called after each `save`, which writes them somewhere; None when there is nowhere.
    """

    def __init__(self, library: MessageLibrary, saved: Callable[[], int] | None = None):
        self.library, self.saved = library, saved

    def put(self, store: str, name: str, value: object, provenance: str = "") -> Operation[None]:
        """Add or replace a value; without a name it goes to the end of the store's queue."""

        def work() -> None:
            there = self.library.store(store, make=True)
            if name:
                there.put(name, value, provenance)
            else:
                there.push(value, provenance)

        return _at_once(work)

    def get(self, store: str, name: str) -> Operation[Entry[object]]:
        """Return an entry; without a name the oldest of the store's queue, which is removed."""
        return _at_once(lambda: self.library.store(store).entry(name) if name else self.library.store(store).take())

    def names(self, store: str) -> Operation[tuple[str, ...]]:
        """Return the names in a store."""
        return _at_once(lambda: self.library.store(store).names())

    def delete(self, store: str, name: str) -> Operation[None]:
        """Remove an entry."""
        return _at_once(lambda: self.library.store(store).delete(name))

    def reset(self, store: str = "") -> Operation[None]:
        """Empty a store, or all, and read the project's files again."""
        return _at_once(lambda: self.library.reset(store))

    def save(self) -> Operation[int]:
        """Keep everything for later runs; return how many entries there are."""
        if self.saved is None:
            return Operation.failed(NoEntryError("messages can't be saved outside of a project"))
        return _at_once(self.saved)


def _at_once(work: Callable[[], T]) -> Operation[T]:
    try:
        return Operation.finished(work())
    except UnknownNameError as error:
        return Operation.failed(NoEntryError(str(error), names=list(error.allowed)))
    except ExpectedError as error:
        return Operation.failed(error)
