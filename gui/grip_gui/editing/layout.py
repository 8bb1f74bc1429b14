"""Where a person put nodes on the canvas: a file of its own beside the task, `pick.layout.yaml` for `pick.yaml`.

Nothing in it means anything to a task, and a task needs none. Paths are sorted and positions are whole numbers, one
node a line, so that changes are read and merged easily. What this version doesn't know is kept, not refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.tree import YamlMapping, from_data, parse, to_data
from grip_bt.base.yaml.writer import write
from grip_bt.task.edit.steps import Step, path_after

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
