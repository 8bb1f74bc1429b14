"""BT.CPP's scripts in a task: conditions, and assignments as leaves that set or compute a variable."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass

from grip_bt.formats.blackboard import Board
from grip_bt.nodes.btcpp.script import names_of, parse_script, parts_of, renamed

from .drafts import NodeDraft, container, controlled, failing, named, sequence_of, set_variable, switch
from .expressions import Inexact, Translator, Value

_INPUTS = "abcdefgh"


@dataclass(frozen=True)
class Asked:
    """A condition: what is done first, and the expression; `negated`: it holds where the script doesn't."""

    first: list[NodeDraft]
    text: str
    negated: bool = False

    def before(self, node: NodeDraft, meaning: str, **more: object) -> NodeDraft:
        """Return a node with what is done before its condition is asked."""
        if not self.first:
            return node
        made = container("sequence", named([*self.first, NodeDraft(node.keys, node.skips, "do")]), meaning, **more)
        made.instant = node.instant
        return made


class Scripts:
    """The scripts of one sub-tree; `note` takes what to know about one.

    Raises:
        ScriptError: from every method, where a text isn't a script.
    """

    def __init__(self, board: Board, note: Callable[[str], None]):
        self.board, self.note = board, note

    def condition(self, text: str, negated: bool = False) -> Asked:
        """Return what holds where a script's last value does, or where it doesn't."""
        *first, last = parse_script(text) or [ast.Constant(False)]
        try:
            made = [self._statement(statement) for statement in first]
            asked = ast.UnaryOp(ast.Not(), last) if negated else last
            return Asked(made, self._translated(lambda translator: translator.condition(asked)).text, negated)
        except Inexact:
            holds = self.board.variables.new("holds")
            self.board.variables.every[holds].written.append("bool")
            return Asked([self._as_it_is(text, holds)], f"not {holds}" if negated else holds, negated)

    def assignments(self, text: str) -> list[NodeDraft]:
        """Return a node for each assignment of a script, in order, or one for all."""
        made = []
        for part, statement in zip(parts_of(text), parse_script(text), strict=True):
            try:
                made.append(self._statement(statement))
            except Inexact:
                made.append(self._as_it_is(part))
        return made

    def on_halted(self, text: str, node: NodeDraft, meaning: str) -> NodeDraft:
        """Return a node after whose interruption a script is run."""
        return controlled(self._as_it_is(text, node="btcpp/OnHalted"), [node], meaning)

    def _as_it_is(self, text: str, holds: str = "", node: str = "btcpp/Script") -> NodeDraft:
        parse_script(text)
        names, assigned, read = names_of(text)
        if len(names) > len(_INPUTS):
            raise Inexact(f"more than {len(_INPUTS)} variables in one script")
        letters = dict(zip(names, _INPUTS, strict=False))
        bound = {letters[name]: self._read(name) for name in names}
        for name in assigned:
            self.board.entry(name).written.append("Any")
        keys = {"node": node, "with": {"code": renamed(text, letters)}}
        keys["in"] = {letters[name]: bound[letters[name]] for name in names if name in read}
        keys["out"] = {**{letters[n]: bound[letters[n]] for n in assigned}, **({"value": holds} if holds else {})}
        return NodeDraft({k: v for k, v in keys.items() if v}, name="script", instant=True)

    def _statement(self, statement: ast.expr) -> NodeDraft:
        if not isinstance(statement, ast.NamedExpr):
            raise Inexact("a statement that assigns nothing")
        return self._assignment(statement.target.id, statement.value)

    def _assignment(self, key: str, value: ast.expr) -> NodeDraft:
        variable, entry = self.board.variable(key), self.board.entry(key)
        match value:
            case ast.IfExp(test=test, body=then, orelse=otherwise):
                asked = self._translated(lambda translator: translator.condition(test)).text
                ways = {"yes": self._assignment(key, then), "no": self._assignment(key, otherwise)}
                made = switch(asked, {"yes": True, "no": False}, ways, "success")
                made.name = f"choose {variable}"
                return made
            case ast.Constant(value=bool() | int() | float() | str() as said):
                entry.written.append(type(said).__name__)
                return set_variable(variable, self._fitted(said, entry.type))
        inputs: dict[str, str] = {}
        computed = self._computed(value, inputs)
        entry.written.append(computed.type)
        if (entry.type == "int" and computed.type == "float") or (
            "bool" in (entry.type, computed.type) and {"int", "float", "str"} & {entry.type, computed.type}
        ):
            raise Inexact("a value of another type")
        keys = {"node": "flow/compute", "with": {"expression": computed.text}}
        bound = {letter: name for name, letter in inputs.items()}
        return NodeDraft({**keys, "in": bound, "out": {"value": variable}}, name=f"compute {variable}", instant=True)

    def _fitted(self, value: bool | int | float | str, kind: str) -> bool | int | float | str:
        if isinstance(value, bool) and kind in ("int", "float"):
            return int(value)
        if kind == "bool" and value in (0, 1):
            return bool(value)
        if (kind == "bool" and not isinstance(value, bool)) or (kind == "int" and isinstance(value, float)):
            raise Inexact("a value of another type")
        return value

    def _computed(self, value: ast.expr, inputs: dict[str, str]) -> Value:
        def letter(key: str) -> str:
            variable = self._read(key)
            if variable not in inputs:
                if len(inputs) == len(_INPUTS):
                    raise Inexact("too many variables")
                inputs[variable] = _INPUTS[len(inputs)]
            return inputs[variable]

        return self._translated(lambda translator: translator.value(value), letter)

    def _translated(self, work: Callable[[Translator], Value], name: Callable[[str], str] | None = None) -> Value:
        translator = Translator(name or self._read, lambda key: self.board.variables.every[self._read(key)].type)
        value = work(translator)
        for note in dict.fromkeys(translator.notes):
            self.note(note)
        return value

    def _read(self, key: str) -> str:
        self.board.entry(key).read.append("Any")
        return self.board.variable(key)


def after(node: NodeDraft, on_success: list[NodeDraft], on_failure: list[NodeDraft], meaning: str) -> NodeDraft:
    """Return a node with what is done when it has succeeded and when it has failed."""
    made = node
    if on_failure:
        told = failing("then", sequence_of(on_failure, "set"))
        made = container("fallback", {"do": made, "failed": told}, meaning)
    if on_success:
        made = container("sequence", {"do": made, "then": sequence_of(on_success, "set")}, meaning)
    made.name, made.instant = node.name, node.instant
    return made
