import shutil
from pathlib import Path

import pytest

from grip_bt.cli.__main__ import main

EXAMPLE = str(Path(__file__).parents[2] / "examples" / "tasks" / "reactive_pick.yaml")
TANGLED = """\
grip: 1
name: tangled
root:
  kind: state_machine
  initial: start
  outcomes: {success: success, failure: failure}
  children:
    start: {node: flow/fail, on: {failure.x: b, failure: a}}
    a: {node: flow/fail, on: {failure: b}}
    b: {node: flow/fail, on: {failure.again: a, failure: failure}}
"""


@pytest.fixture
def tangled(tmp_path):
    path = tmp_path / "tangled.yaml"
    path.write_text(TANGLED)
    return path


@pytest.mark.parametrize("form", ["bt", "sm"])
def test_the_example_in_another_form_is_canonical_and_without_issues(form, tmp_path):
    out = tmp_path / "converted.yaml"
    assert main(["convert", EXAMPLE, "--to", form, "-o", str(out)]) == 0
    text = out.read_text()
    assert text.startswith("# reactive_pick.yaml as a ")
    assert ("kind: state_machine" in text) == (form == "sm")
    assert ("kind: sequence" in text) == (form == "bt")
    assert main(["fmt", "--check", str(out)]) == 0


def test_there_and_back_is_the_same_as_at_once(tmp_path):
    shutil.copytree(Path(EXAMPLE).parents[1], tmp_path, dirs_exist_ok=True)
    for form, source, name in (
        ("sm", EXAMPLE, "sm.yaml"),
        ("bt", tmp_path / "sm.yaml", "back.yaml"),
        ("bt", EXAMPLE, "bt.yaml"),
    ):
        assert main(["convert", str(source), "--to", form, "-o", str(tmp_path / name)]) == 0
    back, once = ((tmp_path / name).read_text().partition("\ngrip: 1")[2] for name in ("back.yaml", "bt.yaml"))
    assert back == once


def test_what_stays_is_said_in_the_file_and_on_stderr(tangled, capsys):
    assert main(["convert", str(tangled), "--to", "bt"]) == 0
    said = capsys.readouterr()
    assert "kind: state_machine" in said.out
    assert "entered at more than one state" in said.err
    comment = " ".join(line.lstrip("# ") for line in said.out.splitlines() if line.startswith("#"))
    assert "entered at more than one state" in comment


def test_strict_refuses_what_would_stay(tangled, tmp_path, capsys):
    out = tmp_path / "out.yaml"
    assert main(["convert", str(tangled), "--to", "bt", "--strict", "-o", str(out)]) == 1
    assert "can't be expressed exactly as a behaviour tree" in capsys.readouterr().err
    assert not out.exists()
