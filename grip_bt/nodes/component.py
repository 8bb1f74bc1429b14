"""The base of the leaves that call somebody else's software: a service, an action or a topic.

The component contract: a request with a field `input`, a reply with an integer `outcome` and a field `returned_object`.
More fields on either side become ports of their own. An interface that keeps no contract has rules instead: the first
outcome whose rule holds over the reply's fields is the node's.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, SupportsIndex

from grip_bt.base.errors import EvaluationError
from grip_bt.base.evaluation import condition_of
from grip_bt.base.expression import parse_expression
from grip_bt.base.failures import BadReplyError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Component
from grip_bt.base.types import Value
from grip_bt.task.catalog.component_file import FEEDBACK

from .leaf import OperationLeaf, Status


class ComponentLeaf(OperationLeaf):
    """Call a component and end with the outcome that its reply numbers.

    A generated class sets the two class attributes; a manifest may set them as `settings` of the same names instead.
    The manifest's inputs are the fields of the request, its outputs those of the reply. A lost server, a time-out and
    a reply that breaks the contract are failures with the codes `server_lost`, `timed_out` and `bad_reply`.

    Attributes:
        component: the component's name in the project.
        labels: the outcome of each number, from 0.
        rules: instead of numbers, the rule of each outcome, over the fields of the reply, in the language of guards.
    """

    component: ClassVar[str] = ""
    labels: ClassVar[tuple[str, ...]] = ()
    rules: ClassVar[Mapping[str, str]] = {}
    _remote: Component

    def prepare(self) -> None:
        settings = self.manifest.settings
        rules = self.rules or settings.get("rules", {})
        self._rules = {label: parse_expression(rule) for label, rule in rules.items()}
        self._labels: tuple[str, ...] = tuple(self.labels or settings.get("labels", ()) or self._rules)
        name = self.component or str(settings.get("component", ""))
        if not self._labels:
            raise TypeError(f"{self.path}: {type(self).__name__} names no outcomes: set `labels`, on it or in settings")
        if undeclared := [label for label in self._labels if label not in self.meaning]:
            raise TypeError(f"{self.path}: the manifest of {self.manifest.id} lacks the outcomes {undeclared}")
        self._remote = self.context.component(name)

    def start(self) -> Operation[Mapping[str, Value]]:
        """Send the bound inputs as the request's fields; a field that nobody binds keeps its default."""
        ports = [port for port, face in self.manifest.inputs.items() if face.required or port in self.readers]
        return self._remote.call({port: self.read(port) for port in ports})

    def finish(self, result: Mapping[str, Value]) -> Status:
        label = self._label_by_rule(result) if self._rules else self._label(result)
        outputs = self.outputs_of_failure()
        for port, face in self.manifest.outputs.items():
            if port in outputs:
                continue
            if label in face.on or (not face.on and self.meaning[label] == "success"):
                if port not in result:
                    raise BadReplyError(f"the reply has no field {port!r}; it has {sorted(result)}")
                outputs[port] = result[port]
        return self.end(label, **outputs)

    def outputs_of_failure(self) -> dict[str, Value]:
        """Hand out the last feedback, however the call ends."""
        if FEEDBACK not in self.manifest.outputs or self.operation is None:
            return {}
        return {FEEDBACK: self.operation.progress}

    def waiting(self, operation: Operation[Value]) -> str:
        return "" if operation.progress is None else f"feedback: {shown(operation.progress)}"

    def _label_by_rule(self, reply: Mapping[str, object]) -> str:
        for label, rule in self._rules.items():
            readers = {name: (lambda name=name: reply[name]) for name in rule.names if name in reply}
            if missing := [name for name in rule.names if name not in reply]:
                raise BadReplyError(f"the rule of {label!r} reads {missing[0]!r}; the reply has {sorted(reply)}")
            try:
                if condition_of(rule, readers)():
                    return label
            except EvaluationError as error:
                raise BadReplyError(f"the rule of {label!r} can't be computed: {error}") from None
        raise BadReplyError(f"none of the rules holds: {', '.join(f'{k}: {r.text}' for k, r in self._rules.items())}")

    def _label(self, reply: Mapping[str, object]) -> str:
        number = reply.get("outcome")
        if isinstance(number, bool) or not isinstance(number, SupportsIndex):
            raise BadReplyError(f"the reply's `outcome` has to be a whole number, not {number!r}")
        index = number.__index__()
        if not 0 <= index < len(self._labels):
            raise BadReplyError(
                f"the reply's outcome is {index}, but {len(self._labels)} are declared, 0 to {len(self._labels) - 1}:"
                f" {', '.join(self._labels)}",
                outcome=index,
            )
        label: str = self._labels[index]
        return label


def shown(progress: object) -> str:
    """Return feedback on one short line: a message's fields, or the value."""
    fields = getattr(progress, "get_fields_and_field_types", None)
    text = repr(progress) if fields is None else ", ".join(f"{f}={getattr(progress, f)!r}" for f in fields())
    return text if len(text) <= 120 else text[:117] + "..."
