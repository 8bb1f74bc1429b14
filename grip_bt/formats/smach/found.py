"""What is found in a legacy file: states and containers, how they are had again, and what couldn't be said exactly."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from grip_bt.base.issue import Issue, Severity

Verdict = Literal["exact", "partial", "failed"]
_ISSUES: dict[str, tuple[str, Severity]] = {
    "note": ("left-out", "info"),
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


@dataclass(frozen=True)
class Span:
    """A place in a legacy file; lines count from 1."""

    file: Path
    line: int

    def __str__(self) -> str:
        return f"{self.file.name}:{self.line}"


@dataclass(frozen=True)
class Unresolved:
    """A value that no file can hold, by its text for people."""

    text: str


@dataclass(frozen=True)
class Way:
    """How a machine is had again: what is called, and which of the containers is meant that it builds.

    Attributes:
        builder: a function, class, `Class.method` or variable of the module; `__main__` for the file as a program.
        arguments: parameter -> value that was given.
        missing: parameters that nobody has given a value.
        returned: whether the builder returns the machine, or is it; else it is what was built at `line` of `file`.
        called: whether the builder is called.
        number: which of the containers that are built there.
    """

    builder: str
    file: Path
    line: int
    arguments: tuple[tuple[str, Any], ...] = ()
    missing: tuple[str, ...] = ()
    returned: bool = False
    called: bool = True
    number: int = 0


@dataclass(eq=False)
class StateInfo:
    """An object of a State class, or a container.

    Attributes:
        kind: the class of smach or smach_ros that it comes from; empty where its own class isn't here.
        cls: the name of its own class.
        outcomes: None when they aren't known.
    """

    kind: str
    cls: str
    span: Span
    outcomes: list[str] | None = None
    input_keys: list[str] = field(default_factory=list)
    output_keys: list[str] = field(default_factory=list)
    issues: list[Issue] = field(default_factory=list)
    parent: ContainerInfo | None = None

    def problem(self, verdict: str, text: str, span: Span | None = None) -> None:
        """Note what can't be imported exactly, and what to do.

        A `partial` task has a gap that a person can fill; what `failed` is left out of it; a `note` is only told.
        """
        code, severity = _ISSUES[verdict]
        place = span or self.span
        issue = Issue(self.title, code, severity, text, line=place.line, source=place.file.name)
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
        constants: userdata of the container that is set before each execution.
    """

    label: str
    state: StateInfo
    transitions: dict[str, str | None]
    remapping: dict[str, str]
    span: Span
    constants: dict[str, Any] = field(default_factory=dict)


@dataclass(eq=False)
class ContainerInfo(StateInfo):
    """A container.

    Attributes:
        added: its children by label, in order.
        settings: what it was given besides outcomes and keys.
        userdata: initial values.
        way: of an outermost container, how it is had again; None where it is an object of this process.
    """

    added: dict[str, Child] = field(default_factory=dict)
    initial: str | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    userdata: dict[str, Any] = field(default_factory=dict)
    way: Way | None = None

    @property
    def verdict(self) -> Verdict:
        """How well it was read."""
        severities = {issue.severity for issue in self.issues}
        return "failed" if "error" in severities else "partial" if "warning" in severities else "exact"

    @property
    def outermost(self) -> ContainerInfo:
        """The container around all others, which generated code can build."""
        return self if self.parent is None else self.parent.outermost

    def within(self) -> list[ContainerInfo]:
        """Return it, and all containers in it."""
        inner = [added.state for added in self.added.values() if isinstance(added.state, ContainerInfo)]
        return [self, *(each for one in inner for each in one.within())]
