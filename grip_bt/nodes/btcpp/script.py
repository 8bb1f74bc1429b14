"""BehaviorTree.CPP's scripting language: text -> statements.

The grammar is that of BT.CPP 4: `&&` and `||` bind equally and to the left, comparisons chain, `?:` and assignments
don't, and an operand of a comparison is made of arithmetic, of bits (`! ~ & | ^`) or of text (`..`), which don't mix
without parentheses.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
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
ASSIGNMENTS = (":=", "=", "+=", "-=", "*=", "/=")
_COMPARISONS = ("==", "!=", "<", ">", "<=", ">=")


class ScriptError(ValueError):
    """A text isn't a script; the message says where."""


@dataclass(frozen=True)
class Literal:
    """A number, a truth value or a text."""

    value: bool | int | float | str


@dataclass(frozen=True)
class Name:
    """A blackboard entry, or an enum's word."""

    name: str


@dataclass(frozen=True)
class Unary:
    """`-`, `!` or `~` before an operand."""

    sign: str
    operand: Script


@dataclass(frozen=True)
class Binary:
    """Two operands: arithmetic, bits, `..`, `&&` or `||`."""

    left: Script
    sign: str
    right: Script


@dataclass(frozen=True)
class Comparison:
    """`operands[0] signs[0] operands[1] signs[1] ...`: all of them hold."""

    operands: tuple[Script, ...]
    signs: tuple[str, ...]


@dataclass(frozen=True)
class Ternary:
    """`condition ? then : otherwise`."""

    condition: Script
    then: Script
    otherwise: Script


@dataclass(frozen=True)
class Assignment:
    """`target sign value`."""

    target: str
    sign: str
    value: Script


Script = Literal | Name | Unary | Binary | Comparison | Ternary | Assignment


def parse_script(text: str) -> list[Script]:
    """Return the statements of a script.

    Raises:
        ScriptError: it isn't one.
    """
    if len(text) > LONGEST:
        raise ScriptError(f"longer than {LONGEST} characters")
    parser = _Parser(_tokens(text))
    statements: list[Script] = []
    while not parser.at_end():
        statements.append(parser.expression())
        if not parser.at_end():
            parser.expect(";")
    return statements


def names_of(statements: list[Script]) -> tuple[list[str], list[str], set[str]]:
    """Return the entries that a script names, each once, those that it assigns, and those that it may read."""
    names: dict[str, None] = {}
    assigned: dict[str, None] = {}
    read: set[str] = set()

    def look(part: object) -> None:
        match part:
            case Name(name=name):
                names[name] = None
                read.add(name)
            case Assignment(target=target, sign=sign, value=value):
                look(value)
                names[target] = assigned[target] = None
                if sign != ":=":
                    read.add(target)
            case Unary() | Binary() | Comparison() | Ternary():
                for below in vars(part).values():
                    for each in below if isinstance(below, tuple) else (below,):
                        look(each)

    for statement in statements:
        look(statement)
    return list(names), list(assigned), read


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


class _Parser:
    def __init__(self, tokens: list[tuple[str, str]]):
        self.tokens, self.position, self.depth = tokens, 0, 0

    def at_end(self) -> bool:
        return self.position == len(self.tokens)

    def peek(self) -> str:
        """Return the next sign, or an empty string."""
        kind, text = self.tokens[self.position] if not self.at_end() else ("", "")
        return text if kind == "sign" else ""

    def take(self, *signs: str) -> str:
        """Go past the next token when it is one of these signs, and return it."""
        sign = self.peek()
        if sign not in signs:
            return ""
        self.position += 1
        return sign

    def expect(self, sign: str) -> None:
        if not self.take(sign):
            said = "the end" if self.at_end() else repr(self.tokens[self.position][1])
            raise ScriptError(f"{sign!r} is missing before {said}")

    def expression(self) -> Script:
        self.depth += 1
        if self.depth > DEEPEST:
            raise ScriptError(f"nested deeper than {DEEPEST} levels")
        left = self.conditional()
        sign = self.take(*ASSIGNMENTS)
        if sign:
            if not isinstance(left, Name):
                raise ScriptError(f"left of {sign!r} stands something that isn't a blackboard entry")
            left = Assignment(left.name, sign, self.conditional())
        self.depth -= 1
        return left

    def conditional(self) -> Script:
        condition = self.logical()
        if not self.take("?"):
            return condition
        then = self.expression()
        self.expect(":")
        return Ternary(condition, then, self.logical())

    def logical(self) -> Script:
        left = self.comparison()
        while sign := self.take("||", "&&"):
            left = Binary(left, sign, self.comparison())
        return left

    def comparison(self) -> Script:
        operands, signs = [self.operand()], []
        while sign := self.take(*_COMPARISONS):
            signs.append(sign)
            operands.append(self.operand())
        return Comparison(tuple(operands), tuple(signs)) if signs else operands[0]

    def operand(self) -> Script:
        """Return an operand of a comparison, in one of the three groups that don't mix."""
        if self.peek() in ("!", "~"):
            return self.bits(self.bit_prefix())
        left = self.sum()
        if self.peek() in ("&", "|", "^"):
            return self.bits(left)
        while self.take(".."):
            left = Binary(left, "..", self.sum())
        return left

    def bits(self, left: Script) -> Script:
        while self.take("&"):
            left = Binary(left, "&", self.bit_prefix())
        while sign := self.take("|", "^"):
            right = self.bit_prefix()
            while self.take("&"):
                right = Binary(right, "&", self.bit_prefix())
            left = Binary(left, sign, right)
        return left

    def bit_prefix(self) -> Script:
        sign = self.take("!", "~")
        return Unary(sign, self.atom()) if sign else self.atom()

    def sum(self) -> Script:
        left = self.product()
        while sign := self.take("+", "-"):
            left = Binary(left, sign, self.product())
        return left

    def product(self) -> Script:
        left = self.negation()
        while sign := self.take("*", "/"):
            left = Binary(left, sign, self.negation())
        return left

    def negation(self) -> Script:
        return Unary("-", self.atom()) if self.take("-") else self.atom()

    def atom(self) -> Script:
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
                return Literal(int(text, 16 if kind == "hex" else 10))
            case "real":
                return Literal(float(text))
            case "text":
                return Literal(text[1:-1])
            case "name":
                return Literal(text == "true") if text in ("true", "false") else Name(text)
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
        value: Any = None
        for statement in parse_script(text):
            value = self.value(statement)
        return value

    def value(self, script: Script) -> Value:
        """Return what a part of a script comes to."""
        match script:
            case Literal(value=value):
                return value
            case Name(name=name):
                return self.get(name)
            case Unary(sign=sign, operand=operand):
                number = _number(self.value(operand))
                return -number if sign == "-" else float(~int(number)) if sign == "~" else not number
            case Binary(left=left, sign=sign, right=right):
                return _binary(self.value(left), sign, self.value(right))
            case Comparison(operands=operands, signs=signs):
                left = self.value(operands[0])
                for sign, operand in zip(signs, operands[1:], strict=True):
                    right = self.value(operand)
                    if not _compared(left, sign, right):
                        return False
                    left = right
                return True
            case Ternary(condition=condition, then=then, otherwise=otherwise):
                return self.value(then if self.value(condition) else otherwise)
            case Assignment(target=target, sign=sign, value=value):
                made = self.value(value)
                made = made if sign in (":=", "=") else _binary(self.get(target), sign[0], made)
                self.put(target, _like(self.get(target), made))
                return made


def _like(old: Any, new: Any) -> Any:
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


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:f}" if isinstance(value, float) else str(value)


def _binary(left: Any, sign: str, right: Any) -> Any:
    if sign == ".." or (sign == "+" and isinstance(left, str) and isinstance(right, str)):
        return _text(left) + _text(right)
    if isinstance(left, str) or isinstance(right, str):
        raise TypeError(f"`{sign}` between {left!r} and {right!r}")
    if sign in ("&&", "||"):
        return bool(left) and bool(right) if sign == "&&" else bool(left) or bool(right)
    if sign in "&|^":
        return float({"&": and_, "|": or_, "^": xor}[sign](int(left), int(right)))
    whole = isinstance(left, int) and isinstance(right, int) and sign != "/"
    made = {"+": add, "-": sub, "*": mul, "/": truediv}[sign](float(left), float(right))
    return int(made) if whole else made


def _compared(left: Any, sign: str, right: Any) -> bool:
    if not (isinstance(left, str) and isinstance(right, str)):
        left, right = _number(left), _number(right)
        if sign in ("==", "!="):
            return bool(abs(left - right) <= EPSILON) == (sign == "==")
    return bool({"==": eq, "!=": ne, "<": lt, ">": gt, "<=": le, ">=": ge}[sign](left, right))
