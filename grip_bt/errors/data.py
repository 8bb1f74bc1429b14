"""Errors of variables and of the typed stores of messages."""

from __future__ import annotations

from .base import ExpectedError, GripError


class DataError(GripError):
    """A variable was read before it was written, isn't declared, or has the wrong type."""

    def __init__(self, path: str, port: str, message: str):
        self.path, self.port = path, port
        super().__init__(f"{path}: port {port!r}: {message}")


class WrongTypeError(GripError, TypeError):
    """A value was put into a store of another type."""

    def __init__(self, store: str, name: str, type_name: str, reason: str):
        self.store, self.name, self.type_name = store, name, type_name
        super().__init__(f"store {store!r}: {name!r} has to be of type {type_name}: {reason}")


class EmptyQueueError(ExpectedError):
    """A value was taken from a queue that has none."""

    code = "empty"

    def __init__(self, store: str):
        super().__init__(f"store {store!r}: nothing waits in its queue", store=store)


class NoEntryError(ExpectedError):
    """A message manager doesn't have what it was asked for; `data['names']` lists what it has."""

    code = "no_entry"
