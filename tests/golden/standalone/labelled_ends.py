"""A task as a behaviour tree of plain py_trees: `create_root` builds it, `run` ticks it to its end."""

# Task labelled ends, written by `grip convert --to pytrees-py`.

from __future__ import annotations

import copy
import logging
import time
from collections.abc import Callable, Iterator, Mapping
from numbers import Real
from typing import Any, NamedTuple

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


def look_up(
    table: Mapping[str, str], outcome: str, code: str | None = None
) -> str | None:
    """Return where an end leads: by `outcome.code`, else by its outcome."""
    return table.get(f"{outcome}.{code}", table.get(outcome))


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


# The kinds of nodes, as grip has them: each says which of its children are ticked.
# fmt: off


CHILD = object()


class Settings:
    def __init__(self, **settings):
        vars(self).update(settings)


class Run(NamedTuple):
    """Tick these children now, in this order; those that run and aren't among them are halted: before, with `first`."""

    children: tuple[int, ...]
    state: Any = 0
    first: bool = False


class Next(NamedTuple):
    """No child is ticked any more in this tick; `begin(state)` is asked in the next one, which is asked for at once."""

    state: Any


class Stay(NamedTuple):
    """Everything stays as it is."""

    state: Any


class End(NamedTuple):
    """The container has ended."""

    outcome: str
    reason: object = CHILD
    """A `Reason`, the failure of a child, None, or `CHILD`."""


class Reason(NamedTuple):
    """Why a container fails by itself."""

    code: str
    text: str


class Ended(NamedTuple):
    """How a child has ended."""

    child: str
    outcome: str
    meaning: str
    code: str | None = None
    failure: Any = None


class Kind(Settings):
    """The base of every kind of container."""

    resets = concurrent = late_exits = False

    @property
    def reactive(self):
        """Whether it is asked again at the beginning of every tick."""
        return False

    @property
    def settles(self):
        """Whether it is asked after every tick of its children."""
        return False

    def begin(self, state, q):
        """Return the first step: the first child is run."""
        return Run((0,))

    def ended(self, state, child, end, q):
        """Return what follows the end of a child: the container ends with its meaning."""
        return End(end.meaning)

    def again(self, state, running, q):
        """Return the first step of a further tick; None: those who run go on, and the state is what it was."""
        return None

    def settle(self, state, q):
        """Return what follows when every child was ticked: nothing changes."""
        return Stay(state)

    def over(self, state, q):
        """Note that an activation has ended or was halted."""


class Fallback(Kind):
    """Children in order until one succeeds. With `memory: false` the first child is asked again on every tick."""

    onward = "failure"
    memory = True

    @property
    def reactive(self):
        return not self.memory

    def begin(self, state, q):
        return Run((0,)) if q.names else End(self.onward)

    def ended(self, state, child, end, q):
        if end.meaning == self.onward and child + 1 < len(q.names):
            return Run((child + 1,))
        return End(end.meaning)

    def again(self, state, running, q):
        return Run((0,))


def _reason(q, outcome):
    """Return why it failed: the failure of the first child that accounts for the outcome."""
    there = [end for end in q.ends if end is not None]
    accounts = [e for e in there if q.exit(e) == outcome] or [e for e in there if e.meaning == "failure"]
    return accounts[0].failure if accounts else None


class ParallelRule(Settings):
    """A way in which a parallel ends, from how its children have ended; all of its conditions have to hold."""

    when = {}
    at_least = None
    ends = "success"

    def holds(self, there, complete):
        """Tell whether it holds for the children that have ended; `complete`: no other child is waited for."""
        if not self.when and self.at_least is None:
            return complete
        labels = {end.child: {end.outcome, f"{end.outcome}.{end.code}"} for end in there}
        for child, said in self.when.items():
            if labels.get(child, set()).isdisjoint([said] if isinstance(said, str) else said):
                return False
        return sum(end.meaning == self.ends for end in there) >= (self.at_least or 0)


class Parallel(Kind):
    """All children at once."""

    resets = True
    concurrent = True
    late_exits = True
    policy = "all"
    rules = ()
    wait_for = None
    cancel = "halt"
    retick = False
    prompt = False

    @property
    def reactive(self):
        return self.retick

    @property
    def settles(self):
        return True

    def begin(self, state, q):
        return Run(tuple(range(len(q.names))), None)

    def ended(self, state, child, end, q):
        """Wait until all children were ticked, or with `prompt` decide at once."""
        return self.settle(state, q) if self.prompt else Stay(state)

    def again(self, state, running, q):
        return Run(tuple(range(len(q.names))), state)

    def settle(self, state, q):
        """Decide; `state` is the end that was decided before, while others are asked to stop."""
        everybody = None not in q.ends
        if self.cancel == "join" and not everybody:
            return Stay(None)
        decided: End | None = state
        if decided is None:
            outcome = self._outcome(q)
            if outcome is None:
                return Stay(None)
            decided = End(outcome, _reason(q, outcome))
        if self.cancel == "ask" and not everybody:
            q.ask(f"{decided.outcome}, when the others have stopped")
            return Stay(decided)
        return decided

    def _outcome(self, q):
        there = [end for end in q.ends if end is not None]
        if not self._waited({end.child for end in there}, len(q.ends)):
            return None
        complete = self.wait_for is not None or len(there) == len(q.ends)
        taken = next(filter(None, map(q.exit, there)), None)
        if taken is not None:
            return taken
        matching = next((rule.then for rule in self.rules if rule.holds(there, complete)), None)
        if matching or self.rules and not complete:
            return matching
        return self._by_policy([end.meaning for end in there], complete)

    def _by_policy(self, meanings, complete):
        one, every = self._meanings
        if not meanings and complete:
            return "success"
        return one if one in meanings else every if complete else None

    def _waited(self, ended, size):
        need = self.wait_for
        if need is None or len(ended) == size:
            return True
        if isinstance(need, list):
            return set(need) <= ended
        return len(ended) >= (need if isinstance(need, int) else 1 if need == "any" else size)

    @property
    def _meanings(self):
        """The meaning that decides when one child ends with it, and the one that takes all of them."""
        return ("failure", "success") if self.policy == "all" else ("success", "failure")


class Guard(Kind):
    """Fails with the reason `guard` when `if` is false; looked at on every tick, before the child."""

    @property
    def reactive(self):
        return True

    def begin(self, state, q):
        return self.again(state, (), q) or Run((0,))

    def again(self, state, running, q):
        return None if q.holds("if_") else End("failure", Reason("guard", f"`{self.if_}` is false"))


class Loop(Kind):
    """The child again and again, one pass a tick: while a condition holds, until it fails or an exit is taken."""

    times = None
    while_ = ""

    def begin(self, state, q):
        """Look at the condition, then at the number of passes, which is the state."""
        if self.while_ and not q.holds("while_"):
            return End("success")
        if self.times is None:
            return Run((0,))
        if state is not None and q.reached(state, self.times):
            return End("failure", Reason("loop_limit", f"it reached the limit of {self.times} passes"))
        return Run((0,), q.up(0 if state is None else state))

    def ended(self, state, child, end, q):
        return Next(state) if end.meaning == "success" else End("failure")


class Cooldown(Kind):
    """After the child has ended or was halted it isn't run for `seconds`: until then the container fails at once."""

    def begin(self, state, q):
        """Run the child where it may run again: `q.kept` says from when on."""
        ready = q.kept
        if ready is None or q.passed(ready):
            return Run((0,), "ran")
        return End("failure", Reason("cooldown", f"{q.names[0]} is cooling down for another {ready - q.now():g} s"))

    def over(self, state, q):
        if state == "ran":
            q.kept = q.now() + self.seconds


class ForEach(Kind):
    """The child once for each item of a list, one a tick, until it fails; an empty list runs nothing and succeeds."""

    def begin(self, state, q):
        """Run the child for the next item; the state is what is left of the list."""
        left = q.items("items") if state is None else state
        if q.empty(left):
            return End("success")
        item, left = q.take(left)
        q.put("item", item)
        return Run((0,), left)

    def ended(self, state, child, end, q):
        return Next(state) if end.meaning == "success" else End("failure")


class Switch(Kind):
    """The one child whose case equals the value on entry; else `default`, or a failure with the reason `no_case`."""

    default = ""
    memory = True

    @property
    def reactive(self):
        return not self.memory

    def begin(self, state, q):
        child = q.match("on_value", list(self.literals()), self.default)
        if not child:
            return End("failure", Reason("no_case", f"no case matches {q.value('on_value')!r}"))
        return Run((q.at(child),), 0, True)

    def again(self, state, running, q):
        return self.begin(state, q)

    def literals(self):
        """Yield each child with each literal for which it is taken, in order."""
        for child, said in self.cases.items():
            for literal in said if isinstance(said, list) else [said]:
                yield child, literal


class StateMachine(Kind):
    """One child at a time; each child's `on` says who is next."""

    def begin(self, state, q):
        return Run((q.at(self.initial if state is None else state),))

    def ended(self, state, child, end, q):
        """Go where the end leads; a child's name wins over an outcome that is called the same."""
        target = q.edge(end)
        return Next(target) if target in q.names else End(target)


# fmt: on


class Container(py_trees.composites.Composite):
    """Ticks its children as a kind says.

    Args:
        kind: says who is ticked.
        children: in order.
        outcomes: what its own outcomes mean.
        exits: child -> its end -> the outcome that it leads to, at once.
        edges: child -> its end -> a child or an outcome, where the kind asks for that.
        asked: what the kind asks for by a key.
    """

    def __init__(
        self,
        name: str,
        kind: Kind,
        children: list[py_trees.behaviour.Behaviour],
        *,
        outcomes: Mapping[str, Status] | None = None,
        exits: Mapping[str, Mapping[str, str]] | None = None,
        edges: Mapping[str, Mapping[str, str]] | None = None,
        asked: Mapping[str, Callable[..., Any]] | None = None,
    ):
        super().__init__(name, children)
        plain = {"success": Status.SUCCESS, "failure": Status.FAILURE}
        self.kind, self.outcomes = kind, {**plain, **(outcomes or {})}
        self.exits, self.edges, self.asked = exits or {}, edges or {}, asked or {}
        self.kept = self.outcome = self.last = self.state = self.reason = None
        self.running: tuple[int, ...] = ()
        self.resting = False

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        step = self.opening()
        while isinstance(step, Run):
            following = None
            self.state = step.state
            if step.first:
                self.halt_others(step.children)
            if self.kind.concurrent:
                for i in step.children:
                    self.ends[i] = None
            for i in step.children:
                child = self.children[i]
                yield from child.tick()
                if child.status != Status.RUNNING:
                    following = self.after(i, child)
                    if following is not None:
                        break
            if following is None:
                running = [c.status == Status.RUNNING for c in self.children]
                self.running = tuple(i for i in step.children if running[i])
                self.halt_others(step.children)
                following = Stay(self.state)
                if self.kind.settles:
                    following = self.kind.settle(self.state, self)
            step = following
        if isinstance(step, End):
            self.outcome, self.reason, self.current_child = (*step, self.last)
            self.halt_others(())
            self.stop(self.outcomes[self.outcome])
        else:
            self.state, self.status = step.state, Status.RUNNING
            self.resting = isinstance(step, Next)
            self.running = () if self.resting else self.running
            running = [self.children[i] for i in self.running]
            self.current_child = running[0] if running else None
        yield self

    def opening(self) -> Any:
        """Return the first step of this tick."""
        if self.status == Status.RUNNING and not self.resting:
            step = None
            if self.kind.reactive:
                step = self.kind.again(self.state, self.running, self)
            return step or Run(self.running, self.state)
        if self.status != Status.RUNNING:
            self.last = self.outcome = self.state = None
            self.running, self.resting = (), False
            self.ends = [None] * len(self.children)
            for child in self.children if self.kind.resets else ():
                if child.status != Status.INVALID:
                    child.stop(Status.INVALID)
        return self.kind.begin(self.state, self)

    def after(self, i: int, child: py_trees.behaviour.Behaviour) -> Any:
        """Return the step that follows the end of a child; None when others come first."""
        self.last, meaning = child, child.status.name.lower()
        code = code_of(child)
        end = Ended(child.name, outcome_of(child), meaning, code, code)
        if not self.kind.late_exits:
            target = self.exit(end)
            if target is not None:
                return End(target)
        if self.kind.concurrent:
            self.ends[i] = end
        step = self.kind.ended(self.state, i, end, self)
        if isinstance(step, Stay):
            self.state = step.state
            return None
        return step

    def halt_others(self, run: tuple[int, ...]) -> None:
        """Interrupt the children that run and aren't among these."""
        for i, child in enumerate(self.children):
            if child.status == Status.RUNNING and i not in run:
                child.stop(Status.INVALID)

    def terminate(self, new_status: Status) -> None:
        self.kind.over(self.state, self)
        self.state = None

    @property
    def code(self) -> str | None:
        """The code of its failure: its own, or that of the child that decided it."""
        if self.status != Status.FAILURE:
            return None
        if self.reason is CHILD:
            return code_of(self.last) if self.last is not None else None
        return self.reason.code if isinstance(self.reason, Reason) else self.reason

    # What kinds ask.

    @property
    def names(self) -> list[str]:
        return [child.name for child in self.children]

    def exit(self, end: Ended) -> str | None:
        return look_up(self.exits.get(end.child, {}), end.outcome, end.code)

    def edge(self, end: Ended) -> str:
        target = look_up(self.edges[end.child], end.outcome, end.code)
        assert target is not None, "every end of a state leads somewhere"
        return target

    def at(self, name: str) -> int:
        return self.names.index(name)

    def now(self) -> float:
        return time.monotonic()

    def deadline(self, seconds: float) -> float:
        return self.now() + seconds

    def passed(self, at: float) -> bool:
        return self.now() >= at

    def up(self, count: int) -> int:
        return count + 1

    def reached(self, count: int, limit: int) -> bool:
        return count >= limit

    def holds(self, key: str) -> bool:
        return self.asked[key]()

    def value(self, key: str) -> Any:
        return self.asked[key]()

    def match(self, key: str, literals: list[tuple[str, Any]], default: str) -> str:
        value = self.value(key)
        return next((name for name, said in literals if same(value, said)), default)

    def items(self, key: str) -> list[Any]:
        items = self.asked[key]()
        if not isinstance(items, list | tuple):
            raise TypeError(f"`{key}` is {items!r}, not a list")
        return list(items)

    def empty(self, left: list[Any]) -> bool:
        return not left

    def take(self, left: list[Any]) -> tuple[Any, list[Any]]:
        return left[0], left[1:]

    def put(self, key: str, value: Any) -> None:
        self.asked[key](value)


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
    look = Container(
        "look",
        Fallback(),
        [near_if, far],
        outcomes={"nothing": Status.FAILURE},
        exits={"far": {"failure.no_ik": "nothing"}},
    )
    first = Log("first", message="seen:", value=seen.get)
    second = Fail("second", code="late")
    race = Container("race", Parallel(policy="any", cancel="join"), [first, second])
    fresh_race = Scope("race", race, [seen])

    def condition_of_take() -> bool:
        return count.get() + 1 <= limit.get() and count.get() not in [7, 8]

    take = Container(
        "take",
        Guard(if_="count + 1 <= limit and not count in [7, 8]"),
        [fresh_race],
        asked={"if_": condition_of_take},
    )
    last = Fail("last", code="failed")
    turned = py_trees.decorators.Inverter("turned", child=last)
    settle = py_trees.decorators.Repeat("settle", child=turned, num_success=2)
    few = Fail("few", code="failed")
    call = Log("call", message="next", value=name.get)
    turns = Container(
        "turns",
        Loop(times=2, while_="limit > 3"),
        [call],
        asked={"while_": lambda: limit.get() > 3},
    )
    rest = Container("rest", Cooldown(seconds=60.0), [turns])
    five = Container(
        "five",
        ForEach(),
        [rest],
        outcomes={"tired": Status.SUCCESS},
        exits={"rest": {"failure.cooldown": "tired"}},
        asked={"items": names.get, "item": name.set},
    )
    fresh_five = Scope("five", five, [names, name])
    choose = Container(
        "choose",
        Switch(cases={"few": [1, 2], "five": 5}, default="few"),
        [few, fresh_five],
        asked={"on_value": lambda: count.get() + limit.get()},
    )
    root = Container(
        "labelled ends",
        StateMachine(initial="look"),
        [look, take, settle, choose],
        outcomes={"done": Status.SUCCESS, "lost": Status.FAILURE},
        edges={
            "look": {"success": "look", "failure": "take", "nothing": "take"},
            "take": {"success": "settle", "failure.guard": "lost", "failure": "lost"},
            "settle": {"success": "choose", "failure": "lost"},
            "choose": {"success": "done", "failure.no_case": "lost", "failure": "lost"},
        },
    )
    return root


ENDS = {"done": "done", "lost": "gave up"}


def end_of(root: py_trees.behaviour.Behaviour) -> str:
    """Return the task's outcome; the root has ended."""
    return look_up(ENDS, outcome_of(root), code_of(root))


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
