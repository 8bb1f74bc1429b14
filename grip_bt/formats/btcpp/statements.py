"""Scripts as nodes: an assignment becomes a leaf that sets or computes a variable."""

from __future__ import annotations

from collections.abc import Callable

from . import script as s
from .expressions import Inexact, Translator, Value
from .making import Made, Skipping, container, in_turn, set_to, switch
from .names import Board

_INPUTS = "abcdefgh"


class Scripts:
    """The scripts of one sub-tree.

    Args:
        board: where its keys are.
        note: takes what to know about a script.
    """

    def __init__(self, board: Board, note: Callable[[str], None]):
        self.board, self.note = board, note

    def condition(self, text: str) -> str:
        """Return a script's value as a condition.

        Raises:
            ScriptError: it isn't a script.
            Inexact: it has no exact equal.
        """
        statements = s.parse_script(text)
        if len(statements) != 1:
            raise Inexact(f"{len(statements)} statements where one condition is wanted")
        return self._translated(lambda translator: translator.condition(statements[0])).text

    def assignments(self, text: str) -> list[Made]:
        """Return a node for each assignment of a script, in order.

        Raises:
            ScriptError: it isn't a script.
            Inexact: it has no exact equal.
        """
        made = []
        for statement in s.parse_script(text):
            if not isinstance(statement, s.Assignment):
                raise Inexact("a statement that assigns nothing")
            made.append(self._assignment(statement.target, statement.sign, statement.value))
        return made

    def _assignment(self, key: str, sign: str, value: s.Script) -> Made:
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
            return set_to(variable, self._fitted(key, value.value, entry.type))
        inputs: dict[str, str] = {}
        computed = self._computed(value, inputs)
        entry.written.append(computed.type)
        if (entry.type == "int" and computed.type == "float") or (
            "bool" in (entry.type, computed.type) and {"int", "float", "str"} & {entry.type, computed.type}
        ):
            raise Inexact(f"{key!r} is of type {entry.type} and is given a {computed.type}")
        keys = {"node": "flow/compute", "with": {"expression": computed.text}}
        bound = {letter: name for name, letter in inputs.items()}
        return Made({**keys, "in": bound, "out": {"value": variable}}, name=f"compute {variable}", instant=True)

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

    def _either(self, key: str, sign: str, value: s.Ternary) -> Made:
        condition = self._translated(lambda translator: translator.condition(value.condition)).text
        ways = {
            "yes": self._assignment(key, sign, value.then),
            "no": self._assignment(key, sign, value.otherwise),
        }
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


def after(node: Made, on_success: list[Made], on_failure: list[Made], meaning: str) -> Made:
    """Return a node with what is done when it has succeeded and when it has failed."""
    made = node
    if on_failure:
        cause = in_turn(on_failure, "set")
        told = Made({"kind": "force", "as": "failure", "child": {"then": cause.keys}}, instant=True)
        up = Skipping.of(meaning, {"do": made})
        made = container("fallback", {"do": made, "failed": told}, up)
    if on_success:
        up = Skipping.of(meaning, {"do": made})
        made = container("sequence", {"do": made, "then": in_turn(on_success, "set")}, up)
    made.name, made.instant = node.name, node.instant
    return made
