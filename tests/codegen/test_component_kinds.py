"""Packages of actions, of topics and of services with rules: golden, formatted, tested by themselves."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from grip_bt.base.errors import ContractError, GripError
from grip_bt.codegen import check_contract, render, write_package
from grip_bt.codegen.contract import suggested_outcomes
from grip_bt.codegen.rehearsal import rehearse
from grip_bt.codegen.render import class_name
from grip_bt.codegen.scaffold import OutcomesNeededError, component_text, parse_outcomes
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.manifest import read_manifests
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec

GOLDEN = Path(__file__).parents[1] / "golden"
PLAN = InterfaceSpec(
    "my_pkg",
    "action",
    "PlanGrasp",
    (FieldSpec("input", "sensor_msgs/msg/PointCloud2"), FieldSpec("reach_mm", "float64")),
    (FieldSpec("outcome", "uint8"), FieldSpec("returned_object", "my_pkg/msg/Grasp", array=True)),
    (FieldSpec("progress", "float32"),),
)
COUNT = InterfaceSpec(
    "my_pkg",
    "srv",
    "CountObjects",
    (FieldSpec("image", "sensor_msgs/msg/Image"), FieldSpec("model", "string")),
    (FieldSpec("count", "int32"), FieldSpec("boxes", "my_pkg/msg/Box", array=True), FieldSpec("note", "string")),
)
JOINTS = InterfaceSpec(
    "sensor_msgs",
    "msg",
    "JointState",
    (FieldSpec("name", "string", array=True), FieldSpec("position", "float64", True)),
)


def component(**more):
    return ComponentFile.model_validate({"name": "c", "server": "/do", **more})


ACTION = component(
    name="plan_grasp",
    interface="my_pkg/action/PlanGrasp",
    server="/plan_grasp",
    outcomes=["found", "none"],
    meaning={"none": "failure"},
    ports={
        "input": "PointCloud",
        "returned_object": "list[Grasp]",
        "reach": {"type": "float", "field": "reach_mm", "unit": "mm"},
    },
)
RULED = component(
    name="count_objects",
    interface="my_pkg/srv/CountObjects",
    outcomes={"found": 'count > 0 and note != "a | b"', "none": "count == 0"},
    meaning={"none": "failure"},
    ports={"image": "Image"},
    fixed={"model": "yolo"},
)
TOPIC = component(
    name="joints", interface="sensor_msgs/msg/JointState", outcomes={"still": "len(name) == 0", "moving": "true"}
)
CASES = {"plan_grasp": (ACTION, PLAN), "count_objects": (RULED, COUNT), "joints": (TOPIC, JOINTS)}


@pytest.mark.parametrize("name", CASES)
def test_the_package_is_the_golden_one(name):
    files = render(*CASES[name])
    assert {path: (GOLDEN / name / path).read_text() for path in files} == files
    assert sorted(p.name for p in (GOLDEN / name).iterdir() if p.is_file()) == sorted(files)


@pytest.mark.parametrize("name", CASES)
def test_generated_python_is_formatted_clean_and_passes_its_own_test(tmp_path, name):
    write_package(tmp_path, render(*CASES[name]))
    for command in (["format", "--check"], ["check", "--select", "E,F,W,I,D,UP,B"]):
        done = subprocess.run(
            [sys.executable, "-m", "ruff", *command, "--isolated", "--line-length", "120", str(tmp_path)],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout


def test_an_action_has_its_feedback_however_it_ends(tmp_path):
    write_package(tmp_path, render(ACTION, PLAN))
    (manifest,) = read_manifests(tmp_path / "manifest.yaml")
    assert manifest.outputs["feedback"].type == "my_pkg/action/PlanGrasp_Feedback | None"
    assert set(manifest.outputs["feedback"].on) == set(manifest.outcomes)
    assert {"rejected", "aborted", "canceled", "server_lost", "timed_out", "bad_reply"} == set(manifest.codes)
    end = rehearse(tmp_path, {"outcome": 1, "returned_object": []}, feedback=0.5)
    assert (end.outcome, end.meaning, end.outputs) == ("none", "failure", {"feedback": 0.5})


def test_a_field_that_is_mapped_is_a_port_under_its_own_name(tmp_path):
    write_package(tmp_path, render(ACTION, PLAN))
    (manifest,) = read_manifests(tmp_path / "manifest.yaml")
    assert {name: (p.type, p.required) for name, p in manifest.inputs.items()} == {
        "input": ("PointCloud", True),
        "reach": ("float", False),
    }


def test_rules_choose_the_first_outcome_that_holds_and_say_when_none_does(tmp_path):
    write_package(tmp_path, render(RULED, COUNT))
    assert "model" not in read_manifests(tmp_path / "manifest.yaml")[0].inputs
    found = rehearse(tmp_path, {"count": 2, "boxes": [], "note": ""})
    assert (found.outcome, found.outputs["count"]) == ("found", 2)
    assert rehearse(tmp_path, {"count": 0, "boxes": [], "note": ""}).outcome == "none"
    nothing = rehearse(tmp_path, {"count": 1, "boxes": [], "note": "a | b"})
    assert (nothing.outcome, nothing.code) == ("failure", "bad_reply")
    assert "none of the rules holds: found: count > 0" in nothing.message
    wrong = rehearse(tmp_path, {"count": "two", "boxes": [], "note": ""})
    assert (wrong.code, "can't be computed" in wrong.message) == ("bad_reply", True)


def test_rules_and_fixed_fields_are_checked_against_the_interface():
    wrong = component(interface="my_pkg/srv/CountObjects", outcomes={"found": "cuont > 0"}, fixed={"modle": "x"})
    with pytest.raises(ContractError) as caught:
        check_contract(wrong, COUNT)
    told = caught.value.problems
    assert "the rule of 'found' reads 'cuont'; did you mean 'count'?" in told[0]
    assert "fixed: 'modle' isn't a field of the request; did you mean 'model'?" in told[1]


def test_an_interface_without_the_three_fields_is_told_that_rules_would_do():
    with pytest.raises(ContractError) as caught:
        check_contract(component(interface="my_pkg/srv/CountObjects", outcomes=["found"]), COUNT)
    assert "give outcomes by rule" in caught.value.problems[-1]


def test_a_comment_that_speaks_of_the_three_fields_is_not_the_contract():
    """The original looked for substrings (its fault B38)."""
    spoken = InterfaceSpec(
        "p", "srv", "S", (FieldSpec("input_image", "string", doc="input"),), (FieldSpec("my_outcome", "int32"),)
    )
    with pytest.raises(ContractError) as caught:
        check_contract(component(interface="p/srv/S", outcomes=1), spoken)
    assert len(caught.value.problems) == 4


@pytest.mark.parametrize(
    ("name", "wanted"), [("ezgripper_controller", "EzgripperController"), ("rrt2_star", "Rrt2Star"), ("a", "A")]
)
def test_class_names_are_made_in_one_place_and_found_again(tmp_path, name, wanted):
    """The original spelled a class in two ways, so that importing it failed (its fault B10)."""
    made = component(name=name, interface="my_pkg/action/PlanGrasp", outcomes=1)
    assert class_name(made) == wanted
    write_package(tmp_path, render(made, PLAN))
    assert rehearse(tmp_path, {"outcome": 0, "returned_object": []}).outcome == "outcome_0"


@pytest.mark.parametrize("label", ['clo"se', "it's", 'back\\slash"', "{{ x }}", "line\nbreak"])
def test_no_text_of_a_file_becomes_code(tmp_path, label):
    """The original quoted strings twice and made a syntax error of them (its fault B5)."""
    made = component(
        interface="my_pkg/srv/CountObjects",
        doc=label,
        outcomes={"found": f"note == {label.split(chr(10))[0].replace(chr(92), '')!r}", "no": "true"},
    )
    files = render(made, COUNT)
    tree = ast.parse(files["leaf.py"])
    literals = {n.value for n in ast.walk(tree) if isinstance(n, ast.Constant)}
    assert made.rules["found"] in literals


def test_two_components_with_the_same_class_name_do_not_meet(tmp_path):
    """The original put all generated classes into one name space (its fault B11)."""
    for folder, labels in (("one", ["a"]), ("two", ["b"])):
        made = component(name="move", interface="my_pkg/action/PlanGrasp", outcomes=labels)
        write_package(tmp_path / folder, render(made, PLAN))
    reply = {"outcome": 0, "returned_object": []}
    assert [rehearse(tmp_path / f, reply).outcome for f in ("one", "two")] == ["a", "b"]


@pytest.mark.parametrize("value", [0, False, "", [], None])
def test_a_result_that_looks_like_nothing_is_still_written(tmp_path, value):
    """The original kept only what was true (its fault B27)."""
    write_package(tmp_path, render(ACTION, PLAN))
    assert rehearse(tmp_path, {"outcome": 0, "returned_object": value}).outputs["returned_object"] == value


def test_outcomes_are_read_as_a_person_writes_them():
    assert parse_outcomes("3") == 3
    assert parse_outcomes("one, several,none") == ["one", "several", "none"]
    assert parse_outcomes("found: count > 0; none: true") == {"found": "count > 0", "none": "true"}
    for wrong in ("a b", "found:", "a,b-c", "a: x > 0; a: true"):
        with pytest.raises(GripError, match="--outcomes"):
            parse_outcomes(wrong)


def test_what_an_interface_suggests_is_possible():
    for interface in (PLAN, COUNT):
        text = component_text(interface, "c", "/do", parse_outcomes(suggested_outcomes(interface)), [])
        assert text.startswith("name: c\n")
    assert suggested_outcomes(COUNT) == "found: len(boxes) > 0; none: true"
    assert "--outcomes 'done,failed'" in str(OutcomesNeededError(PLAN))


def test_a_topic_without_rules_says_what_it_needs():
    with pytest.raises(ValueError, match="a message, which numbers no outcome: give outcomes by rule"):
        component(interface="std_msgs/msg/String", outcomes=["a"])
    assert component(interface="std_msgs/msg/String").outcomes == ("received",)
    assert component(interface="std_msgs/msg/String", use="publish").outcomes == ("published",)


def test_a_rule_that_is_no_expression_is_told_when_the_file_is_read():
    with pytest.raises(ValueError, match="the rule of the outcome 'found'"):
        component(interface="my_pkg/srv/CountObjects", outcomes={"found": "__import__('os')"})
