"""What is found in a legacy file: states, containers, and what couldn't be read."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from grip_bt.base.issue import Issue, Severity

Verdict = Literal["exact", "partial", "failed"]
_ISSUES: dict[Verdict, tuple[str, Severity]] = {
    "partial": ("incomplete", "warning"),
    "failed": ("no-equivalent", "error"),
}
CONTAINERS = ("StateMachine", "Sequence", "Concurrence", "Iterator")

# States of smach_ros that nothing has to be said about: their outcomes are fixed.
FIXED_OUTCOMES = {
    "SimpleActionState": ("succeeded", "aborted", "preempted"),
    "ServiceState": ("succeeded", "aborted", "preempted"),
    "MonitorState": ("valid", "invalid", "preempted"),
    "ConditionState": ("true", "false", "preempted"),
}


MISSING = object()
"""What stands for a value that isn't there; None is one."""


@dataclass(frozen=True)
class Span:
    """A place in a legacy file; lines and columns count from 1."""

    file: Path
    line: int
    column: int
    end_line: int

    def __str__(self) -> str:
        return f"{self.file.name}:{self.line}:{self.column}"


@dataclass(frozen=True)
class Unresolved:
    """A value that is known only at run time: its text for people, and its expression in the module's namespace.

    `default`: what it is where nobody has set the parameters of ROS that it comes from.
    """

    text: str
    expression: ast.expr | None = None
    default: object = field(default=MISSING, compare=False)


@dataclass(frozen=True)
class Reference:
    """A name of an imported module that isn't part of the project: `smach.State`, `math.pi`."""

    name: str
    expression: ast.expr | None = None


@dataclass(eq=False)
class StateInfo:
    """An object of a State class, or a container.

    Attributes:
        kind: the class of smach or smach_ros that it comes from.
        cls: the name of its own class; `home` is that class, where it is part of the project.
        expression: source that makes it, in the namespace of the module `file`; None with `why` otherwise.
        outcomes: None when they aren't known.
        initialised: whether its constructor has been followed.
        attributes: what `__init__` sets on `self`.
    """

    kind: str
    cls: str
    span: Span
    expression: ast.expr | None = None
    file: Path | None = None
    why: str = ""
    outcomes: list[str] | None = None
    input_keys: list[str] = field(default_factory=list)
    output_keys: list[str] = field(default_factory=list)
    attributes: dict[str, object] = field(default_factory=dict)
    issues: list[Issue] = field(default_factory=list)
    initialised: bool = False
    home: object = None
    parent: ContainerInfo | None = None

    def problem(self, verdict: Verdict, text: str, span: Span | None = None) -> None:
        """Note what can't be imported exactly, and what to do.

        A `partial` task has a gap that a person can fill; what `failed` is left out of it.
        """
        code, severity = _ISSUES[verdict]
        place = span or self.span
        issue = Issue(self.title, code, severity, text, line=place.line, column=place.column, source=place.file.name)
        if issue not in self.issues:
            self.issues.append(issue)

    @property
    def title(self) -> str:
        """How reports call it."""
        return self.kind if self.cls == self.kind else f"{self.cls} ({self.kind})" if self.kind else self.cls


@dataclass
class Child:
    """One child of a container, as it was added.

    Attributes:
        transitions: outcome -> label, outcome of the container, or None for the outcome of the same name.
        connectors: outcomes that lead to the next child that is added.
        constants: userdata of the container that is set before each execution.
    """

    label: str
    state: StateInfo
    transitions: dict[str, str | None]
    remapping: dict[str, str]
    span: Span
    connectors: tuple[str, ...] = ()
    constants: dict[str, Any] = field(default_factory=dict)


@dataclass(eq=False)
class ContainerInfo(StateInfo):
    """A container.

    Attributes:
        added: its children by label, in order.
        settings: what its constructor was given besides outcomes and keys.
        userdata: initial values.
        entry: source of what gives the container at run time: a function, a class or a variable of the module.
        executed_in: functions that execute it, so that calling them would run the machine.
    """

    added: dict[str, Child] = field(default_factory=dict)
    initial: str | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    userdata: dict[str, Any] = field(default_factory=dict)
    entry: ast.expr | None = None
    entry_is_call: bool = False
    entry_file: Path | None = None
    entry_arguments: dict[str, Any] = field(default_factory=dict)
    executed_in: list[object] = field(default_factory=list)

    @property
    def verdict(self) -> Verdict:
        """How well it was read."""
        severities = {issue.severity for issue in self.issues}
        return "failed" if "error" in severities else "partial" if severities else "exact"

    @property
    def outermost(self) -> ContainerInfo:
        """The container around all others; generated code can get hold of it where it has an `entry`."""
        return self if self.parent is None else self.parent.outermost
