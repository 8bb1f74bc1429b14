"""What written tasks are made of: elements, scripts, conditions on how a node has ended; and parallels of all sorts.

A parallel is BehaviorTree.CPP's: its children wait when they have ended, and one more decides on every tick.
"""

from __future__ import annotations

import ast
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from grip_bt.base.errors import NotExpressibleError
from grip_bt.base.expression import CONSTANTS, parse_expression
from grip_bt.compilers.resolve import Part
from grip_bt.nodes.btcpp.script import SIGNS
from grip_bt.task import model
from grip_bt.task.catalog import Manifest
from grip_bt.task.parts import Edges

if TYPE_CHECKING:
    from .lowering import Lowering

TARGET = "BehaviorTree.CPP's XML"
Xml = ET.Element


def xml(tag: str, /, *children: Xml, **said: str) -> Xml:
    """Return an element with others in it."""
    made = ET.Element(tag, said)
    made.extend(children)
    return made


def script(*statements: str, **said: str) -> Xml:
    """Return assignments."""
    return xml("Script", code="; ".join(statements), **said)


def holds(condition: str, **said: str) -> Xml:
    """Return a condition."""
    return xml("ScriptCondition", code=condition, **said)


def chosen(ways: Iterable[tuple[str, str]], other: str) -> str:
    """Return the value of the first way whose condition holds."""
    text = other
    for condition, value in reversed(list(ways)):
        text = f"({condition} ? {value} : {text})"
    return text.removeprefix("(").removesuffix(")") if text.startswith("(") else text


def tells(manifest: Manifest) -> bool:
    """Tell whether a leaf has more to say of its end than success and failure."""
    more = bool(manifest.codes or manifest.outcomes.keys() - {"success", "failure"})
    return more or not manifest.implementation.startswith("grip_bt.")


def leads(
    edges: Edges, child: str, quote: str = "'", outcome: str = "outcome", code: str = "code"
) -> list[tuple[str, str]]:
    """Return conditions on how a child has ended, those with codes first, and where each leads."""
    found = sorted((each for each in edges if each[0][0] == child), key=lambda each: each[0][2] is None)
    return [
        (labelled(label if why is None else f"{label}.{why}", outcome, code), f"{quote}{to}{quote}")
        for (_, label, why), to in found
    ]


def labelled(said: str, outcome: str, code: str) -> str:
    """Return the condition of `outcome` or `outcome.code`."""
    label, _, why = said.partition(".")
    return f"({outcome} == '{label}' && {code} == '{why}')" if why else f"{outcome} == '{label}'"


def any_of(conditions: Iterable[str]) -> str:
    """Return that one of them holds."""
    every = " || ".join(f"({one})" for one in conditions)
    return f"({every})" if every else "false"


def all_of(conditions: Iterable[str]) -> str:
    """Return that all of them hold."""
    every = " && ".join(f"({one})" for one in conditions)
    return f"({every})" if every else "true"


def tag_of(manifest: Manifest) -> str:
    """Return the element that stands for a node of the catalogue."""
    group, _, name = manifest.id.partition("/")
    return name if group in ("btcpp", "nav2") else manifest.id.replace("/", "__")


_LONGEST = 4_294_967.0
"""BehaviorTree.CPP counts milliseconds in 32 bits: 49 days [s]."""


def milliseconds(part: Part, seconds: float) -> str:
    """Return a time [s] in milliseconds. Raises NotExpressibleError: it isn't a whole number of them, or too many."""
    milliseconds = round(min(seconds, _LONGEST) * 1000)
    if milliseconds / 1000 != seconds:
        raise NotExpressibleError(part.path, f"{seconds} s, which isn't a whole number of milliseconds,", TARGET)
    return str(milliseconds)


@dataclass(frozen=True)
class _Branch:
    """A child of a parallel, and the entries that say whether it has ended, with which label, and why."""

    child: Part
    ended: str
    label: str
    code: str

    def means(self, meaning: str) -> str:
        return any_of(f"{self.label} == '{label}'" for label, means in self.child.meaning.items() if means == meaning)


def parallel(work: Lowering, part: Part, node: model.Parallel) -> Xml:
    """Return a parallel."""
    if not part.children:
        raise work.refuse(part, "a parallel without children")
    done, code = work.entry("done"), work.entry("why")
    branches = [_Branch(c, work.entry("ended"), work.entry("label"), work.entry("because")) for c in part.children]
    first = [f"{done} := ''", f"{code} := ''"]
    for each in branches:
        first += [f"{each.ended} := 0", f"{each.label} := ''", f"{each.code} := ''"]
    decide = _decision(part, node, done, code, branches)
    waits, asking = f"{done} == ''", node.cancel == "ask"
    if asking:  # what is decided stays, and is said to all leaves, until they have ended
        asked = work.entry("asked")
        first.append(f"{asked} := false")
        work.asked.append(asked)
        decide = [f"{to} := ({asked} ? {to} : ({value}))" for to, value in (each.split(" := ", 1) for each in decide)]
        decide.append(f"{asked} := ({done} != '')")
        waits += f" || !{all_of(f'{each.ended} == 1' for each in branches)}"
    ways = [_way(work, node, each, decide, done) for each in branches]
    if asking:
        work.asked.pop()
    ways.append(xml("Inverter", xml("KeepRunningUntilFailure", xml("Sequence", script(*decide), holds(waits)))))
    body = xml("ForceSuccess", xml("Parallel", *ways, success_count="1", failure_count=str(len(ways))))
    ending = script(f"outcome := {done}", f"code := {code}")
    return xml("Sequence", script(*first), body, ending, work.verdict(done, part.meaning))


def _way(work: Lowering, node: model.Parallel, branch: _Branch, decide: list[str], done: str) -> Xml:
    note = script(f"{branch.ended} := 1", f"{branch.label} := outcome", f"{branch.code} := code")
    run, idle = xml("ForceSuccess", work.node(branch.child)), xml("KeepRunningUntilFailure", xml("AlwaysSuccess"))
    if node.retick:
        again = xml("Sequence", script(f"{branch.ended} := 0", f"{branch.label} := ''"), run, note)
        return xml("KeepRunningUntilFailure", again)
    if node.prompt:
        idle = xml("Fallback", xml("Sequence", script(*decide), holds(f"{done} != ''")), idle)
    return xml("Sequence", run, note, idle)


def _decision(part: Part, node: model.Parallel, done: str, code: str, branches: list[_Branch]) -> list[str]:
    by_name = {each.child.name: each for each in branches}
    every = all_of(f"{each.ended} == 1" for each in branches)
    number = " + ".join(each.ended for each in branches)
    wait = node.wait_for
    match wait if node.cancel != "join" else "all":
        case None:
            waited = "true"
        case "all":
            waited = every
        case "any":
            waited = f"({number} >= 1)"
        case int(least):
            waited = f"(({number} >= {least}) || {every})"
        case names:
            waited = f"({all_of(f'{by_name[name].ended} == 1' for name in names)} || {every})"
    complete = "true" if wait is not None else every
    exits = [
        (each, *way) for each in branches for way in leads(part.exits, each.child.name, "'", each.label, each.code)
    ]
    ways = [(condition, to) for _, condition, to in exits]
    for rule in node.rules:
        asked = [] if rule.when or rule.at_least is not None else [complete]
        for name, said in rule.when.items():
            each = by_name[name]
            ends = [said] if isinstance(said, str) else said
            asked.append(any_of(labelled(one, each.label, each.code) for one in ends))
        if rule.at_least is not None:
            counts = [f"({each.means(rule.ends)} ? 1 : 0)" for each in branches]
            asked.append(f"({' + '.join(counts)} >= {rule.at_least})")
        ways.append((all_of(asked), f"'{rule.then}'"))
    one, all_ = ("failure", "success") if node.policy == "all" else ("success", "failure")
    natural = [(any_of(each.means(one) for each in branches), f"'{one}'"), (complete, f"'{all_}'")]
    ways += [(f"({complete} && {asked})", to) for asked, to in natural] if node.rules else natural
    why = [(f"({condition} && {done} == {to})", each.code) for each, condition, to in exits]
    why += [(each.means("failure"), each.code) for each in branches]
    return [f"{done} := ({waited} ? ({chosen(ways, _NONE)}) : '')", f"{code} := {chosen(why, _NONE)}"]


_NONE = "''"


def script_of(text: str, type_of: Callable[[str], str], names: Mapping[str, str] | None = None) -> str:
    """Return an expression of a task as a script that comes to the same; `names`: how it calls variables -> these.

    Raises:
        ValueError: BT.CPP has no words for a part of it, or means something else by them.
    """
    return _Writer(type_of, names or {}).text(parse_expression(text).tree)


class _Writer:
    def __init__(self, type_of: Callable[[str], str], names: Mapping[str, str]):
        self.type_of, self.names = type_of, names

    def text(self, node: ast.expr) -> str:
        match node:
            case ast.BinOp(left=left, op=ast.Mod() | ast.FloorDiv() as op, right=ast.Constant(value=int(by))) if by > 0:
                whole = self.inside(left)
                down = f"~(~(({whole}) / {by}))"  # a complement cuts off what is behind the point, towards 0
                rest = f"({whole} - {by} * ({down}))"
                if isinstance(op, ast.Mod):
                    return f"({rest} < 0 ? {rest} + {by} : {rest})"
                return f"({rest} < 0 ? ({down}) - 1 : ({down}))"
            case ast.Call(func=ast.Name(id="abs"), args=[value]):
                said = self.inside(value)
                return f"({said} < 0 ? (0 - {said}) : {said})"
            case ast.Call(func=ast.Name(id="max" | "min" as name), args=[one, *others]) if others:
                made, sign = self.inside(one), ">=" if name == "max" else "<="
                for other in others:
                    made = f"({made} {sign} {self.inside(other)} ? {made} : {self.inside(other)})"
                return made
            case ast.Compare(left=left, ops=[ast.In() | ast.NotIn() as sense], comparators=[ast.List(elts=items)]):
                any_one = " || ".join(f"({self.comparison([left, item], ['=='])})" for item in items) or "false"
                return f"({any_one})" if isinstance(sense, ast.In) else f"!({any_one})"
        return self.plain(node)

    def plain(self, node: ast.expr) -> str:
        match node:
            case ast.Constant(value=bool() as value):
                return str(value).lower()
            case ast.Constant(value=int() | float() as value):
                return repr(value)
            case ast.Constant(value=str() as value) if value.isascii() and value.isprintable():
                if "'" not in value:  # there is no other quote, and no escape
                    return f"'{value}'"
            case ast.Name(id=name) if isinstance(CONSTANTS.get(name), bool):
                return name
            case ast.Name(id=name) if name not in CONSTANTS:
                return self.names.get(name, name)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return f"!{self.inside(operand)}"
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return f"-{self.inside(operand)}"
            case ast.BoolOp(op=op, values=values):
                return (" && " if isinstance(op, ast.And) else " || ").join(self.operand(v) for v in values)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in SIGNS:
                return f"{self.inside(left)} {SIGNS[type(op)]} {self.inside(right)}"
            case ast.Compare(left=left, ops=ops, comparators=others) if all(type(op) in SIGNS for op in ops):
                return self.comparison([left, *others], [SIGNS[type(op)] for op in ops])
        raise ValueError(f"`{ast.unparse(node)}` has no equivalent")

    def comparison(self, operands: list[ast.expr], signs: list[str]) -> str:
        for sign in signs:
            if sign in ("==", "!=") and not all(self.exact(operand) for operand in operands):
                raise ValueError("BT.CPP takes numbers within 1.2e-7 for equal; compare whole numbers, texts or truth")
        text = self.inside(operands[0])
        for sign, operand in zip(signs, operands[1:], strict=True):
            text += f" {sign} {self.inside(operand)}"
        return text

    def exact(self, node: ast.expr) -> bool:
        """Tell whether equality with this operand is the same in both languages."""
        match node:
            case ast.Constant(value=value):
                return isinstance(value, bool | int | str)
            case ast.Name(id=name):
                return name in CONSTANTS or self.type_of(self.names.get(name, name)) in ("int", "bool", "str")
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult() | ast.Mod() | ast.FloorDiv(), right=right):
                return self.exact(left) and self.exact(right)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.exact(operand)
            case ast.Call(args=args):
                return all(map(self.exact, args))
        return False

    def operand(self, node: ast.expr) -> str:
        """Return an operand of `&&` and `||`, which bind equally there."""
        return f"({self.text(node)})" if isinstance(node, ast.BoolOp) else self.text(node)

    def inside(self, node: ast.expr) -> str:
        """Return an operand of anything else."""
        text = self.text(node)
        simple = isinstance(node, ast.Name) or (isinstance(node, ast.Constant) and not text.startswith("-"))
        return text if simple else f"({text})"
