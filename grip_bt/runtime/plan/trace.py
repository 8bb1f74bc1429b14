"""Ticks of a tree that settled: straight down to the leaves that run, and nothing else.

While every node on the way is RUNNING and as it was, a tick of py_trees does nothing but call those leaves (and
conditions in front of them that overrode `update` alone). A trace looks whether it is so, then calls them. When one
of them gives another result, the tree is still as it was before the tick: the whole tick is done by the ordinary plan,
to which the results so far are handed, so that nothing is called twice.

What a callback sees meanwhile is what it would see: current children that move during a tick are moved.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees import decorators
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from .builtin import is_builtin
from .emit_ours import failed
from .kinds import Kind, replaced_on
from .parts import INVALID, F, Inside, Part, R, S
from .regions import code_of
from .trace_ours import emit_deadline, stays, watches_time
from .watch import Classes, Methods
from .writer import Writer

PATIENCE = 64
"""Nodes to look at besides the way itself, at most; wider trees are left to the ordinary plan."""

_LEAVING_ALONE = {
    cls.update
    for cls in (
        decorators.Condition,
        decorators.Count,
        decorators.FailureIsRunning,
        decorators.FailureIsSuccess,
        decorators.ForEach,
        decorators.Inverter,
        decorators.PassThrough,
        decorators.Repeat,
        decorators.Retry,
        decorators.StatusToBlackboard,
        decorators.SuccessIsFailure,
        decorators.SuccessIsRunning,
        decorators.Timeout,
    )
}
"""Updates that never touch the child, but for a timeout's when the time is over."""


class Unsettled(Exception):
    """The tree isn't in a state that a trace can hold on to."""


class Handed:
    """Results that nodes have given already, waiting for the ordinary plan to ask.

    A status is what `update` has returned, a truth value what `open` of a guard has.

    Attributes:
        given: those of leaves of py_trees' own, which are asked by compiled functions, by `id` of the leaf.
    """

    def __init__(self) -> None:
        self._waiting: list[tuple[Any, str, Any]] = []
        self._passing = False
        self.given: dict[int, Status] = {}

    def give(self, node: Any, expected: Status | bool, result: Any) -> None:
        """Have the next call of `update`, or of `open` where True was expected, return `result`; only that one."""
        if is_builtin(node):
            self.given[id(node)] = result
            return
        if not self._passing:
            self._passing = True
            Methods.passing += 1
        name = "open" if expected is True else "update"
        waiting = node, name, getattr(node, name) if replaced_on(node, name) else None

        def once() -> Any:
            self._restore(waiting)
            return result

        self._waiting.append(waiting)
        setattr(node, name, once)

    def end(self) -> None:
        """The tick is over: forget what nobody asked for."""
        self.given.clear()
        for waiting in list(self._waiting):
            self._restore(waiting)
        if self._passing:
            self._passing = False
            Methods.passing -= 1

    def _restore(self, waiting: tuple[Any, str, Any]) -> None:
        self._waiting.remove(waiting)
        node, name, own = waiting
        if own is None:
            delattr(node, name)
        else:
            setattr(node, name, own)


class Tracer:
    """Makes traces of one compiled tree.

    Args:
        root: the compiled root.
        handed: where the results of an interrupted trace go.
        fixed_methods: nobody replaces methods.
    """

    def __init__(self, root: Part, handed: Handed, fixed_methods: bool):
        self._root, self._handed, self._fixed = root, handed, fixed_methods

    def trace(self) -> Callable[[], bool] | None:
        """Return what does a whole tick and tells whether it has; None where the tree isn't settled."""
        writing = _Writing()
        try:
            writing.way(self._root)
        except Unsettled:
            return None
        return self._link(writing)

    def _link(self, writing: _Writing) -> Callable[[], bool]:
        names, calls = writing.write.names, writing.calls
        if not self._fixed:
            methods = Methods(writing.nodes)
            names.update(watched=methods.dicts, sizes=methods.sizes, replaced=methods.replaced)
            names["classes_changed"] = Classes(type(node) for node in writing.nodes).changed
            writing.checks += ["([*map(len, watched)] == sizes or not replaced())", "not classes_changed()"]
        handed = self._handed

        def missed(at: int, *result: Any) -> bool:
            for node, expected in calls[:at]:
                handed.give(node, expected, expected)
            for said in result:
                handed.give(*calls[at], said)
            return False

        names["missed"] = missed
        lines = [
            f"def make({', '.join(names)}):",
            "def tick(S=S, F=F, R=R, I=I):",
            " try:",
            f"  if not ({' and '.join(writing.checks)}): return False",
            " except (IndexError, AttributeError): return False",
            *writing.write.lines,
            " return True",
            "return tick",
        ]
        made: dict[str, Any] = {}
        exec(code_of("\n ".join(lines), tuple(type(node) for node in writing.nodes)), made)
        return made["make"](**names)  # type: ignore[no-any-return]


class _Writing:
    """Writes one trace, from the root down.

    Attributes:
        checks: expressions that are true while the tree is as it was.
        calls: the nodes whose `update` or `open` is called, with the result that is expected.
        nodes: whose methods matter.
    """

    def __init__(self) -> None:
        self.write = Writer()
        self.write.names.update(S=S, F=F, R=R, I=INVALID)
        self.checks: list[str] = []
        self.calls: list[tuple[Any, Status | bool]] = []
        self.nodes: list[Behaviour] = []

    def way(self, part: Part) -> None:
        """Write the tick of a node that runs, and goes on to run."""
        inside, node = part.inside, part.node
        if inside is None or node.status is not R:
            raise Unsettled
        name = self._name(node, R)
        if inside.ours:
            self._ours(node, inside, name)
            return
        if inside.kind is Kind.LEAF:
            self._call(part, name, R)
            return
        match inside.kind:
            case Kind.SEQUENCE:
                self._sequence(node, inside, name)
            case Kind.SELECTOR:
                self._selector(node, inside, name)
            case Kind.PARALLEL:
                self._parallel(node, inside, name)
            case _:
                self._decorator(part, inside, name)
        self.write(f"{name}.status = R")

    def _sequence(self, node: Any, inside: Inside, name: str) -> None:
        kids = [kid.node for kid in inside.kids]
        at = self._points(node, kids, name)
        if inside.memory:
            self.checks.append(f"{name}.memory")
            self.way(inside.kids[at])
            return
        self._unchanged(node, kids, name)
        self.checks.append(f"not {name}.memory")
        first = self.write.bind(f"{name}f", kids[0])
        for before in inside.kids[:at]:
            self.write(f"{name}.current_child = {self._bare(before, S)}")
            self._call(before, f"n{len(self.nodes) - 1}", S)
        if at:
            self.write(f"{name}.current_child = {self.write.bind(f'{name}c', kids[at])}")
        else:
            self.write(f"{name}.current_child = {first}")
        self.way(inside.kids[at])
        for later in kids[at + 1 :]:
            self._waits(later)

    def _selector(self, node: Any, inside: Inside, name: str) -> None:
        kids = [kid.node for kid in inside.kids]
        at = self._points(node, kids, name)
        self.checks.append(f"{name}.memory" if inside.memory else f"not {name}.memory")
        if not inside.memory:
            self._unchanged(node, kids[: at + 1], name, f".children[:{at + 1}]")
        for before in inside.kids[:at]:
            if inside.memory:
                self._waits(before.node)
            else:
                self._bare(before, F)
                self._call(before, f"n{len(self.nodes) - 1}", F)
        if inside.memory and at:
            self._unchanged(node, kids[:at], name, f".children[:{at}]")
        self.way(inside.kids[at])

    def _parallel(self, node: Any, inside: Inside, name: str) -> None:
        policy, kids = inside.policy, [kid.node for kid in inside.kids]
        if type(policy) is not ParallelPolicy.SuccessOnAll or node.policy is not policy or not kids:
            raise Unsettled
        self._unchanged(node, kids, name)
        self.checks += [
            f"{name}.policy is {self.write.bind(f'{name}p', policy)}",
            f"{name}.policy.synchronise is {bool(policy.synchronise)}",
            f"{name}.current_child is {self.write.bind(f'{name}c', kids[-1])}",
        ]
        for kid in inside.kids:
            if kid.node.status is R:
                self.way(kid)
            elif policy.synchronise and kid.node.status is S:
                self._name(kid.node, S)
            else:
                self._bare(kid, S)
                self._call(kid, f"n{len(self.nodes) - 1}", S)

    def _decorator(self, part: Part, inside: Inside, name: str) -> None:
        node: Any = part.node
        kid = inside.kids[0]
        update = type(node).update
        if replaced_on(node, "update") or update not in _LEAVING_ALONE:
            raise Unsettled
        self.checks.append(f"{name}.decorated is {self.write.bind(f'{name}d', kid.node)}")
        self.checks.append(f"{self.write.bind(f'{name}y', type(node))}.update is {self.write.bind(f'{name}u', update)}")
        if kid.node.status is R:
            self.way(kid)
        elif update is decorators.Timeout.update or kid.node.status not in (S, F):
            raise Unsettled
        else:  # it ends in each tick, and the decorator says that it runs
            self._bare(kid, kid.node.status)
            self._call(kid, f"n{len(self.nodes) - 1}", kid.node.status)
        if update is not decorators.Timeout.update:
            self._call(part, name, R)
            return
        # its update stops the child when the time is over, after which the tick couldn't be done over
        self.write.bind("decorators", decorators)
        self.write("t = decorators.time.monotonic()", f"if t > {name}.finish_time: return missed({len(self.calls)})")
        self.write(f'{name}.feedback_message = f"time still ticking ... [remaining: {{{name}.finish_time - t}}s]"')

    def _ours(self, node: Any, inside: Inside, name: str) -> None:
        """Write what a node of ours does, which reports nothing as long as it runs on."""
        if inside.kind is Kind.LEAF:
            with self.write.block("try:"):
                self.write(f"s = {name}.update()")
            self.write(f"except Exception as e: raise {self.write.bind('failed', failed)}({name}, e) from e")
            self._expect(node, name, R)
            return
        if not stays(node, inside.kind):
            raise Unsettled
        if inside.kind is Kind.GATE:
            at = len(self.calls)
            self.calls.append((node, True))
            self.write(f"if not {name}.open(): return missed({at}, False)")
        if inside.kind is Kind.ROUNDS:
            self._rounds(node, inside, name)
        elif inside.kind in (Kind.DECORATOR, Kind.GATE):
            kid = inside.kids[0]
            self.checks.append(f"{name}.decorated is {self.write.bind(f'{name}d', kid.node)}")
            self.way(kid)
        else:
            if inside.kind in (Kind.SEQUENCE, Kind.SELECTOR):
                self.checks.append(f"{name}.memory")
            kids = [kid.node for kid in inside.kids]
            at = self._points(node, kids, name)
            if inside.kind is Kind.SELECTOR:
                for before in kids[:at]:
                    self._waits(before)
            self.way(inside.kids[at])
        if watches_time(node):
            emit_deadline(self.write, name, len(self.calls))
            self.calls.append((node, R))
        self.write(f"{name}.status = R")

    def _rounds(self, node: Any, inside: Inside, name: str) -> None:
        kids = [kid.node for kid in inside.kids]
        if node.retick or not kids or node.current_child is not kids[-1]:
            raise Unsettled
        self._unchanged(node, kids, name)
        self.checks += [f"not {name}.retick", f"{name}.current_child is {self.write.bind(f'{name}c', kids[-1])}"]
        for kid in inside.kids:
            if kid.node.status is R:
                self.way(kid)
            elif kid.node.status in (S, F):
                self._name(kid.node, kid.node.status)
            else:
                raise Unsettled

    # --- pieces ---

    def _name(self, node: Any, status: Status) -> str:
        """Take a node in, whose status has to be `status`."""
        name = self.write.bind(f"n{len(self.nodes)}", node)
        self.nodes.append(node)
        self.checks.append(f"{name}.status is {status.name[0]}")
        if len(self.nodes) > PATIENCE:
            raise Unsettled
        return name

    def _bare(self, part: Part, status: Status) -> str:
        """Take in a leaf that ends with the same status in each tick, and overrides `update` alone."""
        inside = part.inside
        if inside is None or inside.ours or inside.kind is not Kind.LEAF or inside.initialises or inside.terminates:
            raise Unsettled
        if part.node.status is not status:
            raise Unsettled
        return self._name(part.node, status)

    def _waits(self, node: Any) -> None:
        """Take in a node that isn't ticked and has to be INVALID already."""
        if node.status is not INVALID:
            raise Unsettled
        self._name(node, INVALID)

    def _call(self, part: Part, name: str, expected: Status) -> None:
        known = part.inside.builtin if part.inside is not None else None
        update = f"{name}.update" if known is None else self.write.bind(f"{name}u", known.update)
        self.write(f"s = {update}()")
        self._expect(part.node, name, expected)

    def _expect(self, node: Any, name: str, expected: Status) -> None:
        at, letter = len(self.calls), expected.name[0]
        self.calls.append((node, expected))
        self.write(f"if s is not {letter}: return missed({at}, s)", f"{name}.status = {letter}")

    def _points(self, node: Any, kids: list[Any], name: str) -> int:
        """Check that the node points to the child that it goes on with; return which one."""
        kid = node.current_child
        if kid not in kids:
            raise Unsettled
        at = kids.index(kid)
        child = self.write.bind(f"{name}k", kid)
        self.checks += [f"{name}.current_child is {child}", f"{name}.children[{at}] is {child}"]
        return at

    def _unchanged(self, node: Any, kids: list[Any], name: str, which: str = ".children") -> None:
        if len(kids) > PATIENCE:
            raise Unsettled
        self.checks.append(f"{name}{which} == {self.write.bind(f'{name}kids', list(kids))}")
