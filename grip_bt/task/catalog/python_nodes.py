"""Nodes of a project that are written in Python: their manifests, read from the source without running it.

The arguments of the decorator `grip_bt.leaf(...)` and all defaults are literals, so that checking a task or opening the
editor never runs a project's code; it is imported when a task that uses it is run.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.types import check_value, parse_type
from grip_bt.base.yaml.tree import read_file

from .manifest import InputPort, Manifest, OutputPort, Parameter
from .source_code import imported

_DECORATORS = ("grip_bt.leaf", "grip_bt.nodes.function.leaf")
_ARGUMENTS = ("id", "doc", "outputs", "codes", "outcomes", "quick", "moves")
_PORTS = ("Input", "Output", "Param")
_Ports = tuple[dict[str, InputPort], dict[str, Parameter], dict[str, OutputPort]]
_Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def find_python_nodes(folder: Path | str) -> list[Manifest]:
    """Return the manifests of all decorated functions and classes in a folder and below it, in the order of the files.

    Hidden folders, and files whose name begins with `test_` or `_`, are left out.

    Raises:
        DocumentError: a file isn't Python, or what is decorated isn't a node; with line and column.
    """
    files = sorted(Path(folder).glob("**/*.py"))
    hidden = [file for file in files if any(part[0] in "_." for part in file.relative_to(folder).parts)]
    read = [file for file in files if file not in hidden and not file.name.startswith("test_")]
    return [manifest for file in read for manifest in read_python_nodes(file)]


def read_python_nodes(path: Path | str) -> list[Manifest]:
    """Return the manifests of one file's decorated functions and classes.

    Raises:
        DocumentError: see `find_python_nodes`.
    """
    text = read_file(path)
    return list(_nodes_in(text, Path(path).resolve(), str(path))) if "leaf" in text else []


@lru_cache(maxsize=256)  # a campaign's trials read the same files again and again
def _nodes_in(text: str, file: Path, path: str) -> tuple[Manifest, ...]:
    try:
        module = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line, column = getattr(error, "lineno", None), getattr(error, "offset", None)
        message = getattr(error, "msg", None) or str(error)
        raise DocumentError(f"isn't Python: {message}", path, line, column) from None
    return tuple(_Source(path, file, module).manifests())


class _Source:
    def __init__(self, path: str, file: Path, module: ast.Module):
        self._path, self._file, self._module = path, file, module
        self._names = dict(imported(module))

    def manifests(self) -> Iterator[Manifest]:
        for item in self._module.body:
            if isinstance(item, _Definition):
                for decorator in item.decorator_list:
                    if self._meaning(decorator.func if isinstance(decorator, ast.Call) else decorator) in _DECORATORS:
                        yield self._manifest(item, decorator)

    def _manifest(self, item: _Definition, decorator: ast.expr) -> Manifest:
        said = self._arguments(decorator)
        ports = self._ports_of_class(item) if isinstance(item, ast.ClassDef) else self._ports_of_function(item)
        inputs, parameters, outputs = ports
        if "outputs" in said:
            outputs = {**outputs, **self._outputs(said.pop("outputs"))}
        doc = said.pop("doc", None) or ast.get_docstring(item) or str(said.get("id", ""))
        said.pop("quick", None)
        if not isinstance(item, ast.ClassDef):
            arguments = (*item.args.posonlyargs, *item.args.args, *item.args.kwonlyargs)
            if not any(map(self._is_context, arguments)):
                said.setdefault("moves", False)
        try:
            return Manifest(
                doc=doc,
                implementation=f"{self._file}:{item.name}",
                parameters=FrozenDict(parameters),
                inputs=FrozenDict(inputs),
                outputs=FrozenDict(outputs),
                **said,
            )
        except ValidationError as error:
            first = error.errors()[0]
            where = "/".join(str(part) for part in first["loc"])
            raise self._fault(decorator, f"{item.name}: {where}: {first['msg']}") from None

    def _arguments(self, decorator: ast.expr) -> dict[str, Any]:
        """Return the decorator's arguments; all but `outputs`, whose values are types, are literals."""
        if not isinstance(decorator, ast.Call):
            raise self._fault(decorator, "the decorator needs the node's id: @leaf('group/name')")
        given: dict[str, ast.expr] = dict(zip(_ARGUMENTS[:1], decorator.args, strict=False))
        if len(decorator.args) > 1:
            raise self._fault(decorator.args[1], "only the id is given without a name")
        for keyword in decorator.keywords:
            if keyword.arg not in _ARGUMENTS:
                hint = nearest(str(keyword.arg), _ARGUMENTS)
                raise self._fault(
                    keyword.value, f"leaf() has no {keyword.arg!r}{hint} (available: {listing(_ARGUMENTS)})"
                )
            given[str(keyword.arg)] = keyword.value
        if "id" not in given:
            raise self._fault(decorator, "the decorator needs the node's id: @leaf('group/name')")
        return {k: v if k == "outputs" else self._literal(v, k) for k, v in given.items()}

    def _outputs(self, given: ast.expr) -> dict[str, OutputPort]:
        if isinstance(given, ast.Constant) and given.value is None:
            return {}
        if not isinstance(given, ast.Dict):
            raise self._fault(given, "outputs are written {'port': type}")
        ports = {}
        for key, value in zip(given.keys, given.values, strict=True):
            if not isinstance(key, ast.Constant) or not isinstance(key.value, str):
                raise self._fault(key or given, "the name of an output is a text")
            ports[key.value] = OutputPort(type=self._type(value, key.value))
        return ports

    def _ports_of_function(self, item: ast.FunctionDef | ast.AsyncFunctionDef) -> _Ports:
        arguments = item.args
        if arguments.vararg or arguments.kwarg:
            raise self._fault(item, f"{item.name}: a node takes a fixed number of arguments, not * or **")
        plain = [*arguments.posonlyargs, *arguments.args]
        absent: list[ast.expr | None] = [None] * (len(plain) - len(arguments.defaults))
        inputs, parameters = {}, {}
        for argument, default in zip(plain, [*absent, *arguments.defaults], strict=True):
            if not self._is_context(argument):
                inputs[argument.arg] = InputPort(type=self._annotated(argument), required=default is None)
        for argument, default in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True):
            if not self._is_context(argument):
                parameters[argument.arg] = self._parameter(self._annotated(argument), argument.arg, default)
        return inputs, parameters, {}

    def _ports_of_class(self, item: ast.ClassDef) -> _Ports:
        made: _Ports = ({}, {}, {})
        inputs, parameters, outputs = made
        for line in item.body:
            if not isinstance(line, ast.AnnAssign) or not isinstance(line.target, ast.Name):
                continue
            hint, name = line.annotation, line.target.id
            kind = _last_name(hint.value) if isinstance(hint, ast.Subscript) else ""
            if kind not in _PORTS:
                continue
            assert isinstance(hint, ast.Subscript)
            type_ = self._type(hint.slice, name)
            if kind == "Input":
                inputs[name] = InputPort(type=type_, required=line.value is None)
            elif kind == "Param":
                parameters[name] = self._parameter(type_, name, line.value)
            else:
                outputs[name] = OutputPort(type=type_)
        return made

    def _parameter(self, type_: str, name: str, default: ast.expr | None) -> Parameter:
        if default is None:
            return Parameter(type=type_)
        value = self._literal(default, name)
        if reason := check_value(type_, value):
            raise self._fault(default, f"{name}: the default {reason}")
        return Parameter(type=type_, default=value)

    def _annotated(self, argument: ast.arg) -> str:
        if argument.annotation is None:
            raise self._fault(argument, f"{argument.arg!r} needs an annotation: its type is the port's")
        return self._type(argument.annotation, argument.arg)

    def _is_context(self, argument: ast.arg) -> bool:
        return argument.annotation is not None and _last_name(argument.annotation) == "Context"

    def _type(self, hint: ast.expr, name: str) -> str:
        """Return how a manifest spells an annotation: modules before names are dropped, `Optional[T]` is `T | None`."""
        text = _spelled(hint)
        try:
            parse_type(text)
        except ValueError as error:
            raise self._fault(hint, f"{name}: {error}") from None
        return text

    def _literal(self, value: ast.expr, name: str) -> object:
        try:
            return ast.literal_eval(value)
        except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
            raise self._fault(value, f"{name}: a literal is needed here, since the file isn't run to find it") from None

    def _meaning(self, name: ast.expr) -> str:
        """Return the full name that a name or attribute stands for by the file's imports."""
        if isinstance(name, ast.Attribute):
            return f"{self._meaning(name.value)}.{name.attr}"
        return self._names.get(name.id, "") if isinstance(name, ast.Name) else ""

    def _fault(self, at: ast.AST, message: str) -> DocumentError:
        line, column = getattr(at, "lineno", None), getattr(at, "col_offset", None)
        return DocumentError(message, str(self._path), line, None if column is None else column + 1)


def _last_name(hint: ast.expr) -> str:
    if isinstance(hint, ast.Constant) and isinstance(hint.value, str):
        return hint.value.rpartition(".")[2]
    return hint.attr if isinstance(hint, ast.Attribute) else hint.id if isinstance(hint, ast.Name) else ""


def _spelled(hint: ast.expr) -> str:
    if isinstance(hint, ast.Constant):
        return str(hint.value)
    if isinstance(hint, ast.BinOp) and isinstance(hint.op, ast.BitOr):
        return f"{_spelled(hint.left)} | {_spelled(hint.right)}"
    if isinstance(hint, ast.Subscript):
        inner = hint.slice.elts if isinstance(hint.slice, ast.Tuple) else [hint.slice]
        parts = ", ".join(_spelled(part) for part in inner)
        outer = _last_name(hint.value)
        return f"{parts} | None" if outer == "Optional" else f"{_PLAIN.get(outer, outer)}[{parts}]"
    return _PLAIN.get(_last_name(hint), _last_name(hint)) or ast.unparse(hint)


_PLAIN = {"List": "list", "Sequence": "list", "Dict": "dict", "Mapping": "dict"}
