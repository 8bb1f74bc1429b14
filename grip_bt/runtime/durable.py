"""Nothing outside begins that the journal on disk doesn't know of: for motions that mustn't be begun twice unasked."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from grip_bt.base.values import Failure

from .journal import Journal
from .journal_rows import JournalError


class Durable:
    """An observer that waits, as some leaves begin, until that is on the disk; told after the recorder.

    Args:
        journal: where the run is written.
        leaves: paths of those leaves.
    """

    def __init__(self, journal: Journal, leaves: Collection[str]):
        self._journal, self._leaves = journal, frozenset(leaves)

    def entered(self, path: str) -> None:
        """Wait for the disk; a journal that can't be written has said so in the log, and the run goes on without."""
        if path in self._leaves:
            try:
                self._journal.flush()
            except JournalError:
                self._leaves = frozenset()

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Wait for the disk too: what has been done isn't asked about."""
        self.entered(path)

    def interrupted(self, path: str) -> None:
        """Do nothing: it may have been stopped, which nobody waits for."""

    def message(self, path: str, text: str) -> None:
        """Do nothing."""

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        """Do nothing."""
