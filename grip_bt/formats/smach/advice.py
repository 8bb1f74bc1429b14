"""What somebody can do about containers that weren't imported exactly."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from typing import Any

from .files import ImportedFile
from .found import FoundContainer
from .project import Project

_BY_A_RUN = ("only a run knows", "known only by a run")


def advice(imported: ImportedFile, executed: bool, given: Mapping[str, Mapping[str, Any]] | None = None) -> list[str]:
    """Return what to do, in lines; none where everything is exact.

    Args:
        imported: what became of a file.
        executed: whether it was run.
        given: the arguments that it was run with.
    """
    open_ = [c for c in imported.containers if c.verdict != "exact"]
    unknown = [c for c in open_ if any(words in p.text for p in c.problems for words in _BY_A_RUN)]
    lines = []
    if unknown and not executed:
        lines.append("what only a run knows: import it again with --execute, which runs the file, if you trust it")
    needs = _arguments(imported, unknown, given or {})
    for name, parameters in needs.items():
        said = ", ".join(f"{parameter}: ..." for parameter in parameters)
        how = "" if executed else "--execute and "
        lines.append(f"what {name} is given: {how}--arguments FILE.yaml with `{name}: {{{said}}}`")
    if executed and any(c.verdict == "failed" for c in unknown) and not needs:
        lines.append(
            "what it takes from its surroundings: write a function without arguments that builds the machine, and use"
            " grip_bt.from_machine(build(), source=build)"
        )
    return lines


def _arguments(
    imported: ImportedFile, unknown: list[FoundContainer], given: Mapping[str, Mapping[str, Any]]
) -> dict[str, list[str]]:
    """Return class or function around a container -> parameters that have no default and weren't given."""
    tree = Project(imported.file.parent).source(imported.file).tree
    found: dict[str, list[str]] = {}
    for container in unknown:
        for node in tree.body:
            inside = node.lineno <= container.span.line <= (node.end_lineno or node.lineno)
            own = isinstance(node, ast.ClassDef) and node.name == container.cls
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and (own or inside):
                missing = [p for p in _required(node) if p not in given.get(node.name, {})]
                if missing:
                    found[node.name] = missing
    return found


def _required(node: ast.ClassDef | ast.FunctionDef) -> list[str]:
    if isinstance(node, ast.ClassDef):
        made = next((n for n in node.body if isinstance(n, ast.FunctionDef) and n.name == "__init__"), None)
        return _required(made)[1:] if made is not None else []
    arguments = node.args.posonlyargs + node.args.args
    required = arguments[: len(arguments) - len(node.args.defaults)]
    return [a.arg for a in required] + [
        a.arg for a, default in zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True) if default is None
    ]
