"""Commands that make a container one of another kind or form, and the edges that a kind implies."""

from __future__ import annotations

from typing import ClassVar, Literal

from grip_bt.base.errors import EditError, listing, nearest
from grip_bt.base.frozen import FrozenDict

from ..document import CHILDREN, keys_of
from ..kind_analysis import following
from ..model import KINDS, AnyNode, Kind, Sequence, StateMachine, children_of, kind_of
from ..parts import FREE_PREFIX
from .editing import Edit, PathCommand, kind_in_words, path_in_words, slot, slot_of

STANDARD = ("success", "failure")


class ChangeKind(PathCommand):
    """A container is of another kind; what both kinds have stays.

    To a state machine, the order of the children becomes edges. From one, edges to its outcomes become `exits`, edges
    between children go. (What does exactly the same in the other form is found by `grip convert --to bt|sm`.)
    """

    do: Literal["change_kind"] = "change_kind"
    kind: str
    fields: FrozenDict[str, object] = FrozenDict()

    def in_words(self) -> str:
        return f"change {path_in_words(self.path)} to {kind_in_words(self.kind)}"

    def plan(self, edit: Edit) -> None:
        node = edit.node(self.path)
        expect_kind(self.path, self.kind)
        if not slot(node) or not slot_of(KINDS[self.kind]):
            raise EditError(self.path, "only a container becomes another container; add a node, or wrap this one")
        names = list(children_of(node))
        new_slot = slot_of(KINDS[self.kind])
        if new_slot == "child" and len(names) != 1:
            held = listing(names, "no child")
            raise EditError(self.path, f"a {self.kind} has one child, this {kind_of(node)} has {held}")
        place = edit.place(self.path)
        if self.kind != kind_of(node):
            _change_edges(edit, node, self)
            edit.set(place, "kind", self.kind)
            allowed = {*keys_of(KINDS[self.kind]), *CHILDREN}
            for key in [k for k in edit.draft.mapping(place) if k not in allowed and not k.startswith(FREE_PREFIX)]:
                edit.drop(place, key)
            if KINDS[self.kind].by_edges and "initial" not in self.fields and names:
                edit.put(place, "initial", names[0])
            edit.rekey(place, slot(node), new_slot)
        for key, value in self.fields.items():
            edit.set(place, key, value)


class _TakesCatalog(PathCommand):
    """A command that needs a catalogue: `apply` takes what `grip_bt.compilers.restructure` makes of it."""

    def plan(self, edit: Edit) -> None:
        name = "extracted" if isinstance(self, Extract) else "expanded"
        what = "a conversion needs" if isinstance(self, Convert) else f"{type(self).__name__.lower()} needs"
        message = f"{what} a catalogue: apply what `grip_bt.compilers.restructure.{name}` returns for it"
        raise EditError(self.path, message)


class Convert(_TakesCatalog):
    """A container and those in it become their equals in the other form, exactly, or stay; see docs/conversion.md."""

    do: Literal["convert"] = "convert"
    path: str
    to: Literal["bt", "sm"]
    """Sequences, fallbacks and repeats; or state machines."""

    def in_words(self) -> str:
        return f"convert {path_in_words(self.path)} to {'composites' if self.to == 'bt' else 'state machines'}"


class Extract(_TakesCatalog):
    """A node with all below it goes to a file of its own, and a subtask that runs that file takes its place."""

    do: Literal["extract"] = "extract"
    words: ClassVar[str] = "extract {path} to {file}"
    path: str
    file: str
    """The new file, relative to the project's folder, such as `tasks/fetch.yaml`."""
    approximate: bool = False
    """Also where somebody can tell that values go in and out at once: what may be halted, or has others beside it."""


def expect_kind(path: str, kind: str) -> None:
    """Refuse a kind that there isn't."""
    if kind not in KINDS:
        raise EditError(path, f"unknown kind {kind!r}{nearest(kind, KINDS)} (available: {listing(KINDS)})")


def edges_of(container: AnyNode) -> dict[str, dict[str, str]]:
    """Return where each child's outcomes lead: outcome -> sibling or outcome of the container, by child.

    In a state machine that is what is written; elsewhere what the kind does with success and failure, and `exits`.
    """
    below = children_of(container)
    if isinstance(container, StateMachine):
        return {name: dict(child.on) for name, child in below.items()}
    edges = chain(container, list(below))
    for key, label in getattr(container, "exits", {}).items():
        name, _, outcome = key.partition(".")
        if name in edges:
            edges[name][outcome] = label
    return edges


def chain(container: AnyNode | None, names: list[str]) -> dict[str, dict[str, str]]:
    """Return the edges by which a container of this kind leads from child to child; those of a sequence for None."""
    kind = container if isinstance(container, Kind) else Sequence(kind=Sequence.kind_name(), children=FrozenDict())
    return {name: {end: following(kind, names, name, end) for end in STANDARD} for name in names}


def _change_edges(edit: Edit, node: AnyNode, command: ChangeKind) -> None:
    place = edit.place(command.path)
    below = (*place, slot(node))
    edges = edges_of(node)
    if KINDS[command.kind].by_edges:
        for name, on in edges.items():
            edit.set((*below, name), "on", on)
        reached = {target for on in edges.values() for target in on.values() if target in STANDARD}
        for label in STANDARD:
            if label in reached and label not in edit.entries(place, "outcomes"):
                edit.set_in(place, "outcomes", label, label)
    elif isinstance(node, StateMachine):
        for name, on in edges.items():
            if "on" in edit.draft.mapping((*below, name)):
                edit.drop((*below, name), "on")
            for outcome, target in on.items():
                if target in node.outcomes and target not in STANDARD and target not in edges:
                    edit.set_in(place, "exits", f"{name}.{outcome}", target)
        for label in STANDARD:
            if label in edit.entries(place, "outcomes"):
                edit.drop_in(place, "outcomes", label)
