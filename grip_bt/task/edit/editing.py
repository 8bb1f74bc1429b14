"""An edit under way: the draft that a task becomes, what commands look at, and the steps that they take."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, ValidationError

from grip_bt.base.errors import EditError, listing, nearest
from grip_bt.base.types import Value
from grip_bt.base.yaml.models import diagnostic_of
from grip_bt.base.yaml.tree import YamlMapping, from_data
from grip_bt.task.canonical import file_data
from grip_bt.task.document import CHILDREN
from grip_bt.task.edit.steps import Assign, Drop, Place, Put, Rekey, Shift, Step, is_head, is_record
from grip_bt.task.model import AnyNode, StateMachine, Task, children_of, join, kind_of, walk
from grip_bt.task.parts import FREE_PREFIX


class Draft:
    """The data of a task's file, in mappings and lists of its own."""

    def __init__(self, task: Task):
        self._top: dict[str, object] = file_data(task)

    def mapping(self, at: Place) -> dict[str, object]:
        """Return the mapping at a place, to read; or the list, whose keys are `0`, `1` ...

        Raises:
            EditError: there is none.
        """
        current: Any = self._top
        for depth, key in enumerate(at):
            if not _has(current, key):
                raise EditError("/".join(at[:depth]), f"there is no {key!r}")
            current = current[_index(current, key)]
            if not isinstance(current, dict | list):
                raise EditError("/".join(at[:depth]), f"{key!r} holds nothing")
        return current  # type: ignore[no-any-return]

    def apply(self, step: Step) -> None:
        """Do one step. Raises EditError: an entry isn't there, or is there already; nothing is changed."""
        inside = self.mapping(step.at)
        if isinstance(step, Put):
            _expect(inside, step.at, step.key, False)
            _insert(inside, step.at, step.key, file_data(step.value), step.index)
            return
        if not is_head(step):
            _expect(inside, step.at, step.key, True)
        if isinstance(step, Drop):
            inside.pop(step.key)
        elif isinstance(step, Assign):
            inside[_index(inside, step.key)] = file_data(step.value)
        elif isinstance(step, Rekey):
            _expect(inside, step.at, step.to, False)
            entries = [(step.to if key == step.key else key, value) for key, value in inside.items()]
            inside.clear()
            inside.update(entries)
        elif isinstance(step, Shift):
            self._shift(inside, step)

    def _shift(self, inside: dict[str, object], step: Shift) -> None:
        if step.to[: len(step.at) + 1] == (*step.at, step.key):
            raise EditError("/".join(step.at), f"{step.key!r} can't go into itself")
        into = self.mapping(step.to)
        if into is not inside:
            _expect(into, step.to, step.key, False)
        _insert(into, step.to, step.key, inside.pop(step.key), step.index)

    def task(self, where: str) -> Task:
        """Return the task that the draft has become.

        Raises:
            EditError: it isn't one; `where` is what the message speaks about.
        """
        try:
            return Task.model_validate(self._top, strict=True, by_name=False)
        except ValidationError as error:
            tree = from_data(self._top)
            assert isinstance(tree, YamlMapping), "a file is a mapping"
            faults = "; ".join(dict.fromkeys(diagnostic_of(tree, e)[0] for e in error.errors()))
            raise EditError(where, faults) from None


def _index(inside: object, key: str) -> Any:
    return int(key) if isinstance(inside, list) else key


def _has(inside: Collection[object], key: str) -> bool:
    return key.isdecimal() and int(key) < len(inside) if isinstance(inside, list) else key in inside


def _insert(mapping: dict[str, object], at: Place, key: str, value: object, index: int | None) -> None:
    ordered = [k for k in mapping if not is_record(at) or (key.startswith(FREE_PREFIX) and k.startswith(FREE_PREFIX))]
    following = [] if index is None else ordered[index:]
    moved = [(k, mapping.pop(k)) for k in following]
    mapping[key] = value
    mapping.update(moved)


def _expect(mapping: dict[str, object], at: Place, key: str, present: bool) -> None:
    if _has(mapping, key) != present:
        where = "/".join(at) or "the task"
        raise EditError(where, f"there is no {key!r}" if present else f"there is a {key!r} already")


class Edit:
    """A task, the draft that it becomes, and the steps taken.

    `task` is as it was before the command; `draft` is as it is now.
    """

    def __init__(self, task: Task):
        self.task = task
        self.draft = Draft(task)
        self.steps: list[Step] = []

    def take(self, step: Step) -> None:
        self.draft.apply(step)
        self.steps.append(step)

    def put(self, at: Place, key: str, value: object, index: int | None = None) -> None:
        """Add an entry; an index beyond the last is the end."""
        self.take(Put(at=at, key=key, value=value, index=index))

    def drop(self, at: Place, key: str) -> None:
        """Remove an entry."""
        self.take(Drop(at=at, key=key))

    def rekey(self, at: Place, key: str, to: str) -> None:
        """Rename an entry."""
        if key != to:
            self.take(Rekey(at=at, key=key, to=to))

    def shift(self, at: Place, key: str, to: Place, index: int | None = None) -> None:
        """Move an entry."""
        self.take(Shift(at=at, key=key, to=to, index=index))

    def set(self, at: Place, key: str, value: object) -> None:
        """Give an entry a value, whether or not it is there."""
        inside = self.draft.mapping(at)
        if key not in inside:
            self.put(at, key, value)
        elif isinstance(value, dict | list) or type(inside[key]) is not type(value) or inside[key] != value:
            self.take(Assign(at=at, key=key, value=value))

    def set_in(self, at: Place, field: str, key: str, value: object) -> None:
        """Give an entry of a field that is a mapping a value, and the record at `at` the field where it has none."""
        if field in self.draft.mapping(at):
            self.set((*at, field), key, value)
        else:
            self.put(at, field, {key: value})

    def drop_in(self, at: Place, field: str, key: str) -> None:
        """Remove an entry of a field that is a mapping, and the field with its last entry."""
        if len(self.draft.mapping((*at, field))) == 1 and key in self.draft.mapping((*at, field)):
            self.drop(at, field)
        else:
            self.drop((*at, field), key)

    def entries(self, at: Place, field: str) -> dict[str, Value]:
        """Return a copy of a field that is a mapping; empty where the record at `at` has none."""
        if field not in self.draft.mapping(at):
            return {}
        return dict(self.draft.mapping((*at, field)))

    # --- nodes, as they were before the command -------------------------------------------------------------------

    def node(self, path: str) -> AnyNode:
        """Return the node at a path; EditError where there is none."""
        node = self.task.root
        if path == "/":
            return node
        for name in path.split("/"):
            below = children_of(node)
            if name not in below:
                paths = [p for p, _ in walk(self.task.root)]
                raise EditError(path, f"there is no such node{nearest(path, paths)}")
            node = below[name]
        return node

    def container(self, path: str) -> AnyNode:
        """Return the container at a path; EditError where there is none, or a leaf is there."""
        node = self.node(path)
        if not slot(node):
            raise EditError(path, f"a {kind_of(node)} holds no nodes; wrap it in a container first")
        return node

    def place(self, path: str) -> Place:
        """Return the place of the node at a path; of the task for an empty path."""
        if path == "":
            return ()
        self.node(path)
        node: AnyNode = self.task.root
        place: Place = ("root",)
        for name in path.split("/") if path != "/" else ():
            place = (*place, slot(node), name)
            node = children_of(node)[name]
        return place

    def parent(self, path: str, why: str) -> tuple[str, str, AnyNode]:
        """Return path and node of the container of a node, and the node's name: (path, name, container).

        Raises:
            EditError: the node is the root; the message ends with `why`.
        """
        self.node(path)
        if path == "/":
            raise EditError(path, f"the root {why}")
        above, _, name = path.rpartition("/")
        return above or "/", name, self.node(above or "/")


def slot_of(shape: type[BaseModel]) -> str:
    """Return the key under which containers of a model have their children, `children` or `child`; empty for others."""
    return next((key for key in CHILDREN if key in shape.model_fields), "")


def slot(container: AnyNode) -> str:
    """Return the key under which a container has its children."""
    return slot_of(type(container))


def expect_free(container: AnyNode, path: str, name: str) -> None:
    """Refuse a child's name that is taken."""
    below = children_of(container)
    if name in below:
        raise EditError(join(path, name), f"the name is taken (available: {listing(below)}); choose another")


def expect_room(container: AnyNode, path: str) -> None:
    """Refuse a further child of a decorator."""
    if hasattr(container, "child"):
        raise EditError(
            path, f"a {kind_of(container)} has one child; wrap that child in a sequence, and add to the sequence"
        )


def expect_others(container: AnyNode, path: str) -> None:
    """Refuse that the last child leaves where one is needed."""
    if len(children_of(container)) == 1 and (hasattr(container, "child") or isinstance(container, StateMachine)):
        kind = kind_of(container)
        raise EditError(path, f"a {kind} needs a child; remove or unwrap the {kind} instead")


_PATHS = ("path", "parent")
"""Fields of commands that hold a node's path."""


class BaseCommand(BaseModel):
    """An edit of a task, as a value: the same in Python, on the wire and in a history."""

    # built on first use: whoever only runs tasks needs none of it
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    words: ClassVar[str] = ""
    """What it does in a few words, with its fields in braces."""

    def in_words(self) -> str:
        """Return the command in a few words, such as `rename look to see`."""
        return self.words.format_map({key: path_in_words(value) if key in _PATHS else value for key, value in self})

    def plan(self, edit: Edit) -> None:
        """Take the steps of which the command consists; EditError where it can't be carried out."""
        raise NotImplementedError


class PathCommand(BaseCommand):
    """An edit of the node at `path`; of the task where that is empty, if a task has what is changed."""

    path: str


def path_in_words(path: str) -> str:
    """Return a node's path as titles say it."""
    return {"": "the task", "/": "the root"}.get(path, path)


def kind_in_words(kind: str) -> str:
    """Return a kind with its article, such as `a state machine`."""
    words = kind.replace("_", " ")
    return f"an {words}" if words[:1] in "aeiou" else f"a {words}"
