"""Leaves of a compiled task: manifests and foreign behaviours made, and values copied into and out of subtasks."""

from __future__ import annotations

import inspect
import logging
import sys
from collections.abc import Callable, Iterable
from copy import deepcopy
from importlib import import_module
from typing import Any, cast

from py_trees.behaviour import Behaviour

from grip_bt.base.errors import ImplementationError, InvalidTaskError, NodeError
from grip_bt.base.issue import Issue
from grip_bt.compilers.resolve import Part
from grip_bt.compilers.scopes import UNSET, Cell, Scopes
from grip_bt.nodes.leaf import Leaf
from grip_bt.task import model
from grip_bt.task.catalog import AllowedImports, Manifest, load_implementation
from grip_bt.task.model import Foreign
from grip_bt.task.validation.parts import not_listed

_log = logging.getLogger(__name__)

LeafFactory = Callable[[str, model.Leaf, Manifest], Leaf]
"""(path, what the document says, manifest) -> a leaf, not bound yet."""


def implementation_of(path: str, node: model.Leaf, manifest: Manifest) -> Leaf:
    """Make a leaf of the class that its manifest names, with the defaults of its parameters filled in."""
    defaults = {name: p.default for name, p in manifest.parameters.items() if not p.required}
    implementation = load_implementation(manifest)
    if not issubclass(implementation, Behaviour):  # before it is called: a manifest may name any class there is
        reason = f"{implementation.__name__} is no class of nodes; derive it from `grip_bt.nodes.Leaf`"
        raise ImplementationError(manifest.id, manifest.implementation, reason)
    name = path.rsplit("/", 1)[-1] or manifest.id
    return cast(Leaf, implementation(name, path, manifest, {**defaults, **node.with_}, dict(node.meaning)))


def make_leaf(part: Part, factory: LeafFactory, scopes: Scopes) -> Leaf:
    """Make one leaf and bind its ports to the cells of its variables."""
    node = cast(model.Leaf, part.node)
    assert part.manifest is not None, "resolved leaves have a manifest"
    leaf = factory(part.path, node, part.manifest)
    leaf.name = part.name
    for port, variable in node.in_.items():
        leaf.readers[port] = scopes.reader(part.path, port, part.scope.cell(variable))
    for port, variable in node.out.items():
        leaf.writers[port] = scopes.writer(part.path, port, part.scope.cell(variable))
    return leaf


def prepare(nodes: Iterable[Behaviour], context: object) -> None:
    """Set up nodes, each once.

    Raises:
        NodeError: one raised; it is named.
    """
    for node in nodes:
        try:
            node.setup(context=context)
        except Exception as error:
            raise NodeError(getattr(node, "path", node.name), error) from error


def release(nodes: Iterable[Behaviour]) -> None:
    """Undo `prepare` as far as nodes can; what one raises is logged, since nobody could do anything about it."""
    for node in nodes:
        try:
            node.shutdown()
        except Exception:  # noqa: BLE001 - the run has ended, with a result that this must not replace
            _log.exception("shutdown of %s", getattr(node, "path", node.name))


BehaviourFactory = Callable[[str, str, Foreign], Behaviour]
"""(path, name, what the document says) -> the behaviour of a foreign node."""


def adopter(code: AllowedImports) -> BehaviourFactory:
    """Return what imports and makes the behaviours of foreign nodes, of such code as a project lists."""

    def adopt(path: str, name: str, node: Foreign) -> Behaviour:
        """Return the behaviour of a foreign node.

        Args:
            path: the node's path.
            name: the node's name, which the behaviour gets where its constructor takes a `name` and `args` has none.
            node: what the document says.

        Raises:
            InvalidTaskError: it isn't listed, there is nothing at the import path, it isn't a class of behaviours or a
                function that is listed, it can't be made of these arguments, or what it makes isn't a behaviour.
        """
        make = _maker(path, node.behaviour, code)
        given: dict[str, Any] = dict(node.args)
        try:
            if "name" not in given and "name" in inspect.signature(make).parameters:
                given["name"] = name
            made = make(**given)
        except Exception as error:
            reason = f"{node.behaviour} can't be made of `args`: {type(error).__name__}: {error}"
            raise _refused(path, reason) from error
        if not isinstance(made, Behaviour):
            raise _refused(path, f"{node.behaviour} makes a {type(made).__name__}, not a py_trees Behaviour")
        if made.parent is not None:
            raise _refused(path, f"{node.behaviour} makes a behaviour that is part of another tree already")
        return made

    return adopt


def _maker(path: str, where: str, code: AllowedImports) -> Any:
    """Return what is at an import path, where it may be called."""
    if not code.allows(where):
        trouble = not_listed(where, code.listed)
        raise InvalidTaskError([Issue(path, trouble.code, "error", trouble.message, trouble.fix)])
    found = _found(path, where, code)
    if isinstance(found, type) and issubclass(found, Behaviour):
        return found
    if isinstance(found, type) or not callable(found):
        what = "a class" if isinstance(found, type) else f"a {type(found).__name__}"
        raise _refused(path, f"{where} is {what}, and no Behaviour of py_trees; name a class of behaviours")
    if not code.names(where):
        raise _refused(
            path,
            f"{where} is a function, which is called only if the project lists it by its name: "
            f"`code: [{where!r}]` in grip.yaml",
        )
    return found


def _found(path: str, where: str, code: AllowedImports) -> Any:
    module, _, attributes = where.partition(":")
    if code.folder is not None and code.is_third_party(where) and str(code.folder) not in sys.path:
        sys.path.append(str(code.folder))  # last: nothing in a project takes the place of what is installed
    try:
        found: Any = import_module(module)
        for attribute in attributes.split("."):
            found = getattr(found, attribute)
    except Exception as error:
        raise _refused(path, f"{where} can't be imported: {type(error).__name__}: {error}") from error
    return found


def _refused(path: str, message: str) -> InvalidTaskError:
    return InvalidTaskError([Issue(path, "unknown-behaviour", "error", message)])


_Move = tuple[Callable[[], Any], Callable[[Any], None]]


def variables_of(part: Part, scopes: Scopes) -> tuple[Callable[[], None] | None, Callable[[], None] | None]:
    """Return what a container calls when it is entered, and when it has ended by itself: its variables begin anew."""
    if isinstance(part.node, model.Subtask):
        return _hand_in(part, scopes), _hand_out(part, scopes)
    return (part.scope.reset if part.declares else None), None


def _hand_in(part: Part, scopes: Scopes) -> Callable[[], None]:
    """Return what begins the variables of a subtask anew and gives it its inputs."""
    node = part.node
    assert isinstance(node, model.Subtask), "only these have ports of their own file"
    moves: list[_Move] = []
    for port, variable in node.in_.items():
        read = scopes.reader(part.path, port, part.around.cell(variable))
        moves.append((read, scopes.writer(part.path, port, part.scope.cell(port))))
    for port, literal in node.with_.items():
        moves.append((_copies(literal), scopes.writer(part.path, port, part.scope.cell(port))))

    def enter() -> None:
        part.scope.reset()
        _carry_out(part.path, moves)

    return enter


def _hand_out(part: Part, scopes: Scopes) -> Callable[[], None]:
    """Return what gives the outputs of a subtask to the variables around it; an output that wasn't made is none."""
    node = part.node
    assert isinstance(node, model.Subtask), "only these have ports of their own file"
    bound = [
        (part.scope.cell(port), scopes.writer(part.path, port, part.around.cell(variable)))
        for port, variable in node.out.items()
    ]

    def leave() -> None:
        _carry_out(part.path, [(_value(cell), write) for cell, write in bound if cell.value is not UNSET])

    return leave


def _carry_out(path: str, moves: list[_Move]) -> None:
    try:
        for read, write in moves:
            write(read())
    except Exception as error:
        raise NodeError(path, error) from error


def _value(cell: Cell) -> Callable[[], Any]:
    return lambda: cell.value


def _copies(literal: object) -> Callable[[], Any]:
    return lambda: deepcopy(literal)
