"""Running from the middle: what comes before a node is passed over, by scripts that play its way to the node."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from grip_bt.base.errors import GripError, UnknownNameError
from grip_gui.wire.task import Meaning, NodeView, TaskView

_CHOOSERS = {"switch": "chooses by its own conditions"}


class NotFromHereError(GripError):
    """Nothing leads to a node but the run itself."""

    def __init__(self, node: str, why: str):
        super().__init__(f"a run can't begin at {node}: {why}; begin at its container, or hold there with a breakpoint")


def mocks_before(task: TaskView, node: str) -> dict[str, str]:
    """Return the mocks with which a run comes to a node at once.

    Earlier children of a sequence succeed and those of a fallback fail; a state machine takes the shortest way from its
    initial state. What was passed over writes no variables.

    Args:
        task: the task.
        node: path of the node.

    Returns:
        node -> script, as `grip run --mock` takes them.

    Raises:
        UnknownNameError: there is no such node.
        NotFromHereError: its container can't be led there.
    """
    by_path = {view.path: view for view in task.nodes}
    if node not in by_path:
        raise UnknownNameError("node", node, by_path, task.path)
    mocks: dict[str, str] = {}
    below = by_path[node]
    while below.parent is not None:
        container = by_path[below.parent]
        mocks |= _way(container, below, by_path)
        below = container
    return mocks


def _way(container: NodeView, child: NodeView, by_path: Mapping[str, NodeView]) -> dict[str, str]:
    earlier = [by_path[path] for path in container.children[: container.children.index(child.path)]]
    match container.kind:
        case "sequence":
            return {each.path: _outcome(each, "success", child) for each in earlier}
        case "fallback":
            return {each.path: _outcome(each, "failure", child) for each in earlier}
        case "state_machine":
            return _transitions(container, child, by_path)
        case kind if kind in _CHOOSERS:
            raise NotFromHereError(child.path, f"{container.path} {_CHOOSERS[kind]}")
    return {}


def _outcome(node: NodeView, meaning: Meaning, target: NodeView) -> str:
    """Return an outcome of a node that means this."""
    fitting = [name for name, means in node.outcomes.items() if means == meaning]
    if not fitting:
        raise NotFromHereError(target.path, f"{node.path} before it has no outcome that means {meaning}")
    return meaning if meaning in fitting else fitting[0]


def _transitions(machine: NodeView, target: NodeView, by_path: Mapping[str, NodeView]) -> dict[str, str]:
    """Return the outcomes on the shortest way from the initial state."""
    states = {by_path[path].name: by_path[path] for path in machine.children}
    first = next((state for state in states.values() if state.initial), None)
    ways: dict[str, dict[str, str]] = {} if first is None else {first.name: {}}
    queue = deque(ways)
    while queue:
        name = queue.popleft()
        if name == target.name:
            return ways[name]
        state = states[name]
        for edge in state.on:
            if not edge.ends and edge.target in states and edge.target not in ways:
                ways[edge.target] = {**ways[name], state.path: edge.outcome}
                queue.append(edge.target)
    raise NotFromHereError(target.path, f"no way leads there from the initial state of {machine.path}")
