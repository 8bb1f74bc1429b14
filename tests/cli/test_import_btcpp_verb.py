"""`grip import --from btcpp` and `grip convert --to btcpp`, as they are typed."""

from __future__ import annotations

from pathlib import Path

import pytest

from grip_bt.cli.__main__ import main

FILE = """<root BTCPP_format="4"><BehaviorTree ID="Fetch"><Sequence>
<Find object="cup" at="{where}"/><Sleep msec="1"/><Grasp at="{where}"/></Sequence></BehaviorTree><TreeNodesModel>
<Action ID="Find"><input_port name="object" type="std::string"/><output_port name="at" type="Pose"/></Action>
<Action ID="Grasp"><input_port name="at" type="Pose"/></Action></TreeNodesModel></root>
"""


def test_a_file_becomes_a_task_and_manifests_that_say_what_is_to_be_provided(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "fetch.xml").write_text(FILE)
    assert main(["import", str(tmp_path / "fetch.xml"), "--from", "btcpp", "-o", str(tmp_path / "fetch.yaml")]) == 0
    said = capsys.readouterr().out
    assert "nodes whose code has to be written: btcpp/Find, btcpp/Grasp" in said
    assert "write the code of btcpp/Grasp: leaf.py beside its manifest" in said
    manifest = (tmp_path / "nodes/btcpp/Find/manifest.yaml").read_text()
    assert "what it does: write the class" in manifest
    assert "implementation: leaf.py:Find" in manifest
    assert main(["check", str(tmp_path / "fetch.yaml")]) == 0
    assert main(["run", str(tmp_path / "fetch.yaml")]) == 1
    assert "leaf.py" in capsys.readouterr().err


def test_a_report_says_what_becomes_of_the_file_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "fetch.xml").write_text(FILE)
    command = ["import", str(tmp_path / "fetch.xml"), "--from", "btcpp", "-o", str(tmp_path / "x.yaml"), "--report"]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "task Fetch: 4 nodes, 1 variables, 0 inputs" in said
    assert "node types: flow/wait" in said
    assert "nodes whose code has to be written: btcpp/Find, btcpp/Grasp" in said
    assert [p.name for p in tmp_path.iterdir()] == ["fetch.xml"]


def test_importing_again_keeps_the_manifests_and_the_code(tmp_path: Path) -> None:
    (tmp_path / "fetch.xml").write_text(FILE)
    command = ["import", str(tmp_path / "fetch.xml"), "--from", "btcpp", "-o", str(tmp_path / "fetch.yaml")]
    assert main(command) == 0
    manifest = tmp_path / "nodes/btcpp/Grasp/manifest.yaml"
    manifest.write_text(manifest.read_text() + "codes: [slipped]\n")
    assert main(command) == 0
    assert manifest.read_text().endswith("codes: [slipped]\n")


def test_what_was_imported_can_be_written_and_comes_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "fetch.xml").write_text(FILE)
    task, written, again = tmp_path / "fetch.yaml", tmp_path / "out.xml", tmp_path / "again.yaml"
    assert main(["import", str(tmp_path / "fetch.xml"), "--from", "btcpp", "-o", str(task)]) == 0
    assert main(["convert", str(task), "--to", "btcpp", "-o", str(written)]) == 0
    assert '<btcpp__Find name="Find" object="cup" at="{where}"/>' in written.read_text()
    assert main(["import", str(written), "--from", "btcpp", "-o", str(again)]) == 0
    assert again.read_text().splitlines()[1:] == task.read_text().splitlines()[1:]


def test_a_file_with_parts_that_have_no_equal_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bad.xml").write_text(FILE.replace("<Sleep", "<UnsetBlackboard key='a'/><Sleep"))
    assert main(["import", str(tmp_path / "bad.xml"), "--from", "btcpp", "-o", str(tmp_path / "bad.yaml")]) == 1
    assert "bad.xml:2: error[no-equivalent] <UnsetBlackboard>: takes a variable away" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad.xml"]
