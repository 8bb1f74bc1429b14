"""Nodes made and bound to variables: leaves, foreign behaviours, conditions; values go into and out of subtasks."""

from __future__ import annotations

import inspect
import logging
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import deepcopy
from functools import partial
from importlib import import_module
from typing import Any, Protocol, cast

from py_trees import decorators
from py_trees.behaviour import Behaviour

from grip_bt.base.errors import ExpressionError, ImplementationError, InvalidTaskError, NodeError, UnknownNameError
from grip_bt.base.evaluation import condition_of, value_of
from grip_bt.base.expression import Expression, parse_expression
from grip_bt.base.issue import Issue
from grip_bt.compilers.resolve import Part, Resolved
from grip_bt.compilers.scopes import UNSET, Scope, Scopes, written
from grip_bt.nodes.answers import Answers
from grip_bt.nodes.foreign import by_path, class_path, give_children
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Condition
from grip_bt.nodes.tree_code import Place, TreeCodeError, find_tree
from grip_bt.task import model
from grip_bt.task.catalog import AllowedImports, Manifest, load_implementation
from grip_bt.task.model import Foreign, Kind
from grip_bt.task.validation.parts import not_listed

_log = logging.getLogger(__name__)

LeafFactory = Callable[[str, model.Leaf, Manifest], Leaf]
"""(path, what the document says, manifest) -> a leaf, not bound yet."""


def implementation_of(path: str, node: model.Leaf, manifest: Manifest) -> Leaf:
    """Make a leaf of the class that its manifest names, with the defaults of its parameters filled in."""
    defaults = {name: p.default for name, p in manifest.parameters.items() if not p.required}
    implementation = load_implementation(manifest)
    if not issubclass(implementation, Behaviour):  # before it is called: a manifest may name any class there is
        reason = f"{implementation.__name__} isn't a class of nodes; derive it from `grip_bt.nodes.Leaf`"
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
    for port in set(leaf.watched) & set(node.in_):
        part.scope.cell(node.in_[port]).watchers.append(partial(leaf.note_write, port))
    for port, variable in node.out.items():
        leaf.writers[port] = scopes.writer(part.path, port, part.scope.cell(variable))
    return leaf


def prepare(nodes: Iterable[Behaviour], context: object) -> None:
    """Set up nodes, each once; a NodeError names the one that raised."""
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


BehaviourFactory = Callable[[str, str, Foreign, Sequence[Behaviour]], Behaviour]
"""(path, name, what the document says, children) -> the behaviour of a foreign node."""


def adopter(code: AllowedImports) -> BehaviourFactory:
    """Return what imports and makes the behaviours of foreign nodes, of such code as a project lists."""
    trees: dict[str, Mapping[str, Behaviour]] = {}

    def adopt(path: str, name: str, node: Foreign, children: Sequence[Behaviour] = ()) -> Behaviour:
        """Return the behaviour of a foreign node.

        Args:
            name: the node's name, which the behaviour gets where its constructor takes a `name` and `args` has none.

        Raises:
            InvalidTaskError: it isn't listed, there is nothing at the import path, it isn't a class of behaviours or a
                function that is listed, it can't be made of these arguments, or what it makes isn't a behaviour.
        """
        if node.built_by:
            if node.built_by not in trees:
                trees[node.built_by] = _built(path, node.built_by, code)
            return _part_of(trees[node.built_by], path, node, children)
        make = _maker(path, node.behaviour, code)
        given: dict[str, Any] = dict(node.args)
        if children:
            given |= {"child": children[0]} if issubclass(make, decorators.Decorator) else {"children": [*children]}
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


def _built(path: str, where: str, code: AllowedImports) -> Mapping[str, Behaviour]:
    if not code.names(where):
        issue = not_listed(where, code.listed)
        raise InvalidTaskError([Issue(path, issue.code, "error", issue.message, issue.fix)])
    _look_in(code, where)
    module, _, name = where.partition(":")
    try:
        return by_path(find_tree(Place(module, name)).tree.root)
    except TreeCodeError as error:
        raise _refused(path, str(error)) from error


def _part_of(tree: Mapping[str, Behaviour], path: str, node: Foreign, children: Sequence[Behaviour]) -> Behaviour:
    made = tree.get(node.at)
    if made is None or class_path(made) != node.behaviour:
        what = "nothing" if made is None else f"a {type(made).__name__}"
        raise _refused(path, f"{node.built_by} builds {what} at {node.at!r}, not {node.behaviour}; import it again")
    made.parent = None
    if len(made.children) != len(children):
        raise _refused(path, f"{node.behaviour} has {len(made.children)} children, and {len(children)} here")
    if children:
        give_children(made, children)
    return made


def _maker(path: str, where: str, code: AllowedImports) -> Any:
    """Return what is at an import path, where it may be called."""
    if not code.allows(where):
        issue = not_listed(where, code.listed)
        raise InvalidTaskError([Issue(path, issue.code, "error", issue.message, issue.fix)])
    found = _found(path, where, code)
    if isinstance(found, type) and issubclass(found, Behaviour):
        return found
    if isinstance(found, type) or not callable(found):
        what = "a class" if isinstance(found, type) else f"a {type(found).__name__}"
        raise _refused(path, f"{where} is {what}, not a Behaviour of py_trees; name a class of behaviours")
    if not code.names(where):
        raise _refused(
            path,
            f"{where} is a function, which is called only if the project lists it by its name: "
            f"`code: [{where!r}]` in grip.yaml",
        )
    return found


def _found(path: str, where: str, code: AllowedImports) -> Any:
    module, _, attributes = where.partition(":")
    _look_in(code, where)
    try:
        found: Any = import_module(module)
        for attribute in attributes.split("."):
            found = getattr(found, attribute)
    except Exception as error:
        raise _refused(path, f"{where} can't be imported: {type(error).__name__}: {error}") from error
    return found


def _look_in(code: AllowedImports, where: str) -> None:
    if code.folder is not None and code.is_third_party(where) and str(code.folder) not in sys.path:
        sys.path.append(str(code.folder))  # last: nothing in a project takes the place of what is installed


def _refused(path: str, message: str) -> InvalidTaskError:
    return InvalidTaskError([Issue(path, "unknown-behaviour", "error", message)])


def variables_of(part: Part, scopes: Scopes) -> tuple[Callable[[], None] | None, Callable[[], None] | None]:
    """Return what a container calls when it is entered, and when it has ended by itself: its variables begin anew.

    A subtask gets its inputs then, and gives its outputs; one that wasn't made is none.
    """
    node, path, inside, around = part.node, part.path, part.scope, part.around
    if not isinstance(node, model.Subtask):
        return (inside.reset if part.declares else None), None
    writers = {port: scopes.writer(path, port, inside.cell(port)) for port in (*node.in_, *node.with_)}
    inputs = {port: scopes.reader(path, port, around.cell(variable)) for port, variable in node.in_.items()}
    outputs = [(inside.cell(port), scopes.writer(path, port, around.cell(v))) for port, v in node.out.items()]

    def enter() -> None:
        inside.reset()
        with _errors_of(path):
            for port, read in inputs.items():
                writers[port](read())
            for port, literal in node.with_.items():
                writers[port](written(inside.cell(port).parsed, deepcopy(literal)))

    def leave() -> None:
        with _errors_of(path):
            for cell, write in outputs:
                if cell.value is not UNSET:
                    write(cell.value)

    return enter, leave


@contextmanager
def _errors_of(path: str) -> Iterator[None]:
    try:
        yield
    except Exception as error:
        raise NodeError(path, error) from error


def bind_condition(path: str, key: str, text: str, scope: Scope, scopes: Scopes) -> Condition:
    """Return the condition at `key` of the node at `path`."""
    expression = parse_expression(text)

    def watch(written: Callable[[], None]) -> None:
        for name in expression.names:
            scope.cell(name).watchers.append(written)

    return Condition(expression.text, condition_of(expression, _readers(path, key, expression, scope, scopes)), watch)


def _readers(path: str, key: str, expression: Expression, scope: Scope, scopes: Scopes) -> dict[str, Callable[[], Any]]:
    return {name: scopes.reader(path, key, scope.cell(name)) for name in expression.names}


def answers_of(part: Part, scopes: Scopes) -> Answers:
    """Return the answers of a run to the kind of a container."""
    assert isinstance(part.node, Kind), "leaves ask nothing"
    answers = Answers(part.path, [child.name for child in part.children], part.exits, part.edges)
    bind_answers(answers, part, part.node, scopes)
    return answers


def bind_answers(answers: Answers, part: Part, kind: Kind, scopes: Scopes) -> None:
    """Bind answers to the cells of the variables that a kind asks for."""
    path, scope = part.path, part.scope
    for key, text in kind.expressions():
        field = next(name for name in (*kind.conditions, *kind.values) if name.rstrip("_") == key)
        if field in kind.conditions:
            condition = bind_condition(path, key, text, scope, scopes)
            answers.conditions[field] = condition.holds
            if kind.reactive:
                condition.watch(answers.written)
        else:
            expression = parse_expression(text)
            answers.readers[field] = value_of(expression, _readers(path, key, expression, scope, scopes))
    for key in kind.reads:
        answers.readers[key] = scopes.reader(path, key, scope.cell(getattr(kind, key)))
    for key in kind.puts:
        answers.writers[key] = scopes.writer(path, key, scope.cell(getattr(kind, key)))


class Compiled(Protocol):
    """A compiled task, tree or machine."""

    data: Scopes
    _resolved: Resolved


def parts_of(compiled: Compiled) -> Mapping[str, Part]:
    """Return every node of a compiled task by path, in document order."""
    return {part.path: part for part in compiled._resolved.root.walk()}


def probe(compiled: Compiled, part: Part, text: str) -> Callable[[], bool]:
    """Return what computes a condition over the variables that a node sees.

    Raises:
        ExpressionError: the text isn't a condition.
        UnknownNameError: it names a variable that isn't declared there or above.
    """
    if not text.strip():
        raise ExpressionError(text, "a condition is missing, such as `count > 3`")
    for name in parse_expression(text).names:
        if part.scope.find(name) is None:
            raise UnknownNameError("variable", name, part.scope.visible(), f"`{text}` at {part.path}")
    return bind_condition(part.path, "if", text, part.scope, compiled.data).holds
