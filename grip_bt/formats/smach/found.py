"""What is found in a legacy file: states and containers, how they are had again, and what couldn't be said exactly.

Recording processes tell it as JSON.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel, JsonValue, PrivateAttr

from grip_bt.base.issue import Issue
from grip_bt.formats.imported import CODES, Verdict, verdict_of

_ISSUES = {"note": "left-out", "partial": "incomplete", "failed": "no-equivalent"}
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


class Value(BaseModel):
    """What JSON holds, or the class of what it doesn't: objects of subclasses, too."""

    value: JsonValue = None
    opaque: str | None = None


@dataclass(frozen=True)
class Way:
    """How a machine is had again: what is called, and which of its containers is meant (line 0: what is executed).

    Attributes:
        builder: a function, class, `Class.method` or variable of the module; `__main__` for the file as a program.
        calls: the source of its arguments, and before them of those of its class.
        missing: parameters that nobody has given a value.
        returned: whether the builder returns the machine, or is it; else it is what was built at `line` of `file`.
        number: which of the containers that are built there.
    """

    builder: str
    file: Path
    line: int
    calls: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    returned: bool = False
    called: bool = True
    number: int = 0


class StateInfo(BaseModel):
    """An object of a State class, or a container; `kind` is the class of smach or smach_ros that it is of, if any."""

    kind: str
    cls: str
    span: Span
    outcomes: list[str] = []
    input_keys: list[str] = []
    output_keys: list[str] = []
    issues: list[Issue] = []
    _parent: ContainerInfo | None = PrivateAttr(default=None)

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @property
    def parent(self) -> ContainerInfo | None:
        """The container around it."""
        return self._parent

    def problem(self, verdict: str, text: str, span: Span | None = None) -> None:
        """Note what can't be imported exactly, and what to do.

        A `partial` task has a gap that a person can fill; what `failed` is left out of it; a `note` is only told.
        """
        code, place = _ISSUES[verdict], span or self.span
        issue = Issue(self.title, code, CODES[code], text, line=place.line, source=place.file.name)
        if issue not in self.issues:
            self.issues.append(issue)

    @property
    def title(self) -> str:
        """How reports call it."""
        return self.kind if self.cls == self.kind else f"{self.cls} ({self.kind})" if self.kind else self.cls


class Child(BaseModel):
    """One child of a container, as it was added; a transition to None leads to the outcome of the same name."""

    label: str
    state: ContainerInfo | StateInfo
    transitions: dict[str, str | None]
    remapping: dict[str, str]
    span: Span
    constants: list[str] = []


class ContainerInfo(StateInfo):
    """A container.

    Attributes:
        settings: what it was given besides outcomes and keys; of callbacks, whether there is one.
        way: of an outermost container, how it is had again; None where it is an object of this process.
    """

    added: dict[str, Child]
    initial: str | None = None
    settings: dict[str, Any] = {}
    items: Value | None = None
    userdata: dict[str, Value] = {}
    way: Way | None = None

    def model_post_init(self, context: Any) -> None:
        """Be the parent of the states in it."""
        super().model_post_init(context)
        for child in self.added.values():
            child.state._parent = self

    @property
    def verdict(self) -> Verdict:
        """How well it was read."""
        return verdict_of(self.issues)

    def within(self) -> list[ContainerInfo]:
        """Return it, and all containers in it."""
        inner = [added.state for added in self.added.values() if isinstance(added.state, ContainerInfo)]
        return [self, *(each for one in inner for each in one.within())]


Child.model_rebuild()  # here, and not in each process that makes one


class Job(BaseModel):
    """A file to record.

    Attributes:
        given: class or function, or empty for all -> parameter -> value.
        builders: which ones to call, if not all.
        answers: to what its import asks, in their order; what is asked after them is answered as is wanted.
    """

    file: str
    root: str | None = None
    given: dict[str, dict[str, JsonValue]] = {}
    builders: list[str] | None = None
    answers: list[bool] = []


class Built(BaseModel):
    """An outermost machine as one run has built it.

    Attributes:
        key: where it is made, and the how many-th there: `file:line#0`.
        returned: whether the builder returned it; `variable`: the module's name for it.
    """

    key: str
    state: ContainerInfo
    returned: bool = False
    variable: str = ""

    @property
    def shape(self) -> str:
        """What it is, wherever the code that makes it is."""
        return re.sub(r'"file":"[^"]*"|"line":\d+', "", self.state.model_dump_json())


class Told(BaseModel):
    """Something that code goes by; `value` is what it was taken for, where that is known."""

    what: str
    value: str | None = None
    line: int = 0
    file: str = ""


class Run(BaseModel):
    """What one builder did, with one way of answering.

    Attributes:
        answers: to the questions with two answers, in their order, and `asked` what these were.
        calls: the source of the arguments of what was called, one after the other.
        missing: parameters of the builder that a stand-in was given for.
        unfinished: whether there are answers that weren't tried.
        wanted: of a program that built nothing, a class of machines that it names.
    """

    builder: str
    machines: list[Built] = []
    answers: list[bool] = []
    asked: list[Told] = []
    told: list[Told] = []
    error: str = ""
    calls: list[str] = []
    missing: list[str] = []
    unfinished: bool = False
    wanted: str = ""
    stopped: bool = False


class Record(BaseModel):
    """What became of a file: all runs, each after an import that was answered in one way; what that has loaded."""

    runs: list[Run] = []
    read: list[str] = []
    error: str = ""
    libraries: list[str] = []
