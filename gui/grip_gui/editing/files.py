"""Files of a project as they are edited: read, written, noticed when others change them, recovered; and the layout.

Where a person put nodes on the canvas is in a file of its own beside the task, `pick.layout.yaml` for `pick.yaml`.
Nothing in it means anything to a task, and a task needs none. Paths are sorted and positions are whole numbers, one
node a line, so that changes are read and merged easily. What this version doesn't know is kept, not refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from hashlib import blake2b
from pathlib import Path
from typing import Any, NamedTuple

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.files import replace_bytes
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.tree import YamlMapping, from_data, parse, read_file, to_data
from grip_bt.base.yaml.writer import write
from grip_bt.task.edit.steps import Step, path_after
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


Position = tuple[int, int]
"""x and y [px] of a node's upper left corner, in the frame of the container that holds it."""
VIEWS = ("flow", "tree")
_GRID = 8
_NONE: Mapping[Any, Any] = FrozenDict()


class Layout(NamedTuple):
    """Pinned positions of one task, by view.

    Attributes:
        pinned: view -> path of a node -> position.
        unknown: what stands in the file besides, kept as it is.
    """

    pinned: Mapping[str, Mapping[str, Position]] = _NONE
    unknown: Mapping[str, Any] = _NONE

    def pin(self, view: str, path: str, spot: tuple[float, float] | None) -> Layout:
        """Return the layout with a node pinned at the grid point nearest to a spot; None: placed automatically."""
        spots = {p: at for p, at in self.pinned.get(view, _NONE).items() if p != path}
        if spot is not None:
            x, y = (_GRID * math.floor(number / _GRID + 0.5) for number in spot)
            spots[path] = (x, y)
        return Layout({**self.pinned, view: spots}, self.unknown)

    def after(self, steps: Iterable[Step]) -> Layout:
        """Return the layout after an edit of the task: entries follow their nodes, those of removed nodes go."""
        taken = tuple(steps)
        pinned = {}
        for view, spots in self.pinned.items():
            moved = {path_after(path, taken): spot for path, spot in spots.items()}
            pinned[view] = {path: spot for path, spot in moved.items() if path is not None}
        return Layout(pinned, self.unknown)


def layout_path(task: Path) -> Path:
    """Return the file of the layout of a task's file."""
    return task.with_name(f"{task.stem}.layout.yaml")


def read_layout(text: str) -> Layout:
    """Read a layout, of YAML. Entries that aren't ones of a layout are kept aside or passed over, never refused."""
    data = to_data(parse(text)) if text.strip() else None
    if not isinstance(data, dict):
        return Layout()
    pinned = {view: _spots(data[view]) for view in VIEWS if isinstance(data.get(view), dict)}
    unknown = {key: value for key, value in data.items() if key not in VIEWS}
    return Layout({view: spots for view, spots in pinned.items() if spots}, unknown)


def write_layout(layout: Layout) -> str:
    """Return the text of a layout: paths sorted, one node a line; an empty layout is an empty text."""
    pinned = {view: layout.pinned[view] for view in VIEWS if layout.pinned.get(view)}
    data: dict[str, Any] = {view: {p: list(spots[p]) for p in sorted(spots)} for view, spots in pinned.items()}
    data |= {key: layout.unknown[key] for key in sorted(layout.unknown)}
    if not data:
        return ""
    tree = from_data(data)
    assert isinstance(tree, YamlMapping)
    blocks = {id(entry.value) for key, entry in tree.entries.items() if key in VIEWS}
    return write(tree, lambda value: id(value) in blocks)


def _spots(entries: dict[str, Any]) -> dict[str, Position]:
    lists = {path: spot for path, spot in entries.items() if isinstance(spot, list) and len(spot) == 2}
    return {path: (spot[0], spot[1]) for path, spot in lists.items() if all(type(number) is int for number in spot)}
