"""Files in and out, to the byte: what was read is known, so that nobody's change is overwritten unseen."""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path

from grip_bt.base.errors import DocumentError
from grip_bt.base.files import replace_bytes
from grip_bt.base.yaml.tree import read_file

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

    def change(self) -> str:
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
