"""docs/commanders.md and docs/own_nodes.md are held to what they say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from grip_bt.commanders.taught import TaughtStates
from grip_bt.task import loads
from grip_bt.task.catalog import Catalog, read_python_nodes
from grip_bt.task.catalog.ros_config import sensor_manifest
from grip_bt.task.validation import validate

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {name: (DOCS / f"{name}.md").read_text() for name in ("commanders", "own_nodes")}


def fences(page, language):
    return re.findall(rf"```{language}\n(.*?)```", PAGES[page], re.DOTALL)


def test_every_node_that_the_pages_name_is_there():
    groups = {id.split("/")[0] for id in Catalog.builtin().ids()}
    named = re.findall(r"`([a-z]+/[a-z_]+)`", PAGES["commanders"])
    assert len(named) > 30
    assert {name for name in named if name.split("/")[0] in groups} <= set(Catalog.builtin().ids())
    assert {name for name in named if name.split("/")[0] not in groups} <= {"tests/contracts"}


def test_the_page_names_every_node_of_the_scene_and_the_hand():
    missing = [
        i for i in Catalog.builtin().ids() if i.split("/")[0] in ("scene", "hand") and i not in PAGES["commanders"]
    ]
    assert set(missing) <= {"hand/hold"}


@pytest.mark.parametrize("text", fences("commanders", "python"))
def test_its_python_runs(text):
    exec(compile(text, "docs/commanders.md", "exec"), {})


def test_its_tasks_are_right():
    (*tasks, taught) = fences("commanders", "yaml")
    assert len(tasks) == 3
    catalog = Catalog.builtin().with_manifests([sensor_manifest("overhead")])
    for task in tasks:
        assert validate(loads(task), catalog).issues == ()
    assert "above_crate" in taught


def test_its_file_of_taught_names_is_one(tmp_path):
    (tmp_path / "taught.yaml").write_text(fences("commanders", "yaml")[-1])
    taught = TaughtStates(tmp_path / "taught.yaml")
    assert set(taught.of("right")) == {"above_crate", "look"}
    assert set(taught.states("right_hand")) == {"pinch"}


def test_the_nodes_of_the_page_are_found_and_run(tmp_path):
    found = []
    for k, text in enumerate(fences("own_nodes", "python")):
        file = tmp_path / f"page_{k}.py"
        file.write_text(text)
        found += read_python_nodes(file)
        exec(compile(text, str(file), "exec"), {"__name__": "page"})
    assert [manifest.id for manifest in found] == ["table/tallest", "shelf/next_slot", "shelf/peek", "shelf/stubborn"]
    catalog = Catalog.builtin().with_manifests([*found, sensor_manifest("overhead")])
    for task in fences("own_nodes", "yaml"):
        assert validate(loads(task), catalog).issues == ()
