"""What every node does: it is entered, ticked to its end, or halted; and the variables that it sees."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any, Protocol

from .expressions import compute, is_true

UNWRITTEN = object()


@dataclass(frozen=True)
class End:
    """How a node has ended. A code is the reason of an end that means failure."""

    outcome: str
    meaning: str
    code: str | None = None


SUCCESS = End("success", "success")


def failure(code: str | None = None) -> End:
    """Return the plain failure with a reason."""
    return End("failure", "failure", code)


class Broken(Exception):
    """The run ends as an error of a node."""

    def __init__(self, node: Node):
        super().__init__(node.path)
        self.node = node


class Left(Exception):
    """A container ends by one of its exits."""

    def __init__(self, end: End):
        super().__init__(end.outcome)
        self.end = end


class Run(Protocol):
    """What the nodes of one run share."""

    now: float
    preempted: bool

    def note(self, path: str, *event: Any) -> None:
        """Write an event down."""


@dataclass
class Scope:
    """The variables that a container, a task or a file declares.

    Attributes:
        path: of the container.
        declared: name -> its type, or its type and initial value.
        around: the variables that are seen too, unless one here has their name.
    """

    path: str
    declared: Mapping[str, Any]
    around: Scope | None = None
    values: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Give each variable its initial value again, or make it unwritten."""
        for name, said in self.declared.items():
            self.values[name] = deepcopy(said["value"]) if isinstance(said, dict) and "value" in said else UNWRITTEN

    def home(self, name: str) -> Scope:
        """Return the nearest scope that declares a name."""
        return self if name in self.declared or self.around is None else self.around.home(name)

    def type(self, name: str) -> str:
        """Return the type of a variable of this scope."""
        said = self.declared[name]
        return str(said["type"] if isinstance(said, dict) else said)

    def read(self, name: str) -> Any:
        """Return a variable's value; an unwritten one raises."""
        value = self.home(name).values[name]
        if value is UNWRITTEN:
            raise LookupError(name)
        return value


class Node:
    """One node of a task.

    Args:
        document: of the node.
        name: its key.
        path: its path.
        around: the variables around it.
        above: its container, or the subtask whose file it is the root of.
        run: what all nodes share.
    """

    def __init__(self, document: Mapping[str, Any], name: str, path: str, around: Scope, above: Node | None, run: Run):
        self.document, self.name, self.path, self.around, self.above, self.run = (
            document,
            name,
            path,
            around,
            above,
            run,
        )
        self.children: list[Node] = []
        self.running = False
        self.scope = around

    # --- what kinds differ in ---

    def begin(self) -> None:
        """Be entered anew."""

    def work(self) -> End | None:
        """Do what is done in one tick; return the end, or None while it runs."""
        raise NotImplementedError

    def over(self) -> None:
        """It has ended or was halted."""

    # --- what all have in common ---

    def tick(self) -> End | None:
        """Be ticked."""
        if not self.running:
            if not self._may_begin():
                self.run.note(self.path, "enter")
                return self._ended(failure("precondition"))
            self._enter()
        try:
            end = self.work()
        except Left as left:
            end = left.end
        return None if end is None else self._ended(end)

    def halt(self) -> None:
        """Be interrupted with everything below."""
        if self.running:
            for child in self.children:
                child.halt()
            self.running = False
            self.over()
            self.run.note(self.path, "interrupted")

    def asks_to_stop(self) -> bool:
        """Tell whether this container asks what runs in it to stop."""
        return False

    def preempted(self) -> bool:
        """Tell whether a leaf here is asked to stop: by everybody's request, or by a container above."""
        return self.run.preempted or any(above.asks_to_stop() for above in self.ancestors())

    def ancestors(self) -> Iterator[Node]:
        """Yield the containers above, the nearest first."""
        above = self.above
        while above is not None:
            yield above
            above = above.above

    def holds(self, text: str) -> bool:
        """Compute a condition over the variables that are seen inside."""
        return bool(self.computed(lambda: is_true(text, self.scope.read)))

    def value(self, text: str) -> Any:
        """Compute an expression over the variables that are seen inside."""
        return self.computed(lambda: compute(text, self.scope.read))

    def computed(self, function: Callable[[], Any]) -> Any:
        """Return what a function does; what it raises ends the run as an error of this node."""
        try:
            return function()
        except (LookupError, TypeError, ArithmeticError) as error:
            raise Broken(self) from error

    def write(self, name: str, value: Any) -> None:
        """Write a variable that is seen here."""
        home = self.scope.home(name)
        home.values[name] = value
        self.run.note(self.path, "write", name, home.type(name), value)

    def _may_begin(self) -> bool:
        text = self.document.get("precondition")
        if text is None:
            return True
        try:
            return is_true(text, self.around.read)
        except (LookupError, TypeError, ArithmeticError) as error:
            self._note_entry()
            raise Broken(self) from error

    def _note_entry(self) -> None:
        self.running = True
        self.run.note(self.path, "enter")

    def _enter(self) -> None:
        self._note_entry()
        if self.scope is not self.around:
            self.scope.reset()
        self.begin()

    def _ended(self, end: End) -> End:
        for child in self.children:
            child.halt()
        if self.running:
            self.running = False
            self.over()
        end = end if end.meaning == "failure" else End(end.outcome, end.meaning)
        self.run.note(self.path, "exit", end.outcome, end.code)
        return end


def code_first(table: Mapping[str, str], prefix: str, end: End) -> str | None:
    """Return where an end leads: the key with its code wins over the one without."""
    return table.get(f"{prefix}{end.outcome}.{end.code}" if end.code else "", table.get(f"{prefix}{end.outcome}"))


class Container(Node):
    """A node with children, variables, outcomes and exits."""

    def __init__(self, *arguments: Any):
        super().__init__(*arguments)
        more = self.own_variables()
        if more:
            self.scope = Scope(self.path, more, self.around)
        self.meaning = {"success": "success", "failure": "failure", **self.document.get("outcomes", {})}

    def own_variables(self) -> dict[str, Any]:
        """Return what it declares."""
        return dict(self.document.get("data", {}))

    @property
    def child(self) -> Node:
        """The only child."""
        return self.children[0]

    def ask(self, child: Node) -> End | None:
        """Tick a child; an end that is mapped to an exit is taken at once."""
        end = child.tick()
        leaving = None if end is None else self.exit(child, end)
        if leaving is not None:
            raise Left(leaving)
        return end

    def exit(self, child: Node, end: End) -> End | None:
        """Return the end that a child's end is mapped to, if it is."""
        label = code_first(self.document.get("exits", {}), f"{child.name}.", end)
        return None if label is None else End(label, self.meaning[label], end.code)
