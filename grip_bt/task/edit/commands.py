"""What can be done to a task, as values: the same in Python, on the wire and in a history.

Paths are those of nodes (`attempt/grasp`, the root is `/`); where a command may speak about the task itself, its path
is empty. Keys are those of the file (`with`, `in`, `as`).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, TypeAdapter

from grip_bt.base.frozen import FrozenDict

from ..model import Meaning, Name, Variable
from .steps import Step


class _Command(BaseModel):
    # built on first use: whoever only runs tasks needs none of it
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class Add(_Command):
    """A new node in a container."""

    do: Literal["add"] = "add"
    parent: str
    name: Name
    node: FrozenDict[str, Any]
    """The node as it stands in a file, with whatever is below it."""
    index: int | None = Field(default=None, ge=0)
    """Position among the children; None: after the last."""


class Remove(_Command):
    """A node goes, with all below it, and with the edges and exits of its neighbours that name it.

    Where a state machine began with it, the machine begins with its first remaining child.
    """

    do: Literal["remove"] = "remove"
    path: str


class Clip(BaseModel):
    """A copy of a node: what `clip_of` returns, a clipboard holds and `paste` takes."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    name: Name
    node: FrozenDict[str, Any]
    """The node as it stands in a file, with whatever is below it."""
    variables: FrozenDict[Name, Any] = FrozenDict()
    """The declarations of the variables that it uses and that are declared around it."""


class Paste(_Command):
    """A copy of a node goes into a container, of this task or of another one.

    Its name gets a number where it is taken. A variable that it uses is the one of that name and type that is seen
    there; where there is none, it is declared in the container, under a fresh name where the name means something
    else. Edges that lead to nothing there are left out.
    """

    do: Literal["paste"] = "paste"
    parent: str
    clip: Clip
    name: Name | None = None
    index: int | None = Field(default=None, ge=0)
    """Position among the children; None: after the last."""
    variables: Literal["share", "fresh"] = "share"
    """`fresh`: its own variables, even where there are ones of their names and types."""


class Move(_Command):
    """A node goes elsewhere: to another position, or into another container.

    In another container it loses its `on`, and its old neighbours lose what they said about it.
    """

    do: Literal["move"] = "move"
    path: str
    parent: str
    index: int | None = Field(default=None, ge=0)
    """Position among the new parent's children, counted without the node itself; None: after the last."""
    name: Name | None = None
    """Another name, where the new parent has a child of the old one."""


class Rename(_Command):
    """A node is called `name`; `initial`, `on` and `exits` around it follow."""

    do: Literal["rename"] = "rename"
    path: str
    name: Name


class Set(_Command):
    """A key of a node or of the task has a value: `["times"]`, `["with", "arm"]`, `["x-note"]`."""

    do: Literal["set"] = "set"
    path: str
    key: tuple[str, ...] = Field(min_length=1)
    value: Any


class Unset(_Command):
    """A key of a node or of the task goes, so that its default holds."""

    do: Literal["unset"] = "unset"
    path: str
    key: tuple[str, ...] = Field(min_length=1)


class Comment(_Command):
    """A node has another comment in its file; in place of the lines right above it and of the end of its first line."""

    do: Literal["comment"] = "comment"
    path: str
    """Empty for the task, whose comment is the lines at the top of the file."""
    text: str
    """Its lines without `#`; empty for none."""


class Connect(_Command):
    """An outcome of a node leads to `target`.

    In a state machine to a sibling or to an outcome of the machine; at the root to an outcome of the task; in any other
    container to one of its outcomes (an entry of its `exits`).
    """

    do: Literal["connect"] = "connect"
    path: str
    outcome: str
    """An outcome, or `outcome.code`."""
    target: str


class Disconnect(_Command):
    """An outcome of a node leads nowhere any more."""

    do: Literal["disconnect"] = "disconnect"
    path: str
    outcome: str


class Wrap(_Command):
    """Neighbours go into a new container, which takes their place and what leads to them.

    Edges and exits for labels of theirs other than success and failure become outcomes of the new container, so that
    they lead where they led.
    """

    do: Literal["wrap"] = "wrap"
    paths: tuple[str, ...] = Field(min_length=1)
    """Children of one container that stand side by side; or the root alone."""
    kind: str
    name: Name
    """Name of the container; of the child where the root is wrapped, since the root has none."""
    fields: FrozenDict[str, Any] = FrozenDict()
    """Keys of the container that it needs or that differ from defaults: `{times: 3}`."""


class Unwrap(_Command):
    """A container goes and its children take its place."""

    do: Literal["unwrap"] = "unwrap"
    path: str


class ChangeKind(_Command):
    """A container is of another kind; what both kinds have stays.

    To a state machine, the order of the children becomes edges. From one, edges to its outcomes become `exits`, edges
    between children go. (What does exactly the same in the other form is found by `grip convert --to bt|sm`.)
    """

    do: Literal["change_kind"] = "change_kind"
    path: str
    kind: str
    fields: FrozenDict[str, Any] = FrozenDict()


class Convert(_Command):
    """A container and those in it become their equals in the other form, exactly, or stay; see docs/conversion.md.

    What is equal depends on how leaves can end, so this takes a catalogue: `expanded` of
    `grip_bt.compilers.restructure` returns the edit that it comes to, and `apply` refuses it as it is.
    """

    do: Literal["convert"] = "convert"
    path: str
    to: Literal["bt", "sm"]
    """Sequences, fallbacks and repeats; or state machines."""
    approximate: bool = False
    """Of `sm`: reactive composites too, which then aren't the same."""


class Extract(_Command):
    """A node with all below it goes to a file of its own, and a subtask that runs that file takes its place.

    What goes in and out depends on what leaves read and write, so this takes a catalogue: `extracted` of
    `grip_bt.compilers.restructure` returns the file and the edit, and `apply` refuses it as it is.
    """

    do: Literal["extract"] = "extract"
    path: str
    file: str
    """The new file, relative to the project's folder, such as `tasks/fetch.yaml`."""
    approximate: bool = False
    """Also where somebody can tell that values go in and out at once: what may be halted, or has others beside it."""


class Inline(_Command):
    """What is in a subtask's file takes the subtask's place; the reverse of `extract`.

    It takes a catalogue, which knows the file: `expanded` of `grip_bt.compilers.restructure` returns the edit that it
    comes to, and `apply` refuses it as it is.
    """

    do: Literal["inline"] = "inline"
    path: str
    approximate: bool = False
    """As in `extract`."""


class Bind(_Command):
    """A port of a leaf reads from or writes to a variable."""

    do: Literal["bind"] = "bind"
    path: str
    side: Literal["in", "out"]
    port: str
    variable: str


class Unbind(_Command):
    """A port of a leaf has no variable any more."""

    do: Literal["unbind"] = "unbind"
    path: str
    side: Literal["in", "out"]
    port: str


class SetMeaning(_Command):
    """An outcome of a node, or of the task, means success or failure; for a leaf, None is what its manifest says."""

    do: Literal["set_meaning"] = "set_meaning"
    path: str
    outcome: str
    meaning: Meaning | None


class RenameOutcome(_Command):
    """An outcome that a container declares, or (with an empty path) the task, is called `to`.

    What leads to it inside and what leads on from it around the container follows: `exits`, `on` and `rules`. Nothing
    of what the task does changes.
    """

    do: Literal["rename_outcome"] = "rename_outcome"
    path: str
    outcome: str
    to: Name


class Declare(_Command):
    """A new variable of a container, or (with an empty path) of the task."""

    do: Literal["declare"] = "declare"
    path: str
    name: Name
    variable: Variable | str
    index: int | None = Field(default=None, ge=0)


class Undeclare(_Command):
    """A variable goes; nothing may use it any more."""

    do: Literal["undeclare"] = "undeclare"
    path: str
    name: str


class RenameVariable(_Command):
    """A variable is called `to`; the bindings and expressions that see it follow."""

    do: Literal["rename_variable"] = "rename_variable"
    path: str
    name: str
    to: Name


class Group(_Command):
    """Several commands, one gesture: all of them or none."""

    do: Literal["group"] = "group"
    title: str = ""
    commands: tuple[Annotated[AnyCommand, Discriminator("do")], ...]


class Splice(_Command):
    """A piece of a text for another; offsets are characters."""

    start: int
    old: str
    new: str


class Restore(_Command):
    """How a text gets back the very bytes that it had, as long as it is still the one that the edit left."""

    digest: str
    """Of the text that the splices fit."""
    splices: tuple[Splice, ...]


class Patch(_Command):
    """The inverse of a command, in steps; what `apply` and `apply_to_document` return."""

    do: Literal["patch"] = "patch"
    title: str = ""
    steps: tuple[Step, ...]
    restore: Restore | None = None


AnyCommand = (
    Add | Paste | Remove | Move | Rename | Set | Unset | Comment | Connect | Disconnect | Wrap | Unwrap | ChangeKind
    | Convert | Extract | Inline | Bind | Unbind | SetMeaning | Declare | Undeclare | RenameVariable | RenameOutcome
    | Group | Patch
)  # fmt: skip
Command = Annotated[AnyCommand, Discriminator("do")]


@lru_cache(maxsize=1)
def _adapter() -> TypeAdapter[AnyCommand]:
    return TypeAdapter(Command)


def command_of(data: Any) -> AnyCommand:
    """Return the command that JSON-like data describes.

    Raises:
        pydantic.ValidationError: it describes none.
    """
    return _adapter().validate_python(data)
