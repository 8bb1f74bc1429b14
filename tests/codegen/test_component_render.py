"""Generated packages are readable, deterministic, harmless, and never take somebody's own file."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grip_bt.base.python_literals import py
from grip_bt.codegen import outdated, render, write_package
from grip_bt.codegen.rehearsal import rehearse
from grip_bt.codegen.render import NotOursError
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.manifest import read_manifests
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec

GOLDEN = Path(__file__).parents[1] / "golden" / "many_fields"
EXAMPLE = Path(__file__).parents[2] / "examples" / "components" / "antipodal_grasps"
SPEC = InterfaceSpec(
    "my_pkg",
    "srv",
    "PlanReach",
    (
        FieldSpec("input", "geometry_msgs/msg/PoseStamped", doc="where to | how"),
        FieldSpec("attempts", "uint8"),
        FieldSpec("names", "string", array=True, size=4, bounded=True),
    ),
    (
        FieldSpec("outcome", "int8"),
        FieldSpec("returned_object", "trajectory_msgs/msg/JointTrajectory"),
        FieldSpec("seconds", "float32", doc="time that it took [s]"),
    ),
)
COMPONENT = ComponentFile.model_validate(
    {
        "name": "plan_reach",
        "doc": 'Plan with "somebody\'s" planner: {{ nothing }} here is a template, and: no YAML either.',
        "interface": "my_pkg/srv/PlanReach",
        "server": "/planner/plan_reach",
        "outcomes": ["planned", "no_path", "failure"],
        "meaning": {"no_path": "failure", "failure": "failure"},
        "ports": {"input": "Pose", "returned_object": {"type": "Trajectory", "doc": "timed"}},
    }
)


def test_the_package_is_the_golden_one():
    files = render(COMPONENT, SPEC)
    assert {path: (GOLDEN / path).read_text() for path in files} == files
    assert sorted(p.name for p in GOLDEN.iterdir() if p.is_file()) == sorted(files)


def test_the_examples_node_is_up_to_date():
    from grip_bt.cli.component import rendered

    assert outdated(EXAMPLE / "node", rendered(EXAMPLE)) == []


def test_generated_python_is_formatted_and_clean(tmp_path):
    write_package(tmp_path, render(COMPONENT, SPEC))
    for command in (["format", "--check"], ["check", "--select", "E,F,W,I,D,UP,B"]):
        done = subprocess.run(
            [sys.executable, "-m", "ruff", *command, "--isolated", "--line-length", "120", str(tmp_path)],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("package", [EXAMPLE / "node", GOLDEN])
def test_generated_tests_pass(package):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-c", "/dev/null", str(package)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert "passed" in done.stdout


def test_the_manifest_reads_back(tmp_path):
    write_package(tmp_path, render(COMPONENT, SPEC))
    (manifest,) = read_manifests(tmp_path / "manifest.yaml")
    assert manifest.doc == COMPONENT.doc
    assert manifest.inputs["input"].doc == "where to | how"
    assert dict(manifest.outcomes) == {"planned": "success", "no_path": "failure", "failure": "failure"}


def test_a_generated_leaf_ends_with_the_outcome_of_the_number(tmp_path):
    write_package(tmp_path, render(COMPONENT, SPEC))
    reply = {"returned_object": "way", "seconds": 0.5}
    assert rehearse(tmp_path, {**reply, "outcome": 0}).outputs == reply
    assert rehearse(tmp_path, {**reply, "outcome": 1}).outcome == "no_path"
    bad = rehearse(tmp_path, {**reply, "outcome": 3})
    assert (bad.outcome, bad.code) == ("failure", "bad_reply")
    assert "planned, no_path, failure" in bad.message


def test_writing_again_changes_nothing_and_old_files_go(tmp_path):
    files = render(COMPONENT, SPEC)
    assert write_package(tmp_path, files) == sorted(files)
    assert write_package(tmp_path, files) == []
    (tmp_path / "leaf.py").write_text((tmp_path / "leaf.py").read_text() + "# edited\n")
    (tmp_path / "test_old_name.py").write_text((tmp_path / "leaf.py").read_text())
    (tmp_path / "notes.txt").write_text("mine")
    assert outdated(tmp_path, files) == ["leaf.py", "test_old_name.py"]
    assert write_package(tmp_path, files) == ["leaf.py", "test_old_name.py"]
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([*files, "notes.txt"])


def test_a_file_that_was_not_generated_is_never_overwritten(tmp_path):
    (tmp_path / "README.md").write_text("my own words")
    with pytest.raises(NotOursError, match=r"README\.md was not generated"):
        write_package(tmp_path, render(COMPONENT, SPEC))
    assert [p.name for p in tmp_path.iterdir()] == ["README.md"]


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner) | st.lists(inner).map(tuple) | st.dictionaries(st.text(), inner),
    max_leaves=8,
)


@given(VALUES)
def test_a_quoted_value_reads_back_as_itself(value):
    assert ast.literal_eval(py(value)) == value


@given(st.text())
def test_quoting_agrees_with_the_formatter_on_quotes(text):
    assert ("'" in text or '"' in text) or py(text)[0] == '"'


def test_what_is_no_literal_is_not_quoted():
    with pytest.raises(TypeError):
        py(object())
