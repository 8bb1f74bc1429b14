"""An edit under way: what commands look at, and the steps that they take."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict

from grip_bt.base.errors import EditError, listing, nearest
from grip_bt.task.edit.draft import Draft
from grip_bt.task.edit.steps import Assign, Drop, Place, Put, Rekey, Shift, Step
from grip_bt.task.model import AnyNode, StateMachine, Task, children_of, join, walk
from grip_bt.task.shape import CHILDREN


class Edit:
    """A task, the draft that it becomes, the steps taken and those that lead back.

    `task` is as it was before the command; `draft` is as it is now.
    """

    def __init__(self, task: Task):
        self.task = task
        self.draft = Draft(task)
        self.steps: list[Step] = []
        self.back: list[Step] = []

    def take(self, step: Step) -> None:
        """Do one step and remember how to undo it."""
        self.back.insert(0, self.draft.apply(step))
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

    def entries(self, at: Place, field: str) -> dict[str, Any]:
        """Return a copy of a field that is a mapping; empty where the record at `at` has none."""
        if field not in self.draft.mapping(at):
            return {}
        return dict(self.draft.mapping((*at, field)))

    # --- nodes, as they were before the command -------------------------------------------------------------------

    def node(self, path: str) -> AnyNode:
        """Return the node at a path.

        Raises:
            EditError: there is none.
        """
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
        """Return the container at a path.

        Raises:
            EditError: there is none, or a leaf is there.
        """
        node = self.node(path)
        if not holds_nodes(node):
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


def slot(container: AnyNode) -> str:
    """Return the key under which a container has its children: `children` or `child`."""
    return "child" if hasattr(container, "child") else "children"


def kind_of(node: AnyNode | Task) -> str:
    """Return a node's kind; `leaf` for a node of the catalogue."""
    return str(getattr(node, "kind", "leaf"))


def holds_nodes(node: AnyNode) -> bool:
    """Tell whether a node is a container."""
    return not type(node).model_fields.keys().isdisjoint(CHILDREN)


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
        """Take the steps of which the command consists.

        Raises:
            EditError: it can't be carried out.
        """
        raise NotImplementedError


def path_in_words(path: str) -> str:
    """Return a node's path as titles say it."""
    return {"": "the task", "/": "the root"}.get(path, path)


def kind_in_words(kind: str) -> str:
    """Return a kind with its article, such as `a state machine`."""
    words = kind.replace("_", " ")
    return f"an {words}" if words[:1] in "aeiou" else f"a {words}"
