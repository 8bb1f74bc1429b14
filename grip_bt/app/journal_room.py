"""A project's journal keeps to its limit: looked at after each run, and by `grip runs --prune`."""

from __future__ import annotations

import logging
from pathlib import Path

from grip_bt.runtime import JournalError, JournalReader
from grip_bt.runtime.journal_limit import Pruned, prune, size_of

_log = logging.getLogger(__name__)


def make_room(file: Path, limit: int, give_back: bool = False) -> Pruned:
    """Remove the oldest runs of a journal that are over, until it holds less than `limit` [bytes].

    A run that has no end stays while its process lives.

    Args:
        file: the journal.
        limit: how much it may hold [bytes].
        give_back: whether free room is given back to the disk.

    Raises:
        JournalError: it is no journal, or can't be written.
    """
    with JournalReader(file) as reader:
        return prune(file, limit, reader.lives, give_back)


def keep_to_limit(file: Path, limit: int) -> None:
    """Make room after a run, where there is need; trouble is logged, since the run itself went well."""
    if size_of(file) <= limit:
        return
    try:
        pruned = make_room(file, limit)
    except JournalError as error:
        _log.warning("%s", error)
        return
    if pruned.runs:
        _log.info("%s: %d old runs were removed (journal_limit)", file, len(pruned.runs))
