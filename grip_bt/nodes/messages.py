"""Leaves over named messages: values that a project keeps by name, beyond one run of one task."""

from __future__ import annotations

from grip_bt.base.failures import BadReplyError
from grip_bt.base.operation import Operation
from grip_bt.base.types import Value, check_value

from .leaf import OperationLeaf, Status


def _name(leaf: OperationLeaf) -> str:
    """Return the name of an entry: set in the task, or worked out by it; of the queue, an empty one."""
    if "name" in leaf.manifest.inputs:
        return str(leaf.read("name"))
    return str(leaf.params.get("name", ""))


class ReadMessage(OperationLeaf):
    """Read a value by its name, or take the oldest one out of a store's queue."""

    def start(self) -> Operation[Value]:
        return self.context.messages().get(self.params["store"], _name(self))

    def finish(self, result: Value) -> Status:
        """Hand it out, when it is what the task expects."""
        wanted = self.params["type"]
        if (reason := check_value(wanted, result.value)) is not None:
            store, name = self.params["store"], result.name
            raise BadReplyError(f"store {store!r}: {name or 'the queue'}: it {reason}", store=store, name=name)
        return self.end(value=result.value)


class WriteMessage(OperationLeaf):
    """Keep a value under a name, or put it at the end of a store's queue."""

    def start(self) -> Operation[None]:
        return self.context.messages().put(self.params["store"], _name(self), self.read("value"), self.path)


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
