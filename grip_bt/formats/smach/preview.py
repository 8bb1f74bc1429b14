"""What a legacy file shows without being run: where it makes containers, and a preview of what they are.

A preview takes the text by its word: `with sm:` and `add` with literals, in the order of their lines. It is `partial`.
"""

from __future__ import annotations

import ast
import inspect
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from grip_bt import smach_compat
from grip_bt.nodes.smach_construction import Construction
from grip_bt.nodes.smach_source import read_source
from grip_bt.smach_compat import Container, State
from grip_bt.smach_compat._settings import hooks

from .facts import facts_of
from .found import CONTAINERS, FIXED_OUTCOMES, ContainerInfo, Way

_CALLED = ("it", "outcome_cb", "child_termination_cb")
"""Arguments that may be functions; `object` stands for those that the text doesn't show."""
_PREVIEW = "a preview of the text: whether it is so shows when it is built, with --execute"


@dataclass(frozen=True)
class Place:
    """Where a text makes a container, or has a class of them (`cls`); `around`: the function or class that it is in."""

    kind: str
    line: int
    end_line: int
    cls: str = ""
    around: str = ""


def places_of(tree: ast.Module) -> list[Place]:
    """Return where a file makes containers."""
    found, left_open = [], never_filled(tree)
    for around in tree.body:
        name = getattr(around, "name", "") if isinstance(around, (ast.ClassDef, ast.FunctionDef)) else ""
        for node in ast.walk(around):
            if isinstance(node, ast.ClassDef) and node.name not in left_open and (kind := _kind_of_class(node)):
                found.append(Place(kind, node.lineno, node.end_lineno or node.lineno, node.name, name))
            elif isinstance(node, ast.Call) and (kind := _kind(node.func)):
                found.append(Place(kind, node.lineno, node.end_lineno or node.lineno, "", name))
    return found


def never_filled(tree: ast.Module) -> set[str]:
    """Return the classes that open nothing with `with`: a container among them is of a kind that other code fills."""
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    return {cls.name for cls in classes if not any(isinstance(node, ast.With) for node in ast.walk(cls))}


def _kind(node: ast.expr) -> str:
    """Return the container class of smach that an expression names."""
    match node:
        case ast.Name(name) | ast.Attribute(_, name) if name in CONTAINERS:
            if isinstance(node, ast.Name) or ast.unparse(node).startswith("smach."):
                return name
    return ""


def _kind_of_class(node: ast.ClassDef) -> str:
    return next((kind for base in node.bases if (kind := _kind(base))), "")


def preview(file: Path) -> list[ContainerInfo]:
    """Return the containers of a file, as its text shows them.

    Raises:
        DocumentError: it isn't Python.
    """
    body = read_source(file).tree.body
    classes = {node.name: node for node in body if isinstance(node, ast.ClassDef)}
    found = list[ContainerInfo]()
    quiet: dict[str, Any] = dict.fromkeys(("loginfo", "logwarn", "logdebug", "logerr"), lambda text: None)
    with mock.patch.multiple(hooks, **quiet):
        for node in body:
            if isinstance(node, ast.FunctionDef):
                found += _Reader(file, classes).machines(node, node.name)
            if isinstance(node, ast.ClassDef):
                for method in (each for each in node.body if isinstance(each, ast.FunctionDef)):
                    found += _Reader(file, classes).machines(method, node.name, node)
        found += _Reader(file, classes).machines(ast.Module(body, []), "")
    return sorted((each for one in found for each in one.within()), key=lambda each: each.span.line)


class _Reader:
    """Builds the machines that a function, a method or the file itself shows, with states that only have outcomes."""

    def __init__(self, file: Path, classes: dict[str, ast.ClassDef]):
        self.file, self.classes = file, classes
        self.known, self.made = dict[str, Container](), list[tuple[str, Container]]()
        self.places = Construction()

    def machines(self, node: ast.FunctionDef | ast.Module, name: str, cls: ast.ClassDef | None = None) -> Any:
        if cls is not None and getattr(node, "name", "") == "__init__" and (own := _kind_of_class(cls)):
            self._container("self", own, cls.name, cls.lineno, _constructor(node, own))
        self._block(node.body, None)
        ends = (each.value for each in ast.walk(node) if isinstance(each, ast.Return))
        returned = {end.id for end in ends if isinstance(end, ast.Name)}
        given = [] if isinstance(node, ast.Module) else node.args.args[cls is not None :]
        missing = given[: len(given) - len(node.args.defaults)] if isinstance(node, ast.FunctionDef) else []
        inside = {id(child) for _, made in self.made for child in made.get_children().values()}
        for variable, made in self.made:
            if id(made) not in inside:
                found = facts_of(made, self.file, self.places)
                assert isinstance(found, ContainerInfo), "a machine is one"
                direct = variable == "self" or not name or (cls is None and variable in returned)
                names = tuple(argument.arg for argument in missing)
                said = ", ".join(f"{each}=argument({each!r})" for each in names)
                found.way = Way(name or variable, self.file, found.span.line, (said,), names, direct, bool(name))
                for each in found.within():  # what isn't shown may be computed
                    for state in (each, *(child.state for child in each.added.values())):
                        state.issues = []
                    each.problem("partial", _PREVIEW)
                yield found

    def _block(self, body: list[ast.stmt], opened: Container | None) -> None:
        for statement in body:
            match statement:
                case ast.Assign([ast.Name(name)], ast.Call(func) as call) if kind := _kind(func):
                    self._container(name, kind, kind, call.lineno, call)
                case ast.With([ast.withitem(ast.Name(name))], inner) if name in self.known:
                    self._block(inner, self.known[name])
                case ast.Expr(ast.Call(ast.Attribute(_, "add" | "set_contained_state" as method)) as call) if opened:
                    with suppress(Exception), opened.opened():  # such as a label that is there
                        self._add(opened, call, method)
                case ast.FunctionDef() | ast.ClassDef():
                    pass
                case _:
                    for part in ("body", "orelse", "finalbody"):
                        inner = getattr(statement, part, [])
                        self._block(inner if isinstance(inner, list) else [], opened)

    def _container(self, name: str, kind: str, cls: str, line: int, call: ast.Call | None) -> None:
        base = getattr(smach_compat, kind)
        given = {"outcomes": [], "input_keys": [], "output_keys": [], **_literals(base, call)}
        if kind in ("Sequence", "Concurrence"):
            key = "connector_outcome" if kind == "Sequence" else "default_outcome"
            given.setdefault(key, next(iter(given["outcomes"]), ""))
        with suppress(Exception):  # an outcome map that isn't whole, for instance
            made = (base if cls == kind else type(cls, (base,), {}))(**given)
            self.places.places[id(made)] = (str(self.file), line)
            self.known[name] = made
            self.made.append((name, made))

    def _add(self, opened: Container, call: ast.Call, method: str) -> None:
        add = getattr(type(opened), method)
        given = inspect.signature(add).bind(*call.args, **{k.arg or "": k.value for k in call.keywords}).arguments
        label, state = ast.literal_eval(given.pop("label")), given.pop("state")
        rest = {key: value for key, node in given.items() if (value := _literal(node)) is not object}
        made: State | None = self.known.get(state.id) if isinstance(state, ast.Name) else None
        if made is None or made is opened:
            made = self._state(state, list(rest.get("transitions") or ()))
        self.places.added[id(opened), label] = (str(self.file), call.lineno)
        add(label, made, **rest)

    def _state(self, node: ast.expr, ends: list[str]) -> State:
        """Return a state that is called as the text calls its class; without that, it ends as its transitions say."""
        callee = node.func if isinstance(node, ast.Call) else node
        name = ast.unparse(callee).split(".")[-1]
        cls, of_ros = self.classes.get(name), name in FIXED_OUTCOMES
        init = next((n for n in cls.body if getattr(n, "name", "") == "__init__"), None) if cls is not None else None
        said = {"outcomes": FIXED_OUTCOMES[name]} if of_ros else _literals(State, _constructor(init, "State"))
        kind = type(name if name.isidentifier() else "State", (State,), {"__module__": "smach_ros"} if of_ros else {})
        made: Any = kind(**{**said, "outcomes": [*dict.fromkeys((*said.get("outcomes", ()), *ends))]})
        if "outcomes" not in said:
            made.stands_for = name
        self.places.places[id(made)] = (str(self.file), node.lineno)
        state: State = made
        return state


def _constructor(function: Any, kind: str) -> ast.Call | None:
    """Return the call of the base's constructor in one, without `self`."""
    for statement in function.body if function is not None else ():
        match statement:
            case ast.Expr(ast.Call(ast.Attribute(ast.Call(ast.Name("super")), "__init__")) as call):
                return call
            case ast.Expr(ast.Call(ast.Attribute(base, "__init__"), [_, *rest]) as call):
                if ast.unparse(base).endswith(kind):
                    return ast.Call(call.func, rest, call.keywords)
    return None


def _literals(cls: type, call: ast.Call | None) -> dict[str, Any]:
    if call is None:
        return {}
    names = list(inspect.signature(cls).parameters)
    given = dict(zip(names, call.args, strict=False)) | {k.arg: k.value for k in call.keywords if k.arg in names}
    values = {str(name): _literal(node) for name, node in given.items()}
    return {name: value for name, value in values.items() if value is not object or name in _CALLED}


def _literal(node: ast.expr) -> Any:
    """Return a literal's value, and `object` for what is none."""
    try:
        value = ast.literal_eval(node)
    except (ValueError, TypeError, SyntaxError, MemoryError):
        return object
    return list(value) if isinstance(value, tuple) else value
