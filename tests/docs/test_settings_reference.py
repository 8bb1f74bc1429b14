"""The pages about the project's files say what the models say, and their examples are read without an error."""

import json
import re
from pathlib import Path
from runpy import run_path

import pytest

from grip_bt.app.campaign.file import read_campaign
from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.mocks import read_mocks
from grip_bt.commanders.taught import TaughtStates
from grip_bt.task.catalog.component_file import load_component
from grip_sim.noise import PRESETS
from grip_sim.objects import load_object
from grip_sim.worlds import load_world

ROOT = Path(__file__).parents[2]
TOOL = run_path(str(ROOT / "tools" / "settings_reference.py"))
NAMES = [*(page.name for page in TOOL["PAGES"]), *TOOL["SCHEMAS"], TOOL["SHAPES"]]
WRITTEN = {name: (ROOT / "docs" / name).read_text(encoding="utf-8") for name in NAMES}
PAGES = {name: text for name, text in WRITTEN.items() if name.endswith(".md")}
READERS = {
    "grip.yaml": find_project,
    "component.yaml": load_component,
    "taught.yaml": TaughtStates,
    "mocks.yaml": read_mocks,
    "campaigns": read_campaign,
    "objects": load_object,
    "worlds": lambda path: load_world(str(path)),
}
EXAMPLE = re.compile(r'^```yaml title="([^"]+)"\n(.*?)^```$', re.DOTALL | re.MULTILINE)
EXAMPLES = [example for text in PAGES.values() for example in EXAMPLE.findall(text)]


def test_they_are_as_new_as_the_models():
    made = TOOL["reference"]()
    assert made.keys() == WRITTEN.keys()
    for name, text in made.items():
        assert text == WRITTEN[name], f"{name}: run: python tools/settings_reference.py docs"


def test_every_kind_of_file_has_an_example():
    assert {title.split("/")[0] for title, _ in EXAMPLES} == set(READERS)


@pytest.mark.parametrize(("title", "text"), EXAMPLES, ids=[title for title, _ in EXAMPLES])
def test_its_reader_takes_the_example(tmp_path, title, text):
    path = tmp_path / title
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8")
    READERS[title.split("/")[0]](path)


def test_the_robot_of_the_example_is_there_and_has_the_groups_that_it_names(tmp_path):
    text = next(text for title, text in EXAMPLES if title == "grip.yaml" and "mount: {link" in text)
    (tmp_path / "grip.yaml").write_text(text, encoding="utf-8")
    project = find_project(tmp_path)
    groups = {part.group for part in (*project.file.arms.values(), *project.file.hands.values())}
    assert groups <= set(project.description().groups)


def test_each_key_has_a_type_and_a_meaning():
    for name, text in PAGES.items():
        rows = [re.split(r" ?(?<!\\)\| ?", line)[1:-1] for line in text.splitlines() if line.startswith("| `")]
        assert rows
        assert all(row[1] and row[-1] for row in rows), name
        assert not re.findall(r"any value (?!\|)|\bConfig\b", text), name


def test_the_schemas_take_what_a_file_may_say_in_short():
    world = json.loads(WRITTEN["world.schema.json"])
    noise = world["$defs"]["CameraConfig"]["properties"]["noise"]["anyOf"]
    assert {name for option in noise for name in option.get("enum", [])} == set(PRESETS)
    assert json.loads(WRITTEN["project.schema.json"])["required"] == ["grip"]
