"""How a preempt request travels among imported SMACH states: container by container, as SMACH's own flags do.

Whatever form a task runs in, its leaves say when they begin, and containers that were SMACH's count how often they were
entered (`Enclosing`). From that alone the flags are kept here.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any, Protocol

MARK = "x-smach"
"""Says of a container in a task which class of SMACH it was."""


class Enclosing:
    """A container of a task that was one of SMACH's; made by the compilers, one per compiled task.

    Attributes:
        path: its path in the task.
        kind: the class of SMACH that it was.
        entries: how often it was entered.
        runs: tells whether it is being executed.
        unfinished: of a Concurrence: returns how many of its children haven't ended.
    """

    def __init__(self, path: str, kind: str, runs: Callable[[], bool], unfinished: Callable[[], int]):
        self.path, self.kind, self.runs, self.unfinished = path, kind, runs, unfinished
        self.entries = 0

    def entered(self) -> None:
        self.entries += 1


class Child(Protocol):
    """A state or container with its flag, as the container around it sees it."""

    def request_preempt(self) -> None: ...
    def preempt_requested(self) -> bool: ...
    def recall_preempt(self) -> None: ...
    def is_running(self) -> bool: ...


class Container:
    """The flag of a container, and what it does with it; the base is a StateMachine, and a Sequence.

    Several children run at once only where a person has put something of a task's own between them.
    """

    def __init__(self, enclosing: Enclosing | None):
        self.enclosing, self.flag, self.entries = enclosing, False, -1
        self.executing = False
        self.current: Child | None = None
        self.begun: list[Child] = []
        self.asked: Child | None = None

    def request_preempt(self) -> None:
        """Set the flag; a container that is executed asks what runs in it."""
        self.flag = True
        if self.executing:
            self.ask()

    def preempt_requested(self) -> bool:
        return self.flag

    def recall_preempt(self) -> None:
        self.flag = False

    def is_running(self) -> bool:
        return self.enclosing is None or self.enclosing.runs()

    def enter(self) -> None:
        """Begin an execution; the flag is kept, so that a request that came before asks the initial state."""
        self.executing, self.current, self.asked, self.begun = True, None, None, []

    def leave(self) -> None:
        """End an execution: where the last state has obeyed, so has the container."""
        if self.flag and self.asked is not None and self.current is not None:
            if not self.current.preempt_requested():
                self.flag = False
        self.executing, self.current = False, None

    def come(self, child: Child) -> None:
        """Take note of what is executed next."""
        self.begun = [each for each in self.begun if each is not child and each.is_running()]
        self.begun.append(child)
        self.current = child

    def before(self, child: Child) -> None:
        """Bring the flag to a child that is about to begin, or see that the one before has obeyed."""
        if not self.flag:
            return
        if self.asked is None:
            self.ask()
        elif self.asked is not child and self.asked.is_running():
            child.request_preempt()  # beside the one that was asked
        elif self.asked.preempt_requested():
            if self.asked is not child:
                self.asked.recall_preempt()
                self.ask()
        else:
            self.flag, self.asked = False, None

    def ask(self) -> None:
        """Ask what runs, each child once."""
        for child in self.begun:
            if child is not self.asked and (child is self.current or child.is_running()):
                child.request_preempt()
        self.asked = self.current


class Whole(Container):
    """The run, around everything: each new request is asked of what runs, and goes on until something has obeyed."""

    def request_preempt(self) -> None:
        self.asked = None
        super().request_preempt()


class Together(Container):
    """A Concurrence: all children that haven't ended are asked, once; a request before it begins reaches none."""

    def enter(self) -> None:
        super().enter()
        self.has_asked = False

    def leave(self) -> None:
        """End; the flag was looked at by `obeyed`."""
        self.executing = False

    def come(self, child: Child) -> None:
        if child not in self.begun:
            self.begun.append(child)

    def before(self, child: Child) -> None:
        if self.has_asked:
            child.request_preempt()

    def ask(self) -> None:
        if not self.has_asked:
            self.has_asked = True
            for child in self.begun:
                if child.is_running():
                    child.request_preempt()

    def obeyed(self) -> bool:
        """Look at the flag when all have ended: whether there was a request and nobody has left it unanswered.

        Otherwise requests that children haven't answered are taken back, and the flag stays.
        """
        for child in self.begun:
            if isinstance(child, Container) and child.executing:
                _end(child)
        if not self.flag:
            return False
        unanswered = [child for child in self.begun if child.preempt_requested()]
        for child in unanswered:
            child.recall_preempt()
        if not unanswered:
            self.flag = False
        return not unanswered


class Iteration(Container):
    """An Iterator: asks its state while it is executed, and ends after this item, whatever the state does."""

    exhausted = False

    def enter(self) -> None:
        super().enter()
        self.exhausted = False

    def leave(self) -> None:
        """End; only where items run out, a request is left unanswered."""
        self.flag = self.flag and self.exhausted
        self.executing = False

    def before(self, child: Child) -> None:
        """A request that came before isn't brought to the state."""

    def ask(self) -> None:
        if self.current is not None:
            self.current.request_preempt()


_KINDS: dict[str, type[Container]] = {"Concurrence": Together, "Iterator": Iteration}


class Asking:
    """All flags of one run. What isn't in a container of SMACH is in one that the run itself is.

    `built`: what builds a legacy container -> the container that it has built, for all leaves of the run.
    """

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.whole = Whole(None)
        self.whole.enter()
        self.built: dict[Callable[..., Any], Any] = {}
        self._containers: dict[str, Container] = {}
        self._seen = 0

    def container(self, enclosing: Enclosing) -> Container:
        if enclosing.path not in self._containers:
            self._containers[enclosing.path] = _KINDS.get(enclosing.kind, Container)(enclosing)
        return self._containers[enclosing.path]

    def begin(self, around: Sequence[Enclosing], leaf: Child | None, requests: int) -> None:
        """Take note that a leaf begins in containers, outermost first; None where it is no state of SMACH's."""
        with self.lock:
            inside = [self.container(enclosing) for enclosing in around]
            outer: list[Container] = [self.whole, *inside]
            children: list[Child] = [*inside, *([] if leaf is None else [leaf])]
            new = next((n for n, c in enumerate(inside) if c.entries != around[n].entries), len(inside))
            if new < len(children):
                _close(outer[new], children[new])
                outer[new].come(children[new])
            self.arrive(requests)
            for number in range(new, len(children)):
                around_it, child = outer[number], children[number]
                if number > new:
                    around_it.come(child)
                around_it.before(child)
                if isinstance(child, Container):
                    child.entries = around[number].entries
                    child.enter()

    def arrive(self, requests: int) -> None:
        with self.lock:
            if requests > self._seen:
                self.whole.request_preempt()
                self._seen = requests


def _close(outer: Container, child: Child) -> None:
    """End what was executed in a container before `child`, from the inside."""
    for before in outer.begun:
        ended = before is child or not before.is_running()
        if isinstance(before, Container) and before.executing and ended and not isinstance(outer, Together):
            _end(before)
    if isinstance(outer, Together) and isinstance(child, Container) and child.executing:
        _end(child)


def _end(container: Container) -> None:
    for below in container.begun:
        if isinstance(below, Container) and below.executing:
            _end(below)
    container.leave()
