"""Parameters of ROS with a default in the text: where a machine's shape hangs on one, it is taken, and told."""

from __future__ import annotations

import ast
import copy
import itertools
import json
import operator
import reprlib
from collections.abc import Callable, Collection, Iterable
from typing import Any

from .found import CONTAINERS, MISSING, ContainerInfo, Reference, StateInfo, Unresolved
from .names import Bound, Class, Function, Instance, Scope, UserDataOf, express_or_none, is_literal

GET_PARAMETER = "rospy.get_param"
_METHODS = ("items", "keys", "values", "get")
_LARGEST = 10_000


def default_given(arguments: list[Any], named: dict[str, Any]) -> Any:
    """Return the default in a call of `get_param`; `MISSING` where it has none."""
    return arguments[1] if len(arguments) > 1 else named.get("default", MISSING)


def repeatable(node: ast.expr, functions: Collection[str], methods: Collection[str]) -> bool:
    """Tell whether evaluating twice is as good as once, given functions and methods that change nothing."""
    for each in ast.walk(node):
        if isinstance(each, (ast.Lambda, ast.NamedExpr, ast.Await, ast.Yield)):
            return False
        if isinstance(each, ast.Call):
            callee = each.func
            name = callee.attr if isinstance(callee, ast.Attribute) else getattr(callee, "id", "")
            plain = name in functions if isinstance(callee, ast.Name) else name in methods or name in _METHODS
            if not plain and name != "get_param":
                return False
    return True


def default_of(value: Any) -> Any:
    """Return the default of what is known only at run time, where the text gives one; else the value itself."""
    known = isinstance(value, Unresolved) and value.default is not MISSING
    return copy.deepcopy(value.default) if known else value


def use_default(value: Any, note: Callable[[str], None]) -> Any:
    """Return a value, or the default that is taken for it; `note` is given the words then."""
    found = default_of(value)
    if found is not value:
        note(assumption_text(value, found))
    return found


def assumption_text(value: Unresolved, default: object) -> str:
    """Return what is told where a default is taken."""
    return (
        f"assumes `{value.text}` = {reprlib.repr(default)}, its default in the source; other ROS parameters, known only"
        " at run time, would give another machine"
    )


_BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}
_COMPARE: dict[type, Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    f.__name__: f
    for f in (*(range, len, str, int, float, bool, list, dict, tuple, set, sorted, min, max), *(sum, abs, repr))
}
_FUNCTIONS |= {
    "enumerate": lambda *a, **k: list(enumerate(*a, **k)),
    "zip": lambda *a: list(zip(*a, strict=False)),
    "reversed": lambda a: list(reversed(a)),
}
_LIBRARY: dict[str, Callable[..., Any]] = {
    "itertools.product": lambda *a, **k: _limited(itertools.product(*a, **k)),
    "itertools.permutations": lambda *a: _limited(itertools.permutations(*a)),
    "itertools.combinations": lambda *a: _limited(itertools.combinations(*a)),
    "itertools.chain": lambda *a: _limited(itertools.chain(*a)),
    "itertools.islice": lambda *a: _limited(itertools.islice(*a)),
    "collections.OrderedDict": dict,
    "json.loads": json.loads,
    "copy.copy": copy.copy,
    "copy.deepcopy": copy.deepcopy,
}
"""Functions of Python's library that give the same whenever they are called, by what they are given."""
_PURE = {
    str: ("format", "upper", "lower", "join", "replace", "strip", "split", "title", "capitalize", "startswith"),
    dict: ("items", "keys", "values", "get", "copy", "update", "pop", "setdefault"),
    list: ("append", "extend", "insert", "index", "count", "copy", "pop"),
    tuple: ("index", "count"),
    set: ("add", "union", "copy"),
}


class Evaluation:
    """Evaluates expressions; the interpreter calls functions and knows smach."""

    assuming = False
    """Whether defaults of parameters are taken for what a run may find."""

    def call(self, node: ast.Call, scope: Scope) -> Any:
        """Evaluate a call; the interpreter does."""
        raise NotImplementedError

    def value(self, node: ast.expr | None, scope: Scope) -> Any:
        """Return what an expression gives: a Python value, something found, or `Unresolved`."""
        if node is None:
            return None
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is not None:
            try:
                result = method(node, scope)
            except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
                return self.opaque(node, scope)  # the run would raise, or knows more
            if result is not NotImplemented:
                return default_of(result) if self.assuming else result
        return self.opaque(node, scope)

    def opaque(self, node: ast.expr, scope: Scope) -> Unresolved:
        """Return the expression as what is known only at run time."""
        return Unresolved(ast.unparse(node), express_or_none(node, scope), self._default(node, scope))

    def _default(self, node: ast.expr, scope: Scope) -> Any:
        """Return what an expression gives where nobody has set the parameters that it asks for."""
        if self.assuming or not repeatable(node, _FUNCTIONS, _PURE[str]):
            return MISSING
        self.assuming = True
        try:
            value = self.value(node, scope)
        finally:
            self.assuming = False
        return value if is_literal(value) else MISSING

    def _constant(self, node: ast.Constant, scope: Scope) -> Any:
        return node.value

    def _name(self, node: ast.Name, scope: Scope) -> Any:
        found = scope.find(node.id)
        if found is not None:
            return found[0]
        return Reference(f"builtins.{node.id}", node) if node.id in _FUNCTIONS or node.id == "super" else NotImplemented

    def _list(self, node: ast.List, scope: Scope) -> Any:
        return list(self._items(node.elts, scope))

    def _tuple(self, node: ast.Tuple, scope: Scope) -> Any:
        return tuple(self._items(node.elts, scope))

    def _set(self, node: ast.Set, scope: Scope) -> Any:
        return set(self._items(node.elts, scope))

    def _items(self, nodes: list[ast.expr], scope: Scope) -> Any:
        for node in nodes:
            if isinstance(node, ast.Starred):
                yield from self.known(node.value, scope)
            else:
                yield self.value(node, scope)

    def known(self, node: ast.expr, scope: Scope) -> Any:
        """Return a sequence's items; raise ValueError where they are known only at run time."""
        return self.items(self.value(node, scope), node)

    def items(self, value: Any, node: ast.expr) -> list[Any]:
        """Return the items of what `node` gives; raise ValueError where they are known only at run time."""
        if isinstance(value, range) and len(value) > _LARGEST:
            raise ValueError("too many items to follow")
        if isinstance(value, (list, tuple, range, str, set, dict)) or type(value).__name__.startswith("dict_"):
            return list(value)
        raise ValueError(ast.unparse(node))

    def _dict(self, node: ast.Dict, scope: Scope) -> Any:
        made: dict[Any, Any] = {}
        for key, item in zip(node.keys, node.values, strict=True):
            if key is None:
                made.update(self.value(item, scope))
            else:
                made[self.value(key, scope)] = self.value(item, scope)
        return made

    def _joinedstr(self, node: ast.JoinedStr, scope: Scope) -> Any:
        parts = []
        for piece in node.values:
            value = self.value(piece.value if isinstance(piece, ast.FormattedValue) else piece, scope)
            if not is_literal(value):
                return NotImplemented
            spec = self.value(piece.format_spec, scope) if isinstance(piece, ast.FormattedValue) else None
            parts.append(format(value, spec or ""))
        return "".join(parts)

    def _binop(self, node: ast.BinOp, scope: Scope) -> Any:
        left, right = self.value(node.left, scope), self.value(node.right, scope)
        whole = isinstance(left, list) and isinstance(right, list) and isinstance(node.op, ast.Add)
        if type(node.op) not in _BINARY or not (whole or (is_literal(left) and is_literal(right))):
            return NotImplemented
        if isinstance(node.op, ast.Mult) and max(_size(left), _size(right)) > _LARGEST:
            return NotImplemented
        return _BINARY[type(node.op)](left, right)

    def _unaryop(self, node: ast.UnaryOp, scope: Scope) -> Any:
        value = self.value(node.operand, scope)
        if not is_literal(value):
            return NotImplemented
        return (not value) if isinstance(node.op, ast.Not) else -value if isinstance(node.op, ast.USub) else +value

    def _boolop(self, node: ast.BoolOp, scope: Scope) -> Any:
        stops = isinstance(node.op, ast.Or)
        value: Any = NotImplemented
        for part in node.values:
            value = self.value(part, scope)
            if not is_literal(value):
                return NotImplemented
            if bool(value) is stops:
                return value
        return value

    def _compare(self, node: ast.Compare, scope: Scope) -> Any:
        left = self.value(node.left, scope)
        for op, right_node in zip(node.ops, node.comparators, strict=True):
            right = self.value(right_node, scope)
            if right is None and isinstance(left, (StateInfo, Instance, Class, Function)):
                return isinstance(op, (ast.IsNot, ast.NotEq))
            if not (is_literal(left) and is_literal(right)):
                return NotImplemented
            if not _COMPARE[type(op)](left, right):
                return False
            left = right
        return True

    def _ifexp(self, node: ast.IfExp, scope: Scope) -> Any:
        test = self.value(node.test, scope)
        return self.value(node.body if test else node.orelse, scope) if is_literal(test) else NotImplemented

    def _subscript(self, node: ast.Subscript, scope: Scope) -> Any:
        value = self.value(node.value, scope)
        if isinstance(value, UserDataOf):
            key = self.value(node.slice, scope)
            return getattr(value.target, "userdata", {}).get(key, NotImplemented)
        if isinstance(node.slice, ast.Slice):
            low, high = self.value(node.slice.lower, scope), self.value(node.slice.upper, scope)
            return value[low:high] if node.slice.step is None else NotImplemented
        return value[self.value(node.slice, scope)] if isinstance(value, (list, tuple, dict, str)) else NotImplemented

    def _attribute(self, node: ast.Attribute, scope: Scope) -> Any:
        return self.attribute_of(self.value(node.value, scope), node, scope)

    def attribute_of(self, value: object, node: ast.Attribute, scope: Scope) -> Any:
        """Return the attribute that `node` names of a value."""
        if isinstance(value, UserDataOf):
            return getattr(value.target, "userdata", {}).get(node.attr, NotImplemented)
        if isinstance(value, (StateInfo, Instance)):
            return self.attribute(value, node, scope)
        if isinstance(value, Class):
            found = self.member(value, node.attr)
            return Bound(value, node.attr) if found is None else found
        if isinstance(value, Reference):
            return Reference(f"{value.name}.{node.attr}", express_or_none(node, scope))
        if any(isinstance(value, t) and node.attr in names for t, names in _PURE.items()):
            return Bound(value, node.attr)
        return NotImplemented

    def attribute(self, value: StateInfo | Instance, node: ast.Attribute, scope: Scope) -> Any:
        """Return an attribute of an object that the file makes."""
        if node.attr == "userdata" and isinstance(value, ContainerInfo):
            return UserDataOf(value)
        if node.attr in value.attributes:
            return value.attributes[node.attr]
        cls = value.cls if isinstance(value, Instance) else value.home
        held = self.member(cls, node.attr) if isinstance(cls, Class) else None
        if held is not None and not isinstance(held, Function):
            return held
        if held is not None or isinstance(value, StateInfo):
            return Bound(value, node.attr)
        return NotImplemented

    def member(self, cls: Class, name: str) -> Any:
        """Return what a class or one of its bases in the project defines under a name; None for nothing."""
        for each in self.lineage(cls):
            if isinstance(each, Class) and name in each.names:
                return each.names[name]
        return None

    def lineage(self, cls: object) -> list[Any]:
        """Return a class and its bases, depth first, as classes of the project and references to others."""
        found: list[Any] = [cls]
        if isinstance(cls, Class):
            for base in cls.bases:
                found.extend(each for each in self.lineage(base) if each not in found)
        return found

    def kind_of(self, cls: Any) -> str:
        """Return the class of smach or smach_ros that a class comes from; empty when none is known."""
        for each in self.lineage(cls):
            if isinstance(each, Reference) and each.name.split(".")[0] in ("smach", "smach_ros"):
                return each.name.split(".")[-1]
        return ""

    def is_container(self, cls: object) -> bool:
        """Whether a class is one of smach's containers."""
        return self.kind_of(cls) in CONTAINERS

    def _listcomp(self, node: ast.ListComp, scope: Scope) -> Any:
        return [self.value(node.elt, inner) for inner in self._rounds(node.generators, scope)]

    _generatorexp = _listcomp

    def _dictcomp(self, node: ast.DictComp, scope: Scope) -> Any:
        rounds = self._rounds(node.generators, scope)
        return {self.value(node.key, inner): self.value(node.value, inner) for inner in rounds}

    def _rounds(self, generators: list[ast.comprehension], scope: Scope) -> Any:
        first, *rest = generators
        for item in self.known(first.iter, scope):
            inner = scope.inner()
            bind(first.target, item, inner)
            tests = [self.value(test, inner) for test in first.ifs]
            if not all(is_literal(test) for test in tests):
                raise ValueError("a test that is known only at run time")
            if all(tests):
                yield from self._rounds(rest, inner) if rest else (inner,)

    def _call(self, node: ast.Call, scope: Scope) -> Any:
        return self.call(node, scope)

    def library(self, name: str, arguments: list[Any], named: dict[str, Any]) -> Any:
        """Call a function of Python's library on what is known."""
        known = all(map(is_literal, (*arguments, *named.values())))
        ranges = any(isinstance(a, range) and len(a) > _LARGEST for a in arguments)
        return _LIBRARY[name](*arguments, **named) if name in _LIBRARY and known and not ranges else NotImplemented

    def pure(self, target: object, name: str, arguments: list[Any], named: dict[str, Any]) -> Any:
        """Call a method of a Python value, or a builtin function where `target` is None."""
        if any(isinstance(a, range) and len(a) > _LARGEST for a in arguments):
            return NotImplemented
        if target is None:
            if name in ("len", "list", "tuple", "enumerate", "zip", "reversed") or all(map(is_literal, arguments)):
                return _FUNCTIONS[name](*arguments, **named)
            return NotImplemented
        if isinstance(target, str) and not all(map(is_literal, (*arguments, *named.values()))):
            return NotImplemented
        return getattr(target, name)(*arguments, **named)


def bind(target: ast.expr, value: Any, scope: Scope) -> None:
    """Bind the names of a simple target; what can't be taken apart becomes opaque."""
    if isinstance(target, ast.Name):
        scope.names[target.id] = value
    elif isinstance(target, (ast.Tuple, ast.List)):
        known = isinstance(value, (tuple, list)) and len(value) == len(target.elts)
        for i, each in enumerate(target.elts):
            bind(each, value[i] if known else Unresolved(ast.unparse(each)), scope)


def _limited(items: Iterable[object]) -> list[Any]:
    found = list(itertools.islice(items, _LARGEST + 1))
    if len(found) > _LARGEST:
        raise ValueError("too many items to follow")
    return found


def _size(value: Any) -> int:
    return int(abs(value)) if isinstance(value, (int, float)) else len(value)
