"""Running from the middle: what comes before a node is passed over, by scripts that play its way to the node."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.task.model import KINDS
from grip_gui.wire.task import NodeView, TaskView


class NotFromHereError(GripError):
    """Nothing leads to a node but the run itself."""

    def __init__(self, node: str, why: str):
        super().__init__(f"cannot start at {node}: {why}; start at its container, or set a breakpoint")


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
    """Return the outcomes on the shortest way from the child with which a container begins."""
    children = {by_path[path].name: by_path[path] for path in container.children}
    first = next((each for each in children.values() if each.initial), None)
    if len(children) == 1 or KINDS[container.kind].concurrent:
        return {}
    if first is None:
        raise NotFromHereError(child.path, f"{container.path} chooses by its own conditions")
    ways: dict[str, dict[str, str]] = {first.name: {}}
    queue = deque(ways)
    while queue:
        name = queue.popleft()
        if name == child.name:
            return ways[name]
        for outcome, target in _leads(children[name]):
            if target in children and target not in ways:
                ways[target] = {**ways[name], children[name].path: outcome}
                queue.append(target)
    raise NotFromHereError(child.path, f"no way leads there from {first.path}, with which {container.path} begins")


def _leads(node: NodeView) -> Iterator[tuple[str, str]]:
    """Yield each outcome after which a sibling may run, and the sibling."""
    yield from ((edge.outcome, edge.target) for edge in node.on if not edge.ends)
    taken = {edge.outcome for edge in node.on}
    for edge in node.derived:
        fitting = [name for name, means in node.outcomes.items() if means == edge.outcome and name not in taken]
        if fitting and not edge.ends:
            yield (edge.outcome if edge.outcome in fitting else fitting[0]), edge.target
