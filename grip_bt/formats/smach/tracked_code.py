"""Legacy code, compiled so that what it does with stand-ins stays known, and what goes by hashes.

Python asks no object about `x is None`, and turns a stand-in into text or a number where a function of its library
wants one; `for x in {…}` goes by hashes. Such places call the functions below, which see what they are given.
"""

from __future__ import annotations

import ast
import builtins
import os
import re
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial, wraps
from types import BuiltinFunctionType, FrameType, FunctionType, MethodType
from typing import Any

from grip_bt.nodes import stand_ins
from grip_bt.nodes.stand_ins import StandIn, asked_once, lifted, name_of, stand_in, stands_in, surely, value_of

NAMES = IS, CALL, STAR, SET, MOD, TEXT, IDLE, MAYBE, SAID = tuple(
    f"__grip_{name}__" for name in "is call star set mod text idle maybe said".split()
)
Tries = list[tuple[int, int, str]]
"""The first line of each `try` of a file, the one after its last, and what it takes."""
_DIRECT = ("super", "locals", "globals", "vars", "dir", "eval", "exec")


_IDLE = re.compile(r"print|os\.(mkdir|makedirs)|(rospy|logging)\.(log)?(debug|info|warn(ing)?|err(or)?|fatal)(_\w+)?")
"""Calls that change nothing here: an `if` that guards nothing else needn't be asked."""


class _Tracking(ast.NodeTransformer):
    def __init__(self) -> None:
        self.tries: Tries = []

    def visit_Try(self, node: ast.Try) -> ast.AST:
        caught = " ".join(ast.unparse(h.type or ast.Name("Exception")) for h in node.handlers)
        self.tries.append((node.body[0].lineno, (node.body[-1].end_lineno or 0) + 1, caught))
        return self.generic_visit(node)

    def visit_If(self, node: ast.If) -> ast.AST:
        called = [] if node.orelse else _idly_called(node.body)
        self.generic_visit(node)
        match node:
            case ast.If(test, [ast.AugAssign(ast.Name(name) as text, ast.Add(), ast.Constant(str()) as more)], []):
                value = _calling(MAYBE, test, test, ast.Name(name, ast.Load()), more)
                return ast.copy_location(ast.Assign([text], value), node)
            case ast.If(ast.UnaryOp(ast.Not(), test) | test) if called:
                functions = ast.Lambda(_NONE, ast.Tuple(called, ast.Load()))
                node.test = _calling(IDLE, test, test, ast.Constant(test is not node.test), functions)
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        if node.name in ("__str__", "__repr__"):
            node.decorator_list.append(ast.copy_location(ast.Name(SAID, ast.Load()), node))
        return self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id in _DIRECT:
            return node
        for each in node.args:
            if isinstance(each, ast.Starred):
                each.value = _calling(STAR, each.value, each.value)
        return _calling(CALL, node, node.func, *node.args, keywords=node.keywords)

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        self.generic_visit(node)
        if len(node.ops) != 1 or not isinstance(node.ops[0], (ast.Is, ast.IsNot)):
            return node
        made = _calling(IS, node, node.left, node.comparators[0])
        return made if isinstance(node.ops[0], ast.Is) else ast.copy_location(ast.UnaryOp(ast.Not(), made), node)

    def _set(self, node: Any) -> ast.expr:
        self.generic_visit(node)
        return _calling(SET, node, node)

    visit_Set = visit_SetComp = _set

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        return _calling(MOD, node, node.left, node.right) if isinstance(node.op, ast.Mod) else node

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.expr:
        self.generic_visit(node)
        parts: list[ast.expr] = []
        for part in node.values:
            if isinstance(part, ast.FormattedValue):
                spec = part.format_spec or ast.Constant("")
                parts.append(ast.Tuple([part.value, ast.Constant(part.conversion), spec], ast.Load()))
            else:
                parts.append(part)
        return _calling(TEXT, node, *parts)


_ACTING = (ast.Call, ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom)
_NONE = ast.arguments([], [], None, [], [], None, [])


def _idly_called(body: list[ast.stmt]) -> list[ast.expr]:
    """Return the functions that a body calls, if it does nothing but call such that change nothing."""
    calls = [each.value for each in body if isinstance(each, ast.Expr) and isinstance(each.value, ast.Call)]
    given = [n for call in calls for each in (*call.args, *call.keywords) for n in ast.walk(each)]
    acting = [n for n in given if isinstance(n, _ACTING) and getattr(getattr(n, "func", n), "attr", "") != "format"]
    idle = len(calls) == len(body) and all(_IDLE.fullmatch(ast.unparse(call.func)) for call in calls)
    return [call.func for call in calls] if idle and not acting else []


def _calling(name: str, node: ast.expr, *arguments: ast.expr, keywords: Iterable[ast.keyword] = ()) -> ast.Call:
    function = ast.copy_location(ast.Name(name, ast.Load()), node)
    made = ast.Call(function, list(arguments), list(keywords))
    return ast.copy_location(made, node)


def tracked(tree: ast.Module) -> tuple[ast.Module, Tries]:
    """Return the code so that stand-ins are seen; lines stay."""
    tracking = _Tracking()
    return ast.fix_missing_locations(tracking.visit(tree)), tracking.tries


def install() -> None:
    """Give compiled code its functions."""
    for name, function in zip(NAMES, (_is, _call, _star, TrackedSet, _mod, _text, _idle, _maybe, _said), strict=True):
        setattr(builtins, name, function)


def is_tracked(frame: FrameType | None) -> bool:
    """Tell whether a frame is one of legacy code."""
    return frame is not None and frame.f_code.co_filename in files


def caller() -> FrameType | None:
    """Return the innermost frame of legacy code."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and not is_tracked(frame):
        frame = frame.f_back
    return frame


def _is(left: Any, right: Any) -> bool:
    for one, other in ((left, right), (right, left)):
        if stands_in(one):
            held = value_of(one)
            if other is None and one._stand_in_class is not None:
                return False
            if held is not stand_ins.UNKNOWN:
                return asked_once(one, name_of(one), held is value_of(other), other)
            if other is None and type(one) is not StandIn:  # made by calling a class
                return False
            if other is None or isinstance(other, bool):
                same = asked_once(one, f"{name_of(one)} is {other!r}", False)
                if same:
                    vars(one)["_stand_in_answers"]["",] = bool(other), ()
                return same
            if isinstance(other, type):
                return bool(one == other)
    return left is right


def _idle(tested: Any, turned: bool, called: Callable[[], tuple[Any, ...]]) -> bool:
    """Return whether an `if` goes in that guards only calls of some functions; it needn't if these do nothing here."""
    return not (stands_in(tested) and all(map(_does_nothing, called()))) and bool(tested) != turned


def _does_nothing(function: Any) -> bool:
    if stands_in(function):  # to compare it would be a question
        return True
    return function in (print, os.mkdir, os.makedirs) or getattr(function, "__module__", "") == "logging"


def _maybe(tested: Any, text: Any, more: str) -> Any:
    """Return a text with more or without: where that goes by what only is so here, one that is so here."""
    if stands_in(tested) and value_of(tested) is not stand_ins.UNKNOWN and isinstance(held := value_of(text), str):
        return surely(str, stand_in(name_of(tested), held + more if value_of(tested) else held))
    return text + more if tested else text


def _mod(left: Any, right: Any) -> Any:
    if isinstance(left, (str, bytes)) and (unknown := next(_held_in(right), None)) is not None:
        return surely(type(left), lifted(lambda a, b: a % b, f"text with {name_of(unknown)}", left, right))
    return left % right


def _text(*parts: Any) -> Any:
    def joined(*values: Any) -> str:
        shown: dict[int, Callable[[Any], Any]] = {-1: lambda v: v, ord("r"): repr, ord("s"): str, ord("a"): ascii}
        return "".join(p if isinstance(p, str) else format(shown[p[1]](p[0]), p[2]) for p in values)

    unknown = next(_held_in(parts), None)
    return joined(*parts) if unknown is None else surely(str, lifted(joined, f"text with {name_of(unknown)}", *parts))


def _said(method: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Have a method return a text, where it would return one that stands in, which Python doesn't take."""
    return wraps(method)(lambda self: str(made) if stands_in(made := method(self)) else made)


def _sure_class(value: Any) -> Any:
    kind = value._stand_in_class if stands_in(value) else None
    return None if kind is object else kind


def _held_in(value: Any) -> Iterator[Any]:
    """Yield what stands in: a value, or what is in lists, tuples and dictionaries."""
    if isinstance(value, (tuple, list)) or type(value) is dict:
        for each in value.values() if isinstance(value, dict) else value:
            yield from _held_in(each)
    elif stands_in(value):
        yield value


class TrackedSet(set[Any]):
    """A set whose order goes by hashes: of two both orders are tried, of more it is noted that code goes by it."""

    def __iter__(self) -> Iterator[Any]:
        items = sorted(set.__iter__(self), key=repr)
        if len(items) > 1 and not all(isinstance(item, int) for item in items):
            if len(items) > 2:
                stand_ins.judge.note("the order of a set")
                return set.__iter__(self)
            turned, key = stand_ins.judge.lasting, frozenset(items)
            if key not in turned:
                turned[key] = not stand_ins.judge.decide(f"whether {items[0]!r} is first in a set", True)
            items = items[::-1] if turned[key] else items
        return iter(items)

    def __repr__(self) -> str:
        return f"{{{', '.join(map(repr, self))}}}" if self else "set()"

    def pop(self) -> Any:
        """Remove and return one, by its hash."""
        item = next(iter(self), None)
        return super().pop() if item is None else super().remove(item) or item


def _kept(name: str) -> Callable[..., Any]:
    plain = getattr(set, name)
    return lambda self, *others: TrackedSet(plain(self, *map(_untracked, others)))


for _name in "union intersection difference symmetric_difference copy __or__ __and__ __sub__ __xor__".split():
    setattr(TrackedSet, _name, _kept(_name))


def _untracked(value: Any) -> Any:
    return set(set.__iter__(value)) if type(value) is TrackedSet else value


def _in_a_row(kind: type, *given: Any) -> Any:
    """Return a list or tuple; one of a set stands in, so that it matters only where code goes by it."""
    items = [*set.__iter__(given[0])] if given and type(given[0]) is TrackedSet else []
    if len(items) < 3 or all(isinstance(item, int) for item in items):
        return kind(*given)
    made = surely(kind, stand_in("the order of a set", kind(items)))
    vars(made)["_stand_in_each"] = sorted(items, key=repr)
    return made


def without_order(value: Any) -> Any:
    """Return a set, or a list of one that is as it was, so that each order of it is the same."""
    if type(value) is TrackedSet:
        return dict.fromkeys(sorted(set.__iter__(value), key=repr))  # which can't be added to a list either
    each = vars(value).get("_stand_in_each") if stands_in(value) and not isinstance(value, type) else None
    return each if each is not None and each == sorted(value_of(value), key=repr) else value


def _hasattr(value: Any, name: str) -> bool:
    if (sure := _sure_class(value)) is not None:
        return hasattr(sure, name)
    if isinstance(value, (stand_ins.StandInModule, StandIn)) and name not in vars(value):
        known_as = value.__name__ if isinstance(value, stand_ins.StandInModule) else name_of(value)
        held = value_of(value) if stands_in(value) else stand_ins.UNKNOWN
        return asked_once(value, f"hasattr({known_as}, {name!r})", held is stand_ins.UNKNOWN or hasattr(held, name))
    return hasattr(value, name)


def _getattr(value: Any, name: Any, *default: Any) -> Any:
    name = _plain_text(name)
    if default and isinstance(value, (stand_ins.StandInModule, StandIn)) and not _hasattr(value, name):
        return default[0]
    return getattr(value, name, *default)


def _plain_text(name: Any) -> Any:
    return str(name) if stands_in(name) else name


def _isinstance(value: Any, kinds: Any) -> bool:
    if (sure := _sure_class(value)) is not None:
        return issubclass(sure, kinds)
    if stands_in(value):
        held = value_of(value)
        if held is not stand_ins.UNKNOWN:
            return asked_once(value, f"the class of {name_of(value)}", isinstance(held, kinds), kinds)
        names = [getattr(k, "__name__", str(k)) for k in _each(kinds)]
        declared = vars(value).get("_stand_in_declared")
        if isinstance(value, kinds) if type(value) is not StandIn else declared in names:
            return True
        if type(value) is not StandIn and all(issubclass(kind, StandIn) for kind in _each(kinds)):
            return False  # as was answered just now
        is_one = asked_once(value, f"isinstance({name_of(value)}, {' or '.join(names)})", True, *_each(kinds))
        if is_one and kinds in (str, list, dict, tuple) and value._stand_in_class in (None, object):
            surely(kinds, value)
        return is_one
    return isinstance(value, kinds)


def _each(kinds: Any) -> tuple[Any, ...]:
    return kinds if isinstance(kinds, tuple) else (kinds,)


def _issubclass(value: Any, kinds: Any) -> bool:
    if isinstance(value, type) and not stands_in(kinds):
        return issubclass(value, kinds)
    return stand_ins.judge.decide(f"issubclass({name_of(value)}, {name_of(kinds)})", True)


def _type(value: Any) -> Any:
    return _sure_class(value) or (
        lifted(type, f"type({name_of(value)})", value) if type(value) is StandIn else type(value)
    )


def _callable(value: Any) -> bool:
    return asked_once(value, f"callable({name_of(value)})", True) if stands_in(value) else callable(value)


def _map(function: Any, *each: Any) -> Any:
    unknown = next(filter(stands_in, each), None)  # a function that stands in makes stand-ins of what is known
    return map(function, *each) if unknown is None else lifted(map, name_of(unknown), function, *each)


def _without_order(function: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *arguments, **named: function(*map(_untracked, arguments), **named)


SPECIAL: dict[Any, Callable[..., Any]] = {
    hasattr: _hasattr,
    getattr: _getattr,
    setattr: lambda value, name, new: setattr(value, _plain_text(name), new),
    isinstance: _isinstance,
    issubclass: _issubclass,
    callable: _callable,
    set: lambda *given: stand_in(name_of(given[0])) if given and stands_in(given[0]) else TrackedSet(*given),
    print: lambda *arguments, **named: None,
    type: lambda *given, **named: type(*given, **named) if len(given) != 1 else _type(*given),
    repr: repr,
    map: _map,
}
SPECIAL.update({kind: partial(_in_a_row, kind) for kind in (list, tuple)})
_ORDERLESS: tuple[Any, ...] = (sorted, min, max, any, all, sum, len)
SPECIAL.update({function: _without_order(function) for function in _ORDERLESS})
_CONTAINERS = (list, dict, set, deque, tuple)
_KEEPING = ("grip_bt.", "smach", "functools", "threading", "collections", "enum", "abc", "typing", "contextlib")


_FUNCTIONS = (FunctionType, BuiltinFunctionType, MethodType)


@dataclass
class _Spread:
    """Arguments of which nobody knows how many they are."""

    value: StandIn


def _star(value: Any) -> Any:
    return [_Spread(value)] if stands_in(value) and stand_ins.held_by(value) is stand_ins.UNKNOWN else value


def _as_seen(value: Any) -> Any:
    """Return what stands for a function that is handed on, such as `map(os.getenv, names)`."""
    return SPECIAL.get(value, value) if isinstance(value, _FUNCTIONS) else value


def _call(function: Any, *arguments: Any, **named: Any) -> Any:
    arguments, named = tuple(map(_as_seen, arguments)), {key: _as_seen(value) for key, value in named.items()}
    if any(type(a) is _Spread for a in arguments):
        kept = _is_stand_in(function)
        each = [([a.value] if kept else list(a.value)) if type(a) is _Spread else [a] for a in arguments]
        arguments = tuple(value for values in each for value in values)
    try:
        special = SPECIAL.get(function) if not stands_in(function) else None
    except TypeError:  # unhashable
        special = None
    about = next(filter(stands_in, (*arguments, *named.values())), None)
    if special is not None and (about is None or special not in _LIFTED):
        return special(*arguments, **named)
    owner = getattr(function, "__self__", None)
    if about is None and type(owner) is str:  # such as `join`
        about = next(_held_in(arguments), None)
    if about is None or _takes_stand_ins(function, owner):
        return function(*arguments, **named)
    return lifted(function, name_of(about), *arguments, **named)


_LIFTED = {SPECIAL[each] for each in (*_ORDERLESS, list, tuple)}


def _is_stand_in(function: Any) -> bool:
    return stands_in(function) or (isinstance(function, type) and issubclass(function, StandIn))


def _takes_stand_ins(function: Any, owner: object) -> bool:
    """Whether a function is legacy code, smach's, or one that only keeps what it is given."""
    if _is_stand_in(function) or isinstance(owner, _CONTAINERS) or hasattr(function, "_stand_in_free"):
        return True
    plain = getattr(function, "__func__", function)
    code, kind = getattr(plain, "__code__", None), isinstance(function, type)
    if not (code or kind):
        return callable(function) and type(function).__module__ in legacy_modules
    module = str(getattr(plain, "__module__", ""))
    sure = issubclass(function, BaseException) if kind else getattr(code, "co_filename", "") in files
    return sure or module.startswith(_KEEPING) or module in legacy_modules


legacy_modules: set[str] = {"__main__"}
"""Names of modules of the workspace."""
files: set[str] = set()
"""Files whose code was compiled here."""
