"""Tasks made in Python, such as `grip.build("pick", grip.sequence(grip.node("arm/lift"), grip.node("hand/open")))`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import PrivateAttr

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import Project, find_project
from grip_bt.base.errors import InvalidTaskError, UnknownNameError
from grip_bt.base.issue import Issue
from grip_bt.nodes.function import FunctionLeaf, type_name
from grip_bt.nodes.leaf import Leaf
from grip_bt.task import Task, dumps, loads
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.edit.paste import fresh_name
from grip_bt.task.model import KINDS, Variable, type_of

_NOTHING = object()


@dataclass(frozen=True)
class NamedVariable:
    """A variable of a task; `variable` makes it."""

    name: str
    declared: Variable | str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Part:
    """A node with all that is below it, before it is in a task; `node` and the kinds of containers make it.

    Attributes:
        name: the node's name among its siblings; where two have the same, the later gets a number.
        fields: what a task file has.
        variables: those that it and what is below it use.
        leaves: the nodes that are made in this program, which no file of the project has.
    """

    name: str
    fields: Mapping[str, Any]
    variables: tuple[NamedVariable, ...] = ()
    leaves: tuple[Manifest, ...] = field(default=(), repr=False)

    def named(self, name: str) -> Part:
        """Return it with another name."""
        return replace(self, name=name)


class BuiltTask(Task):
    """A task that was made in this program, with the nodes that were made there too."""

    _own_nodes: tuple[Manifest, ...] = PrivateAttr(())


def catalogue_for(task: Task, project: Project | None = None) -> Catalog:
    """Return the nodes of a task's project, and those of the program that made it."""
    found = catalogue_of(project or project_of(task))
    return found.with_manifests(task._own_nodes) if isinstance(task, BuiltTask) else found


def project_of(task: Task) -> Project:
    """Return the project of the file that a task comes from; of a task that was made in Python, that of this folder."""
    return find_project(task.file or Path.cwd())


def variable(name: str, type: object, value: object = _NOTHING, doc: str = "") -> NamedVariable:
    """Return a variable, which a task declares where its nodes use it.

    Args:
        type: a Python type, such as `int`, `list[Grasp]` or `float | None`, or how a task file spells it.
        value: at first; without it, the variable has to be written before it is read.
    """
    spelled = type if isinstance(type, str) else type_name(type)
    if value is _NOTHING:
        return NamedVariable(name, Variable(type=spelled, doc=doc) if doc else spelled)
    return NamedVariable(name, Variable(type=spelled, value=value, doc=doc))


def node(
    id: str | type[Leaf],
    /,
    *,
    out: Mapping[str, NamedVariable] | None = None,
    on: Mapping[str, str] | None = None,
    meaning: Mapping[str, str] | None = None,
    doc: str = "",
    precondition: str = "",
    **ports: Any,
) -> Part:
    """Return a leaf.

    Args:
        id: of the catalogue, such as `arm/lift`, or a function of this program with `grip.leaf`.
        out: output -> variable.
        on: in a state machine, outcome -> the next node, or an outcome of the machine.
        meaning: outcome -> `success` or `failure`, where it differs from the node's own.
        precondition: an expression; where it is false, the node fails at once.
        **ports: input -> variable, or parameter -> literal.

    Raises:
        TypeError: a class that isn't made of a function; it belongs into the project's folder of nodes.
    """
    leaves: tuple[Manifest, ...] = ()
    if not isinstance(id, str):
        if not issubclass(id, FunctionLeaf):
            raise TypeError(f"{id.__name__} is a class: put it into the project's nodes/, and give its id here")
        if "<locals>" in id.face.implementation:
            raise TypeError(f"{id.__name__} is made within a function, where no run finds it; make it outside")
        leaves, id = (id.face,), id.face.id
    bound = {name: given for name, given in ports.items() if isinstance(given, NamedVariable)}
    said = {
        "node": id,
        "with": {name: given for name, given in ports.items() if name not in bound},
        "in": {name: str(given) for name, given in bound.items()},
        "out": {name: str(given) for name, given in (out or {}).items()},
        "meaning": dict(meaning or {}),
        "on": dict(on or {}),
        "precondition": precondition,
        "doc": doc,
    }
    used = (*bound.values(), *(out or {}).values())
    return Part(id.rpartition("/")[2], {key: value for key, value in said.items() if value}, used, leaves)


def container(kind: str, /, *children: Part, **fields: Any) -> Part:
    """Return a container of a kind; `grip.sequence(...)` is `container("sequence", ...)`, and so on for each kind.

    Args:
        children: in order; a decorator, such as `retry`, has one.
        **fields: the kind's own, as a task file has them, and `doc`, `on`, `exits`, `data`, `precondition`. A variable
            stands for its name. What Python has a word for, is written with an underscore: `while_`, `in_`, `with_`.

    Raises:
        UnknownNameError: there is no such kind.
        TypeError: a decorator hasn't one child, or a kind without children has some.
    """
    if kind not in KINDS:
        raise UnknownNameError("kind", kind, KINDS)
    several, one = "children" in KINDS[kind].model_fields, "child" in KINDS[kind].model_fields
    if (one and len(children) != 1) or (children and not one and not several):
        raise TypeError(f"{kind} has {'one child' if one else 'no children'}, not {len(children)}")
    own = [each for each in fields.values() if isinstance(each, NamedVariable)]
    said = {name.rstrip("_"): _plain(value) for name, value in fields.items()}
    declared = {*said.get("data", ()), *(said.get(name) for name in KINDS[kind].puts)}
    if children:
        said["children" if several else "child"] = {name: dict(part.fields) for name, part in _named_apart(children)}
    used = (each for each in (*own, *(v for part in children for v in part.variables)) if each.name not in declared)
    leaves = tuple(each for part in children for each in part.leaves)
    return Part(kind, {"kind": kind, **said}, tuple(used), leaves)


def _plain(value: Any) -> Any:
    if isinstance(value, NamedVariable):
        return value.name
    if isinstance(value, Mapping):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, Sequence) and value and all(isinstance(each, NamedVariable) for each in value):
        return {each.name: each.declared for each in value}  # of `data`
    return value


def _named_apart(parts: Sequence[Part]) -> Iterator[tuple[str, Part]]:
    taken: set[str] = set()
    for part in parts:
        name = fresh_name(part.name, taken)
        taken.add(name)
        yield name, part


def build(
    name: str,
    root: Part,
    *,
    inputs: Sequence[NamedVariable] = (),
    outputs: Sequence[NamedVariable] = (),
    data: Sequence[NamedVariable] = (),
    outcomes: Mapping[str, str] | None = None,
    doc: str = "",
) -> Task:
    """Return a task; `grip.dumps` writes it as the file that a person would have written.

    Args:
        root: its node; its variables that nothing below declares are the task's.
        inputs: variables that are given from outside.
        outputs: variables that are handed out at the end.
        data: variables besides, such as those that only expressions name.
        outcomes: outcome -> `success` or `failure`; these two by default.

    Raises:
        DocumentError, InvalidTaskError: it isn't a task, or two variables of different types have one name.
    """
    declared: dict[str, Variable | str] = {}
    for each in (*inputs, *outputs, *data, *root.variables):
        if declared.setdefault(each.name, each.declared) != each.declared:
            both = f"{type_of(declared[each.name])} and {type_of(each.declared)}"
            fix = "give one of them another name, or use one `grip.variable` for both"
            message = f"two variables are called {each.name!r}: {both}, or with different values"
            raise InvalidTaskError([Issue("", "two-variables", "error", message, fix)], name)
    ports = {each.name for each in (*inputs, *outputs)}
    said = {
        "grip": 1,
        "name": name,
        "doc": doc,
        "outcomes": dict(outcomes or {}),
        "inputs": {each.name: each.declared for each in inputs},
        "outputs": {each.name: each.declared for each in outputs},
        "data": {each: variable for each, variable in declared.items() if each not in ports},
        "root": root.fields,
    }
    made = loads(dumps(Task.model_validate({key: value for key, value in said.items() if value})), name)
    built = BuiltTask.model_construct(**{key: getattr(made, key) for key in made.model_fields_set})
    built._own_nodes = tuple({each.id: each for each in root.leaves}.values())
    return built
