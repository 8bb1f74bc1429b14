"""A task as a behaviour tree of plain py_trees: `create_root` builds it, `run` ticks it to its end."""

# Task labelled ends, written by `grip convert --to pytrees-py`.

from __future__ import annotations

import copy
import logging
import time
from collections.abc import Callable, Iterator, Mapping
from numbers import Real
from typing import Any

import py_trees
from py_trees.common import Status


class Variable:
    """A value that nodes share; to read it before it was written is an error."""

    def __init__(self, name: str, *initial: Any):
        self.name, self.initial = name, initial
        self.reset()

    def reset(self) -> None:
        """Take the initial value again, or become unwritten."""
        self.content = [copy.deepcopy(value) for value in self.initial]

    def get(self) -> Any:
        """Return the value."""
        if not self.content:
            raise LookupError(f"variable {self.name!r} was read before it was written")
        return self.content[0]

    def set(self, value: Any) -> None:
        """Replace the value."""
        self.content = [value]


def outcome_of(node: py_trees.behaviour.Behaviour) -> str:
    """Return the label that a node has ended with: its own, or that of its status."""
    return getattr(node, "outcome", None) or node.status.name.lower()


def code_of(node: py_trees.behaviour.Behaviour) -> str | None:
    """Return the code of the failure that a node has ended with, where it has one."""
    return node.code if hasattr(node, "code") else carried_code(node)


def carried_code(node: py_trees.behaviour.Behaviour) -> str | None:
    """Return the code that a container has from the child that made it fail."""
    if node.status != Status.FAILURE or not node.children:
        return None
    child = getattr(node, "current_child", None) or node.children[0]
    if isinstance(node, py_trees.decorators.Timeout) and child.status == Status.INVALID:
        return "time_out"
    return code_of(child)


def look_up(table: Mapping[str, str], node: py_trees.behaviour.Behaviour) -> str | None:
    """Return where the end of a node leads: by `label.code`, else by `label`."""
    outcome, code = outcome_of(node), code_of(node)
    if code is not None and f"{outcome}.{code}" in table:
        return table[f"{outcome}.{code}"]
    return table.get(outcome)


class Scope(py_trees.decorators.Decorator):
    """Gives variables their initial values again when its child is entered anew."""

    def __init__(
        self, name: str, child: py_trees.behaviour.Behaviour, variables: list[Variable]
    ):
        super().__init__(name, child)
        self.variables = variables

    def initialise(self) -> None:
        for variable in self.variables:
            variable.reset()

    def update(self) -> Status:
        return self.decorated.status

    @property
    def outcome(self) -> str:
        return outcome_of(self.decorated)


class Precondition(py_trees.decorators.Decorator):
    """Fails when its condition is false as it is entered; its child is then left alone."""

    def __init__(
        self,
        name: str,
        child: py_trees.behaviour.Behaviour,
        condition: Callable[[], bool],
    ):
        super().__init__(name, child)
        self.condition, self.refused = condition, False

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        if self.status != Status.RUNNING:
            self.refused = not self.condition()
        if self.refused:
            self.stop(Status.FAILURE)
            yield self
        else:
            yield from super().tick()

    def update(self) -> Status:
        return self.decorated.status

    @property
    def outcome(self) -> str:
        return "failure" if self.refused else outcome_of(self.decorated)

    @property
    def code(self) -> str | None:
        return "precondition" if self.refused else code_of(self.decorated)


class Guard(py_trees.decorators.EternalGuard):
    """An EternalGuard that knows when it was its condition that failed."""

    def __init__(
        self,
        name: str,
        child: py_trees.behaviour.Behaviour,
        condition: Callable[[], bool],
    ):
        super().__init__(name, child, self.open)
        self.holds, self.closed = condition, False

    def open(self) -> bool:
        """Look at the condition."""
        self.closed = not self.holds()
        return not self.closed

    @property
    def code(self) -> str | None:
        return "guard" if self.closed else carried_code(self)


class Chooser(py_trees.composites.Composite):
    """Ticks the child that was chosen, until that ends; at most one choice a tick."""

    again = False  # whether a child's success leads to the next choice
    refusal: str | None = None  # code of a failure that isn't a child's

    def begin(self) -> None:
        """Start anew: it was entered."""

    def choose(self) -> py_trees.behaviour.Behaviour | None:
        """Return the next child; None ends it: with success, or with a refusal."""
        raise NotImplementedError

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        if self.status != Status.RUNNING:
            self.current_child = self.refusal = None
            self.begin()
        child = self.current_child or self.choose()
        self.current_child = child
        if child is None:
            self.stop(Status.FAILURE if self.refusal else Status.SUCCESS)
            yield self
            return
        yield from child.tick()
        if child.status == Status.SUCCESS and self.again:
            self.current_child, self.status = None, Status.RUNNING
        elif child.status == Status.RUNNING:
            self.status = Status.RUNNING
        else:
            self.stop(child.status)
        yield self

    @property
    def code(self) -> str | None:
        return self.refusal or carried_code(self)


def is_truth(value: Any) -> bool:
    """Tell whether a value is true or false, by Python's type or by numpy's."""
    kind = getattr(getattr(value, "dtype", None), "kind", "")
    return isinstance(value, bool) or (kind == "b" and value.ndim == 0)


def same(value: Any, literal: Any) -> bool:
    """Tell whether a value is a literal: 1 and 1.0 are the same, 1 and True aren't."""
    if is_truth(value) or isinstance(literal, bool):
        return is_truth(value) and isinstance(literal, bool) and bool(value) == literal
    if isinstance(value, Real) and isinstance(literal, Real):
        return bool(value == literal)
    return type(value) is type(literal) and bool(value == literal)


class Switch(Chooser):
    """The child that has the value, as it is on entry, among its cases."""

    def __init__(
        self,
        name: str,
        children: list[py_trees.behaviour.Behaviour],
        value: Callable[[], Any],
        cases: Mapping[str, list[Any]],
        default: str,
    ):
        super().__init__(name, children)
        self.by_name = {child.name: child for child in children}
        self.value, self.cases, self.default = value, cases, default

    def choose(self) -> py_trees.behaviour.Behaviour | None:
        value, chosen = self.value(), self.default
        for name, literals in self.cases.items():
            if any(same(value, literal) for literal in literals):
                chosen = name
                break
        if not chosen:
            self.refusal = "no_case"
            return None
        return self.by_name[chosen]


class Loop(Chooser):
    """The child again while a condition holds, so many times at most; one pass a tick."""

    again = True

    def __init__(
        self,
        name: str,
        child: py_trees.behaviour.Behaviour,
        condition: Callable[[], bool] | None,
        times: int | None,
    ):
        super().__init__(name, [child])
        self.condition, self.times = condition, times

    def begin(self) -> None:
        self.done = 0

    def choose(self) -> py_trees.behaviour.Behaviour | None:
        if self.condition is not None and not self.condition():
            return None
        if self.done == self.times:
            self.refusal = "loop_limit"
            return None
        self.done += 1
        return self.children[0]


class ForEach(Chooser):
    """The child once for each item of a list, as it is on entry; one item a tick."""

    again = True

    def __init__(
        self,
        name: str,
        child: py_trees.behaviour.Behaviour,
        items: Variable,
        item: Variable,
    ):
        super().__init__(name, [child])
        self.items, self.item = items, item

    def begin(self) -> None:
        self.left: list[Any] | None = None

    def choose(self) -> py_trees.behaviour.Behaviour | None:
        if self.left is None:
            items = self.items.get()
            if not isinstance(items, list | tuple):
                raise TypeError(f"`items` is {items!r}, not a list")
            self.left = list(reversed(items))
        if not self.left:
            return None
        self.item.set(self.left.pop())
        return self.children[0]


class Cooldown(Chooser):
    """The child, unless it ended or was halted less than `seconds` [s] ago."""

    def __init__(self, name: str, child: py_trees.behaviour.Behaviour, seconds: float):
        super().__init__(name, [child])
        self.seconds, self.ready_at, self.used = seconds, None, False

    def now(self) -> float:
        """Return the time [s]."""
        return time.monotonic()

    def choose(self) -> py_trees.behaviour.Behaviour | None:
        if self.ready_at is not None and self.now() < self.ready_at:
            self.refusal = "cooldown"
            return None
        self.used = True
        return self.children[0]

    def terminate(self, new_status: Status) -> None:
        if self.used:
            self.used, self.ready_at = False, self.now() + self.seconds


class WithExits(py_trees.behaviour.Behaviour):
    """Mixed in before a composite or decorator: some ends of children end it at once.

    Args:
        exits: child -> its end -> the outcome that it leads to.
        outcomes: what these outcomes mean.
    """

    def __init__(
        self,
        *args: Any,
        exits: Mapping[str, Mapping[str, str]],
        outcomes: Mapping[str, Status],
        **kwargs: Any,
    ):
        super().__init__(*args, **kwargs)
        self.exits, self.outcomes = exits, outcomes
        self.outcome: str | None = None

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        self.outcome = None
        inner = super().tick()
        for node in inner:
            yield node
            if node.parent is self and node.status in (Status.SUCCESS, Status.FAILURE):
                self.outcome = look_up(self.exits.get(node.name, {}), node)
                if self.outcome is not None:
                    inner.close()
                    for child in self.children:
                        if child.status == Status.RUNNING:
                            child.stop(Status.INVALID)
                    self.current_child = node
                    self.stop(self.outcomes[self.outcome])
                    yield self
                    return


class SelectorWithExits(WithExits, py_trees.composites.Selector):
    """Selector that some ends of children end at once."""


class ForEachWithExits(WithExits, ForEach):
    """ForEach that some ends of children end at once."""


class Parallel(py_trees.composites.Parallel):
    """Ticks every unfinished child once a tick, in order, and a finished one not again.

    Args:
        policy: `all`: every child has to succeed; `any`: one of them.
        join: whether it ends only when every child has ended; else the rest is halted.
        exits: child -> its end -> the outcome that it leads to; before the policy.
        outcomes: what these outcomes mean.
    """

    def __init__(
        self,
        name: str,
        children: list[py_trees.behaviour.Behaviour],
        policy: str,
        join: bool,
        exits: Mapping[str, Mapping[str, str]],
        outcomes: Mapping[str, Status],
    ):
        shown = {
            "all": py_trees.common.ParallelPolicy.SuccessOnAll,
            "any": py_trees.common.ParallelPolicy.SuccessOnOne,
        }
        super().__init__(name, shown[policy](), children)
        self.rule, self.join, self.exits, self.outcomes = policy, join, exits, outcomes
        self.outcome: str | None = None

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        if self.status != Status.RUNNING:
            for child in self.children:
                if child.status != Status.INVALID:
                    child.stop(Status.INVALID)
        for child in self.children:
            if child.status not in (Status.SUCCESS, Status.FAILURE):
                yield from child.tick()
        status = self.decide()
        if status != Status.RUNNING:
            self.stop(status)
        self.status = status
        yield self

    def decide(self) -> Status:
        """Read the rule; the current child is the one that accounts for the end."""
        self.outcome = None
        ended = [child for child in self.children if child.status != Status.RUNNING]
        if self.join and len(ended) < len(self.children):
            return Status.RUNNING
        return self.leave(ended) or self.by_policy(self.children)

    def leave(self, ended: list[py_trees.behaviour.Behaviour]) -> Status | None:
        """Take the exit of the first child that has one."""
        for child in ended:
            self.outcome = look_up(self.exits.get(child.name, {}), child)
            if self.outcome is not None:
                self.current_child = child
                return self.outcomes[self.outcome]
        return None

    def by_policy(self, children: list[py_trees.behaviour.Behaviour]) -> Status:
        """Go by how these children have ended."""
        ends = [child.status for child in children]
        failed = [child for child in children if child.status == Status.FAILURE]
        self.current_child = next(iter(failed or children), None)
        if self.rule == "any":
            decisive, other = Status.SUCCESS, Status.FAILURE
        else:
            decisive, other = Status.FAILURE, Status.SUCCESS
        if decisive in ends:
            return decisive
        if Status.RUNNING in ends:
            return Status.RUNNING
        return other if ends else Status.SUCCESS


class Dispatch(py_trees.composites.Composite):
    """A state machine: one active child; where its end leads, the next tick goes on.

    Args:
        children: the states.
        initial: name of the first one.
        edges: state -> its end -> a state, or one of the outcomes.
        outcomes: what the outcomes mean.
    """

    def __init__(
        self,
        name: str,
        children: list[py_trees.behaviour.Behaviour],
        initial: str,
        edges: Mapping[str, Mapping[str, str]],
        outcomes: Mapping[str, Status],
    ):
        super().__init__(name, children)
        self.states = {child.name: child for child in children}
        self.initial, self.edges, self.outcomes = initial, edges, outcomes
        self.outcome: str | None = None

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        if self.status != Status.RUNNING:
            self.current_child, self.outcome = self.states[self.initial], None
        state = self.current_child
        yield from state.tick()
        if state.status == Status.RUNNING:
            self.status = Status.RUNNING
        else:
            target = look_up(self.edges[state.name], state)
            if target in self.states:
                self.current_child, self.status = self.states[target], Status.RUNNING
            else:
                self.outcome = target
                self.stop(self.outcomes[target])
        yield self


class Fail(py_trees.behaviours.Failure):
    """Fails with a code."""

    def __init__(self, name: str, code: str):
        super().__init__(name)
        self.code = code


class Log(py_trees.behaviours.Success):
    """Logs a sentence, and a value where one is bound."""

    def __init__(self, name: str, message: str, value: Callable[[], Any] | None = None):
        super().__init__(name)
        self.message, self.value = message, value

    def update(self) -> Status:
        more = "" if self.value is None else f": {self.value()!r}"
        self.feedback_message = f"{self.message}{more}"
        logging.getLogger(__name__).info("%s", self.feedback_message)
        return Status.SUCCESS


def create_root() -> py_trees.behaviour.Behaviour:
    """Build the tree."""
    count = Variable("count", 2)  # int
    limit = Variable("limit", 3)  # int
    seen = Variable("seen", ["a", "b's"])  # list[str]
    names = Variable("names", ["Ann", "Bob"])  # list[str]
    name = Variable("name")  # str
    near = Fail("near", code="no_plan")
    near_if = Precondition("near", near, lambda: count.get() < limit.get())
    far = Fail("far", code="no_ik")
    look = SelectorWithExits(
        "look",
        memory=True,
        children=[near_if, far],
        exits={"far": {"failure.no_ik": "nothing"}},
        outcomes={"nothing": Status.FAILURE},
    )
    first = Log("first", message="seen:", value=seen.get)
    second = Fail("second", code="late")
    race = Parallel(
        "race",
        children=[first, second],
        policy="any",
        join=True,
        exits={},
        outcomes={},
    )
    fresh_race = Scope("race", race, [seen])

    def condition_of_take() -> bool:
        return count.get() + 1 <= limit.get() and count.get() not in [7, 8]

    take = Guard("take", child=fresh_race, condition=condition_of_take)
    last = Fail("last", code="failed")
    turned = py_trees.decorators.Inverter("turned", child=last)
    settle = py_trees.decorators.Repeat("settle", child=turned, num_success=2)
    few = Fail("few", code="failed")
    call = Log("call", message="next", value=name.get)
    turns = Loop("turns", child=call, condition=lambda: limit.get() > 3, times=2)
    rest = Cooldown("rest", child=turns, seconds=60.0)
    five = ForEachWithExits(
        "five",
        child=rest,
        items=names,
        item=name,
        exits={"rest": {"failure.cooldown": "tired"}},
        outcomes={"tired": Status.SUCCESS},
    )
    fresh_five = Scope("five", five, [names, name])
    choose = Switch(
        "choose",
        children=[few, fresh_five],
        value=lambda: count.get() + limit.get(),
        cases={"few": [1, 2], "five": [5]},
        default="few",
    )
    root = Dispatch(
        "labelled ends",
        children=[look, take, settle, choose],
        initial="look",
        edges={
            "look": {"success": "look", "failure": "take", "nothing": "take"},
            "take": {"success": "settle", "failure.guard": "lost", "failure": "lost"},
            "settle": {"success": "choose", "failure": "lost"},
            "choose": {"success": "done", "failure.no_case": "lost", "failure": "lost"},
        },
        outcomes={"done": Status.SUCCESS, "lost": Status.FAILURE},
    )
    return root


ENDS = {"done": "done", "lost": "gave up"}


def end_of(root: py_trees.behaviour.Behaviour) -> str:
    """Return the task's outcome; the root has ended."""
    return look_up(ENDS, root)


def run(root: py_trees.behaviour.Behaviour, period: float = 0.05) -> str:
    """Tick every `period` [s] until the tree has ended; return the task's outcome."""
    tree = py_trees.trees.BehaviourTree(root)
    tree.setup()
    try:
        tree.tick()
        while root.status == Status.RUNNING:
            time.sleep(period)
            tree.tick()
    finally:
        for node in root.iterate():
            if node.status == Status.RUNNING:
                node.stop(Status.INVALID)
        tree.shutdown()
    return end_of(root)


if __name__ == "__main__":
    print(run(create_root()))
