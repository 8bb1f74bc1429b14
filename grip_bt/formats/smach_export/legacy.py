"""What SMACH's states know a task by: the userdata that a node reads and writes, and the legacy states of leaves."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from grip_bt.base.expression import parse_expression
from grip_bt.compilers.resolve import Part
from grip_bt.compilers.scopes import Cell, Scope
from grip_bt.nodes.smach_asking import CONSTANT, MARK
from grip_bt.task import model

NEXT_ITEM = "grip_bt.nodes.smach_leaf:NextItem"
OBEYED = "grip_bt.nodes.smach_leaf:Obeyed"
_LOADER = "load_legacy"


def reads(part: Part) -> dict[str, Cell]:
    """Return the variables around a node that it, or something below it, reads."""
    return _outside(part, _read(part))


def writes(part: Part) -> dict[str, Cell]:
    """Return the variables around a node that it, or something below it, writes."""
    return _outside(part, _written(part))


def shares(part: Part) -> bool:
    """Tell whether a child of a parallel writes what a sibling of it reads or writes."""
    for child in part.children:
        mine = {id(cell) for cell in writes(child).values()}
        for other in part.children:
            theirs = {**reads(other), **writes(other)}
            if other is not child and mine & {id(cell) for cell in theirs.values()}:
                return True
    return False


def _outside(part: Part, used: Iterator[tuple[Scope, str]]) -> dict[str, Cell]:
    own = {id(cell) for below in part.walk() if below.declares for cell in below.scope.cells.values()}
    found: dict[str, Cell] = {}
    for scope, name in used:
        cell = scope.find(name)
        if cell is not None and id(cell) not in own:
            found[name] = cell
    return found


def _read(part: Part) -> Iterator[tuple[Scope, str]]:
    for below in part.walk():
        node = below.node
        for key, text in model.expressions_of(node):
            scope = below.around if key == "precondition" else below.scope
            yield from ((scope, name) for name in parse_expression(text).names)
        if isinstance(node, model.Leaf | model.Subtask):
            yield from ((below.around, name) for name in node.in_.values())
        if isinstance(node, model.ForEach):
            yield below.scope, node.items


def _written(part: Part) -> Iterator[tuple[Scope, str]]:
    for below in part.walk():
        if isinstance(below.node, model.Leaf | model.Subtask):
            yield from ((below.around, name) for name in below.node.out.values())


@dataclass(frozen=True)
class LegacyState:
    """How a legacy state is made: an expression in the names of modules and `self.built(...)`.

    `remapping`: its key -> variable, `outcomes`: outcome of the leaf -> that of the state, where they differ.
    """

    source: ast.expr
    modules: dict[str, Path]
    remapping: dict[str, str]
    outcomes: dict[str, str]


def legacy_state(part: Part) -> LegacyState | None:
    """Return how the state of a leaf is made; None where the leaf is more than a legacy state, or another kind."""
    node, manifest = part.node, part.manifest
    if not isinstance(node, model.Leaf) or manifest is None or node.precondition:
        return None
    where, _, name = manifest.implementation.rpartition(":")
    made = _classes(Path(where)).get(name) if where.endswith(".py") else None
    if made is None or any(node.in_.get(k, v) != v for k, v in node.out.items()):
        return None
    ports = {*manifest.inputs, *manifest.outputs}
    if not ports <= {*node.in_, *node.out}:  # a key of the state that nothing is bound to isn't the parent's
        return None
    bound = {**node.in_, **node.out}
    source, modules = made
    renamed = node.x.get("x-outcomes")
    outcomes = dict(renamed) if isinstance(renamed, dict) else {}
    return LegacyState(source, modules, {k: v for k, v in bound.items() if k != v}, outcomes)


def is_next_item(part: Part) -> bool:
    """Tell whether a leaf hands out the items of what was an Iterator."""
    return part.manifest is not None and part.manifest.implementation == NEXT_ITEM


def is_obeyed(part: Part) -> bool:
    """Tell whether a leaf ends what was a Concurrence when it is preempted, which SMACH's does by itself."""
    return part.manifest is not None and part.manifest.implementation == OBEYED


def names_inside(state: LegacyState | None, variables: Iterable[str]) -> dict[str, str] | None:
    """Return variable -> key of an Iterator around a state; None where two variables would be one key."""
    keys = {variable: key for key, variable in state.remapping.items()} if state is not None else {}
    names = {variable: keys.get(variable, variable) for variable in variables}
    return names if len(set(names.values())) == len(names) else None


def constants_before(part: Part) -> dict[str, tuple[str, dict[str, object]]]:
    """Return, for each state of a machine that only sets constants, the state that they are for, and the constants."""
    steps: dict[str, tuple[str, dict[str, object]]] = {}
    for child in part.children:
        node = child.node
        if isinstance(node, model.Leaf) and node.x.get(MARK) == CONSTANT:
            steps[child.name] = node.on["success"], {node.out["value"]: node.with_["value"]}
    found = {}
    for name, (target, constants) in steps.items():
        while target in steps:
            target, more = steps[target]
            constants = {**constants, **more}
        found[name] = target, constants
    return found


@cache
def _classes(file: Path) -> dict[str, tuple[ast.expr, dict[str, Path]]]:
    """Return class -> what its `make` returns, and the legacy files that this names."""
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (OSError, SyntaxError, ValueError):
        return {}
    modules: dict[str, Path] = {}
    found = {}
    for statement in tree.body:
        match statement:
            case ast.Assign(
                [ast.Name(name)], ast.Call(ast.Name(loader), [ast.BinOp(_, ast.Div(), ast.Constant(path))])
            ):
                if loader == _LOADER:
                    modules[name] = (file.parent / str(path)).resolve()
            case ast.ClassDef(name, [ast.Name("SmachLeaf")], body=body):
                source = _made(body)
                if source is not None:
                    found[name] = source
    return {name: (source, modules) for name, source in found.items()}


def _made(body: list[ast.stmt]) -> ast.expr | None:
    """Return what `make` returns, where that is all that the class says."""
    for statement in body:
        match statement:
            case ast.Expr(ast.Constant(str())):
                continue
            case ast.FunctionDef("make", body=[ast.Return(ast.expr() as made)]):
                return made
        return None
    return None
