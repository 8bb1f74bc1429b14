"""Files in and out, to the byte: what was read is known, so that nobody's change is overwritten unseen."""

from __future__ import annotations

import os
from hashlib import blake2b
from pathlib import Path
from tempfile import NamedTemporaryFile

from grip_bt.base.errors import DocumentError
from grip_bt.base.yaml.files import read_file

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
            with NamedTemporaryFile(dir=self.path.parent, prefix=f".{self.path.name}.", delete=False) as new:
                new.write(data)
                new.flush()
                os.fsync(new.fileno())
            _settle(Path(new.name), self.path)
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


def _settle(new: Path, path: Path) -> None:
    """Put a finished file in the place of another one."""
    try:
        mode = path.stat().st_mode & 0o777
    except OSError:
        mask = os.umask(0)
        os.umask(mask)
        mode = 0o666 & ~mask
    try:
        new.chmod(mode)
        new.replace(path)
    except OSError:
        new.unlink(missing_ok=True)
        raise


def _digest(data: bytes) -> str:
    return blake2b(data, digest_size=16).hexdigest()
