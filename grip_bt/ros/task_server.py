"""A project's tasks as a lifecycle node: an action that runs them, services beside it, a status topic, diagnostics.

Other software starts GRIP's tasks by it as GRIP starts others' components. Names are below the node's own, `/grip`:
`run_task` (grip_msgs/action/RunTask), `list_tasks`, `pause`, `resume`, `stop`, `status` (kept for late listeners).
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.utilities import ok
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from grip_bt.base.errors import GripError
from grip_bt.base.types import JsonObject

from .client.types import load_type
from .interfaces.build import ensure_package

EventListener = Callable[[JsonObject], None]


@dataclass(frozen=True)
class Order:
    """What a goal asks for; see grip_msgs/action/RunTask."""

    task: str
    inputs: JsonObject
    form: str
    robot: str
    seed: int


class RunningTask(Protocol):
    """A run in a process of its own."""

    def send(self, command: JsonObject) -> None:
        """Pass on `{"command": "pause"}`, `resume` or `stop`."""

    def wait(self) -> JsonObject:
        """Return how it has ended."""


class Tasks(Protocol):
    """What is served."""

    def listed(self) -> Mapping[str, tuple[str, str]]:
        """Return the tasks, name -> file and sentence; a task that can't be read says so in its sentence."""

    def start(self, order: Order, told: EventListener) -> RunningTask:
        """Start a run, which `told` hears of from other threads. Raises GripError where it can't be."""


class TaskServer(LifecycleNode):
    """Serves tasks while it is active; one at a time, since there is one robot."""

    def __init__(self, tasks: Tasks, name: str = "grip"):
        ensure_package("grip_msgs")
        super().__init__(name)
        self._tasks, self._active, self._lock = tasks, False, threading.Lock()
        self._running: RunningTask | None = None
        self._cancelled = False
        self._told: dict[str, str] = {"state": "idle"}
        self._status_type, self._run_task = load_type("grip_msgs/msg/TaskStatus"), load_type("grip_msgs/action/RunTask")
        kept, group = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL), ReentrantCallbackGroup()
        self._status = self.create_publisher(self._status_type, "~/status", kept)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_timer(1.0, self._diagnose, callback_group=group)
        self.create_service(load_type("grip_msgs/srv/ListTasks"), "~/list_tasks", self._list, callback_group=group)
        for command in ("pause", "resume", "stop"):
            self.create_service(Trigger, f"~/{command}", self._commanding(command), callback_group=group)
        self._server = ActionServer(
            self,
            self._run_task,
            "~/run_task",
            self._execute,
            goal_callback=self._accepts,
            cancel_callback=self._cancels,
            callback_group=group,
        )

    # --- the life cycle ---

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the tasks; wrong ones are told, and are refused when they are asked for."""
        self.get_logger().info(f"{len(self._tasks.listed())} tasks")
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Take goals from now on."""
        self._active = True
        self._tell(state="idle")
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Take no goals any more, and stop what runs."""
        self._active = False
        self.stop()
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.stop()
        return TransitionCallbackReturn.SUCCESS

    def stop(self) -> None:
        if (running := self._running) is not None:
            running.send({"command": "stop"})

    # --- the interface ---

    def _accepts(self, goal: Any) -> GoalResponse:
        with self._lock:
            busy = self._told["state"] not in _FREE
            if self._active and not busy:
                self._told, self._cancelled = {"task": goal.task, "state": "starting"}, False
                return GoalResponse.ACCEPT
        why = f"{self._told.get('task')} is running" if busy else "the node isn't active"
        self.get_logger().warning(f"{goal.task} is refused: {why}")
        return GoalResponse.REJECT

    def _execute(self, handle: Any) -> Any:
        goal, result, end = handle.request, self._run_task.Result(), dict[str, Any]()
        self._tell()
        try:
            order = Order(goal.task, _inputs(goal.inputs), goal.form or "bt", goal.robot, goal.seed)
            self._running = self._tasks.start(order, lambda event: self._hear(handle, event))
            if self._cancelled:  # while it was being started
                self.stop()
            end = dict(self._running.wait())
        except GripError as error:
            end = {"status": "error", "message": str(error)}
        self._running = None
        result.run = self._told.get("run", "")
        for name in ("status", "outcome", "code", "message"):
            setattr(result, name, str(end.get(name) or ("error" if name == "status" else "")))
        result.duration = float(end.get("duration") or 0.0)
        if handle.is_cancel_requested:
            handle.canceled()
        elif result.status == "success":
            handle.succeed()
        else:
            handle.abort()
        self._tell(state=result.status, message=result.message)
        return result

    def _cancels(self, handle: Any) -> CancelResponse:
        self._cancelled = True
        self.stop()
        return CancelResponse.ACCEPT

    def _hear(self, handle: Any, event: JsonObject) -> None:
        match event:
            case {"event": "started", "run": run}:
                self._tell(run=str(run), state="running")
            case {"event": "state", "state": state}:
                self._tell(state=state)
            case {"event": "node", "path": path}:
                feedback = self._run_task.Feedback(node=path, event=event["what"], code=event["code"], time=event["t"])
                handle.publish_feedback(feedback)
                self._tell(node=path)

    def _list(self, request: Any, response: Any) -> Any:
        listed = self._tasks.listed()
        response.names = list(listed)
        response.files, response.docs = [file for file, _ in listed.values()], [doc for _, doc in listed.values()]
        return response

    def _commanding(self, command: str) -> Callable[[Any, Any], Any]:
        def answer(request: Any, response: Any) -> Any:
            running = self._running
            response.success = running is not None
            response.message = "" if response.success else "nothing runs"
            if running is not None:
                running.send({"command": command})
            return response

        return answer

    def _tell(self, **changed: str) -> None:
        with self._lock:
            self._told = {**self._told, **changed}
            told = {name: self._told.get(name, "") for name in ("run", "task", "state", "node", "message")}
        self._status.publish(self._status_type(stamp=self.get_clock().now().to_msg(), **told))

    def _diagnose(self) -> None:
        told = dict(self._told)
        level = DiagnosticStatus.ERROR if told["state"] in ("error", "died") else DiagnosticStatus.OK
        values = [KeyValue(key=name, value=value) for name, value in told.items()]
        status = DiagnosticStatus(level=level, name=f"{self.get_name()}: task", message=told["state"], values=values)
        self._diagnostics.publish(
            DiagnosticArray(header=Header(stamp=self.get_clock().now().to_msg()), status=[status])
        )


_FREE = ("idle", "success", "failure", "error", "stopped", "died")


def _inputs(text: str) -> JsonObject:
    try:
        found = json.loads(text) if text else {}
    except ValueError as error:
        raise GripError(f"`inputs` isn't JSON: {error}") from None
    if not isinstance(found, dict):
        raise GripError(f"`inputs` is a JSON object, variable -> value, not {text[:40]}")
    return found


def serve_tasks(tasks: Tasks, name: str, active: bool, ready: Callable[[], None]) -> None:
    """Serve until ROS shuts down: by a signal, or by somebody who asks for it.

    Args:
        name: of the node.
        active: whether it configures and activates itself, as without a life-cycle manager.
        ready: called when it can be found.
    """
    rclpy.init()
    node = TaskServer(tasks, name)
    executor = MultiThreadedExecutor(6)
    executor.add_node(node)
    try:
        if active:
            node.trigger_configure()
            node.trigger_activate()
        ready()
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.stop()
        executor.shutdown()
        if ok():
            rclpy.shutdown()
