"""What isn't saved yet, kept beside the journal: a server that dies takes no edit with it."""

from __future__ import annotations

import json
import logging
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path

from grip_bt.base.errors import DocumentError

from .files import TextFile

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Unsaved:
    """A text that was never saved.

    Attributes:
        text: the text.
        known: the state of the task's file that it was made from.
    """

    text: str
    known: str


class Recovery:
    """The unsaved text of one task file.

    Args:
        folder: where such texts are kept.
        name: the task's path in the project.
    """

    def __init__(self, folder: Path, name: str):
        digest = blake2b(name.encode(), digest_size=8).hexdigest()
        self._file = TextFile(folder / f"{Path(name).stem}-{digest}.json", name)

    def find(self) -> Unsaved | None:
        """Return what was left behind; None where nothing was."""
        if not self._file.path.exists():
            return None
        try:
            data = json.loads(self._file.read())
            return Unsaved(str(data["text"]), str(data["known"]))
        except (DocumentError, ValueError, KeyError, TypeError) as error:
            log.warning("the unsaved text of %s can't be read: %s", self._file.name, error)
            return None

    def keep(self, unsaved: Unsaved) -> None:
        """Keep a text; that it can't be kept keeps nobody from editing."""
        try:
            self._file.write(json.dumps({"known": unsaved.known, "text": unsaved.text}))
        except DocumentError as error:
            log.warning("unsaved changes aren't kept: %s", error)

    def forget(self) -> None:
        """Forget the text: it was saved."""
        self._file.remove()
