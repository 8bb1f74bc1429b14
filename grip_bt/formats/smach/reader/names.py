"""Where names of legacy code lead: the project's modules, and the scopes of each."""

from __future__ import annotations

import ast
import builtins
import copy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError
from grip_bt.nodes.smach_source import Source, read_source

from .found import Reference, StateInfo, Unresolved

SMACH = {
    **{name: f"smach.{name}" for name in ("State", "CBState", "StateMachine", "Sequence", "Concurrence", "Iterator")},
    **{name: f"smach.{name}" for name in ("Container", "UserData", "Remapper", "cb_interface", "CBInterface")},
    **{name: f"smach.{name}" for name in ("set_loggers", "set_shutdown_check", "has_smach_interface")},
}
SMACH_ROS = {
    name: f"smach_ros.{name}"
    for name in (
        *("SimpleActionState", "ServiceState", "MonitorState", "ConditionState", "RosState"),
        *("ActionServerWrapper", "IntrospectionServer", "IntrospectionClient", "set_preempt_handler"),
    )
}
MODULE = "legacy"
"""How generated code calls the legacy module."""


@dataclass
class Project:
    """Files by module name.

    Attributes:
        root: the folder in which modules are looked for, besides the importing file's own.
        scopes: the modules that have been read.
    """

    root: Path
    sources: dict[Path, Source] = field(default_factory=dict)
    scopes: dict[Path, Scope] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._roots = [self.root, self.root / "src", *sorted(self.root.glob("*/src"))]

    def source(self, file: Path) -> Source:
        """Read a file, once.

        Raises:
            DocumentError: it isn't Python.
        """
        if file not in self.sources:
            self.sources[file] = read_source(file)
        return self.sources[file]

    def find(self, module: str, beside: Path, level: int = 0) -> Path | None:
        """Return the file of a module; None when it isn't part of the project."""
        parts = [p for p in module.split(".") if p]
        folders = [beside.parent]
        for _ in range(level - 1):
            folders = [folders[0].parent]
        if level == 0:
            folders += self._roots
        for folder in folders:
            for candidate in (folder.joinpath(*parts).with_suffix(".py"), folder.joinpath(*parts, "__init__.py")):
                if parts and candidate.is_file() and self._readable(candidate):
                    return candidate
        return None

    def _readable(self, file: Path) -> bool:
        try:
            self.source(file)
        except DocumentError:
            return False
        return True


class UnresolvedError(Exception):
    """Source uses a name that is known only at run time."""


@dataclass(eq=False)
class Scope:
    """Names of a module, or of one call of a function.

    Attributes:
        names: name -> value.
        outer: the scope around it.
        file: where its code is.
        is_module: whether its names are there once the module is imported.
        takes_more: whether a star import from a package that isn't here may give it any name.
    """

    names: dict[str, Any] = field(default_factory=dict)
    outer: Scope | None = None
    file: Path = Path()
    is_module: bool = False
    takes_more: bool = False

    def find(self, name: str) -> tuple[object, Scope] | None:
        """Return a name's value and the scope that holds it."""
        scope: Scope | None = self
        while scope is not None:
            if name in scope.names:
                return scope.names[name], scope
            scope = scope.outer
        return None

    def inner(self) -> Scope:
        """Return a new scope within this one."""
        return Scope(outer=self, file=self.file)


@dataclass(eq=False)
class Function:
    """A function of a legacy file; `owner` is the class that defines it."""

    node: ast.FunctionDef | ast.Lambda
    scope: Scope
    name: str
    owner: Class | None = None
    interface: dict[str, object] | None = None
    called: bool = False


@dataclass(eq=False)
class Class:
    """A class of a legacy file."""

    node: ast.ClassDef
    scope: Scope
    bases: list[object]
    names: dict[str, Any] = field(default_factory=dict)
    made: int = 0

    @property
    def name(self) -> str:
        """The name of the class."""
        return self.node.name


@dataclass(frozen=True)
class Bound:
    """A method of an object."""

    target: Any
    name: str


@dataclass(eq=False)
class Instance:
    """An object of a class that is no state."""

    cls: Class
    attributes: dict[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class UserDataOf:
    """The userdata of a container."""

    target: StateInfo


def is_literal(value: object, depth: int = 0) -> bool:
    """Tell whether a value is wholly known."""
    if depth > 20:
        return False
    if isinstance(value, dict):
        return all(is_literal(k, depth + 1) and is_literal(v, depth + 1) for k, v in value.items())
    if isinstance(value, (list, tuple, set, frozenset)):
        return all(is_literal(v, depth + 1) for v in value)
    return value is None or isinstance(value, (bool, int, float, str, bytes, range))


def literal_source(value: object) -> ast.expr:
    """Return the source of a known value."""
    return ast.parse(repr(value), mode="eval").body


def express(node: ast.expr, scope: Scope) -> ast.expr:
    """Return source that means the same in generated code, where the module is called `legacy`.

    Raises:
        UnresolvedError: it uses what is known only at run time.
    """
    made: ast.expr = _Expressed(scope).visit(copy.deepcopy(node))
    return made


def express_or_none(node: ast.expr, scope: Scope) -> ast.expr | None:
    """Return what `express` does; None where it refuses."""
    try:
        return express(node, scope)
    except UnresolvedError:
        return None


class _Expressed(ast.NodeTransformer):
    def __init__(self, scope: Scope):
        self.scope = scope
        self.bound: set[str] = set()

    def visit_Lambda(self, node: ast.Lambda) -> ast.expr:
        self.bound.update(a.arg for a in ast.walk(node.args) if isinstance(a, ast.arg))
        return self.generic_visit(node)  # type: ignore[return-value]

    def visit_comprehension(self, node: ast.comprehension) -> ast.AST:
        self.bound.update(n.id for n in ast.walk(node.target) if isinstance(n, ast.Name))
        return self.generic_visit(node)

    def _comprehension(self, node: Any) -> Any:
        node.generators = [self.visit(g) for g in node.generators]
        return self.generic_visit(node)

    visit_ListComp = visit_SetComp = visit_DictComp = visit_GeneratorExp = _comprehension

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        if isinstance(node.value, ast.Name):
            found = self.scope.find(node.value.id)
            if found is not None and isinstance(found[0], (StateInfo, Instance)):
                held = found[0].attributes.get(node.attr, UnresolvedError)
                if is_literal(held):
                    return literal_source(held)
        return self.generic_visit(node)  # type: ignore[return-value]

    def visit_Name(self, node: ast.Name) -> ast.expr:
        name = node.id
        if name in self.bound or not isinstance(node.ctx, ast.Load):
            return node
        found = self.scope.find(name)
        if found is None:
            if hasattr(builtins, name):
                return node
            if _outermost(self.scope).takes_more:
                return ast.Attribute(ast.Name(MODULE, ast.Load()), name, ast.Load())
            raise UnresolvedError(name)
        value, holder = found
        if holder.is_module:
            return ast.Attribute(ast.Name(MODULE, ast.Load()), name, ast.Load())
        if is_literal(value):
            return literal_source(value)
        if isinstance(value, StateInfo):  # made here, used there: only the machine that is built has both
            value.expression, value.why = None, f"the object of {value.cls} is used by another"
        if isinstance(value, (Unresolved, Reference)) and value.expression is not None and not _makes(value.expression):
            return value.expression
        raise UnresolvedError(name)


def _outermost(scope: Scope) -> Scope:
    return scope if scope.outer is None else _outermost(scope.outer)


def _makes(expression: ast.expr) -> bool:
    """Whether it makes something: two uses of a local variable share an object, two copies of its source don't."""
    return any(isinstance(n, ast.Call) for n in ast.walk(expression))
