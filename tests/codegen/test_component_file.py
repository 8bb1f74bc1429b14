"""Component files say what is wrong with them, and where."""

from __future__ import annotations

import pytest

from grip_bt.base.errors import DocumentError
from grip_bt.task.catalog.component_file import load_component

GOOD = """\
name: my_grasps
interface: my_pkg/srv/Propose
server: /propose
outcomes: [one, none]
meaning: {none: failure}
ports: {input: PointCloud, returned_object: {type: "list[Grasp]", doc: best first}}
start: {command: ["{python}", server.py], env: {FOO: bar}}
timeouts: {call: 3}
"""


def load(tmp_path, text):
    (tmp_path / "component.yaml").write_text(text)
    return load_component(tmp_path)


def test_a_good_file_is_read_with_its_defaults(tmp_path):
    component = load(tmp_path, GOOD)
    assert component.meanings() == {"one": "success", "none": "failure"}
    assert component.port_type("input", "x") == "PointCloud"
    assert component.port_type("other", "x") == "x"
    assert component.start.env == {"FOO": "bar"}
    assert (component.timeouts.call, component.timeouts.ready) == (3, 15)


def test_a_number_of_outcomes_names_them(tmp_path):
    component = load(tmp_path, GOOD.replace("[one, none]", "3").replace("meaning: {none: failure}\n", ""))
    assert component.outcomes == ("outcome_0", "outcome_1", "outcome_2")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("name: my_grasps", "name: My-Grasps", "name"),
        ("server: /propose", "server: propose", "server"),
        ("my_pkg/srv/Propose", "my_pkg/Propose", "interface"),
        ("my_pkg/srv/Propose", "my_pkg/msg/Propose", "interface"),
        ("[one, none]", "[]", "outcomes"),
        ("[one, none]", "[one, one]", "outcomes are named twice: one"),
        ("[one, none]", "[one, 'a.b']", "outcomes"),
        ("{none: failure}", "{nun: failure}", r"undeclared outcomes: nun \(available: one, none\)"),
        ("{none: failure}", "{none: maybe}", "meaning"),
        ("{call: 3}", "{call: 0}", "timeouts"),
        ("timeouts:", "timeout:", "did you mean 'timeouts'"),
        ("command:", "comand:", "did you mean 'command'"),
        ("{python}", "{python", ""),
    ],
)
def test_what_is_wrong_is_named(tmp_path, old, new, told):
    text = GOOD.replace(old, new)
    if not told:
        assert load(tmp_path, text).start.command[0] == new
        return
    with pytest.raises(DocumentError, match=told) as caught:
        load(tmp_path, text)
    assert str(caught.value).startswith(str(tmp_path / "component.yaml"))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DocumentError, match=r"component\.yaml"):
        load_component(tmp_path)
