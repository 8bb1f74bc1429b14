"""What an import of any source takes and gives: tasks, what has to go with them, what was found, and its files.

Files are marked as generated, so that an import replaces its own and nobody else's.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from pydantic import JsonValue

from grip_bt.base.errors import GripError, listing, plural
from grip_bt.base.files import replace_text
from grip_bt.base.issue import Issue, Severity, ordered
from grip_bt.task import Task, model
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.catalog.manifest import manifest_text

CODES: dict[str, Severity] = {
    "unreadable": "error",
    "no-equivalent": "error",
    "incomplete": "warning",
    "changed": "info",
    "renamed": "info",
    "left-out": "info",
    "null-at-first": "info",
    "stood-in": "info",
}
"""What an import may find; `docs/validation_rules.md` explains each."""

Verdict = Literal["exact", "partial", "failed"]


def verdict_of(issues: Iterable[Issue]) -> Verdict:
    """Return how well something came in: `partial` has gaps that a person can fill, `failed` isn't in the task."""
    severities = {issue.severity for issue in issues}
    return "failed" if "error" in severities else "partial" if "warning" in severities else "exact"


@dataclass(frozen=True)
class Request:
    """What is imported.

    Attributes:
        path: a file, a folder, or `module:factory`.
        more: further files or folders of the same project.
        catalog: gives the nodes of the project that the tasks are for.
        nodes: that project's folder of nodes.
        bound: the folder that files which it includes have to lie in; its own by default.
        select: the only tree or machine that is wanted; empty for all.
        execute: whether the source's code may be run.
        stand_ins: whether that code gets stand-ins for packages that are missing.
        arguments: what is given to that code: class or function, or empty for all -> parameter -> value.
        success: outcomes that mean success, whatever they are called.
        progress: hears how many of how many files are done, and which one comes.
    """

    path: Path
    catalog: Callable[[], Catalog] = Catalog.builtin
    nodes: Path = Path("nodes")
    bound: Path | None = None
    select: str = ""
    execute: bool = False
    stand_ins: bool = False
    arguments: Mapping[str, Mapping[str, JsonValue]] = field(default_factory=dict)
    success: tuple[str, ...] = ()
    progress: Callable[[int, int, str], None] = lambda done, all, name: None
    more: tuple[Path, ...] = ()


class Issues:
    """Collects what is found about a file, each thing once."""

    def __init__(self, source: str = ""):
        self.source = source
        self._found: dict[Issue, None] = {}

    def add(self, code: str, path: str, message: str, source: str = "", line: int | None = None) -> None:
        """Note something; its code says how severe it is."""
        self._found[Issue(path, code, CODES[code], message, line=line, source=source or self.source)] = None

    def extend(self, issues: Iterable[Issue]) -> None:
        """Note what was found elsewhere."""
        self._found |= dict.fromkeys(issues)

    def __iter__(self) -> Iterator[Issue]:
        """Yield them in the order in which they were found."""
        return iter(self._found)

    @property
    def errors(self) -> tuple[Issue, ...]:
        """What has no equivalent in a task, in the order of the text."""
        return ordered(self._found).errors

    def raise_if_refused(self, what: str) -> None:
        """Raise ImportRefusedError with all errors if there are any."""
        if self.errors:
            raise ImportRefusedError(what, self.errors)


class ImportRefusedError(GripError):
    """Parts of a tree, a machine or a file have no exact equivalent in a task; nothing was made of it."""

    def __init__(self, what: str, issues: Iterable[Issue]):
        self.what, self.issues = what, tuple(issues)
        parts = "1 part has" if len(self.issues) == 1 else f"{len(self.issues)} parts have"
        listed = "".join(f"\n  {issue}" for issue in self.issues)
        super().__init__(f"{what} can't be converted to a task: {parts} no exact equivalent:{listed}")


@dataclass(frozen=True)
class Item:
    """One machine of a source: what it is, where, and what was found about it."""

    name: str
    source: str
    line: int
    issues: tuple[Issue, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """How well it was imported."""
        return verdict_of(self.issues)


@dataclass(frozen=True)
class Imported:
    """What became of a source.

    Attributes:
        tasks: by the name that their files have.
        issues: what was found, but for what the items have.
        items: its machines, where several can be in one file.
        manifests: node types that the catalogue doesn't have; their code is still to be written.
        files: path in the project -> text, tasks not among them; `nodes/...` is the project's folder of nodes.
        copies: path in the project -> a file that is copied as it is.
        advice: what somebody can do about what wasn't imported.
    """

    tasks: Mapping[str, Task]
    issues: tuple[Issue, ...] = ()
    items: tuple[Item, ...] = ()
    manifests: tuple[Manifest, ...] = ()
    files: Mapping[str, str] = field(default_factory=dict)
    copies: Mapping[str, Path] = field(default_factory=dict)
    advice: tuple[str, ...] = ()

    @property
    def task(self) -> Task:
        """The only task. Raises GripError: there are others, or none."""
        if len(self.tasks) != 1:
            many = f"several tasks were imported ({listing(self.tasks)}); name a folder for them by -o"
            raise GripError(many if self.tasks else "no task was imported")
        return next(iter(self.tasks.values()))

    @property
    def failed(self) -> bool:
        """Whether something wasn't imported."""
        every = [*self.issues, *(issue for item in self.items for issue in item.issues)]
        return any(issue.severity == "error" for issue in every)

    def as_dict(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        items = [vars(i) | {"verdict": i.verdict, "issues": [each.as_dict() for each in i.issues]} for i in self.items]
        issues = [issue.as_dict() for issue in self.issues]
        return {"items": items, "tasks": list(self.tasks), "issues": issues, "to_do": list(self.advice)}

    def text(self) -> str:
        """Return the report that `grip import` prints."""
        lines, several = [], len({item.source for item in self.items}) > _LISTED
        if several:
            lines += _totals(self.items)
        for source, group in groupby(self.items, key=lambda item: item.source):
            items = list(group)
            lines.append(f"{source}: {_counts(items)}")
            for item in () if several else items:
                lines.append(f"  {item.verdict:<8}{item.line:>5}  {item.name}")
                lines += [f"{'':>17}{issue}" for issue in item.issues]
        for name, task in () if several else self.tasks.items():
            nodes = [node for _, node in model.walk(task.root)]
            types = sorted({n.node for n in nodes if isinstance(n, model.Leaf)} - {m.id for m in self.manifests})
            sizes = {"node": nodes, "variable": task.data, "input": task.inputs, "outcome": task.outcomes}
            lines.append(f"task {name}: {', '.join(plural(len(all_), word) for word, all_ in sizes.items())}")
            lines.append(f"  node types: {listing(types)}")
        lines += [f"  {issue}" for issue in self.issues]
        if self.manifests:
            lines.append(f"  nodes whose code has to be written: {listing(m.id for m in self.manifests)}")
        lines += [f"  to do: {line}" for line in self.advice]
        return "\n".join(lines) + "\n"


_LISTED = 3
"""Of more sources than these, a report has totals and causes."""


def _counts(items: Iterable[Item]) -> str:
    verdicts = [item.verdict for item in items]
    return ", ".join(f"{verdicts.count(v)} {v}" for v in ("exact", "partial", "failed") if v in verdicts)


def _totals(items: Iterable[Item]) -> list[str]:
    """Return how many machines came in how well, and why the others didn't: each cause with one place."""
    items = list(items)
    causes: dict[tuple[str, str], list[Issue]] = {}
    for issue in (issue for item in items for issue in item.issues):
        cause = re.sub(r"`[^`]*`|'[^']*'|\d+", "…", issue.message)
        causes.setdefault((issue.severity, cause), []).append(issue)
    lines = [f"{plural(len(items), 'machine')} in {plural(len({i.source for i in items}), 'file')}: {_counts(items)}"]
    for (severity, _), issues in sorted(causes.items(), key=lambda entry: -len(entry[1])):
        if severity != "info":
            place = f"{issues[0].source}:{issues[0].line}"
            lines.append(f"  {len(issues)} × {issues[0].message} ({place}{', and others' if len(issues) > 1 else ''})")
    return lines


def generated_by(source: str) -> str:
    """Return the mark of files that an import from this source may replace; it stands in their first line."""
    return f"Generated by `grip import --from {source}`"


def manifests_text(manifests: Iterable[Manifest], header: str) -> str:
    """Return a file of several manifests."""
    entries = (manifest_text(manifest, "").rstrip("\n").replace("\n", "\n  ") for manifest in manifests)
    return header + "".join(f"- {entry}\n" for entry in entries)


def write_generated(texts: Mapping[Path, str], source: str, copies: Mapping[Path, Path] | None = None) -> list[Path]:
    """Write texts and copy files, all or none; return their paths.

    Raises:
        GripError: a file is in the way that no import from this source has made, or one can't be written.
    """
    copies = copies or {}
    for path in (*texts, *copies):
        if path.exists() and (path in copies or generated_by(source) not in _first_line(path)):
            raise GripError(
                f"{path} was not generated by an import and would be overwritten; move it or choose another -o"
            )
    for path in (*texts, *copies):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if path in texts:
                replace_text(path, texts[path])
            else:
                shutil.copyfile(copies[path], path)
        except OSError as error:
            raise GripError(f"{path}: can't be written: {error.strerror or error}") from error
    return [*texts, *copies]


def _first_line(path: Path) -> str:
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return file.readline(1000)
    except OSError as error:
        raise GripError(f"{path}: can't be read: {error.strerror or error}") from error
