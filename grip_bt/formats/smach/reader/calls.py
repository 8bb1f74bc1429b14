"""Calls in a legacy file: objects that are made, and what smach's own functions do to them."""

from __future__ import annotations

import ast
from typing import Any

from . import construction
from .evaluation import GET_PARAMETER, Evaluation, default_given
from .found import CONTAINERS, FIXED_OUTCOMES, MISSING, ContainerInfo, Reference, Span, StateInfo, Unresolved
from .names import Bound, Class, Function, Instance, Project, Scope, UnresolvedError, UserDataOf, express

_STATES = ("State", "CBState", *FIXED_OUTCOMES)


class Calls(Evaluation):
    """What has been found, and the calls that find more.

    Attributes:
        open: the containers whose `with` block is being read.
        conditions: what has to hold for the code that is being read, and whether it makes a machine unknowable.
        running: the functions whose bodies are being read.
        base: how many of the conditions lie outside the innermost of them.
        in_main: whether what is read happens only when the file is run and not when it is imported.
        steps: how many statements were read.
        modules: modules of the project that were imported as modules, by name.
    """

    def __init__(self, project: Project):
        self.project = project
        self.containers: list[ContainerInfo] = []
        self.open: list[ContainerInfo] = []
        self.conditions: list[tuple[str, bool]] = []
        self.running: list[Function] = []
        self.base = 0
        self.in_main = False
        self.steps = 0
        self.modules: dict[str, Scope] = {}

    def apply(self, function: Function, arguments: list[object], named: dict[str, object]) -> object:
        """Follow a function; the interpreter does."""
        raise NotImplementedError

    def span(self, node: ast.AST, scope: Scope) -> Span:
        """Return where a piece of source is."""
        line = getattr(node, "lineno", 1)
        return Span(scope.file, line, getattr(node, "col_offset", 0) + 1, getattr(node, "end_lineno", None) or line)

    def arguments(self, node: ast.Call, scope: Scope) -> tuple[list[Any], dict[str, Any]]:
        """Evaluate the arguments of a call."""
        named: dict[str, Any] = {}
        for keyword in node.keywords:
            value = self.value(keyword.value, scope)
            if keyword.arg is not None:
                named[keyword.arg] = value
            elif isinstance(value, dict):
                named.update(value)
        return list(self._items(node.args, scope)), named

    def call(self, node: ast.Call, scope: Scope) -> object:
        """Follow a call."""
        if isinstance(node.func, ast.Name) and node.func.id == "super" and scope.find("super") is None:
            return self._super(node, scope)
        callee = self._callee(node.func, scope)
        arguments, named = self.arguments(node, scope)
        span = self.span(node, scope)
        if isinstance(callee, Class):
            return self._make(callee, arguments, named, node, scope, span)
        if isinstance(callee, Function):
            return self.apply(callee, arguments, named)
        if isinstance(callee, Reference):
            return self._reference(callee, arguments, named, node, scope, span)
        if isinstance(callee, Bound):
            return self._method(callee, arguments, named, span)
        return NotImplemented

    def _callee(self, node: ast.expr, scope: Scope) -> object:
        callee = self.value(node, scope)
        if isinstance(callee, Reference):
            module, _, name = callee.name.rpartition(".")
            there = self.modules.get(module)
            if there is not None and name in there.names:
                return there.names[name]
        return callee

    def _super(self, node: ast.Call, scope: Scope) -> object:
        function = next((f for f in reversed(self.running) if f.owner is not None), None)
        me = scope.find(function.node.args.args[0].arg) if function and function.node.args.args else None
        if function is None or me is None:
            return NotImplemented
        for base in function.owner.bases if function.owner else ():
            return Bound((base, me[0]), "super")
        return NotImplemented

    def _attribute(self, node: ast.Attribute, scope: Scope) -> object:
        if isinstance(node.value, ast.Call):
            owner = self.value(node.value, scope)
            if isinstance(owner, Bound) and owner.name == "super":
                base, me = owner.target
                held = self.member(base, node.attr) if isinstance(base, Class) else None
                return Bound((held or base, me), node.attr)
            return self.attribute_of(owner, node, scope)
        return super()._attribute(node, scope)

    # --- making objects ---

    def _make(
        self, cls: Class, arguments: list[object], named: dict[str, object], node: ast.Call, scope: Scope, span: Span
    ) -> object:
        kind = self.kind_of(cls)
        external = [b for b in self.lineage(cls) if isinstance(b, Unresolved) or _of_a_package(b)]
        if not kind and not external:
            made = Instance(cls)
            init = self.member(cls, "__init__")
            if isinstance(init, Function):
                self.apply(init, [made, *arguments], named)
            return made
        found = self.instantiate(cls, arguments, named, kind, span)
        self._express(found, node, scope)
        return found

    def instantiate(
        self, cls: Class, arguments: list[object], named: dict[str, object], kind: str | None, span: Span
    ) -> StateInfo:
        """Make an object of a class of the project whose base is a state or a container."""
        kind = self.kind_of(cls) if kind is None else kind
        cls.made += 1
        found = self._new(kind, cls.name, span)
        found.home = cls
        init = self.member(cls, "__init__")
        if isinstance(init, Function):
            self.apply(init, [found, *arguments], named)
            if isinstance(found, ContainerInfo):
                self._entry_of_class(found, cls, init)
        elif kind:
            construction.initialise(self, found, kind, arguments, named)
        if kind and not found.initialised:
            construction.initialise(self, found, kind, [], {})
        return found

    def _entry_of_class(self, found: ContainerInfo, cls: Class, init: Function) -> None:
        spec = init.node.args
        if cls.scope.is_module and len(spec.args) - 1 - len(spec.defaults) <= 0 and found.entry is None:
            found.entry = ast.Attribute(ast.Name("legacy", ast.Load()), cls.name, ast.Load())
            found.entry_is_call, found.entry_file = True, cls.scope.file

    def _new(self, kind: str, cls: str, span: Span) -> StateInfo:
        if kind not in CONTAINERS:
            return StateInfo(kind, cls, span)
        made = ContainerInfo(kind, cls, span)
        self.containers.append(made)
        return made

    def _express(self, found: StateInfo, node: ast.Call, scope: Scope) -> None:
        try:
            found.expression, found.file = express(node, scope), scope.file
        except UnresolvedError as error:
            found.why = f"`{ast.unparse(node)}` needs `{error}`, known only at run time"

    def _reference(
        self,
        callee: Reference,
        arguments: list[object],
        named: dict[str, object],
        node: ast.Call,
        scope: Scope,
        span: Span,
    ) -> object:
        package, _, rest = callee.name.partition(".")
        last = callee.name.split(".")[-1]
        if package == "builtins":
            return self.pure(None, rest, arguments, named)
        if package in ("smach", "smach_ros"):
            if last in CONTAINERS or last in _STATES:
                found = self._new(last, last, span)
                construction.initialise(self, found, last, arguments, named)
                self._express(found, node, scope)
                return found
            if last == "UserData" and not arguments:
                return UserDataOf(ContainerInfo("UserData", "UserData", span))  # of no container yet
            owner = callee.name.split(".")[-2] if callee.name.count(".") > 1 else ""
            if last == "__init__" and arguments and isinstance(arguments[0], StateInfo):
                construction.initialise(self, arguments[0], owner, arguments[1:], named)
                return None
            if owner in CONTAINERS:
                return construction.call(self, owner, last, None, arguments, named, span)
        if callee.name == GET_PARAMETER and self.assuming:
            default = default_given(arguments, named)
            return NotImplemented if default is MISSING else default
        return self.library(callee.name, arguments, named)

    # --- methods ---

    def _method(self, bound: Bound, arguments: list[object], named: dict[str, object], span: Span) -> object:
        target, name = bound.target, bound.name
        if isinstance(target, tuple) and name != "super" and len(target) == 2:
            return self._base_method(target, name, arguments, named, span)
        if isinstance(target, Class):
            return construction.call(self, self.kind_of(target), name, None, arguments, named, span)
        if isinstance(target, (StateInfo, Instance)):
            cls = target.cls if isinstance(target, Instance) else target.home
            method = self.member(cls, name) if isinstance(cls, Class) else None
            if isinstance(method, Function):
                decorators = {ast.unparse(d) for d in getattr(method.node, "decorator_list", ())}
                return self.apply(method, arguments if "staticmethod" in decorators else [target, *arguments], named)
            if isinstance(target, StateInfo):
                return construction.call(self, target.kind, name, target, arguments, named, span)
            return NotImplemented
        return self.pure(target, name, arguments, named)

    def _base_method(self, pair: Any, name: str, arguments: list[Any], named: dict[str, Any], span: Span) -> Any:
        base, me = pair
        if isinstance(base, Function):
            return self.apply(base, [me, *arguments], named)
        if not isinstance(me, StateInfo):
            return NotImplemented
        kind = self.kind_of(base)
        if name == "__init__":
            if kind:
                construction.initialise(self, me, kind, arguments, named)
            return None
        return construction.call(self, kind, name, me, arguments, named, span)

    def doubtful(self, container: ContainerInfo, what: str, span: Span) -> None:
        """Note that what happens to a container hangs on what is known only at run time."""
        for text, failed in self.conditions:
            container.problem("failed" if failed else "partial", f"{what} {text}", span)

    def set_userdata(self, container: StateInfo, key: str, value: object, span: Span) -> None:
        """Note an initial value."""
        if isinstance(container, ContainerInfo):
            container.userdata[key] = value
            self.doubtful(container, f"userdata `{key}` is set", span)


def _of_a_package(base: object) -> bool:
    return isinstance(base, Reference) and not base.name.startswith("builtins.")
