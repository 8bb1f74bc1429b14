"""`grip import --from btcpp` and `grip convert --to btcpp`, as they are typed."""

from __future__ import annotations

import json
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
    assert "write the code of btcpp/Find, btcpp/Grasp: leaf.py beside the manifest" in said
    manifest = (tmp_path / "nodes/btcpp/Find/manifest.yaml").read_text()
    assert "what it does stands in leaf.py" in manifest
    assert main(["run", str(tmp_path / "fetch.yaml"), "--mocks", str(tmp_path / "mocks/fetch.yaml")]) == 0
    assert "implementation: leaf.py:Find" in manifest
    assert main(["check", str(tmp_path / "fetch.yaml")]) == 0
    assert main(["run", str(tmp_path / "fetch.yaml")]) != 0
    assert "leaf.py" in "".join(capsys.readouterr())


def test_a_report_says_what_becomes_of_the_file_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "fetch.xml").write_text(FILE)
    command = ["import", str(tmp_path / "fetch.xml"), "--from", "btcpp", "-o", str(tmp_path / "x.yaml"), "--report"]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "task Fetch: 4 nodes, 1 variable, 0 inputs" in said
    assert "node types: flow/wait" in said
    assert "nodes whose code has to be written: btcpp/Find, btcpp/Grasp" in said
    assert main([*command, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["tasks"], report["items"]) == (["Fetch"], [])
    assert "write the code of btcpp/Find" in report["to_do"][0]
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
    assert '<Find name="Find" object="cup" at="{where}" />' in written.read_text()
    assert main(["import", str(written), "--from", "btcpp", "-o", str(again)]) == 0
    assert again.read_text().splitlines()[1:] == task.read_text().splitlines()[1:]


def test_a_file_with_parts_that_have_no_equal_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bad.xml").write_text(FILE.replace("<Sleep", "<Inverter/><Sleep"))
    assert main(["import", str(tmp_path / "bad.xml"), "--from", "btcpp", "-o", str(tmp_path / "bad.yaml")]) == 1
    assert "bad.xml:2: error[no-equivalent] <Inverter>: has 0 children and needs 1" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad.xml"]


NAVIGATE = """text before it <root BTCPP_format="4" main_tree_to_execute="Go"><include path="../parts/drive.xml"/>
<BehaviorTree ID="Go"><RecoveryNode number_of_retries="2">
<SubTree ID="Drive" where="{goal}"/><Spin by="1.57"/></RecoveryNode></BehaviorTree></root>"""
DRIVE = """<root BTCPP_format="4"><BehaviorTree ID="Drive"><PipelineSequence>
<RateController hz="2"><Plan to="{where}" path="{path}"/></RateController>
<Throttled by="{path}"><SubTree ID="Follow" path="{path}"/></Throttled></PipelineSequence></BehaviorTree></root>"""
FOLLOW = """<root BTCPP_format="4"><BehaviorTree ID="Follow">
<FollowPath _skipIf="path == 'none' && speed < 1" path="{path}"/>
</BehaviorTree></root>"""
MODELS = """<root><TreeNodesModel><Action ID="Plan"><input_port name="to" type="std::string"/>
<output_port name="path" type="std::string"/></Action></TreeNodesModel></root>"""


def navigation(folder: Path) -> Path:
    for name, text in {"trees/go.xml": NAVIGATE, "parts/drive.xml": DRIVE, "parts/more/follow.xml": FOLLOW}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    (folder / "models.xml").write_text(MODELS)
    (folder / "package.xml").write_text("<package><name>nav</name></package>")
    return folder


def test_a_folder_comes_in_whole_with_includes_models_and_control_nodes_of_others(tmp_path: Path) -> None:
    source, lab = navigation(tmp_path / "ws" / "nav"), tmp_path / "lab"
    assert main(["import", str(source), "--from", "btcpp", "-o", str(lab / "tasks")]) == 0
    assert [path.name for path in (lab / "tasks").glob("*.yaml")] == ["Go.yaml"]
    task = (lab / "tasks/Go.yaml").read_text()
    assert "nav2/RecoveryNode, with: {number_of_retries: 2}" in task
    assert "outputs:\n  path: {type: str}" in (lab / "tasks/nodes/btcpp/Plan/manifest.yaml").read_text()
    assert "grip.Control" in (lab / "tasks/nodes/btcpp/Throttled/leaf.py").read_text()
    assert main(["check", str(lab / "tasks/Go.yaml")]) == 0


def test_trees_of_one_name_are_told_apart_by_their_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tree = '<root BTCPP_format="4"><BehaviorTree ID="{}"><AlwaysSuccess/></BehaviorTree></root>'
    for place, name in (("a/go", "MainTree"), ("a/wait", "MainTree"), ("b/go", "MainTree"), ("c/go", "go")):
        (tmp_path / "in" / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "in" / f"{place}.xml").write_text(tree.format(name))
    assert main(["import", str(tmp_path / "in"), "--from", "btcpp"]) == 1
    assert "several tasks were imported (a_go, wait, b_go, go); name a folder" in capsys.readouterr().err
    assert main(["import", str(tmp_path / "in"), "--from", "btcpp", "-o", str(tmp_path / "out")]) == 0
    assert sorted(path.stem for path in (tmp_path / "out").glob("*.yaml")) == ["a_go", "b_go", "go", "wait"]
    assert "name: MainTree" in (tmp_path / "out/wait.yaml").read_text()  # an export has it again


def test_one_file_finds_the_trees_of_its_package(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = navigation(tmp_path / "ws" / "nav")
    assert main(["import", str(source / "trees/go.xml"), "--from", "btcpp", "--report"]) == 0
    assert "<BehaviorTree> 'Follow': was found in" in capsys.readouterr().out


def test_another_document_of_a_project_widens_the_manifests_of_the_first(tmp_path: Path) -> None:
    for name, ports in (("one", 'speed="1"'), ("two", 'goal="{g}" speed="{s}"')):
        (tmp_path / f"{name}.xml").write_text(
            f'<root BTCPP_format="4"><BehaviorTree ID="{name}"><MoveTo {ports}/></BehaviorTree></root>'
        )
        assert (
            main(["import", str(tmp_path / f"{name}.xml"), "--from", "btcpp", "-o", str(tmp_path / f"{name}.yaml")])
            == 0
        )
    manifest = (tmp_path / "nodes/btcpp/MoveTo/manifest.yaml").read_text()
    assert "  speed: {type: str | None, default: null}" in manifest
    assert "  goal: {type: Any, required: false}" in manifest
    assert [main(["check", str(tmp_path / f"{name}.yaml")]) for name in ("one", "two")] == [0, 0]
