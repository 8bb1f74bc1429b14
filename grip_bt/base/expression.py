"""The expression language of guards, switches and loops: read once, checked against an allow-list, never `eval`ed.

Nothing else can be said than the allow-list has, so nothing else can happen: no calls but of four functions, no
indexing, no powers, no text arithmetic, no private attributes. `grip_bt.base.evaluation` computes it.
"""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache

from grip_bt.base.errors import ExpressionError, nearest

LONGEST, DEEPEST = 500, 30
_FUNCTIONS = ("len", "min", "max", "abs")
CONSTANTS = {"true": True, "false": False, "null": None}
"""Words of YAML that mean here what they mean there; no variable of such a name can be used."""
_ALLOWED = (
    "literals, variables, `== != < <= > >=`, `in`, `is None`, `and or not`, `+ - * / // %`, "
    "`len() min() max() abs()`, lists, attributes such as `grasp.quality`"
)
_PLAIN = (
    *(ast.BoolOp, ast.And, ast.Or, ast.UnaryOp, ast.Not, ast.USub, ast.UAdd, ast.Load),
    *(ast.BinOp, ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod),
    *(ast.Compare, ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.In, ast.NotIn, ast.List, ast.Tuple),
)
"""Syntax that needs no further look."""
_NAMES: dict[type[ast.AST], str] = {
    ast.Subscript: "indexing with [...]",
    ast.Pow: "**",
    ast.Lambda: "lambda",
    ast.IfExp: "... if ... else ...",
    ast.JoinedStr: "an f-string",
    ast.NamedExpr: ":=",
    ast.Starred: "*",
    ast.Dict: "a dict",
    ast.Set: "a set",
}


@dataclass(frozen=True)
class Expression:
    """An expression of the language.

    Attributes:
        names: the variables that it reads, each once, in order.
    """

    text: str
    names: tuple[str, ...]
    tree: ast.expr = field(repr=False, compare=False)

    def column(self, node: ast.expr) -> int:
        """Return the 1-based column of a part of it."""
        return _column(self.text, node)


@lru_cache(maxsize=4096)
def parse_expression(text: str) -> Expression:
    """Read an expression; ExpressionError where it isn't one; the message says where, and what is allowed."""
    text = text.strip()
    tree = _syntax(text)
    names: dict[str, None] = {}
    for node, depth in _walk(tree):
        if depth > DEEPEST:
            raise ExpressionError(text, f"nested deeper than {DEEPEST} levels", 1)
        _check(text, node)
        if isinstance(node, ast.Name) and node.id not in CONSTANTS:
            names[node.id] = None
    return Expression(text, tuple(name for name in names if name not in _FUNCTIONS or _used_as_value(tree, name)), tree)


def _syntax(text: str) -> ast.expr:
    if len(text) > LONGEST:
        raise ExpressionError(text[:40] + "...", f"longer than {LONGEST} characters", LONGEST)
    for wrong, word in (("\n", "a line break"), ("\\", "a backslash"), ("#", "`#`"), ("\0", "a null character")):
        if wrong in text:
            raise ExpressionError(text, f"expressions can't contain {word}", text.index(wrong) + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ast.parse(text, mode="eval").body
    except SyntaxError as error:
        at = error.offset if error.offset and error.lineno == 1 else len(text) + 1
        raise ExpressionError(text, f"{error.msg} ({_hint(text)})", at) from None
    except (ValueError, RecursionError, MemoryError) as error:
        raise ExpressionError(text, f"can't be read: {error or 'nested too deep'}", 1) from None


def _hint(text: str) -> str:
    if not text:
        return "write a condition such as `count < 3`"
    if "&&" in text or "||" in text:
        return "write `and`, `or`, `not`"
    if "=" in text and not any(sign in text for sign in ("==", "<=", ">=", "!=")):
        return "equality is `==`"
    return f"allowed are {_ALLOWED}"


def _walk(tree: ast.expr) -> Iterator[tuple[ast.AST, int]]:
    stack: list[tuple[ast.AST, int]] = [(tree, 1)]
    while stack:
        node, depth = stack.pop()
        yield node, depth
        stack.extend((child, depth + 1) for child in reversed(list(ast.iter_child_nodes(node))))


def _check(text: str, node: ast.AST) -> None:
    match node:
        case ast.Constant(value=value):
            if not (value is None or isinstance(value, bool | int | float | str)):
                raise _refused(text, node, f"the literal {ast.unparse(node)}")
        case ast.Name(id=name):
            if name.startswith("__"):
                raise _refused(text, node, f"the name {name!r}")
        case ast.Attribute(attr=name):
            if name.startswith("_"):
                raise _refused(text, node, f"the attribute {name!r}, which begins with an underscore,")
        case ast.Call():
            _check_call(text, node)
        case ast.Compare(ops=ops, comparators=right) if any(isinstance(op, ast.Is | ast.IsNot) for op in ops):
            for op, operand in zip(ops, right, strict=True):
                if isinstance(op, ast.Is | ast.IsNot) and not _is_none(operand):
                    raise ExpressionError(
                        text, "`is` is for None only; compare with `==` or `!=`", _column(text, operand)
                    )
        case ast.Is() | ast.IsNot():
            pass
        case _ if not isinstance(node, _PLAIN):
            raise _refused(text, node, _NAMES.get(type(node), type(node).__name__))


def _is_none(node: ast.expr) -> bool:
    return (isinstance(node, ast.Constant) and node.value is None) or (isinstance(node, ast.Name) and node.id == "null")


def _check_call(text: str, node: ast.Call) -> None:
    if not isinstance(node.func, ast.Name) or node.func.id not in _FUNCTIONS:
        what = ast.unparse(node.func)
        hint = nearest(what, _FUNCTIONS)
        raise ExpressionError(
            text, f"{what}() can't be called{hint} (functions: {', '.join(_FUNCTIONS)})", _column(text, node)
        )
    name = node.func.id
    if node.keywords or not node.args or (name in ("len", "abs") and len(node.args) != 1):
        wanted = "one value" if name in ("len", "abs") else "a list, or values"
        raise ExpressionError(text, f"{name}() takes {wanted}", _column(text, node))


def _used_as_value(tree: ast.expr, name: str) -> bool:
    called = [n.func for n in ast.walk(tree) if isinstance(n, ast.Call)]
    return any(isinstance(n, ast.Name) and n.id == name and n not in called for n in ast.walk(tree))


def _refused(text: str, node: ast.AST, what: str) -> ExpressionError:
    return ExpressionError(text, f"{what} isn't part of the language (allowed are {_ALLOWED})", _column(text, node))


def _column(text: str, node: ast.AST) -> int:
    offset: int = getattr(node, "col_offset", 0)
    return len(text.encode(errors="replace")[:offset].decode(errors="replace")) + 1
