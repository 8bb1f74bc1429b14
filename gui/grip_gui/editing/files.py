"""Files of a project as they are edited: read, written, noticed when others change them, and recovered."""

from __future__ import annotations

import json
import logging
from hashlib import blake2b
from pathlib import Path

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.files import replace_bytes
from grip_bt.base.yaml.tree import read_file
from grip_gui.wire.editing import Change


class StaleEditError(GripError):
    """An edit was made on an older state, and what it is about has changed since."""


class UnfinishedTextError(GripError):
    """A drawn edit was asked for while the text isn't a task."""

    def __init__(self, path: str, why: str):
        super().__init__(f"{path}: the text is not a valid task ({why}); fix it in the text view, or undo")


class ChangedOnDiskError(GripError):
    """The file was changed by somebody else since it was opened or saved."""

    def __init__(self, path: str, how: str):
        super().__init__(
            f"{path} was {how} outside the editor since it was opened here; take the file's text (undo brings yours "
            "back), or save yours over it"
        )


_BOM = b"\xef\xbb\xbf"


class TextFile:
    """One file, and what was last read from it or written to it.

    Args:
        path: where it is; it may not be there yet.
        name: how it is called in messages.

    Attributes:
        known: tells the bytes that were last read or written; empty for a file that wasn't there.
    """

    def __init__(self, path: Path, name: str):
        self.path, self.name = path, name
        self.known = ""
        self._mark = b""

    def read(self) -> str:
        """Return the text, and remember it as known.

        Raises:
            DocumentError: it can't be read, or isn't text.
        """
        self.known = self._digest()
        text = read_file(self.path)
        with self.path.open("rb") as file:
            self._mark = _BOM if file.read(3) == _BOM else b""
        return text

    def change(self) -> Change:
        """Return how the file has changed since it was known: `changed`, `deleted`, or nothing."""
        digest = self._digest()
        if digest == self.known:
            return ""
        return "changed" if digest else "deleted"

    def write(self, text: str) -> None:
        """Replace the file by a text, wholly or not at all; its permissions stay.

        Raises:
            DocumentError: it can't be written.
        """
        data = self._mark + text.encode("utf-8")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            replace_bytes(self.path, data, durable=True)
        except (OSError, UnicodeEncodeError) as error:
            raise DocumentError(f"can't be written: {error}", self.name) from error
        self.known = _digest(data)

    def remove(self) -> None:
        """Delete the file where it is there."""
        self.path.unlink(missing_ok=True)
        self.known = ""

    def _digest(self) -> str:
        try:
            return _digest(self.path.read_bytes())
        except OSError:
            return ""


def _digest(data: bytes) -> str:
    return blake2b(data, digest_size=16).hexdigest()


log = logging.getLogger(__name__)


class Recovery:
    """The text of one task file that was never saved, and what was known of the file when it was made.

    Args:
        folder: where such texts are kept.
        name: the task's path in the project.
    """

    def __init__(self, folder: Path, name: str):
        digest = blake2b(name.encode(), digest_size=8).hexdigest()
        self._file = TextFile(folder / f"{Path(name).stem}-{digest}.json", name)

    def find(self) -> tuple[str, str] | None:
        """Return the text that was left behind, and what it knew of the file; None where nothing was."""
        if not self._file.path.exists():
            return None
        try:
            data = json.loads(self._file.read())
            return str(data["text"]), str(data["known"])
        except (DocumentError, ValueError, KeyError, TypeError) as error:
            log.warning("the unsaved text of %s can't be read: %s", self._file.name, error)
            return None

    def keep(self, text: str, known: str) -> None:
        """Keep a text; that it can't be kept keeps nobody from editing."""
        try:
            self._file.write(json.dumps({"known": known, "text": text}))
        except DocumentError as error:
            log.warning("unsaved changes aren't kept: %s", error)

    def forget(self) -> None:
        """Forget the text: it was saved."""
        self._file.remove()
