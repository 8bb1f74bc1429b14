"""An external component behind the port `Component`: values in, a ROS call, a goal or a message, values out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grip_bt.base.failures import BadReplyError, CanceledError, GoalAbortedError
from grip_bt.base.operation import Operation
from grip_bt.task.catalog.component_file import FEEDBACK, ComponentFile

from .client.action import ActionClient
from .client.goal import GoalEnd
from .client.service import ServiceClient
from .client.topic import TopicReader, TopicWriter
from .component_adapter import Adapter
from .convert import from_message
from .fields import ConversionError, field_types
from .frames import FrameError, FrameTree

Client = ServiceClient | ActionClient | TopicReader | TopicWriter


class RosComponent:
    """A service, an action or a topic; implements `grip_bt.base.ports.Component`.

    Args:
        file: what the component is.
        client: the client of what it serves.
        frames: where frames are, for ports that name one.
    """

    def __init__(self, file: ComponentFile, client: Client, frames: FrameTree | None = None):
        self.file, self._client = file, client
        self._adapter = Adapter(file, frames)
        self._meaning = list(file.meanings().items())
        self._ports: dict[type, dict[str, str]] = {}

    def call(self, request: Mapping[str, Any]) -> Operation[Mapping[str, Any]]:
        """Send the inputs; the result holds the outputs as the declared values, and the `outcome` of a contract.

        The `outcome` in the result is an integer within the declared ones. A field that can't be converted is left out
        when the outcome means failure, since such an answer often holds nothing of use. The last feedback of an action
        is the operation's progress; cancelling the operation cancels the goal.

        Ends with ServerLostError, ServerTimeOutError or BadReplyError, of an action also with GoalRejectedError,
        GoalAbortedError or CanceledError; with ConversionError when the request is wrong.
        """
        try:
            return self._begin(request)
        except ConversionError as error:
            return Operation.failed(error.below(f"component {self.file.name}: request"))
        except FrameError as error:
            return Operation.failed(error)

    def _begin(self, request: Mapping[str, Any]) -> Operation[Mapping[str, Any]]:
        client, timeouts, moves = self._client, self.file.timeouts, self.file.moves
        limit = f" (`timeouts: {{call: {timeouts.call:g}}}` in component.yaml of {self.file.name})"
        if isinstance(client, ServiceClient):
            asked = self._adapter.pack(request, client.type.Request)
            return client.call(asked, timeouts.call, timeouts.ready, not moves, limit).then(self._unpack)
        if isinstance(client, ActionClient):
            goal = self._adapter.pack(request, client.type.Goal)
            cancel = timeouts.cancel
            sent = client.send(goal, timeouts.call, timeouts.ready, cancel_within=cancel, moves=moves, limit=limit)
            whole = sent.then(self._unpack_end)
            whole.progress_through(self._feedback)
            return whole
        if isinstance(client, TopicReader):
            return client.next(timeouts.call).then(self._unpack)
        message = self._adapter.pack(request, client.type)
        return client.publish(message, 1, timeouts.ready).then(lambda _: Operation.finished({}))

    def _feedback(self, message: Any) -> Any:
        declared = self.file.ports.get(FEEDBACK)
        if message is None or declared is None:
            return message
        try:
            return from_message(message, declared.type)
        except ConversionError:
            return message  # a progress that can't be shown is no reason to give the goal up

    def _unpack_end(self, end: GoalEnd) -> Operation[Mapping[str, Any]]:
        if end.status == "canceled":
            raise CanceledError(f"component {self.file.name}: the goal was canceled")
        if end.status == "aborted":
            fields = {f: getattr(end.result, f) for f in field_types(end.result.__class__)}
            plain = {f: v for f, v in fields.items() if isinstance(v, (bool, int, float, str)) and v}
            said = f" ({', '.join(f'{f}: {v}' for f, v in plain.items())})" if plain else ""
            raise GoalAbortedError(f"component {self.file.name}: the server gave the goal up{said}", result=plain)
        return self._unpack(end.result)

    def _unpack(self, response: Any) -> Operation[Mapping[str, Any]]:
        result: dict[str, Any] = {}
        meaning = "success"
        if not self.file.rules:
            result["outcome"], meaning = self._outcome(response)
        for port, path in self._ports_of(type(response)).items():
            try:
                result[port] = self._adapter.unpack(response, port, path)
            except ConversionError as error:
                if meaning == "success":
                    reason = f"component {self.file.name}: {error.below(f'response.{path}')}"
                    raise BadReplyError(reason, field=path) from None
        return Operation.finished(result)

    def _ports_of(self, cls: type) -> dict[str, str]:
        if cls not in self._ports:
            fields = [f for f in field_types(cls) if self.file.rules or f != "outcome"]
            self._ports[cls] = self.file.port_fields(fields)
        return self._ports[cls]

    def _outcome(self, response: Any) -> tuple[int, str]:
        number = getattr(response, "outcome", None)
        if not isinstance(number, int):
            raise BadReplyError(f"component {self.file.name}: the response has no integer field 'outcome'")
        if not 0 <= number < len(self._meaning):
            names = ", ".join(f"{i} {name}" for i, (name, _) in enumerate(self._meaning))
            raise BadReplyError(
                f"component {self.file.name}: outcome {number} isn't one of the declared ones ({names}); name it in "
                "component.yaml, or mend the server",
                outcome=number,
            )
        return number, self._meaning[number][1]
