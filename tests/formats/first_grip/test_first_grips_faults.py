"""Faults of the first GRIP: the page tells each with the test that holds us to better, and those tests are there."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import grip_bt
from grip_bt.base.errors import InvalidTaskError
from grip_bt.base.values import Pose
from grip_bt.commanders.scene import PlanningScene
from grip_bt.runtime import JournalReader

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "compatibility.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| (B\d+(?:, B\d+)*) \| .+ \| (.+) \|$", re.MULTILINE)
OURS = {*range(1, 6), 8, 9, *range(10, 19), *range(25, 28), 33, 35, 38, 41, 42, 43, 44}


def table() -> dict[int, list[str]]:
    """Return fault -> the tests that the page names for it."""
    found: dict[int, list[str]] = {}
    for numbers, tests in ROW.findall(PAGE):
        for number in re.findall(r"\d+", numbers):
            found.setdefault(int(number), []).extend(re.findall(r"`([^`]+)`", tests))
    return found


def test_every_fault_of_these_rooms_is_on_the_page_with_a_test():
    found = table()
    assert set(found) == OURS
    assert all(found.values())


@pytest.mark.parametrize("name", sorted({name for names in table().values() for name in names}))
def test_a_test_that_the_page_names_is_there_and_asserts_something(name):
    file, _, test = name.partition("::")
    tree = ast.parse((ROOT / "tests" / file).read_text(encoding="utf-8"))
    functions = {node.name: node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    assert test in functions, f"tests/{file} has no {test}"
    checks = (ast.Assert, ast.With)  # a `with` is one of pytest's
    assert any(isinstance(node, checks) for node in ast.walk(functions[test]))


TASK = """
grip: 1
name: texts
data: {said: Any}
root: {node: flow/set, with: {value: VALUE}, out: {value: said}}
"""


def said(tmp_path, value: object) -> object:
    """Return what a task that sets a variable to a literal leaves in it, after a way through a file."""
    file, journal = tmp_path / "texts.yaml", tmp_path / "j.sqlite"
    file.write_text(grip_bt.dumps(grip_bt.loads(TASK.replace("VALUE", json.dumps(value)))), encoding="utf-8")
    result = grip_bt.run(file, journal=journal, robot="fake")
    assert result.outcome == "success"
    with JournalReader(journal) as reader:
        run = max(reader.runs(), key=lambda r: r.started)
        return reader.value(reader.variables(run.id)["said"])


@pytest.mark.parametrize(
    "value",
    [
        "self collision",
        '"close"',
        "'close'",
        "[]",
        "None",
        "True",
        "{{ x }}",
        "a\nb",
        "self",
        "0.10",
        "",
        "Größe é 手",
        [],
        {},
        ["[", "]"],
        {"self": "x"},
        True,
        None,
        1.5,
        -3,
        [1, [2, {"a": None}]],
    ],
)
def test_literals_of_every_kind_reach_the_node_as_they_are(tmp_path, value):
    """The first pasted them into Python (B2, B3, B5)."""
    assert said(tmp_path, value) == value


def test_an_output_that_a_node_does_not_have_is_an_error_before_anything_runs(tmp_path):
    """The first dropped what was written there, and succeeded (B8)."""
    text = TASK.replace("VALUE", "1").replace("out: {value: said}", "out: {valu: said}")
    (tmp_path / "texts.yaml").write_text(text)
    with pytest.raises(InvalidTaskError, match="has no output 'valu'; did you mean 'value'"):
        grip_bt.run(tmp_path / "texts.yaml", robot="fake")


NAMES = ("box", "can", "hand", "*")


@given(st.lists(st.tuples(st.sampled_from(NAMES), st.sampled_from(NAMES), st.booleans()), max_size=12))
@settings(max_examples=60, deadline=None)
def test_forbidding_what_was_allowed_leaves_what_was_before_whatever_the_order(changes):
    """The first forgot what the robot's makers had allowed, and indexed an empty matrix (B1, B4)."""
    scene = PlanningScene({"hand": Pose}, links={"hand": ("finger", "thumb")})
    for name in ("box", "can"):
        scene.set_box(name, (0.1, 0.1, 0.1), Pose())
    before = scene.snapshot()
    meant: set[frozenset[str]] = set()
    for one, other, allowed in changes:
        scene.allow(one, other, allowed)
        pairs = {frozenset((a, b)) for a in _links(one) for b in _links(other)}
        meant = meant | pairs if allowed else meant - pairs
    assert {frozenset(pair) for pair in scene.snapshot().allowed} == meant
    for one, other, _ in changes:
        scene.allow(one, other, allowed=False)
    assert scene.snapshot() == before
    scene.remove("nothing")  # what isn't there can be taken away without harm


def _links(name: str) -> tuple[str, ...]:
    return ("finger", "thumb") if name == "hand" else (name,)
