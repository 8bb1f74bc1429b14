"""`grip component` and `grip interfaces` say what they did, and what is wrong, with the right exit status."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from grip_bt.app.project.components import from_file, make_component
from grip_bt.base.errors import DocumentError
from grip_bt.cli.__main__ import main
from grip_bt.ros.components import find_components

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
    assert main(["component", "list", str(component.parents[1]), "--json"]) == 0
    (listed,) = json.loads(capsys.readouterr().out)
    assert (listed["name"], listed["up_to_date"]) == ("antipodal_grasps", True)


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
    assert "there is no component.yaml in it; `grip component new NAME` makes a component" in capsys.readouterr().err
    package = package_of(tmp_path, "my_msgs", {"srv/A.srv": "---\n", "msg/B.msg": "int32 a\n"})
    assert main(["component", "add", str(package)]) == 1
    assert "it is an interface package: give one of its files (msg/B.msg, srv/A.srv)" in capsys.readouterr().err


def test_a_component_in_a_folder_of_another_name_is_told(project, capsys, monkeypatch):
    monkeypatch.chdir(project)
    assert main(["component", "new", "mine"]) == 0
    (project / "components" / "mine").rename(project / "components" / "other")
    capsys.readouterr()
    assert main(["component", "add", "components/other"]) == 1
    said = capsys.readouterr().err
    assert "components/other: the component is called 'mine', and a run looks for it in " in said
    assert "rename the folder, or write `name: other` in component.yaml" in said
    (project / "task.yaml").write_text("grip: 1\nname: demo\nroot: {node: component/mine}\n")
    main(["check", "task.yaml"])
    assert "is called 'mine', and its folder 'other', so a run cannot find it" in capsys.readouterr().out


def test_outcomes_that_all_mean_success_are_told(project, capsys, monkeypatch):
    monkeypatch.chdir(project)
    rules = ["--outcomes", "done: success; failed: not success"]
    assert main(["component", "add", "std_srvs/srv/SetBool", *rules]) == 0
    assert "all of done, failed mean success; of one that doesn't: `meaning: {LABEL: fail" in capsys.readouterr().err
    assert main(["component", "add", "std_srvs/srv/Trigger", *rules, "--failure", "failed"]) == 0
    assert capsys.readouterr().err == ""


def test_a_type_without_its_kind_is_told_whole(project, capsys, monkeypatch):
    monkeypatch.chdir(project)
    assert main(["component", "add", "std_srvs/SetBool", "--outcomes", "done: success"]) == 1
    assert "std_srvs/SetBool: is neither a .msg, .srv or .action file nor a type such as 'std_srvs/srv/Trigger'" in (
        capsys.readouterr().err
    )


def package_of(folder: Path, name: str, files: dict[str, str], depends: str = "") -> Path:
    (folder / name).mkdir(parents=True)
    (folder / name / "package.xml").write_text(f"<package><name>{name}</name>{depends}</package>")
    for path, text in files.items():
        (folder / name / path).parent.mkdir(exist_ok=True)
        (folder / name / path).write_text(text)
    return folder / name


@pytest.fixture
def project(tmp_path):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    return tmp_path


def test_packages_beside_the_interface_that_it_needs_come_along(project, capsys):
    package_of(project / "src", "lowest_msgs", {"msg/Item.msg": "float64 weight\n"})
    package_of(project / "src", "base_msgs", {"msg/Box.msg": "lowest_msgs/Item item\n"}, "<depend>lowest_msgs</depend>")
    package_of(project / "src", "other_msgs", {"msg/Other.msg": "float64 a\n"})
    text = "base_msgs/Box input\n---\nint32 outcome\nbool returned_object\n"
    mine = package_of(project / "src", "my_msgs", {"srv/HTTPFit.srv": text}, "<depend>base_msgs</depend>")
    given = [str(mine / "srv" / "HTTPFit.srv"), "--outcomes", "fits,no", "--project", str(project)]
    assert main(["component", "add", *given]) == 0
    assert "my_msgs/srv/HTTPFit, served as /http_fit" in capsys.readouterr().out
    interfaces = project / "components" / "http_fit" / "interfaces"
    assert sorted(p.name for p in interfaces.iterdir()) == ["base_msgs", "lowest_msgs", "my_msgs"]


def test_a_component_that_does_not_fit_is_told_and_nothing_of_it_is_left(project, capsys):
    add = ["component", "add", "std_srvs/srv/Trigger", "--project", str(project), "--outcomes"]
    assert main([*add, "done: succes"]) == 1
    assert "the rule of 'done' reads 'succes'; did you mean 'success'?" in capsys.readouterr().err
    assert not (project / "components").exists()
    assert main([*add, "done: success; failed: not success"]) == 0


def test_one_broken_component_does_not_hide_the_others(project, capsys):
    add = ["component", "add", "std_srvs/srv/Trigger", "--project", str(project), "--outcomes", "done: success"]
    assert main([*add, "--name", "a_first"]) == main([*add, "--name", "last"]) == 0
    (project / "components" / "a_first" / "component.yaml").write_text("name: a_first\n")
    capsys.readouterr()
    assert main(["component", "list", str(project)]) == 1
    told = capsys.readouterr()
    assert told.out.startswith("last ")
    assert "can't be read" in told.err
    assert "the key 'interface' is missing" in told.err
    assert list(find_components(project / "components", ["last"])) == ["last"]
    with pytest.raises(DocumentError, match="'interface' is missing"):
        find_components(project / "components", ["a_first"])


def test_what_interfaces_are_not_built_from_is_not_copied(tmp_path):
    package = tmp_path / "old_msgs"
    for name, text in {
        "package.xml": "<package><name>old_msgs</name></package>",
        "srv/Find.srv": "int32 a\n---\nint64[] found\n",
        "srv/README": "",
        "data/weights.pt": "large",
        "scripts/srv/run.py": "",
    }.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text)
    home = make_component(
        from_file(package / "srv/Find.srv"), tmp_path / "components", "some: len(found) > 0; none: true"
    )
    copied = {file.relative_to(home).as_posix() for file in home.rglob("*") if file.is_file()}
    kept = {"package.xml", "srv/Find.srv", "srv/README"}
    assert copied == {"component.yaml", *(f"interfaces/old_msgs/{name}" for name in kept)}
