"""Runs from the middle: the mocks with which a run comes to a node at once."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.task.model import KINDS
from grip_gui.wire.task import NodeView, TaskView


def mocks_before(task: TaskView, node: str) -> dict[str, str]:
    """Return the mocks with which a run comes to a node at once: node -> script, as `grip run --mock` takes them.

    Earlier children of a sequence succeed and those of a fallback fail; a state machine takes the shortest way from its
    initial state. What was passed over writes no variables.

    Raises:
        UnknownNameError: there is no such node.
        GripError: its container can't be led there.
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
    """Return the outcomes on the shortest way from the child with which a container begins."""
    children = {by_path[path].name: by_path[path] for path in container.children}
    first = next((each for each in children.values() if each.initial), None)
    if len(children) == 1 or KINDS[container.kind].concurrent:
        return {}
    why = f"{container.path} chooses by its own conditions"
    ways: dict[str, dict[str, str]] = {}
    if first is not None:
        why = f"no way leads there from {first.path}, with which {container.path} begins"
        ways[first.name] = {}
    queue = deque(ways)
    while queue:
        name = queue.popleft()
        if name == child.name:
            return ways[name]
        for outcome, target in _leads(children[name]):
            if target in children and target not in ways:
                ways[target] = {**ways[name], children[name].path: outcome}
                queue.append(target)
    raise GripError(f"cannot start at {child.path}: {why}; start at its container, or set a breakpoint")


def _leads(node: NodeView) -> Iterator[tuple[str, str]]:
    """Yield each outcome after which a sibling may run, and the sibling."""
    yield from ((edge.outcome, edge.target) for edge in node.on if not edge.ends)
    taken = {edge.outcome for edge in node.on}
    for edge in node.derived:
        fitting = [name for name, means in node.outcomes.items() if means == edge.outcome and name not in taken]
        if fitting and not edge.ends:
            yield (edge.outcome if edge.outcome in fitting else fitting[0]), edge.target
