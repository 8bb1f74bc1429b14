"""BehaviorTree.CPP's scripting language: text -> statements as Python's syntax trees, and what they come to.

The grammar is that of BT.CPP 4: `&&` and `||` bind equally and to the left, comparisons chain, `?:` and assignments
don't, and an operand of a comparison is made of arithmetic, of bits (`! ~ & | ^`) or of text (`..`), which don't mix
without parentheses. In the trees `!` is `not`, `..` is `@`, an assignment is `:=`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from operator import add, and_, eq, ge, gt, le, lt, mul, ne, or_, sub, truediv, xor
from typing import Any

from grip_bt.base.types import Value

EPSILON = 1.1920928955078125e-07
"""Of a single float: numbers that are no further apart are equal to BT.CPP."""
LONGEST, DEEPEST = 4000, 40
_TOKEN = re.compile(
    r"\s*(?:(?P<real>\d+(?:\.\d+(?:[eE][+-]?\d+)?|[eE][+-]?\d+)(?![\w.]))|(?P<hex>0[xX][0-9a-fA-F]+(?![\w.]))"
    r"|(?P<int>\d+(?![\w.]))|(?P<text>'[^']*'|\"[^\"]*\")|(?P<name>[A-Za-z_@][A-Za-z0-9_]*)"
    r"|(?P<sign>:=|\+=|-=|\*=|/=|==|!=|<=|>=|&&|\|\||\.\.|[-+*/<>=!~&|^?:;()]))"
)
_SPACE = re.compile(r"\s*\Z")
_ASSIGNMENTS = (":=", "=", "+=", "-=", "*=", "/=")
_COMPARISONS = {
    **{"==": (ast.Eq, eq), "!=": (ast.NotEq, ne), "<": (ast.Lt, lt)},
    **{">": (ast.Gt, gt), "<=": (ast.LtE, le), ">=": (ast.GtE, ge)},
}
_BITS = {"&": (ast.BitAnd, and_), "|": (ast.BitOr, or_), "^": (ast.BitXor, xor)}
_SUMS = {"+": (ast.Add, add), "-": (ast.Sub, sub), "*": (ast.Mult, mul), "/": (ast.Div, truediv)}
_UNARY = {"-": ast.USub, "!": ast.Not, "~": ast.Invert}
_LOGIC = {"&&": ast.And, "||": ast.Or}
_BINARY: dict[str, type[ast.operator]] = {
    **{sign: operator for sign, (operator, _) in (*_BITS.items(), *_SUMS.items())},
    "..": ast.MatMult,
}
SIGNS: dict[type[ast.AST], str] = {
    **{operator: sign for sign, operator in (*_UNARY.items(), *_LOGIC.items(), *_BINARY.items())},
    **{operator: sign for sign, (operator, _) in _COMPARISONS.items()},
}
"""Operator of the syntax trees -> how a script writes it."""


class ScriptError(ValueError):
    """A text isn't a script; the message says where."""


def parse_script(text: str) -> list[ast.expr]:
    """Return the statements of a script. Raises ScriptError: it isn't one."""
    if len(text) > LONGEST:
        raise ScriptError(f"longer than {LONGEST} characters")
    parser = _Parser(_tokens(text))
    statements: list[ast.expr] = []
    while not parser.at_end():
        statements.append(parser.expression())
        if not parser.at_end():
            parser.expect(";")
    return statements


def names_of(text: str) -> tuple[list[str], list[str], set[str]]:
    """Return the entries that a script names, each once, those that it assigns, and those that it may read."""
    tokens = [*_tokens(text), ("", "")]
    pairs = zip(tokens, tokens[1:], strict=False)
    found = [(said, after) for (kind, said), (_, after) in pairs if kind == "name" and said not in ("true", "false")]
    assigned = dict.fromkeys(said for said, after in found if after in _ASSIGNMENTS)
    return list(dict.fromkeys(said for said, _ in found)), list(assigned), {s for s, after in found if after != ":="}


def parts_of(text: str) -> list[str]:
    """Return the texts of the statements of a script, which can be parsed."""
    parts: list[list[str]] = [[]]
    for _, said in _tokens(text):
        parts.append([]) if said == ";" else parts[-1].append(said)
    return [" ".join(part) for part in parts if part]


def renamed(text: str, names: Mapping[str, str]) -> str:
    """Return a script with other names for its entries."""
    return " ".join(names.get(said, said) if kind == "name" else said for kind, said in _tokens(text))


def _tokens(text: str) -> list[tuple[str, str]]:
    tokens, position = [], 0
    while not _SPACE.match(text, position):
        found = _TOKEN.match(text, position)
        if found is None or found.lastgroup is None:
            raise ScriptError(f"column {position + 1}: {text[position : position + 10]!r} isn't a word of the language")
        tokens.append((found.lastgroup, found.group(found.lastgroup)))
        position = found.end()
    return tokens


def _binary(left: ast.expr, sign: str, right: ast.expr) -> ast.expr:
    if sign in _LOGIC:
        return ast.BoolOp(_LOGIC[sign](), [left, right])
    return ast.BinOp(left, _BINARY[sign](), right)


class _Parser:
    def __init__(self, tokens: list[tuple[str, str]]):
        self.tokens, self.position, self.depth = tokens, 0, 0

    def at_end(self) -> bool:
        return self.position == len(self.tokens)

    def take(self, *signs: str) -> str:
        """Go past the next token when it is one of these signs, and return it."""
        kind, text = self.tokens[self.position] if not self.at_end() else ("", "")
        if kind != "sign" or text not in signs:
            return ""
        self.position += 1
        return text

    def expect(self, sign: str) -> None:
        if not self.take(sign):
            said = "the end" if self.at_end() else repr(self.tokens[self.position][1])
            raise ScriptError(f"{sign!r} is missing before {said}")

    def expression(self) -> ast.expr:
        self.depth += 1
        if self.depth > DEEPEST:
            raise ScriptError(f"nested deeper than {DEEPEST} levels")
        left = self.conditional()
        if sign := self.take(*_ASSIGNMENTS):
            if not isinstance(left, ast.Name):
                raise ScriptError(f"left of {sign!r} stands something that isn't a blackboard entry")
            value = self.conditional()
            left = ast.NamedExpr(left, value if sign in (":=", "=") else _binary(left, sign[0], value))
        self.depth -= 1
        return left

    def conditional(self) -> ast.expr:
        condition = self.chain(self.comparison, "||", "&&")
        if not self.take("?"):
            return condition
        then = self.expression()
        self.expect(":")
        return ast.IfExp(condition, then, self.chain(self.comparison, "||", "&&"))

    def chain(self, below: Callable[[], ast.expr], *signs: str, left: ast.expr | None = None) -> ast.expr:
        """Return operands that signs join, from the left."""
        made = below() if left is None else left
        while sign := self.take(*signs):
            made = _binary(made, sign, below())
        return made

    def comparison(self) -> ast.expr:
        first, operators, operands = self.operand(), list[ast.cmpop](), list[ast.expr]()
        while sign := self.take(*_COMPARISONS):
            operators.append(_COMPARISONS[sign][0]())
            operands.append(self.operand())
        return ast.Compare(first, operators, operands) if operators else first

    def operand(self) -> ast.expr:
        """Return an operand of a comparison, in one of the three groups that don't mix."""
        prefixed = self.tokens[self.position : self.position + 1] in ([("sign", "!")], [("sign", "~")])
        left = self.bit() if prefixed else self.sum()
        some = self.chain(self.bit, "&", left=left)
        bits = self.chain(lambda: self.chain(self.bit, "&"), "|", "^", left=some)
        return bits if prefixed or bits is not left else self.chain(self.sum, "..", left=left)

    def bit(self) -> ast.expr:
        sign = self.take("!", "~")
        return ast.UnaryOp(_UNARY[sign](), self.atom()) if sign else self.atom()

    def sum(self) -> ast.expr:
        return self.chain(lambda: self.chain(self.negation, "*", "/"), "+", "-")

    def negation(self) -> ast.expr:
        if not self.take("-"):
            return self.atom()
        match self.atom():
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return ast.Constant(-number)
            case operand:
                return ast.UnaryOp(ast.USub(), operand)

    def atom(self) -> ast.expr:
        if self.take("("):
            inside = self.expression()
            self.expect(")")
            return inside
        if self.at_end():
            raise ScriptError("it ends where a value is missing")
        kind, text = self.tokens[self.position]
        self.position += 1
        match kind:
            case "int" | "hex":
                return ast.Constant(int(text, 16 if kind == "hex" else 10))
            case "real":
                return ast.Constant(float(text))
            case "text":
                return ast.Constant(text[1:-1])
            case "name":
                return ast.Constant(text == "true") if text in ("true", "false") else ast.Name(text)
        raise ScriptError(f"{text!r} stands where a value is missing")


class Run:
    """Computes scripts as BehaviorTree.CPP does: numbers are doubles, truth is 1.0, texts are converted where needed.

    Args:
        get: the value of an entry by its name.
        put: writes one.
    """

    def __init__(self, get: Callable[[str], Value], put: Callable[[str, Value], None]):
        self.get, self.put = get, put

    def script(self, text: str) -> Value:
        """Run the statements of a script; return the value of the last one.

        Raises:
            ScriptError: it isn't one.
            ValueError, TypeError: values don't fit.
        """
        value: Value = None
        for statement in parse_script(text):
            value = self._value(statement)
        return value

    def _value(self, script: ast.expr) -> Any:
        match script:
            case ast.Constant():
                return script.value
            case ast.Name(id=name):
                return self.get(name)
            case ast.UnaryOp(op=op, operand=operand):
                number = _number(self._value(operand))
                return -number if isinstance(op, ast.USub) else not number if isinstance(op, ast.Not) else ~int(number)
            case ast.BoolOp(op=op, values=[left, right]) | ast.BinOp(left=left, op=op, right=right):
                return _computed(self._value(left), SIGNS[type(op)], self._value(right))
            case ast.Compare(left=first, ops=ops, comparators=others):
                value = self._value(first)
                for sign, other in zip(ops, others, strict=True):
                    before, value = value, self._value(other)
                    if not _compared(before, SIGNS[type(sign)], value):
                        return False
                return True
            case ast.IfExp(test=test, body=then, orelse=otherwise):
                return self._value(then if self._value(test) else otherwise)
            case ast.NamedExpr(target=ast.Name(id=name), value=given):
                made = self._value(given)
                self.put(name, _like(self.get(name), made))
                return made


def _like(old: object, new: object) -> object:
    """Return a value as what stood there before, as an entry keeps its type."""
    if isinstance(old, bool) and not isinstance(new, str):
        return bool(new)
    if isinstance(old, int) and isinstance(new, float) and new == int(new):
        return int(new)
    return new


def _number(value: Any) -> float:
    if isinstance(value, str):
        return {"true": 1.0, "false": 0.0}[value] if value in ("true", "false") else float(value)
    return float(value)


def text_of(value: object) -> str:
    """Return the text that BehaviorTree.CPP makes of a value."""
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:f}" if isinstance(value, float) else str(value)


def _computed(left: Any, sign: str, right: Any) -> Any:
    if sign == ".." or (sign == "+" and isinstance(left, str) and isinstance(right, str)):
        return text_of(left) + text_of(right)
    if isinstance(left, str) or isinstance(right, str):
        raise TypeError(f"`{sign}` between {left!r} and {right!r}")
    if sign in _LOGIC:
        return bool(left) and bool(right) if sign == "&&" else bool(left) or bool(right)
    if sign in _BITS:
        return float(_BITS[sign][1](int(left), int(right)))
    made = _SUMS[sign][1](float(left), float(right))
    return int(made) if isinstance(left, int) and isinstance(right, int) and sign != "/" else made


def _compared(left: object, sign: str, right: object) -> bool:
    if not (isinstance(left, str) and isinstance(right, str)):
        left, right = _number(left), _number(right)
        if sign in ("==", "!="):
            return bool(abs(left - right) <= EPSILON) == (sign == "==")
    return bool(_COMPARISONS[sign][1](left, right))
