"""What the recording process has seen, merged with what was read: structure from the run, source from the text."""

from __future__ import annotations

import ast
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grip_bt.formats.child_process import TIMEOUT, last_json

from .importer import ImportedFile, import_file
from .reader.found import Child, ContainerInfo, Span, StateInfo, Unresolved
from .recorder import Record, RecordedChild, RecordedContainer, RecordedState, RecordedValue

Given = Mapping[str, Mapping[str, Any]]
"""Class or function -> parameter -> value."""


def record(file: Path, root: Path, given: Given, timeout: float = TIMEOUT) -> Record:
    """Run a module in a process of its own and return what it built; what it had built in time, at least."""
    paths = [file.parent, root, root / "src", *sorted(root.glob("*/src"))]
    answer = last_json(f"{__package__}.recorder", [str(file), json.dumps(given)], paths, timeout)
    return Record.model_validate({**(answer.data or {}), "words": answer.stderr})


def import_with_execution(file: Path, root: Path | None = None, given: Given | None = None) -> ImportedFile:
    """Read a legacy file, run it in a process of its own with a recording smach, and merge what both say.

    A container that was read exactly stays as it was read. One that wasn't takes its structure from the run; where
    packages had placeholders it stays `partial`, since another run may build another machine.

    Args:
        file: the file. Its code is run: only for files that are trusted.
        root: the folder in which the modules that it imports are looked for; its own by default.
        given: class or function -> parameter -> value, for what has no default.
    """

    def run(found: list[ContainerInfo], file: Path, folder: Path) -> list[ContainerInfo]:
        return RecordingMerge(found, record(file, folder, given or {}), file, given).merged()

    return import_file(file, root, run)


class RecordingMerge:
    """Containers that were read, and containers that were recorded."""

    def __init__(self, read: list[ContainerInfo], run: Record, file: Path, given: Given | None = None):
        self.read, self.run, self.file, self.given = read, run, file, given or {}
        self.made: dict[int, ContainerInfo] = {}

    def merged(self) -> list[ContainerInfo]:
        """Return the containers of the file."""
        inner = {child.state.container for each in self.run.containers for child in each.children}
        result, used = [], set()
        for number, facts in enumerate(self.run.containers):
            if number in inner or not facts.consistent or not facts.children:
                continue
            counterpart = self._counterpart(facts)
            if (counterpart is None and facts.file != str(self.file) and facts.file) or id(counterpart) in used:
                continue
            used.add(id(counterpart) if counterpart is not None else number)
            verdicts = set() if counterpart is None else {c.verdict for c in _all(counterpart)}
            # the run knows more where what was read failed, or where nothing of the run was a placeholder
            more = "failed" in verdicts or ("partial" in verdicts and not self.run.placeholders)
            if counterpart is None or more:
                result.append((self._container(number, counterpart), counterpart))
            else:
                self._compare(facts, counterpart)
        gone = {id(each) for _, counterpart in result if counterpart is not None for each in _all(counterpart)}
        kept = [c for c in self.read if id(c) not in gone]
        return sorted([*kept, *(c for new, _ in result for c in _all(new))], key=lambda c: c.span.line)

    def _counterpart(self, facts: RecordedState) -> ContainerInfo | None:
        """Return the container that was read where this one was made."""
        for each in self.read:
            here = str(each.span.file) == facts.file and each.span.line <= facts.line <= each.span.end_line
            if each.cls == facts.cls and each.kind == facts.kind and (here or each.cls != each.kind):
                return each
        return None

    def _compare(self, facts: RecordedContainer, counterpart: ContainerInfo) -> None:
        """Say where the run has built other states than the text seemed to, unless a placeholder may be why."""
        built, read = [child.label for child in facts.children], list(counterpart.added)
        if built != read and not self.run.placeholders:
            text = f"the run adds the states {built}, the text seems to add {read}"
            counterpart.problem("partial", text)
        if counterpart.verdict == "partial" and self.run.placeholders:
            names = ", ".join(self.run.placeholders)
            counterpart.problem(
                "partial",
                f"not installed and replaced by placeholders: {names}; what was read from the source is kept",
            )

    def _container(self, number: int, counterpart: ContainerInfo | None) -> ContainerInfo:
        facts = self.run.containers[number]
        line = facts.line or 1
        span = counterpart.span if counterpart is not None else Span(self.file, line, 1, line)
        made = ContainerInfo(facts.kind, facts.cls, span)
        self.made[number] = made
        made.outcomes, made.input_keys = facts.outcomes, facts.input_keys
        made.output_keys, made.initial = facts.output_keys, facts.initial
        made.settings = _settings(facts)
        made.userdata = _values(facts.userdata)
        if counterpart is not None:
            made.expression, made.file, made.why = counterpart.expression, counterpart.file, counterpart.why
            made.entry, made.entry_is_call = counterpart.entry, counterpart.entry_is_call
            made.entry_file = counterpart.entry_file
        if made.entry is None and facts.entry and "." not in facts.entry:
            made.entry = ast.Attribute(ast.Name("legacy", ast.Load()), facts.entry, ast.Load())
            made.entry_is_call, made.entry_file = True, self.file
            made.entry_arguments = dict(self.given.get(facts.entry, {}))
        if self.run.placeholders:
            names = ", ".join(sorted(self.run.placeholders))
            made.problem(
                "partial", f"as one run built it, with placeholders for {names}; compare the states with the source"
            )
        for child in facts.children:
            added = made.added[child.label] = self._added(made, child, counterpart)
            added.constants = _values(child.constants)
        return made

    def _added(self, outer: ContainerInfo, child: RecordedChild, counterpart: ContainerInfo | None) -> Child:
        label, facts = child.label, child.state
        read = counterpart.added.get(label) if counterpart is not None else None
        if facts.container is not None and facts.container not in self.made:
            inner = read.state if read is not None and isinstance(read.state, ContainerInfo) else None
            state: StateInfo = self._container(facts.container, inner or self._counterpart(facts))
        else:
            state = self._state(facts, outer, read.state if read is not None else None)
        state.parent = outer
        span = read.span if read is not None else state.span
        return Child(label, state, child.transitions, child.remapping, span)

    def _state(self, facts: RecordedState, outer: ContainerInfo, read: StateInfo | None) -> StateInfo:
        line = facts.line or outer.span.line
        span = read.span if read is not None else Span(outer.span.file, line, 1, line)
        made = StateInfo(facts.kind, facts.cls, span)
        made.outcomes = facts.outcomes
        made.input_keys, made.output_keys = facts.input_keys, facts.output_keys
        made.why = f"how {facts.cls} is made is known only at run time"
        if read is not None:
            made.expression, made.file, made.why = read.expression, read.file, read.why
        if not facts.kind:
            made.problem("partial", f"the class {facts.cls} isn't here: its outcomes are taken from its transitions")
        return made


def _values(facts: Mapping[str, RecordedValue]) -> dict[str, Any]:
    return {key: value.plain() for key, value in facts.items()}


def _settings(facts: RecordedContainer) -> dict[str, Any]:
    settings: dict[str, Any] = dict(facts.settings)
    for name in ("outcome_cb", "child_termination_cb"):
        if name in settings:
            settings[name] = Unresolved(name) if settings[name] else None
    return settings if facts.items is None else {**settings, "it": facts.items.plain()}


def _all(container: ContainerInfo) -> list[ContainerInfo]:
    inner = [added.state for added in container.added.values() if isinstance(added.state, ContainerInfo)]
    return [container, *(each for one in inner for each in _all(one))]
