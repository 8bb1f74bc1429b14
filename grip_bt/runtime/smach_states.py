"""A behaviour tree as a state of a SMACH machine: for legacy code that takes in trees, and for exported machines.

The machine may stand anywhere: run by its own `execute`, inside of other machines, or as a leaf of a task. A preempt
request reaches the leaves of the tree as a flag; a halt interrupts them at once.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, Literal, Self

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from grip_bt.base.errors import DataError
from grip_bt.base.evaluation import condition_of, value_of
from grip_bt.base.expression import Expression, parse_expression
from grip_bt.base.files import Closing
from grip_bt.compilers import CompiledTree, Halted, Pacer, to_tree
from grip_bt.compilers.behaviour_state import MachineRun, Refined, drive, label, labels
from grip_bt.compilers.binding import LeafFactory, implementation_of
from grip_bt.compilers.scopes import UNSET, Scopes
from grip_bt.compilers.task_machine import Decide
from grip_bt.nodes.answers import Answers
from grip_bt.nodes.node import AskedContext
from grip_bt.smach_compat import State
from grip_bt.task import Leaf, Task
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.kinds.base import Kind
from grip_bt.task.model import KINDS, join
from grip_bt.task.parts import Edges

from .context import RunContext
from .pacing import Pacing

_OnPreempt = Literal["ask", "halt"]


class TreeRun(Closing):
    """What the tree states of one machine share: the robot and the clock, when to tick, and the first error.

    By default it has no robot, the built-in catalogue, and ticks on wakes or every 50 ms.
    """

    def __init__(
        self,
        context: RunContext | None = None,
        catalog: Catalog | None = None,
        *,
        leaf_factory: LeafFactory | None = None,
        pacer: Pacer | None = None,
    ):
        given = RunContext() if context is None else context
        self.context: Any = given
        self.catalog = catalog or Catalog.builtin()
        self.leaf_factory: LeafFactory = leaf_factory or implementation_of
        self.shared = MachineRun()
        self.pacing = pacer if pacer is not None else Pacing(self.context.waker)
        self.shared.pacer = self.pacing
        self.trees: list[BehaviourTree] = []

    def halt(self) -> None:
        """Stop for good: whatever runs is interrupted, and `execute` of the machine raises `Halted`."""
        self.shared.fail(Halted())

    def close(self) -> None:
        while self.trees:
            self.trees.pop().release()


class _Preempted(BaseException):
    """The state has to end with `preempted`."""


class BehaviourTree(State):
    """A state that ticks a tree until it ends.

    A task's inputs and outputs are the state's keys, its outcomes the state's outcomes. Of a tree of py_trees, the keys
    that are given are copied to py_trees' blackboard before and from there afterwards, and it ends with `success` or
    `failure`. The tree is prepared when it is first executed; it begins anew each time.

    Args:
        tree: a task, or a tree of py_trees.
        run: what it shares with other trees of the machine; one of its own by default, without a robot.
        codes: failure codes that have outcomes of their own, such as `failure.no_ik`.
        on_preempt: `ask`: the leaves see the request and end as they want, the usual for tasks; `halt`: the tree is
            interrupted at once and the state ends with `preempted`, the usual for trees of py_trees.
        place: path that its root has in messages.
        input_keys: of a tree of py_trees.
        output_keys: likewise.

    Raises:
        InvalidTaskError: the task is wrong.
    """

    def __init__(
        self,
        tree: Task | Behaviour,
        run: TreeRun | None = None,
        *,
        codes: Collection[str] = (),
        on_preempt: _OnPreempt | None = None,
        place: str = "/",
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
    ):
        self.run = run or TreeRun()
        self._shares, self._prepared, self._halting = run is not None, False, False
        self.on_preempt: _OnPreempt = on_preempt or ("ask" if isinstance(tree, Task) else "halt")
        self.compiled: CompiledTree | None = None
        self._refined: Refined = [(outcome, name) for outcome, _, name in (code.partition(".") for code in codes)]
        if isinstance(tree, Task):
            self.compiled = to_tree(tree, self.run.catalog, leaf_factory=_placed(self.run.leaf_factory, place))
            self.root: Behaviour = self.compiled.root
            for path, node in self.compiled.by_path.items():
                node.path = _inside(place, path)
            outcomes: list[str] = labels(tree.outcomes, self._refined)
            # Keys that only come in would come wrapped, and values with methods couldn't be used.
            inputs = outputs = [*tree.variables] if tree.inputs or tree.outputs else []
        else:
            self.root, outcomes = tree, ["success", "failure"]
            inputs, outputs = list(input_keys), list(output_keys)
        if self.on_preempt == "halt" and "preempted" not in outcomes:
            outcomes.append("preempted")
        super().__init__(outcomes, inputs, outputs)

    @classmethod
    def of_node(
        cls,
        node: Mapping[str, object],
        run: TreeRun,
        *,
        variables: Mapping[str, str] | None = None,
        outcomes: Mapping[str, str] | None = None,
        place: str = "node",
        codes: Collection[str] = (),
    ) -> Self:
        """Return the state of one node as a task file has it: a leaf, or a container with all below.

        Args:
            variables: the variables around it that it reads or writes, with their types; the state's keys.
            outcomes: what it ends with, and whether that is a success; `success` and `failure` by default.
            place: its path in the task that it is from.
            codes: failure codes with outcomes of their own.
        """
        ends = outcomes or {"success": "success", "failure": "failure"}
        name = place.rstrip("/").rsplit("/", 1)[-1] or "node"
        document = {"grip": 1, "name": name, "outcomes": ends, "inputs": dict(variables or {}), "root": node}
        return cls(Task.model_validate(document), run, codes=codes, place=place)

    def execute(self, userdata: object) -> str:
        """Tick the tree to its end."""
        if not self._shares:
            self.run.shared.error = None
        before = self._copy_in(userdata)
        try:
            self._prepare()
            drive(self.root, self)
        except _Preempted:
            self.service_preempt()
            return "preempted"
        except Halted as error:
            if not self._halting:
                self.run.shared.fail(error)
            raise
        except BaseException as error:
            self.run.shared.fail(error)
            raise
        self._copy_out(userdata, before)
        if self.compiled is None:
            return "success" if self.root.status == Status.SUCCESS else "failure"
        end = self.compiled.end()
        return label(end.outcome, end.failure, self._refined)

    def release(self) -> None:
        if self.compiled is not None:
            self.compiled.release()
        else:
            self.root.shutdown()
        self._prepared = False

    def request_preempt(self) -> None:
        """Ask the tree to come to an end, and have it look."""
        super().request_preempt()
        self.run.shared.wake()

    def request_halt(self) -> None:
        """Interrupt the tree at once, and whenever it is executed, until `recall_halt`; `execute` raises `Halted`."""
        self._halting = True
        self.run.shared.wake()

    def recall_halt(self) -> None:
        self._halting = False

    def turn(self) -> int:
        seen = self.run.shared.turn()
        if self._halting:
            raise Halted
        if self.on_preempt == "halt" and self.preempt_requested():
            raise _Preempted
        return seen

    def rest(self, seen: int) -> None:
        self.run.shared.rest(seen)

    def wake(self) -> None:
        self.run.shared.wake()

    def _prepare(self) -> None:
        if self._prepared:
            return
        self._prepared = True
        self.run.trees.append(self)
        if self.compiled is not None:
            self.compiled.prepare(AskedContext(self.run.context, self.preempt_requested))
        else:
            for behaviour in self.root.iterate():
                behaviour.setup()

    def _copy_in(self, userdata: Any) -> dict[str, Any]:
        if self.compiled is None:
            for key in self.get_registered_input_keys():
                Blackboard.set(key, userdata[key])
            return {}
        scope = self.compiled.data[Scopes.TASK]
        scope.reset()
        before = {}
        for name in self.get_registered_input_keys():
            if name in userdata:
                before[name] = scope.cells[name].value = userdata[name]
        return before

    def _copy_out(self, userdata: Any, before: Mapping[str, object]) -> None:
        if self.compiled is None:
            for key in self.get_registered_output_keys():
                if Blackboard.exists(key):
                    userdata[key] = Blackboard.get(key)
            return
        for name, cell in self.compiled.data[Scopes.TASK].cells.items():
            if cell.value is not UNSET and cell.value is not before.get(name, UNSET):
                userdata[name] = cell.value


class Choose(Decide):
    """Asks a kind what follows; ends with `do CHILD`, `success`, or `failure`.

    Its machine begins with it; a loop's child leads back to it. Register `begin` as a start callback of the machine.

    Args:
        node: a `switch` or `loop` as a task file has it, without its children; expressions are over userdata.
        children: names of what it chooses among.
        place: its path in messages.
        codes: failure codes with outcomes of their own, such as `failure.loop_limit`.
    """

    def __init__(
        self,
        run: TreeRun,
        node: Mapping[str, Any],
        children: Sequence[str],
        *,
        place: str = "/",
        codes: Collection[str] = (),
    ):
        refined: Refined = [(outcome, code) for outcome, _, code in (code.partition(".") for code in codes)]
        ends, answers = {label: label for label in ("success", "failure")}, Answers(place, children, Edges(), Edges())
        kind: Kind = KINDS[node["kind"]].model_construct(**node)
        said = {key: parse_expression(text) for key in (*kind.values, *kind.conditions) if (text := getattr(kind, key))}
        names = dict.fromkeys(name for expression in said.values() for name in expression.names)
        super().__init__(kind, answers, ends, run.shared, refined, list(names))
        for key, expression in said.items():
            readers = self._readers(expression, key)
            if key in kind.values:
                answers.readers[key] = value_of(expression, readers)
            else:
                answers.conditions[key] = condition_of(expression, readers)
        self._userdata: Any = None

    def execute(self, userdata: Any) -> str:
        self._userdata = userdata
        return super().execute(userdata)

    def _readers(self, expression: Expression, key: str) -> dict[str, Callable[[], Any]]:
        def reader(name: str) -> Callable[[], Any]:
            def read() -> Any:
                if name not in self._userdata:
                    raise DataError(self.answers.path, key, f"variable {name!r} was read before it was written")
                return self._userdata[name]

            return read

        return {name: reader(name) for name in expression.names}


def _inside(place: str, path: str) -> str:
    """Return where a node of a tree is in the whole task; `//a` is in a subtask that is the root."""
    if path == "/":
        return place
    return f"{place}{path[1:]}" if path.startswith("/") else join(place, path)


def _placed(factory: LeafFactory, place: str) -> LeafFactory:
    def make(path: str, node: Leaf, manifest: Manifest) -> Any:
        return factory(_inside(place, path), node, manifest)

    return make
