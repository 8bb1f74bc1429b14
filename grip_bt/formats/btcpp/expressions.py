"""BT.CPP's scripts in a task: expressions as expressions, assignments as leaves that set or compute a variable."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from grip_bt.formats.btcpp.drafts import Board
from grip_bt.nodes.btcpp import script as s
from grip_bt.nodes.btcpp.script import EPSILON

from .drafts import NodeDraft, container, controlled, failing, named, sequence_of, set_variable, switch

LARGEST = 2**53
NUMBERS = ("int", "float")
_OR, _AND, _NOT, _COMPARE, _SUM, _PRODUCT, _SIGN, _ATOM = range(8)


class Inexact(ValueError):
    """An expression has no exact equivalent; the message says which part, and what to do."""


@dataclass(frozen=True)
class Value:
    """An expression of a task; `Any` is a type that isn't known, `level` how tightly its outermost operator binds."""

    text: str
    type: str
    level: int = _ATOM
    literal: bool = False

    def within(self, level: int) -> str:
        """Return the text as an operand of an operator that binds like `level`."""
        return self.text if self.level >= level else f"({self.text})"


@dataclass
class Translator:
    """Writes scripts as expressions, given what they call a blackboard key, and its type; notes what to know."""

    name_of: Callable[[str], str]
    type_of: Callable[[str], str]
    notes: list[str] = field(default_factory=list)

    def condition(self, script: s.Script) -> Value:
        """Return the expression that is true where BT.CPP casts the script's value to true.

        Raises:
            Inexact: there is none.
        """
        value = self.value(script)
        if value.type == "bool":
            return value
        if value.type == "str":
            raise Inexact(f"the text {value.text} as a condition; compare it with something")
        return Value(f"{value.within(_SUM)} != 0", "bool", _COMPARE)

    def value(self, script: s.Script) -> Value:
        """Return the expression that comes to the script's value.

        Raises:
            Inexact: there is none.
        """
        match script:
            case s.Literal(value=value):
                return literal(value)
            case s.Name(name=name):
                kind = self.type_of(name)
                return Value(self.name_of(name), kind if kind in ("bool", "int", "float", "str") else "Any")
            case s.Unary(sign="-", operand=s.Literal(value=int() | float() as number)) if not isinstance(number, bool):
                return literal(-number)
            case s.Unary(sign="-", operand=operand):
                found = self._number(operand, "-")
                return Value(f"-{found.within(_SIGN)}", found.type, _SIGN)
            case s.Unary(sign="!", operand=operand):
                if isinstance(operand, s.Unary) and operand.sign == "!":
                    return self.condition(operand.operand)
                return Value(f"not {self.condition(operand).within(_NOT)}", "bool", _NOT)
            case s.Binary(sign="&&" | "||"):
                level, word = (_AND, "and") if script.sign == "&&" else (_OR, "or")
                left, right = self.condition(script.left), self.condition(script.right)
                return Value(f"{left.within(level)} {word} {right.within(level + 1)}", "bool", level)
            case s.Binary(sign="+" | "-" | "*" | "/"):
                return self._arithmetic(script)
            case s.Binary(sign=".."):
                return self._joined(script)
            case s.Comparison():
                return self._comparison(script)
            case s.Ternary(condition=asked):
                condition, then, other = self.condition(asked), self.value(script.then), self.value(script.otherwise)
                if (then.type, other.type) != ("bool", "bool"):
                    raise Inexact("`?:` inside of an expression; assign it to a variable of its own")
                yes = f"{condition.within(_AND)} and {then.within(_AND + 1)}"
                return Value(f"{yes} or not {condition.within(_NOT)} and {other.within(_AND + 1)}", "bool", _OR)
            case s.Assignment(target=target):
                raise Inexact(f"the assignment to {target!r} inside of an expression; make it a statement of its own")
        sign = script.sign if isinstance(script, s.Unary | s.Binary) else "?"
        raise Inexact(f"the bit operator `{sign}`, which expressions of a task don't have; use a leaf of your own")

    def _arithmetic(self, script: s.Binary) -> Value:
        if script.sign == "+" and "str" in (self.value(script.left).type, self.value(script.right).type):
            return self._joined(script)
        left, right = self._number(script.left, script.sign), self._number(script.right, script.sign)
        level = _SUM if script.sign in "+-" else _PRODUCT
        if script.sign == "/":
            if right.literal and float(right.text) == 0:
                raise Inexact("a division by zero, which is infinity in BT.CPP and an error here")
            if not right.literal:
                self.notes.append(
                    f"a division by `{right.text}`: where that is 0 the run ends as an error, not at infinity"
                )
        types = {left.type, right.type}
        kind = "float" if script.sign == "/" or "float" in types else "int" if types == {"int"} else "Any"
        return Value(f"{left.within(level)} {script.sign} {right.within(level + 1)}", kind, level)

    def _number(self, script: s.Script, sign: str) -> Value:
        value = self.value(script)
        if value.type in ("bool", "str"):
            what = "truth value" if value.type == "bool" else "text"
            raise Inexact(f"the {what} {value.text} as an operand of `{sign}`, which is for numbers here")
        return value

    def _joined(self, script: s.Binary) -> Value:
        parts = [part.value for part in (script.left, script.right) if isinstance(part, s.Literal)]
        if len(parts) == 2 and all(isinstance(part, str) for part in parts):
            return literal("".join(map(str, parts)))
        raise Inexact("joining texts, which expressions of a task don't do; use a leaf of your own")

    def _comparison(self, script: s.Comparison) -> Value:
        values = [self.value(operand) for operand in script.operands]
        pairs = [self._pair(a, sign, b) for a, sign, b in zip(values, script.signs, values[1:], strict=False)]
        if len(pairs) == 1 or any(pair.startswith("abs(") for pair in pairs):
            return Value(" and ".join(pairs), "bool", _COMPARE if len(pairs) == 1 else _AND)
        text = values[0].within(_SUM)
        for sign, value in zip(script.signs, values[1:], strict=True):
            text += f" {sign} {value.within(_SUM)}"
        return Value(text, "bool", _COMPARE)

    def _pair(self, left: Value, sign: str, right: Value) -> str:
        types = {left.type, right.type}
        if "str" in types and not types <= {"str", "Any"}:
            raise Inexact(f"comparing {left.text} with {right.text}: one is a text, the other a number")
        plain = f"{left.within(_SUM)} {sign} {right.within(_SUM)}"
        if sign not in ("==", "!=") or types <= {"bool", "int", "str"}:
            return plain
        if "float" in types:
            if "bool" in types:
                raise Inexact(f"comparing {left.text} with {right.text}: one is a truth value, the other a number")
            near = "<=" if sign == "==" else ">"
            return f"abs({left.within(_SUM)} - {right.within(_PRODUCT)}) {near} {EPSILON!r}"
        if "str" not in types:
            unknown = left.text if left.type == "Any" else right.text
            self.notes.append(
                f"`{plain}`: nothing says of which type {unknown!r} is; were it a fraction, BT.CPP would take numbers"
                " within 1.2e-7 for the same"
            )
        return plain


def literal(value: bool | int | float | str) -> Value:
    """Return a literal as an expression.

    Raises:
        Inexact: expressions can't hold it.
    """
    if isinstance(value, bool):
        return Value("true" if value else "false", "bool", literal=True)
    if isinstance(value, str):
        quote = '"' if "'" in value else "'"
        if any(c in value for c in "\\#\n\r\0") or quote in value:
            raise Inexact(f"the text {value!r}, which an expression can't hold")
        return Value(f"{quote}{value}{quote}", "str", literal=True)
    if abs(value) > LARGEST or not math.isfinite(value):
        raise Inexact(f"the number {value}, beyond 2**53, of which BT.CPP keeps the nearest double")
    kind = "int" if isinstance(value, int) else "float"
    return Value(repr(value), kind, _ATOM if value >= 0 else _SIGN, literal=True)


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
    """The scripts of one sub-tree; `note` takes what to know about one."""

    def __init__(self, board: Board, note: Callable[[str], None]):
        self.board, self.note = board, note

    def condition(self, text: str, negated: bool = False) -> Asked:
        """Return what holds where a script's last value does, or where it doesn't.

        Raises:
            ScriptError: it isn't a script.
        """
        *first, last = s.parse_script(text) or [s.Literal(False)]
        try:
            made = [self._statement(statement) for statement in first]
            asked = s.Unary("!", last) if negated else last
            return Asked(made, self._translated(lambda translator: translator.condition(asked)).text, negated)
        except Inexact:
            holds = self.board.variables.new("holds")
            self.board.variables.every[holds].written.append("bool")
            return Asked([self._as_it_is(text, holds)], f"not {holds}" if negated else holds, negated)

    def assignments(self, text: str) -> list[NodeDraft]:
        """Return a node for each assignment of a script, in order, or one for all.

        Raises:
            ScriptError: it isn't a script.
        """
        made = []
        for part, statement in zip(s.parts_of(text), s.parse_script(text), strict=True):
            try:
                made.append(self._statement(statement))
            except Inexact:
                made.append(self._as_it_is(part))
        return made

    def on_halted(self, text: str, node: NodeDraft, meaning: str) -> NodeDraft:
        """Return a node after whose interruption a script is run.

        Raises:
            ScriptError: it isn't a script.
        """
        return controlled(self._as_it_is(text, node="btcpp/OnHalted"), [node], meaning)

    def _as_it_is(self, text: str, holds: str = "", node: str = "btcpp/Script") -> NodeDraft:
        """Return a leaf that runs a script by BT.CPP's own rules."""
        names, assigned, read = s.names_of(s.parse_script(text))
        if len(names) > len(_INPUTS):
            raise Inexact(f"more than {len(_INPUTS)} variables in one script")
        letters = dict(zip(names, _INPUTS, strict=False))
        bound = {letters[name]: self._read(name) for name in names}
        for name in assigned:
            self.board.variables.every[self.board.variable(name)].written.append("Any")
        keys = {"node": node, "with": {"code": s.renamed(text, letters)}}
        keys["in"] = {letters[name]: bound[letters[name]] for name in names if name in read}
        keys["out"] = {**{letters[n]: bound[letters[n]] for n in assigned}, **({"value": holds} if holds else {})}
        return NodeDraft({k: v for k, v in keys.items() if v}, name="script", instant=True)

    def _statement(self, statement: s.Script) -> NodeDraft:
        if not isinstance(statement, s.Assignment):
            raise Inexact("a statement that assigns nothing")
        return self._assignment(statement.target, statement.sign, statement.value)

    def _assignment(self, key: str, sign: str, value: s.Script) -> NodeDraft:
        if isinstance(value, s.Ternary):
            return self._either(key, sign, value)
        if sign not in (":=", "="):
            value = s.Binary(s.Name(key), sign[0], value)
        match value:
            case s.Unary(sign="-", operand=s.Literal(value=int() | float() as number)) if not isinstance(number, bool):
                value = s.Literal(-number)
        variable = self.board.variable(key)
        entry = self.board.variables.every[variable]
        if isinstance(value, s.Literal):
            kind = type(value.value).__name__
            entry.written.append(kind)
            return set_variable(variable, self._fitted(key, value.value, entry.type))
        inputs: dict[str, str] = {}
        computed = self._computed(value, inputs)
        entry.written.append(computed.type)
        if (entry.type == "int" and computed.type == "float") or (
            "bool" in (entry.type, computed.type) and {"int", "float", "str"} & {entry.type, computed.type}
        ):
            raise Inexact(f"{key!r} is of type {entry.type} and is given a {computed.type}")
        keys = {"node": "flow/compute", "with": {"expression": computed.text}}
        bound = {letter: name for name, letter in inputs.items()}
        return NodeDraft({**keys, "in": bound, "out": {"value": variable}}, name=f"compute {variable}", instant=True)

    def _fitted(self, key: str, value: bool | int | float | str, kind: str) -> bool | int | float | str:
        if isinstance(value, bool) and kind in ("int", "float"):
            return int(value)
        if kind == "bool" and not isinstance(value, bool):
            if value in (0, 1):
                return bool(value)
            raise Inexact(f"{key!r} is a truth value and is given {value!r}")
        if kind == "int" and isinstance(value, float):
            raise Inexact(f"{key!r} is a whole number and is given {value!r}")
        return value

    def _either(self, key: str, sign: str, value: s.Ternary) -> NodeDraft:
        condition = self._translated(lambda translator: translator.condition(value.condition)).text
        ways = {"yes": self._assignment(key, sign, value.then), "no": self._assignment(key, sign, value.otherwise)}
        made = switch(condition, {"yes": True, "no": False}, ways, "success")
        made.name = f"choose {self.board.variable(key)}"
        return made

    def _computed(self, value: s.Script, inputs: dict[str, str]) -> Value:
        def letter(key: str) -> str:
            variable = self._read(key)
            if variable not in inputs:
                if len(inputs) == len(_INPUTS):
                    raise Inexact(f"more than {len(_INPUTS)} variables in one expression; compute a part of it before")
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
        variable = self.board.variable(key)
        self.board.variables.every[variable].read.append("Any")
        return variable


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
