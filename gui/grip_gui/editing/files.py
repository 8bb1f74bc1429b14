"""Files of a project as they are edited: read, written, noticed when others change them, recovered."""

from __future__ import annotations

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


class ChangedOnDiskError(GripError):
    """The file was changed by somebody else since it was opened or saved."""

    def __init__(self, path: str, how: str):
        super().__init__(
            f"{path} was {how} outside the editor since it was opened here; take the file's text (undo brings yours "
            "back), or save yours over it"
        )


_BOM = b"\xef\xbb\xbf"


class TextFile:
    """One file, called `name` in messages, and what was last read from it or written to it.

    Attributes:
        known: tells the bytes that were last read or written; empty for a file that wasn't there.
    """

    def __init__(self, path: Path, name: str):
        self.path, self.name = path, name
        self.known = ""
        self._mark = b""

    def read(self) -> str:
        """Return the text, and remember it as known; DocumentError where it can't be read, or isn't text."""
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
        """Replace the file by a text, wholly or not at all (DocumentError); its permissions stay."""
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


def recovery_of(folder: Path, name: str) -> TextFile:
    """Return the file in a folder that keeps what was never saved of the project's task file `name`."""
    digest = blake2b(name.encode(), digest_size=8).hexdigest()
    return TextFile(folder / f"{Path(name).stem}-{digest}.json", name)
