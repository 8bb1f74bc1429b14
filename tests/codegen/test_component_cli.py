"""`grip component` and `grip interfaces` say what they did, and what is wrong, with the right exit status."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from grip_bt.cli.__main__ import main

EXAMPLE = Path(__file__).parents[2] / "examples" / "components" / "antipodal_grasps"


@pytest.fixture
def component(tmp_path):
    folder = tmp_path / "components" / "mine"
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("__pycache__", "node"))
    return folder


def test_a_node_is_added_checked_and_listed(component, capsys):
    assert main(["component", "add", "--check", str(component)]) == 1
    assert "leaf.py isn't up to date" in capsys.readouterr().err
    assert not (component / "node").exists()
    assert main(["component", "add", str(component)]) == 0
    assert "leaf.py" in capsys.readouterr().out
    assert main(["component", "add", "--check", str(component)]) == 0
    (component.parents[1] / "grip.yaml").write_text("grip: 1\n")
    assert main(["component", "list", str(component.parents[1])]) == 0
    assert "antipodal_grasps" in capsys.readouterr().out


def test_a_broken_contract_is_told_field_by_field(component, capsys):
    service = component / "interfaces" / "antipodal_interfaces" / "srv" / "ProposeGrasps.srv"
    service.write_text("sensor_msgs/PointCloud2 cloud\n---\nfloat64 outcome\n")
    assert main(["component", "add", str(component)]) == 1
    told = capsys.readouterr().err
    assert "request: the field 'input' is missing (found: sensor_msgs/PointCloud2 cloud)" in told
    assert "response: the field 'outcome' is float64; it must be one integer" in told
    assert "response: the field 'returned_object' is missing" in told
    assert not (component / "node").exists()


def test_a_syntax_error_in_an_interface_is_told_with_file_and_line(component, capsys):
    service = component / "interfaces" / "antipodal_interfaces" / "srv" / "ProposeGrasps.srv"
    service.write_text("sensor_msgs/PointCloud2 input\n---\nint32\n")
    for command in (["component", "add", str(component)], ["interfaces", "build", str(component / "interfaces")]):
        assert main(command) == 1
        assert f"{service}:3: a field is written as 'type name'" in capsys.readouterr().err


def test_an_interface_that_is_nowhere_is_named(component, capsys):
    file = component / "component.yaml"
    file.write_text(file.read_text().replace("antipodal_interfaces/", "nowhere_interfaces/"))
    assert main(["component", "add", str(component)]) == 1
    assert "no package 'nowhere_interfaces'" in capsys.readouterr().err


def test_a_folder_that_is_no_component_is_named(tmp_path, capsys):
    assert main(["component", "add", str(tmp_path)]) == 1
    assert "component.yaml" in capsys.readouterr().err
