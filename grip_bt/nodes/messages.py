"""Leaves over named messages: values that a project keeps by name, beyond one run of one task."""

from __future__ import annotations

from grip_bt.base.failures import BadReplyError
from grip_bt.base.operation import Operation
from grip_bt.base.types import Value, check_value

from .leaf import OperationLeaf, Status


class _Reading(OperationLeaf):
    """Read an entry of a store."""

    def start(self) -> Operation[Value]:
        return self.context.messages().get(self.params["store"], self.entry_name())

    def entry_name(self) -> str:
        """Return the name that is asked for; of the queue, an empty one."""
        return ""

    def finish(self, result: Value) -> Status:
        """Hand it out, when it is what the task expects."""
        wanted = self.params["type"]
        if (reason := check_value(wanted, result.value)) is not None:
            store, name = self.params["store"], result.name
            raise BadReplyError(f"store {store!r}: {name or 'the queue'}: it {reason}", store=store, name=name)
        return self.end(value=result.value)


class GetMessage(_Reading):
    """Read a value by its name."""

    def entry_name(self) -> str:
        return str(self.params["name"])


class SelectMessage(_Reading):
    """Read a value whose name the task has worked out."""

    def entry_name(self) -> str:
        return str(self.read("name"))


class TakeMessage(_Reading):
    """Take the oldest value out of a store's queue."""


class _Writing(OperationLeaf):
    """Hand a value to a store."""

    def start(self) -> Operation[None]:
        return self.context.messages().put(self.params["store"], self.entry_name(), self.read("value"), self.path)

    def entry_name(self) -> str:
        """Return the name under which it is kept; of the queue, an empty one."""
        return ""


class PutMessage(_Writing):
    """Keep a value under a name."""

    def entry_name(self) -> str:
        return str(self.params["name"])


class PushMessage(_Writing):
    """Put a value at the end of a store's queue."""


class DeleteMessage(OperationLeaf):
    """Forget a value."""

    def start(self) -> Operation[None]:
        return self.context.messages().delete(self.params["store"], self.params["name"])


class ListMessages(OperationLeaf):
    """Tell the names in a store."""

    def start(self) -> Operation[tuple[str, ...]]:
        return self.context.messages().names(self.params["store"])

    def finish(self, result: tuple[str, ...]) -> Status:
        return self.end(names=list(result))


class ReinitialiseMessages(OperationLeaf):
    """Empty stores and read the project's files again."""

    def start(self) -> Operation[None]:
        return self.context.messages().reset(self.params["store"])


class SaveMessages(OperationLeaf):
    """Keep all named values for later runs."""

    def start(self) -> Operation[int]:
        return self.context.messages().save()
