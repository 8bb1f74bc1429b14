"""Mistakes of component files, as people make them: each is told with what is there and what to write."""

from __future__ import annotations

import pytest

from grip_bt.base.errors import ContractError, DocumentError
from grip_bt.codegen import check_contract
from grip_bt.task.catalog.component_file import ComponentFile, load_component
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec

REQUEST = (
    FieldSpec("input", "sensor_msgs/msg/PointCloud2"),
    FieldSpec("width_mm", "int32"),
    FieldSpec("height", "float64"),
    FieldSpec("label", "string"),
    FieldSpec("numbers", "float64", array=True),
    FieldSpec("goal", "my_pkg/msg/Goal"),
    FieldSpec("depth", "sensor_msgs/msg/Image"),
)
RESPONSE = (
    FieldSpec("outcome", "int32"),
    FieldSpec("returned_object", "geometry_msgs/msg/PoseStamped"),
    FieldSpec("count", "uint8"),
    FieldSpec("score", "float32"),
    FieldSpec("all", "geometry_msgs/msg/PoseStamped", array=True),
    FieldSpec("seen", "sensor_msgs/msg/Image"),
)
INTERFACE = InterfaceSpec("my_pkg", "srv", "Do", REQUEST, RESPONSE)
INSIDE = {
    "my_pkg/msg/Goal": (FieldSpec("pose", "geometry_msgs/msg/Pose"), FieldSpec("speed", "float64")),
    "geometry_msgs/msg/Pose": (
        FieldSpec("position", "geometry_msgs/msg/Point"),
        FieldSpec("orientation", "geometry_msgs/msg/Quaternion"),
    ),
}
FILE = """\
name: counter
interface: my_pkg/srv/Do
server: /do
outcomes: [found, none]
"""


def told(ports):
    file = {"name": "c", "interface": "my_pkg/srv/Do", "server": "/do", "outcomes": ("one", "none"), "ports": ports}
    component = ComponentFile.model_validate(file)
    try:
        check_contract(component, INTERFACE, INSIDE.get)
    except ContractError as error:
        return error.problems
    return ()


@pytest.mark.parametrize(
    ("ports", "words"),
    [
        ({"input": "Image"}, "the field is sensor_msgs/PointCloud2, which can't be `Image`: write `PointCloud`"),
        ({"input": "sensor_msgs/msg/Pointcloud2"}, "which can't be `sensor_msgs/msg/Pointcloud2`: write `PointCloud`"),
        ({"input": "list[PointCloud]"}, "which can't be `list[PointCloud]`: write `PointCloud`"),
        ({"input": "float"}, None),  # a message of one field `data`, for all that is known of it
        ({"goal": "float"}, "which can't be `float`: write `my_pkg/msg/Goal`"),
        ({"all": "Pose"}, "the field is geometry_msgs/PoseStamped[], which can't be `Pose`: write `list[Pose]`"),
        ({"label": "int"}, "the field is string, which can't be `int`: write `str`"),
        ({"width_mm": "float"}, "which can't be `float`: write `int`"),
        ({"score": "int"}, "which can't be `int`: write `float`"),
        ({"seen": "DepthImage"}, "which can't be `DepthImage`: write `Image`"),
        ({"input": {"type": "PointCloud", "unit": "kg"}}, "`PointCloud` has nothing in kg; `unit` is for numbers"),
        ({"input": {"type": "PointCloud", "unit": "deg"}}, "`unit` is for numbers and JointStates"),
        ({"label": {"type": "str", "unit": "mm"}}, "`str` has nothing in mm; `unit` is for numbers and Poses and Poin"),
        ({"returned_object": {"type": "Pose", "quaternion": "wxyz"}}, "messages have x, y, z, w by name"),
        ({"height": {"type": "float", "frame": "world"}}, "`float` is in no frame; `frame` is for poses"),
        (
            {"t": {"type": "Pose", "field": "goal.pos"}},
            "'goal' has no field 'pos'; did you mean 'pose'? (it has: pose,",
        ),
        ({"t": {"type": "float", "field": "goal.pose.position.x.y"}}, None),  # nobody knows a Point here
        (
            {"t": {"type": "float", "field": "height.x"}},
            "'height' is float64, which has no fields, so 'height.x' isn't",
        ),
        ({"t": {"type": "float", "field": "numbers.x"}}, "'numbers' is float64[], which has no fields"),
        ({"t": {"type": "float", "field": "goal.pose"}}, "the field is geometry_msgs/Pose, which can't be `float`"),
    ],
)
def test_a_port_that_its_field_can_never_be_is_told_with_what_to_write(ports, words):
    problems = told(ports)
    assert (problems == ()) if words is None else (len(problems) == 1 and words in problems[0]), problems


@pytest.mark.parametrize(
    "ports",
    [
        {"input": "PointCloud", "goal": "Grasp", "depth": "DepthImage", "numbers": "list[float]", "all": "list[Pose]"},
        {"width_mm": {"type": "float", "unit": "mm"}, "numbers": {"type": "Pose", "quaternion": "wxyz", "unit": "mm"}},
        {"height": "int", "count": "float", "score": "float", "returned_object": "geometry_msgs/msg/PoseStamped"},
        {"t": {"type": "Pose", "field": "goal.pose", "frame": "base"}, "seen": "Image", "input": "Any"},
        {"t": {"type": "float", "field": "goal.speed", "unit": "cm"}, "numbers": "list", "all": "list[Any]"},
        {"numbers": {"type": "list[float]", "unit": "deg"}, "returned_object": "Pose | None"},
    ],
)
def test_ports_that_do_are_left_alone(ports):
    assert told(ports) == ()


@pytest.mark.parametrize(
    ("wrong", "right", "words"),
    [
        ("name: counter", "name: Counter", "'Counter' isn't a name: lower case letters, digits and _, a letter first"),
        ("name: counter", "name: myGrasps2", "such as my_grasps"),
        ("my_pkg/srv/Do", "my_pkg/Do", "'my_pkg/Do' isn't the name of an interface: package/srv/Name"),
        ("/do", "do", "'do' isn't a whole ROS name"),
        ("[found, none]", "found none", "outcomes: expected a list: write [found, none], not 'found none'"),
        ("[found, none]", "[found, not found]", "'not found' isn't a name: letters, digits and _, no digit first"),
        ("server: /do", "server: /do\nports: {a: {type: Pose, field: 'A.b'}}", "'A.b' isn't a path of fields"),
        ("server: /do", "server: /do\nstart: {command: python server.py}", "write [python, server.py], not"),
        ("server: /do", "server: /do\nstart: {command: '{python} a.py'}", 'write ["{python}", a.py], not'),
        (
            "server: /do",
            "server: /do\nstart: {command: [{python}, a.py]}",
            'stands in quotation marks: write "{python}"',
        ),
        ("[found, none]", "found, none", "outcomes: expected a list: write [found, none], not 'found, none'"),
        ("[found, none]", "{none: 1, found: 0}", "outcomes: they are numbered in their order: write [found, none]"),
    ],
)
def test_a_value_of_another_form_is_told_with_the_form_and_an_example(tmp_path, wrong, right, words):
    assert wrong in FILE
    (tmp_path / "component.yaml").write_text(FILE.replace(wrong, right))
    with pytest.raises(DocumentError) as caught:
        load_component(tmp_path)
    assert words in str(caught.value)
    assert str(tmp_path / "component.yaml") + ":" in str(caught.value)


def test_rules_that_would_do_are_shown_whole():
    plain = InterfaceSpec("std_srvs", "srv", "SetBool", (FieldSpec("data", "bool"),), (FieldSpec("success", "bool"),))
    component = {"name": "c", "interface": "std_srvs/srv/SetBool", "server": "/do", "outcomes": ("a", "b")}
    with pytest.raises(ContractError, match=r'`outcomes: \{done: "success", failed: "not success"\}`'):
        check_contract(ComponentFile.model_validate(component), plain)


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        (
            "count",
            "the rule of 'one', `count`, gives a int; a rule is true or false: compare it with something, such as",
        ),
        (
            "all",
            "gives a list[geometry_msgs/msg/PoseStamped]; a rule is true or false: compare it with something, such as",
        ),
        ("len(score) > 0", "outcomes: the rule of 'one', `len(score) > 0`: "),
        ("count > 0 and score > 0.5", ""),
        ("returned_object.pose.position.z > 0", ""),
    ],
)
def test_a_rule_that_is_neither_true_nor_false_is_told_before_anything_runs(rule, words):
    file = {"name": "c", "interface": "my_pkg/srv/Do", "server": "/do", "outcomes": {"one": rule}}
    component = ComponentFile.model_validate(file)
    if not words:
        check_contract(component, INTERFACE, INSIDE.get)
        return
    with pytest.raises(ContractError) as caught:
        check_contract(component, INTERFACE, INSIDE.get)
    assert words in caught.value.problems[0]
