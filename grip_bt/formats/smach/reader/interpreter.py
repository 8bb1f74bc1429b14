"""Reads a legacy file statement by statement, as far as its construction code says without being run.

Module code, `__main__` blocks, constructors and functions are followed with what is surely known; a branch or loop
whose condition is known only at run time is followed too, and the containers that it changes say so. Nothing is
executed.
"""

from __future__ import annotations

import ast
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .calls import Calls
from .evaluation import assumption_text, bind, default_of
from .found import ContainerInfo, Reference, Span, StateInfo, Unresolved
from .names import SMACH, SMACH_ROS, Class, Function, Instance, Scope, UserDataOf, is_literal

_DEEPEST = 25
_LOOPS = 1000
MOST_STEPS = 50_000
"""Statements that are followed; beyond, functions aren't entered any more."""


class _Return(Exception):
    def __init__(self, value: object):
        self.value = value


class _Leave(Exception):
    """`break` or `continue`."""

    def __init__(self, again: bool):
        self.again = again


class Interpreter(Calls):
    """Reads the files of a project; `containers` are all that were found, in the order in which they are made."""

    # --- modules ---

    def module(self, file: Path) -> Scope:
        """Return the names of a module, reading it if that wasn't done.

        Raises:
            DocumentError: it isn't Python.
        """
        scope = self.project.scopes.get(file)
        if scope is None:
            source = self.project.source(file)
            scope = Scope(file=file, is_module=True)
            scope.names["__name__"] = file.stem
            scope.names["__file__"] = Unresolved("__file__")
            self.project.scopes[file] = scope
            opened, self.open = self.open, []
            self.body(source.tree.body, scope)
            self.open = opened
        return scope

    def main_file(self, file: Path) -> Scope:
        """Read a file wholly: as a module, its `__main__` block, and what nobody calls."""
        scope = self.module(file)
        tree = self.project.source(file).tree
        self.in_main = True
        for statement in tree.body:
            if isinstance(statement, ast.If) and _is_main(statement.test):
                self.body(statement.body, scope.inner())
        derived = any(isinstance(v, Class) and self.is_container(v) for v in scope.names.values())
        if self.containers or "smach" in self.project.source(file).text or derived:
            self._rest(scope, file)
        for name, value in scope.names.items():  # what is there once the module is imported
            if isinstance(value, ContainerInfo) and value.entry is None and value.parent is None:
                value.entry = ast.Attribute(ast.Name("legacy", ast.Load()), name, ast.Load())
        for container in self.containers if self.steps > MOST_STEPS else ():
            container.problem("partial", "there is more code than is followed here: compare the states with the text")
        return scope

    def _rest(self, scope: Scope, file: Path) -> None:
        """Follow the constructors, functions and methods that nothing has called, with arguments that nobody knows."""
        mine = [v for v in scope.names.values() if isinstance(v, (Class, Function)) and v.scope.file == file]
        for value in mine:
            if isinstance(value, Function) and not value.called:
                self.apply(value, [], {})
        for value in mine:
            if isinstance(value, Class) and not self.kind_of(value):
                me = Instance(value)
                for method in [value.names.get("__init__"), *value.names.values()]:
                    if isinstance(method, Function) and not method.called:
                        self.apply(method, [me], {})
        for value in mine:
            if isinstance(value, Class) and self.is_container(value) and not value.made:
                self.instantiate(value, [], {}, None, Span(file, value.node.lineno, 1, value.node.lineno))

    # --- statements ---

    def body(self, statements: list[ast.stmt], scope: Scope) -> None:
        """Follow statements in order."""
        for statement in statements:
            self.steps += 1
            method = getattr(self, f"_do_{type(statement).__name__.lower()}", None)
            if method is not None:
                method(statement, scope)

    def _do_expr(self, node: ast.Expr, scope: Scope) -> None:
        self.value(node.value, scope)

    def _do_import(self, node: ast.Import, scope: Scope) -> None:
        for alias in node.names:
            name = alias.asname or alias.name.split(".")[0]
            scope.names[name] = Reference(alias.name if alias.asname else name, ast.Name(name, ast.Load()))
            file = self.project.find(alias.name, scope.file)
            if file is not None and file != scope.file and "." not in alias.name:
                self.modules[name if not alias.asname else alias.name] = self.module(file)

    def _do_importfrom(self, node: ast.ImportFrom, scope: Scope) -> None:
        module = node.module or ""
        file = self.project.find(module, scope.file, node.level)
        there = self.module(file) if file is not None and file != scope.file else None
        for alias in node.names:
            if alias.name == "*":
                known = SMACH if module.split(".")[0] == "smach" else SMACH_ROS if module == "smach_ros" else {}
                names = {n: v for n, v in there.names.items() if n[0] != "_"} if there is not None else {}
                if there is None and not known:
                    scope.takes_more = True
                scope.names.update({n: Reference(v) for n, v in known.items()} | names)
                continue
            name = alias.asname or alias.name
            if there is not None and alias.name in there.names:
                scope.names[name] = there.names[alias.name]
            else:
                beside = self.project.find(f"{module}.{alias.name}", scope.file, node.level)
                if beside is not None and beside != scope.file:
                    self.modules[f"{module}.{alias.name}"] = self.module(beside)
                scope.names[name] = Reference(f"{module}.{alias.name}")

    def _do_classdef(self, node: ast.ClassDef, scope: Scope) -> None:
        inner = scope.inner()
        self.body(node.body, inner)
        cls = Class(node, scope, [self.value(b, scope) for b in node.bases], inner.names)
        for value in inner.names.values():
            if isinstance(value, Function) and value.owner is None:
                value.owner, value.scope = cls, scope
        scope.names[node.name] = cls

    def _do_functiondef(self, node: ast.FunctionDef, scope: Scope) -> None:
        function = Function(node, scope, node.name)
        for decorator in node.decorator_list:
            if isinstance(decorator, ast.Call):
                made = self.value(decorator.func, scope)
                if isinstance(made, Reference) and made.name.split(".")[-1] == "cb_interface":
                    arguments, named = self.arguments(decorator, scope)
                    function.interface = dict(
                        zip(("outcomes", "input_keys", "output_keys"), arguments, strict=False), **named
                    )
        scope.names[node.name] = function

    def _do_assign(self, node: ast.Assign, scope: Scope) -> None:
        value = self.value(node.value, scope)
        for target in node.targets:
            self.assign(target, value, node.value, scope)

    def _do_annassign(self, node: ast.AnnAssign, scope: Scope) -> None:
        if node.value is not None:
            self.assign(node.target, self.value(node.value, scope), node.value, scope)

    def _take_userdata(self, owner: ContainerInfo, value: object, source: ast.expr, span: Span) -> None:
        """Note a container's store; one that is another container's too is one that the task hasn't."""
        store = value.target if isinstance(value, UserDataOf) else None
        if isinstance(store, ContainerInfo) and store.kind == "UserData" and store.parent is None:
            store.parent, owner.userdata = owner, store.userdata  # what is set later is set in both
            owner.issues += store.issues
        else:
            text = f"its userdata becomes `{ast.unparse(source)}`: SMACH shares that store, the task doesn't"
            owner.problem("partial", text, span)

    def _do_augassign(self, node: ast.AugAssign, scope: Scope) -> None:
        load = ast.parse(ast.unparse(node.target), mode="eval").body
        self.assign(node.target, self.value(ast.BinOp(load, node.op, node.value), scope), node.value, scope)

    def assign(self, target: ast.expr, value: Any, source: ast.expr, scope: Scope) -> None:
        """Bind what an assignment binds, and note userdata and attributes of what was found."""
        if isinstance(target, (ast.Attribute, ast.Subscript)):
            owner = self.value(target.value, scope)
            key = target.attr if isinstance(target, ast.Attribute) else self.value(target.slice, scope)
            if isinstance(owner, UserDataOf) and isinstance(key, str):
                self.set_userdata(owner.target, key, value, self.span(target, scope))
            elif isinstance(owner, (StateInfo, Instance)) and isinstance(key, str):
                owner.attributes[key] = value
                if key == "userdata" and isinstance(owner, ContainerInfo):
                    self._take_userdata(owner, value, source, self.span(target, scope))
                if isinstance(owner, StateInfo) and owner.expression is not None:
                    owner.expression, owner.why = None, f"`{key}` of {owner.cls} is set after it is made"
            elif isinstance(owner, dict) and is_literal(key):
                owner[key] = value
        elif isinstance(target, ast.Name) and isinstance(value, Unresolved) and not scope.is_module:
            scope.names[target.id] = Unresolved(target.id, value.expression, value.default)
        else:
            bind(target, value, scope)
            plain = isinstance(value, StateInfo) and not isinstance(value, ContainerInfo)
            if plain and isinstance(target, ast.Name) and scope.is_module and not self.conditions:
                value.expression = ast.Attribute(ast.Name("legacy", ast.Load()), target.id, ast.Load())
                value.file = scope.file

    def _do_with(self, node: ast.With, scope: Scope) -> None:
        count = 0
        for item in node.items:
            value = self.value(item.context_expr, scope)
            if isinstance(value, ContainerInfo):
                self.open.append(value)
                count += 1
                if isinstance(item.optional_vars, ast.Name):
                    scope.names[item.optional_vars.id] = None  # `with sm as x` gives None upstream
        try:
            self.body(node.body, scope)
        finally:
            del self.open[len(self.open) - count :]

    def _do_if(self, node: ast.If, scope: Scope) -> None:
        if _is_main(node.test):
            return
        test = self.value(node.test, scope)
        if is_literal(test) or isinstance(test, (StateInfo, Class, Function, Instance)):
            self.body(node.body if test else node.orelse, scope)
            return
        text = ast.unparse(node.test)
        for branch, when in ((node.body, f"only if `{text}`"), (node.orelse, f"unless `{text}`")):
            with self.under(f"{when}, known only at run time"):
                self.body(branch, scope)

    def _do_for(self, node: ast.For, scope: Scope) -> None:
        found = self.value(node.iter, scope)
        given = default_of(found)
        try:
            items = self.items(given, node.iter)[:_LOOPS]
        except (ValueError, TypeError, LookupError, AttributeError):
            bind(node.target, Unresolved(ast.unparse(node.target)), scope)
            with self.under(f"in a loop over `{ast.unparse(node.iter)}`, known only at run time", failed=True):
                self._round(node.body, scope)
            return
        if given is found:
            self._rounds_of(node, items, scope)
        else:
            with self.under(f"in a loop: {assumption_text(found, given)}"):
                self._rounds_of(node, items, scope)

    def _rounds_of(self, node: ast.For, items: list[Any], scope: Scope) -> None:
        for item in items:
            bind(node.target, item, scope)
            if not self._round(node.body, scope):
                return
        self.body(node.orelse, scope)

    def _do_while(self, node: ast.While, scope: Scope) -> None:
        for _ in range(_LOOPS):
            test = self.value(node.test, scope)
            if not is_literal(test) or test is True:
                with self.under(f"in a loop while `{ast.unparse(node.test)}`", failed=True):
                    self._round(node.body, scope)
                return
            if not test or not self._round(node.body, scope):
                return

    def _round(self, body: list[ast.stmt], scope: Scope) -> bool:
        try:
            self.body(body, scope)
        except _Leave as leave:
            return leave.again
        return True

    def _do_break(self, node: ast.Break, scope: Scope) -> None:
        if len(self.conditions) == self.base:
            raise _Leave(again=False)

    def _do_continue(self, node: ast.Continue, scope: Scope) -> None:
        if len(self.conditions) == self.base:
            raise _Leave(again=True)

    def _do_try(self, node: ast.Try, scope: Scope) -> None:
        self.body([*node.body, *node.orelse, *node.finalbody], scope)
        for handler in node.handlers:  # `except ImportError: Name = None` and the like: what is bound already stays
            inner = scope.inner()
            self.body(handler.body, inner)
            scope.names.update({k: v for k, v in inner.names.items() if k not in scope.names})

    def _do_return(self, node: ast.Return, scope: Scope) -> None:
        value = self.value(node.value, scope)
        if len(self.conditions) == self.base:
            raise _Return(value)
        if isinstance(value, StateInfo):
            scope.names.setdefault("<return>", value)

    @contextmanager
    def under(self, text: str, failed: bool = False) -> Any:
        """Follow code that a run may or may not reach."""
        self.conditions.append((text, failed))
        try:
            yield
        except (_Leave, _Return):
            pass
        finally:
            self.conditions.pop()

    # --- functions ---

    def apply(self, function: Function, arguments: list[object], named: dict[str, object]) -> object:
        """Follow a function's body and return what it returns."""
        if self.steps > MOST_STEPS or len(self.running) >= _DEEPEST or function in self.running:
            return Unresolved(f"{function.name}(...)")
        function.called = True
        scope = Scope(outer=function.scope, file=function.scope.file)
        self._parameters(function, arguments, dict(named), scope)
        if isinstance(function.node, ast.Lambda):
            return self.value(function.node.body, scope)
        base, self.base = self.base, len(self.conditions)
        opened = len(self.open)
        self.running.append(function)
        result: object = None
        try:
            self.body(function.node.body, scope)
            result = scope.names.get("<return>")
        except _Return as returned:
            result = returned.value
        except _Leave:
            pass
        finally:
            self.running.pop()
            self.base = base
            del self.open[opened:]
        self._note_entry(function, result)
        return result

    def _note_entry(self, function: Function, result: object) -> None:
        """A function of the module that needs no argument and gives a container can give it to the leaves."""
        node = function.node
        required = len(node.args.args) - len(node.args.defaults)
        plain = function.scope.is_module and function.owner is None and required <= 0
        if isinstance(result, ContainerInfo) and result.entry is None and plain and not self.conditions:
            if function not in result.executed_in:
                result.entry = ast.Attribute(ast.Name("legacy", ast.Load()), function.name, ast.Load())
                result.entry_is_call, result.entry_file = True, function.scope.file

    def _parameters(self, function: Function, arguments: list[object], named: dict[str, object], scope: Scope) -> None:
        spec = function.node.args
        names = [a.arg for a in (*spec.posonlyargs, *spec.args)]
        defaults = dict(zip(reversed(names), reversed(spec.defaults), strict=False))
        for position, name in enumerate(names):
            if position < len(arguments):
                scope.names[name] = arguments[position]
            elif name in named:
                scope.names[name] = named.pop(name)
            elif name in defaults:
                scope.names[name] = self.value(defaults[name], function.scope)
            else:
                scope.names[name] = Unresolved(name)
        for argument, default in zip(spec.kwonlyargs, spec.kw_defaults, strict=True):
            missing = Unresolved(argument.arg) if default is None else self.value(default, function.scope)
            scope.names[argument.arg] = named.pop(argument.arg, missing)
        if spec.vararg:
            scope.names[spec.vararg.arg] = tuple(arguments[len(names) :])
        if spec.kwarg:
            scope.names[spec.kwarg.arg] = named


def _is_main(test: ast.expr) -> bool:
    return isinstance(test, ast.Compare) and "__name__" in ast.unparse(test) and "__main__" in ast.unparse(test)
