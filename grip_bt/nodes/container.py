"""The behaviour of every container whose kind is an automaton: it ticks children as the kind says."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from operator import attrgetter
from typing import Any

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from grip_bt.base.ports import Context
from grip_bt.base.types import Value
from grip_bt.base.values import Failure
from grip_bt.task.kinds.base import CHILD, End, Ended, Kind, Next, Reason, Run, Stay, Step
from grip_bt.task.parts import Edges

from .answers import Answers
from .node import STATUS, Node

S, F, R, INVALID = Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID


class KindNode(Node):
    """Mixed in before the composite or decorator of py_trees that drawings and tools shall see.

    Attributes:
        kind: says who is ticked; another one of the same class may take its place between ticks.
        running: positions of the children that run.
        resting: whether nobody runs until the next tick.
        ended: whether a child has ended in this tick.
        enter: called when it is entered anew; it resets the container's variables.
        leave: called when it has ended by itself, before anybody learns of it.
    """

    children: list[Node]
    context: Context
    current_child: Node | None
    kind: Kind
    answers: RunAnswers
    enter: Callable[[], None] | None = None
    leave: Callable[[], None] | None = None
    asked = False

    def take(self, meaning: Mapping[str, str], kind: Kind, answers: RunAnswers) -> None:
        """Become the container that the answers are for; called at the end of construction."""
        self.path, self.meaning, self.kind, self.answers = answers.path, dict(meaning), kind, answers
        answers.node = self
        self.named: list[Any] = []
        self.state: Any = None
        self.running: tuple[int, ...] = ()
        self.rename()
        self.resting = self.ended = False
        self.last: Any = None
        self.why: Any = CHILD

    def setup(self, *, context: Context, **more: object) -> None:
        super().setup(context=context, **more)
        self.context = self.answers.context = context

    def tick(self) -> Iterator[Behaviour]:
        yield from self._follow(self.opening())
        yield self

    def opening(self, reset: Callable[[], None] | None = None) -> Step:
        """Return the first step of this tick; `reset` resets all children in place of py_trees' own means."""
        kind, answers = self.kind, self.answers
        if self.children != self.named:
            self.rename()
        if self.status is not R:
            self.last, self.state, self.asked, self.running, self.resting = None, None, False, (), False
            self.ended = False
            self.begin()
            if self.enter is not None:
                self.enter()
            if kind.resets and reset is not None:
                reset()
            elif kind.resets:
                self.reset(self.children)
            answers.ends = [None] * len(self.children)
            if kind.shown == "Selector":
                self.current_child = self.children[0] if self.children else None
            return kind.begin(None, answers)
        if self.resting or not self.running:
            return kind.begin(self.state if self.resting else None, answers)
        if kind.reactive:
            return kind.again(self.state, self.running, answers) or Run(self.running, self.state)
        if kind.shown == "Selector":
            self.reset(self.children[: self.running[0]])
        return Run(self.running, self.state)

    def rename(self) -> None:
        """Note which children there are now; those that run, and how others have ended, are found again."""
        answers, running = self.answers, [self.named[i] for i in self.running]
        ended = {id(child): end for child, end in zip(self.named, answers.ends, strict=False)}
        self.named = list(self.children)
        self.running = tuple(i for i, child in enumerate(self.named) if child in running)
        answers.ends = [ended.get(id(child)) for child in self.named]
        answers.names = [child.name for child in self.named]

    def _follow(self, step: Step) -> Iterator[Behaviour]:
        while type(step) is Run:
            following: Step | None = None
            run = self.run(step)
            for i in run:
                child = self.children[i]
                yield from child.tick()
                if child.status is not R:
                    following = self.after(i, child)
                    if following is not None:
                        break
            step = following if following is not None else self.ticked(run)
        self.land(step)

    def run(self, step: Run) -> tuple[int, ...]:
        run, self.state, first = step
        if self.resting:
            self.resting, self.running = False, run
        if first:
            self.halt_others(run)
        if self.kind.concurrent:
            for i in run:
                self.answers.ends[i] = None
        return run

    def ticked(self, run: tuple[int, ...]) -> Step:
        self.running = tuple(i for i in run if self.children[i].status is R)
        self.halt_others(run)
        ended, self.ended = self.ended, False
        if self.kind.settles and (ended or not run or not self.kind.concurrent):
            return self.kind.settle(self.state, self.answers)
        return Stay(self.state)

    def after(self, i: int, child: Node) -> Step | None:
        """Return the step that follows the end of a child; None when its siblings are ticked first."""
        self.last, self.ended = child, True
        assert child.outcome is not None, "it has ended"
        end = Ended(child.name, child.outcome, child.meaning[child.outcome], child.code, child.failure)
        if not self.kind.late_exits:
            target = self.answers.exit(end)
            if target is not None:
                return End(target)
        if self.kind.concurrent:
            self.answers.ends[i] = end
        step = self.kind.ended(self.state, i, end, self.answers)
        if type(step) is Stay:
            self.state = step.state
            return None
        return step

    def land(self, step: Step, stop: Callable[[Status], None] | None = None) -> None:
        """End the tick; `stop` ends the activation in place of `self.stop`."""
        if type(step) is End:
            self.why, self.outcome = step.reason, step.outcome
            self.halt_others(())
            self.reset_after(self.last)
            if self.leave is not None:
                self.leave()
            if not isinstance(self, decorators.Decorator):
                self.current_child = self.children[-1] if self.kind.concurrent and self.children else self.last
            (stop or self.stop)(STATUS[self.meaning[step.outcome]])
            return
        assert type(step) is Next or type(step) is Stay, "a run is followed"
        self.resting = type(step) is Next
        self.state, self.status = step.state, R
        if self.resting:
            self.running = ()
            self.context.wake()
        elif self.running:
            self.reset_after(self.children[self.running[0]])
        if not isinstance(self, decorators.Decorator):
            if self.kind.concurrent:
                self.current_child = self.children[-1] if self.children else None
            else:
                self.current_child = self.children[self.running[0]] if self.running else None

    def update(self) -> Status:
        return self.status

    def halt_others(self, run: Sequence[int]) -> None:
        for i, child in enumerate(self.children):
            if child.status is R and i not in run:
                child.stop(INVALID)

    def reset_after(self, child: Node | None) -> None:
        """Reset the children after the one that was come to, as a Selector and a reactive Sequence of py_trees do."""
        match self.kind.shown:
            case "Selector" if child is not None and child.status is not F and child is not self.current_child:
                self.reset(self.children[self.children.index(child) + 1 :])
            case "Sequence" if child is not None and child.status is not S and self.kind.reactive:
                self.reset(self.children[self.children.index(child) + 1 :])

    def reset(self, children: Iterable[Node]) -> None:
        for child in children:
            if child.status is not INVALID:
                child.stop(INVALID)

    def conclude(self, status: Status) -> None:
        super().conclude(status)
        why = self.why
        if status is not F:
            self.failure = None
        elif why is CHILD:
            self.failure = self.last.failure if self.last is not None else None
        else:
            self.failure = Failure(why.code, why.text) if isinstance(why, Reason) else why

    def terminate(self, new_status: Status) -> None:
        self.kind.over(self.state, self.answers)
        self.state = None


class RunAnswers(Answers):
    """Answers of a container in a tree, whose children may be edited while it runs."""

    node: KindNode
    ends: list[Ended | None]

    def __init__(self, path: str, exits: Edges, edges: Edges):
        super().__init__(path, (), exits, edges)

    def written(self) -> None:
        if self.node.active:
            self.node.context.wake()

    def ask(self, text: str) -> None:
        """Request the children that still run to stop; their leaves see it as a preempt request."""
        node = self.node
        if not node.asked:
            node.asked = True
            # Said, since nothing else tells that it was decided in this tick already, and by these children.
            node.observer.message(node.path, text)
            node.context.wake()


@cache
def shown_as(kind: type[Kind], node: Value = KindNode) -> type[KindNode]:
    """Return the class of a kind's behaviours: where py_trees has the composite, people and tools see that one."""
    base = getattr(decorators if kind.shown == "Decorator" else composites, kind.shown)
    attributes: dict[str, Value] = {"__doc__": kind.__doc__, "__module__": __name__}
    if "memory" in kind.model_fields:
        attributes["memory"] = property(attrgetter("kind.memory"), _set_memory)
    return type(kind.__name__, (node, base), attributes)


def _set_memory(node: KindNode, memory: bool) -> None:
    if node.kind.memory is not memory:  # type: ignore[attr-defined]
        node.kind = node.kind.model_copy(update={"memory": memory})


def container(
    name: str,
    meaning: Mapping[str, str],
    kind: Kind,
    answers: RunAnswers,
    children: Sequence[Behaviour],
    cls: Value = KindNode,
) -> KindNode:
    """Return the behaviour of a container, of a class that is made of `cls`."""
    cls = shown_as(type(kind), cls)
    node: KindNode = cls.__new__(cls)
    node.kind = kind
    arguments: dict[str, Value] = {"children": list(children)}
    match kind.shown:
        case "Decorator":
            arguments = {"child": children[0]}
        case "Sequence" | "Selector":
            arguments["memory"] = kind.memory  # type: ignore[attr-defined]
        case "Parallel":
            all_of = kind.policy == "all"  # type: ignore[attr-defined]
            arguments["policy"] = ParallelPolicy.SuccessOnAll() if all_of else ParallelPolicy.SuccessOnOne()
    super(KindNode, node).__init__(name, **arguments)  # type: ignore[call-arg]
    node.take(meaning, kind, answers)
    return node
