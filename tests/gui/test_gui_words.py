"""What the page can call and draw is what a task can be made of."""

from __future__ import annotations

import re
from pathlib import Path

from grip_bt.task.catalog import Catalog
from grip_bt.task.model import KINDS
from grip_gui.editing.projection import kind_views

SRC = Path(__file__).parents[2] / "gui" / "frontend" / "src"
ROWS = {"rules", "cases", "wait_for"}
"""Fields that have a form of their own."""


def keys_of(name: str, file: str = "model/words.ts") -> set[str]:
    """Return the keys of a table of words; the page's own tests see to it that its drawings have the same."""
    table = re.compile(rf"const {name}: Record<string, string> = {{(.*?)^}};", re.S | re.M)
    found = table.search((SRC / file).read_text("utf-8"))
    assert found is not None, f"{file} has no table {name}"
    return set(re.findall(r"^ +(\w+):", found.group(1), re.M))


def test_every_node_of_the_catalogue_is_in_a_group_with_a_word_and_a_drawing() -> None:
    groups = keys_of("GROUPS")
    lost = sorted(manifest.id for manifest in Catalog.builtin() if manifest.id.split("/")[0] not in groups)
    assert not lost, f"say in words.ts and icons.tsx how the groups of {lost} are called and drawn"


def test_every_kind_of_node_has_a_title_and_a_drawing_of_its_own() -> None:
    views = kind_views()
    assert [view.kind for view in views] == list(KINDS)
    assert all(view.icon for view in views)
    assert len({view.icon for view in views}) == len({view.title for view in views}) == len(views)


def test_every_setting_of_a_container_has_a_label() -> None:
    labels = keys_of("LABELS", "view/edit/ContainerForm.tsx")
    kinds = (kind for kind in kind_views() if kind.kind not in ("subtask", "foreign"))
    lost = {field.key for kind in kinds for field in kind.fields} - labels - ROWS
    assert not lost, f"say in ContainerForm.tsx how {sorted(lost)} are called"
