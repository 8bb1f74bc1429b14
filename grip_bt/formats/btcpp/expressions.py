"""BT.CPP's scripts in a task: expressions as expressions, assignments as leaves that set or compute a variable."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass, field

from grip_bt.formats.blackboard import Board
from grip_bt.nodes.btcpp.script import EPSILON, SIGNS, names_of, parse_script, parts_of, renamed

from .drafts import NodeDraft, container, controlled, failing, named, sequence_of, set_variable, switch

LARGEST = 2**53


class Inexact(ValueError):
    """An expression has no exact equivalent: it is computed as the script that it is."""


@dataclass(frozen=True)
class Value:
    """An expression of a task; `Any` is a type that isn't known."""

    tree: ast.expr
    type: str

    @property
    def text(self) -> str:
        """How a task writes it."""
        return ast.unparse(self.tree)


@dataclass
class Translator:
    """Writes scripts as expressions, given what they call a blackboard key, and its type; notes what to know.

    Raises:
        Inexact: from every method, where there is none.
    """

    name_of: Callable[[str], str]
    type_of: Callable[[str], str]
    notes: list[str] = field(default_factory=list)

    def condition(self, script: ast.expr) -> Value:
        """Return the expression that is true where BT.CPP casts the script's value to true."""
        value = self.value(script)
        if value.type == "str":
            raise Inexact("a text as a condition")
        if value.type == "bool":
            return value
        return Value(ast.Compare(value.tree, [ast.NotEq()], [ast.Constant(0)]), "bool")

    def value(self, script: ast.expr) -> Value:
        """Return the expression that comes to the script's value."""
        match script:
            case ast.Constant():
                return literal(script)
            case ast.Name(id=name):
                kind = self.type_of(name)
                return Value(ast.Name(self.name_of(name)), kind if kind in ("bool", "int", "float", "str") else "Any")
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                found = self._number(operand)
                return Value(ast.UnaryOp(ast.USub(), found.tree), found.type)
            case ast.UnaryOp(op=ast.Not(), operand=ast.UnaryOp(op=ast.Not(), operand=operand)):
                return self.condition(operand)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return Value(_not(self.condition(operand)), "bool")
            case ast.BoolOp(op=op, values=values):
                return Value(ast.BoolOp(op, [self.condition(each).tree for each in values]), "bool")
            case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() | ast.MatMult()):
                return self._arithmetic(script)
            case ast.Compare():
                return self._comparison(script)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                asked, then, other = self.condition(test), self.value(body), self.value(orelse)
                if (then.type, other.type) != ("bool", "bool"):
                    raise Inexact("`?:` inside of an expression")
                ways = [
                    ast.BoolOp(ast.And(), [one, two.tree]) for one, two in ((asked.tree, then), (_not(asked), other))
                ]
                return Value(ast.BoolOp(ast.Or(), list[ast.expr](ways)), "bool")
        raise Inexact("bits, or an assignment inside of an expression")

    def _arithmetic(self, script: ast.BinOp) -> Value:
        sign = SIGNS[type(script.op)]
        if sign == ".." or (sign == "+" and "str" in (self.value(script.left).type, self.value(script.right).type)):
            match script.left, script.right:
                case ast.Constant(value=str(one)), ast.Constant(value=str(other)):
                    return literal(ast.Constant(one + other))
            raise Inexact("joined texts")
        left, right = self._number(script.left), self._number(script.right)
        if sign == "/" and isinstance(right.tree, ast.Constant):
            if right.tree.value == 0:
                raise Inexact("infinity")
        elif sign == "/":
            what = f"a division by `{right.text}`"
            self.notes.append(f"{what}: where that is 0 the run ends as an error, not at infinity")
        types = {left.type, right.type}
        kind = "float" if sign == "/" or "float" in types else "int" if types == {"int"} else "Any"
        return Value(ast.BinOp(left.tree, script.op, right.tree), kind)

    def _number(self, script: ast.expr) -> Value:
        value = self.value(script)
        if value.type in ("bool", "str"):
            raise Inexact("no number")
        return value

    def _comparison(self, script: ast.Compare) -> Value:
        values = [self.value(operand) for operand in (script.left, *script.comparators)]
        pairs = [self._pair(a, op, b) for a, op, b in zip(values, script.ops, values[1:], strict=False)]
        if len(pairs) == 1:
            return Value(pairs[0], "bool")
        if any(isinstance(pair.left, ast.Call) for pair in pairs):
            return Value(ast.BoolOp(ast.And(), list[ast.expr](pairs)), "bool")
        return Value(ast.Compare(values[0].tree, script.ops, [value.tree for value in values[1:]]), "bool")

    def _pair(self, left: Value, op: ast.cmpop, right: Value) -> ast.Compare:
        types = {left.type, right.type}
        if "str" in types and not types <= {"str", "Any"}:
            raise Inexact("a text compared with a number")
        plain = ast.Compare(left.tree, [op], [right.tree])
        if not isinstance(op, ast.Eq | ast.NotEq) or types <= {"bool", "int", "str"}:
            return plain
        if "float" in types:
            if "bool" in types:
                raise Inexact("a truth value compared with a fraction")
            apart = ast.Call(ast.Name("abs"), [ast.BinOp(left.tree, ast.Sub(), right.tree)], [])
            near = ast.LtE() if isinstance(op, ast.Eq) else ast.Gt()
            return ast.Compare(apart, [near], [ast.Constant(EPSILON)])
        if "str" not in types:
            unknown = left.text if left.type == "Any" else right.text
            text = f"`{ast.unparse(plain)}`: nothing says of which type {unknown!r} is"
            self.notes.append(f"{text}; were it a fraction, BT.CPP would take numbers within 1.2e-7 for the same")
        return plain


def _not(value: Value) -> ast.expr:
    return ast.UnaryOp(ast.Not(), value.tree)


def literal(said: ast.Constant) -> Value:
    """Return a literal as an expression. Raises Inexact: expressions can't hold it."""
    match said.value:
        case bool(truth):
            return Value(ast.Name(str(truth).lower()), "bool")
        case str(text) if not any(c in text for c in "\\#\n\r\0") and not {"'", '"'} <= set(text):
            return Value(said, "str")
        case int() | float() as number if abs(number) <= LARGEST:
            return Value(said, type(number).__name__)
    raise Inexact("a text that an expression can't hold, or a number of which BT.CPP keeps the nearest double")


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
