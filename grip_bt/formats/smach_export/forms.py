"""What a node becomes in SMACH, and the userdata and legacy states that it is made of."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

from grip_bt.base.expression import parse_expression
from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.machine_table import chooses, counts, interrupts
from grip_bt.compilers.resolve import Part
from grip_bt.compilers.scopes import Cell, Scope
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
    """How a legacy state is made; its key -> variable, outcome of the leaf -> that of the state, where they differ."""

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
    own = {s.name for s in tree.body if isinstance(s, ast.FunctionDef)}  # only leaves.py has them
    plain = {n: s for n, s in found.items() if not own & {x.id for x in ast.walk(s) if isinstance(x, ast.Name)}}
    return {name: (source, modules) for name, source in plain.items()}


def _made(body: list[ast.stmt]) -> ast.expr | None:
    for statement in body:
        match statement:
            case ast.Expr(ast.Constant(str())):
                continue
            case ast.FunctionDef("make", body=[ast.Return(ast.expr() as made)]):
                return made
        return None
    return None


SmachForm = Literal["state", "tree", "machine", "items", "concurrence"]
"""A legacy state; a tree in a state; containers: StateMachine, Iterator, Concurrence."""


def outcome_map(part: Part) -> tuple[dict[str, dict[str, str]], str] | None:
    """Return rules as outcome -> {child: its outcome}, and the outcome of the rest; None where no map says the same."""
    node = part.node
    assert isinstance(node, model.Parallel), "only these join"
    obeyed = {child.name for child in part.children if is_obeyed(child)}
    rules = [rule for rule in node.rules if not set(rule.when) & obeyed]
    plain = all(isinstance(said, str) for rule in rules for said in rule.when.values())
    if not rules or part.exits or not plain or any(rule.at_least is not None for rule in node.rules):
        return None
    *rules, rest = rules
    mapped = {rule.then: {child: str(said) for child, said in rule.when.items()} for rule in rules}
    sizes = [len(rule.when) for rule in rules]
    if rest.when or len(mapped) < len(rules) or 0 in sizes or sizes != sorted(sizes, reverse=True):
        return None
    return mapped, rest.then


def _is_legacy(part: Part) -> bool:
    """Tell whether all that is below are legacy states, which SMACH's containers were once made for."""
    leaves = (below for below in part.walk() if not below.children)
    return all(is_next_item(leaf) or is_obeyed(leaf) or legacy_state(leaf) is not None for leaf in leaves)


def smach_form(part: Part, needed: Refined) -> SmachForm:
    """Return what a node becomes; `needed`: (outcome, code) pairs for which its parent has an edge."""
    node = part.node
    if isinstance(node, model.Leaf):
        return "tree" if legacy_state(part) is None else "state"
    if isinstance(node, model.Foreign | model.Subtask) or node.precondition or interrupts(part):
        return "tree"
    if chooses(part) and not isinstance(node, model.Switch | model.Loop):
        return "tree"
    if isinstance(node, model.Parallel):
        by_code = any(code is not None for (_, _, code), _ in part.exits)
        said = outcome_map(part) is not None and _is_legacy(part)
        return "concurrence" if said and not needed and not by_code and not shares(part) else "tree"
    if counts(part) and needed:
        return "tree"
    if not _hands_out_items(part):
        return "machine"
    return "items" if _is_legacy(part) else "tree"


def _hands_out_items(part: Part) -> bool:
    """Tell whether a machine is what an import makes of an Iterator."""
    if not isinstance(part.node, model.StateMachine):
        return False
    steps = {child.name: child.node.on for child in part.children if is_next_item(child)}
    others = [child for child in part.children if not is_next_item(child)]
    if len(others) != 1 or part.node.initial not in steps:
        return False
    (other,) = others
    state = legacy_state(other)
    named = names_inside(state, {**reads(part), **writes(part)}) is not None
    plain = named and (state is None or not state.outcomes)
    ended = steps[part.node.initial].get("exhausted", "")
    alike = all(on.get("item") == other.name and on.get("exhausted") == ended for on in steps.values())
    rest = {label: target for label, target in other.node.on.items() if target not in steps}
    return plain and alike and rest.get(ended, ended) == ended
