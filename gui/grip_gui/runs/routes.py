"""The server's routes about the project, its tasks, and runs: start, control, breakpoints, who holds control."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from typing import Annotated, get_args

from fastapi import APIRouter, Path, WebSocket

from grip_bt.app.wiring.parts import RobotKind
from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.yaml.tree import read_file
from grip_bt.task.model import KINDS
from grip_gui.editing.projection import kind_views
from grip_gui.editing.routes import DocumentStore
from grip_gui.editing.views import view_of_text
from grip_gui.project import ProjectFolder
from grip_gui.runs.journal import JournalRuns, cloud_view
from grip_gui.runs.run_control import RunControl
from grip_gui.runs.stream import ClientConnection
from grip_gui.wire import runs as wire
from grip_gui.wire.task import NodeView, ProjectView, TaskView

_Number = Annotated[int, Path(ge=1, le=2**53)]
_ROBOTS = [str(kind) for kind in get_args(RobotKind)]


def make_router(
    folder: ProjectFolder, control: RunControl, source: JournalRuns, selected: str | None, edits: DocumentStore
) -> APIRouter:
    """Return the routes below `/api`."""
    api = APIRouter(prefix="/api")

    @api.get("/project")
    def project() -> ProjectView:
        root, tasks = folder.folder, folder.tasks()
        return ProjectView(
            name=root.name, folder=str(root), tasks=tasks, kinds=kind_views(), robots=_ROBOTS, selected=selected
        )

    api.get("/runs")(source.runs)

    @api.get("/runs/{run}")
    def run(run: str) -> wire.RunView:
        record = source.run(run)
        return wire.RunView(run=record, task=view_of_text(folder, source.task_text(run), record.task_path))

    @api.get("/runs/{run}/values/{seq}")
    def value(run: str, seq: _Number) -> wire.ValueView:
        return source.value(run, seq)

    @api.get("/runs/{run}/values/{seq}/cloud")
    def cloud(run: str, seq: _Number) -> wire.CloudView:
        return cloud_view(source.raw(run, seq))

    @api.websocket("/socket")
    async def socket(websocket: WebSocket, page: wire.PageId = "") -> None:
        await websocket.accept()
        await ClientConnection(websocket, control, source, edits.revisions, page).serve()

    _add_runs(api, folder, control)
    return api


def _add_runs(api: APIRouter, folder: ProjectFolder, control: RunControl) -> None:
    """Add what starts and controls runs."""

    @api.get("/session")
    async def session() -> wire.SessionView | None:
        return control.view

    @api.post("/session", status_code=201)
    async def start(request: wire.StartRun) -> wire.SessionView:
        file = folder.task_file(request.task)
        return await control.start(request.task, file, _options(folder, request), request.page, request.run_to)

    @api.post("/session/control")
    async def command(request: wire.Control) -> wire.SessionView:
        return await control.command(request)

    @api.get("/desk")
    async def shared() -> wire.SharedState:
        return control.shared_state

    @api.post("/breakpoints")
    async def breakpoints(request: wire.BreakpointsRequest) -> wire.SharedState:
        folder.task_file(request.task)
        try:
            return control.set_breakpoints(request.task, request.breakpoints, request.page)
        except OSError as error:
            raise GripError(f"the breakpoints can't be kept: {error}") from error

    @api.post("/lease")
    async def lease(request: wire.ControlRequest) -> wire.SharedState:
        if request.take:
            control.presence.take(request.page, request.over)
        else:
            control.presence.give(request.page)
        return control.shared_state


def _options(folder: ProjectFolder, request: wire.StartRun) -> wire.RunOptions:
    fields = request.model_dump(include=set(wire.RunOptions.model_fields))
    if request.begin_at:
        view = view_of_text(folder, read_file(folder.task_file(request.task)), request.task)
        fields["mocks"] = mocks_before(view, request.begin_at) | request.mocks
    return wire.RunOptions(**fields)


# --- from the middle ------------------------------------------------------------------------------------------------


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
