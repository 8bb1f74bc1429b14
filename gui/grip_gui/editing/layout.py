"""Where a person put nodes on the canvas: a file of its own beside the task, `pick.layout.yaml` for `pick.yaml`.

Nothing in it means anything to a task, and a task needs none. Only what was pinned by hand is there: what isn't is
placed automatically. Paths are sorted and positions are whole numbers, one node a line, so that changes are read and
merged easily. What this version doesn't know is kept, not refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from grip_bt.base.yaml.tree import YamlMapping, from_data, parse, read_file, to_data
from grip_bt.base.yaml.writer import write
from grip_bt.task.edit.steps import Step, path_after

Position = tuple[int, int]
"""x and y [px] of a node's upper left corner, in the frame of the container that holds it."""
VIEWS = ("flow", "tree")
_GRID = 8
_NONE: Mapping[Any, Any] = MappingProxyType({})


@dataclass(frozen=True)
class Layout:
    """Pinned positions and folded containers of one task, by view.

    Attributes:
        pinned: view -> path of a node -> position.
        folded: paths of containers that are drawn closed.
        unknown: what stands in the file besides, kept as it is.
    """

    pinned: Mapping[str, Mapping[str, Position]] = field(default_factory=lambda: _NONE)
    folded: frozenset[str] = frozenset()
    unknown: Mapping[str, Any] = field(default_factory=lambda: _NONE)

    def position(self, view: str, path: str) -> Position | None:
        """Return where a node is pinned; None where it isn't."""
        return self.pinned.get(view, _NONE).get(path)

    def pin(self, view: str, path: str, x: float, y: float) -> Layout:
        """Return the layout with a node pinned at the grid point nearest to a position."""
        spot = (_on_grid(x), _on_grid(y))
        return self._with({**self.pinned, view: {**self.pinned.get(view, _NONE), path: spot}})

    def unpin(self, view: str, path: str) -> Layout:
        """Return the layout with a node placed automatically again."""
        kept = {p: spot for p, spot in self.pinned.get(view, _NONE).items() if p != path}
        return self._with({**self.pinned, view: kept})

    def fold(self, path: str, folded: bool = True) -> Layout:
        """Return the layout with a container drawn closed, or open."""
        paths = self.folded | {path} if folded else self.folded - {path}
        return Layout(self.pinned, paths, self.unknown)

    def after(self, steps: Iterable[Step]) -> Layout:
        """Return the layout after an edit of the task: entries follow their nodes, those of removed nodes go."""
        taken = tuple(steps)
        pinned = {}
        for view, spots in self.pinned.items():
            moved = {path_after(path, taken): spot for path, spot in spots.items()}
            pinned[view] = {path: spot for path, spot in moved.items() if path is not None}
        folded = (path_after(path, taken) for path in self.folded)
        return Layout(pinned, frozenset(path for path in folded if path is not None), self.unknown)

    def _with(self, pinned: Mapping[str, Mapping[str, Position]]) -> Layout:
        return Layout(pinned, self.folded, self.unknown)


def layout_path(task: Path | str) -> Path:
    """Return the file of the layout of a task's file."""
    task = Path(task)
    return task.with_name(f"{task.stem}.layout.yaml")


def load_layout(path: Path | str) -> Layout:
    """Read a layout file; one that isn't there is an empty layout.

    Raises:
        DocumentError: it isn't YAML.
    """
    return read_layout(read_file(path), str(path)) if Path(path).exists() else Layout()


def read_layout(text: str, source: str = "") -> Layout:
    """Read a layout. Entries that aren't ones of a layout are kept aside or passed over, never refused.

    Raises:
        DocumentError: it isn't YAML.
    """
    if not text.strip():
        return Layout()
    data = to_data(parse(text, source))
    if not isinstance(data, dict):
        return Layout()
    pinned = {view: _spots(data[view]) for view in VIEWS if isinstance(data.get(view), dict)}
    folded = data.get("folded", [])
    folded = frozenset(p for p in folded if isinstance(p, str)) if isinstance(folded, list) else frozenset()
    unknown = {key: value for key, value in data.items() if key not in (*VIEWS, "folded")}
    return Layout({view: spots for view, spots in pinned.items() if spots}, folded, unknown)


def write_layout(layout: Layout) -> str:
    """Return the text of a layout: paths sorted, one node a line; an empty layout is an empty text."""
    data: dict[str, Any] = {}
    for view in VIEWS:
        spots = layout.pinned.get(view, _NONE)
        if spots:
            data[view] = {path: list(spots[path]) for path in sorted(spots)}
    if layout.folded:
        data["folded"] = sorted(layout.folded)
    data |= {key: layout.unknown[key] for key in sorted(layout.unknown)}
    if not data:
        return ""
    tree = from_data(data)
    assert isinstance(tree, YamlMapping)
    blocks = {id(entry.value) for key, entry in tree.entries.items() if key in (*VIEWS, "folded")}
    return write(tree, lambda value: id(value) in blocks)


def _spots(entries: dict[str, Any]) -> dict[str, Position]:
    return {path: (spot[0], spot[1]) for path, spot in entries.items() if _is_spot(spot)}


def _is_spot(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(type(number) is int for number in value)


def _on_grid(number: float) -> int:
    return _GRID * math.floor(number / _GRID + 0.5)
