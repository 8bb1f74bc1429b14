"""What people get wrong around components: each mistake is told with what is there and what to do."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import grip_bt.ros  # noqa: F401 - its settings come before any message package
from grip_bt.base.errors import ContractError, DocumentError
from grip_bt.cli.__main__ import main
from grip_bt.cli.component import rendered
from grip_bt.ros.component import Adapter
from grip_bt.task.catalog.component_file import ComponentFile

pytestmark = pytest.mark.ros
DATA = Path(__file__).parent / "data"
FILE = "name: work\ninterface: trial_interfaces/action/Work\nserver: /work\noutcomes: {done: 'true'}\n"


@pytest.fixture
def component(tmp_path):
    """A component's folder, with the packages that its interface is in."""
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    home = tmp_path / "components" / "work"
    shutil.copytree(DATA / "trial_interfaces", home / "interfaces" / "trial_interfaces")
    (home / "component.yaml").write_text(FILE)
    return home


def test_an_interface_that_its_own_package_lacks_is_told_with_those_that_it_has(component):
    (component / "component.yaml").write_text(FILE.replace("action/Work", "action/Wrok"))
    with pytest.raises(DocumentError) as caught:
        rendered(component)
    assert "defines no trial_interfaces/action/Wrok; did you mean 'Work'?" in str(caught.value)


def test_a_field_deep_in_an_installed_message_is_looked_up(component):
    text = "name: c\ninterface: nav_msgs/srv/GetPlan\nserver: /s\noutcomes: {a: 'true'}\n"
    text += "ports: {height: {type: float, field: goal.pose.position.z}}\n"
    (component / "component.yaml").write_text(text)
    assert "height" in rendered(component)["manifest.yaml"]
    (component / "component.yaml").write_text(text.replace("position", "positon"))
    with pytest.raises(ContractError, match=r"'goal\.pose' has no field 'positon'; did you mean 'position'\?"):
        rendered(component)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["add", "std_srvs/SetBool"], "nor a type such as 'std_srvs/srv/Trigger'"),
        (["add", "nowhere/srv/Do.srv"], "there is no such file"),
        (["add", "wrok"], "there is no such folder; did you mean 'work'? (available in {home}: work)"),
        (
            ["add", "std_srvs/srv/SetBool", "--outcomes", "done: success", "--server", "set"],
            "server: 'set' isn't a whole ROS name: words of letters, digits and _, each after a /",
        ),
        (
            ["add", "std_srvs/srv/SetBool", "--outcomes", "done: success", "--name", "SetIt"],
            "name: 'SetIt' isn't a name: lower case letters, digits and _, a letter first, such as my_grasps",
        ),
    ],
)
def test_what_cannot_be_added_is_told_with_what_can(component, monkeypatch, capsys, words, said):
    monkeypatch.chdir(component.parents[1])
    assert main(["component", *words]) == 1
    assert said.format(home=component.parent) in capsys.readouterr().err


def test_a_length_in_a_field_of_whole_numbers_is_rounded_to_the_nearest():
    from std_msgs.msg import Int16MultiArray, Int32

    def adapter(type_):
        port = {"width": {"type": type_, "field": "data", "unit": "mm"}}
        file = {"name": "c", "interface": "p/srv/S", "server": "/s", "outcomes": 1, "ports": port}
        return Adapter(ComponentFile.model_validate(file))

    assert adapter("float").pack({"width": 0.0127}, Int32).data == 13
    assert list(adapter("list[float]").pack({"width": [0.0104, 0.02]}, Int16MultiArray).data) == [10, 20]
    back = Int32(data=13)
    assert adapter("float").unpack(back, "width", "data") == pytest.approx(0.013)
