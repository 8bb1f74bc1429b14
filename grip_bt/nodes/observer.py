"""Whoever wants to know what the nodes of a run do: the journal, a trace in a test, a live view."""

from __future__ import annotations

from typing import Any, Protocol

from grip_bt.base.values import Failure


class Observer(Protocol):
    """Told of each activation of each node, in the thread that ticks it; must return quickly and never raise."""

    def entered(self, path: str) -> None:
        """An activation begins."""

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """An activation ended with one of the node's outcomes."""

    def interrupted(self, path: str) -> None:
        """An activation was halted before it had an outcome."""

    def message(self, path: str, text: str) -> None:
        """A running node says how it goes."""

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        """The node at `path` wrote a variable."""


class Silent:
    """An observer that tells nobody."""

    def entered(self, path: str) -> None:
        """Do nothing."""

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Do nothing."""

    def interrupted(self, path: str) -> None:
        """Do nothing."""

    def message(self, path: str, text: str) -> None:
        """Do nothing."""

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        """Do nothing."""


SILENT = Silent()


class Observers:
    """Several observers as one; each is told in turn."""

    def __init__(self, *observers: Observer):
        self._observers = observers

    def entered(self, path: str) -> None:
        """Tell all."""
        for observer in self._observers:
            observer.entered(path)

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Tell all."""
        for observer in self._observers:
            observer.ended(path, outcome, failure)

    def interrupted(self, path: str) -> None:
        """Tell all."""
        for observer in self._observers:
            observer.interrupted(path)

    def message(self, path: str, text: str) -> None:
        """Tell all."""
        for observer in self._observers:
            observer.message(path, text)

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        """Tell all."""
        for observer in self._observers:
            observer.wrote(path, variable, type_name, value)
