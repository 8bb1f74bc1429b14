"""What the page can call and draw is what a task can be made of."""

from __future__ import annotations

import re
from pathlib import Path

from grip_bt.catalog import Catalog
from grip_bt.graph.model import KINDS

WORDS = Path(__file__).parents[2] / "gui" / "frontend" / "src" / "model" / "words.ts"


def keys_of(name: str) -> set[str]:
    """Return the keys of a table of words; the page's own tests see to it that its drawings have the same."""
    table = re.compile(rf"export const {name}: Record<string, string> = {{(.*?)^}};", re.S | re.M)
    found = table.search(WORDS.read_text("utf-8"))
    assert found is not None, f"words.ts has no table {name}"
    return set(re.findall(r"^ +(\w+):", found.group(1), re.M))


def test_every_node_of_the_catalogue_is_in_a_group_with_a_word_and_a_drawing() -> None:
    groups = keys_of("GROUPS")
    lost = sorted(manifest.id for manifest in Catalog.builtin() if manifest.id.split("/")[0] not in groups)
    assert not lost, f"say in words.ts and icons.tsx how the groups of {lost} are called and drawn"


def test_every_kind_of_node_has_a_word_and_a_drawing() -> None:
    assert set(KINDS) | {"leaf"} <= keys_of("KINDS")
