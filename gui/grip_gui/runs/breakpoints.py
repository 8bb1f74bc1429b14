"""Where runs hold, for each task of the project: kept beside the journal, not in the task."""

from __future__ import annotations

import json
import logging
from collections.abc import Sequence
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from grip_bt.base.files import replace_text
from grip_bt.task.edit import path_after
from grip_bt.task.edit.steps import Step
from grip_gui.wire.runs import Breakpoint

log = logging.getLogger(__name__)
_FILE: TypeAdapter[dict[str, list[Breakpoint]]] = TypeAdapter(dict[str, list[Breakpoint]])


class Breakpoints:
    """Task file -> breakpoints.

    Args:
        file: where they are kept; one that can't be read counts as empty.
    """

    def __init__(self, file: Path):
        self._file = file
        self.all: dict[str, list[Breakpoint]] = {}
        try:
            self.all = _FILE.validate_json(file.read_bytes())
        except FileNotFoundError:
            pass
        except (OSError, ValidationError) as error:
            log.warning("breakpoints of %s left out: %s", file, str(error).splitlines()[0])

    def of(self, task: str) -> list[Breakpoint]:
        """Return those of one task."""
        return self.all.get(task, [])

    def set(self, task: str, points: Sequence[Breakpoint]) -> None:
        """Replace those of a task; each place once.

        Raises:
            OSError: they can't be kept.
        """
        self._put(task, points)

    def follow(self, task: str, steps: Sequence[Step]) -> bool:
        """Let the breakpoints of nodes that an edit has renamed or moved go with them; tell whether any did.

        Those of nodes that are gone stay: an undo brings the nodes back.

        Raises:
            OSError: they can't be kept.
        """
        points = self.of(task)
        moved = [p.model_copy(update={"node": path_after(p.node, steps) or p.node}) for p in points]
        if moved == points:
            return False
        self._put(task, moved)
        return True

    def _put(self, task: str, points: Sequence[Breakpoint]) -> None:
        once = {(p.node, p.when, p.outcome): p for p in points}
        self.all = {**self.all, task: list(once.values())}
        if not once:
            self.all.pop(task, None)
        self._file.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps(_FILE.dump_python(self.all, mode="json"), indent=1)
        replace_text(self._file, text + "\n")
