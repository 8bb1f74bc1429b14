"""Which containers of a task were SMACH's, told to the leaves in them: preempt requests travel as these say.

An import marks them, `x-smach: StateMachine`; the mark stays on the composite that takes a machine's place.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from grip_bt.nodes.container import KindNode
from grip_bt.nodes.node import LABEL, Node
from grip_bt.nodes.smach_activation import AmongStates
from grip_bt.nodes.smach_asking import MARK, Enclosing

from .resolve import Part
from .task_machine import TaskConcurrence, TaskContainer


def enclose(root: Part, nodes: Mapping[str, Node], states: Mapping[str, object]) -> None:
    """Tell every leaf that cares which containers of SMACH are around it, and have these count their entries.

    Args:
        root: the resolved task.
        nodes: its behaviours, by path.
        states: what isn't a behaviour but a container of a machine, by path.
    """
    stack: list[tuple[Part, tuple[Enclosing, ...]]] = [(root, ())]
    while stack:
        part, around = stack.pop()
        node = nodes.get(part.path)
        if isinstance(node, AmongStates):
            node.enclosing = around
        kind = part.node.x.get(MARK)
        made = node if isinstance(node, KindNode) else states.get(part.path)
        if isinstance(kind, str) and isinstance(made, KindNode | TaskContainer):
            around = (*around, _enclosing(part.path, kind, made))
        stack.extend((child, around) for child in part.children)


def _enclosing(path: str, kind: str, made: Any) -> Enclosing:
    if isinstance(made, TaskContainer):
        enclosing = Enclosing(path, kind, lambda: made.outcome is None, lambda: _active(made))
        made.on_enter(enclosing.entered)
        if isinstance(made, TaskConcurrence):  # who waits for the others in it learns that one has ended
            made.register_transition_cb(lambda *_: made.run.wake())
        return enclosing
    enclosing = Enclosing(path, kind, lambda: made.active, lambda: _unfinished(made))
    made.enter = _both(made.enter, enclosing.entered)
    return enclosing


def _active(machine: Any) -> int:
    return len(machine.get_active_states())


def _unfinished(container: Any) -> int:
    return sum(child.status not in LABEL for child in container.children)


def _both(first: Callable[[], None] | None, second: Callable[[], None]) -> Callable[[], None]:
    def both() -> None:
        if first is not None:
            first()
        second()

    return both
