import re

import pytest
from robot_files import SRDF, urdf

from grip_bt.base.errors import InvalidRobotError
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.load import inspect_robot, load_robot

LIMIT = '<limit lower="-2.8" upper="2.8" velocity="2.0" effort="80"/>'
J1 = f'<axis xyz="0 0 1"/>{LIMIT}'
MASS = '<mass value="1"/>'
INERTIA = 'ixx="0.01"'
URDF_FAULTS = [
    (('name="l2"', 'name="l1"'), "double-name", "two links are called 'l1'"),
    (('name="j2"', 'name="j1"'), "double-name", "two joints are called 'j1'"),
    (('type="prismatic"', 'type="slides"'), "joint-type", "unknown type 'slides'.*prismatic"),
    (('<parent link="l2"/>', '<parent link="l22"/>'), "unknown-link", "parent of joint 'j3' is link 'l22'.*'l2'"),
    (('<child link="l2"/>', ""), "unknown-link", "child of joint 'j2' is no link"),
    ((J1, J1.replace("2.8", "nan")), "bad-number", "lower='-nan' of <limit> has to be a finite number"),
    (('xyz="0 0 0.2"', 'xyz="0 0 NaN"'), "bad-number", "xyz='0 0 NaN' of <origin> has to be 3 finite numbers"),
    (('joint="slide_left"', 'joint="slide_right"'), "cycle", "mimics itself through a chain"),
    (
        ('<parent link="base"/>', '<parent link="l6"/>'),
        "cycle",
        "in a loop: l1 -> l2 -> l3 -> l4 -> l5 -> l6 -> l1",
    ),
    (('<child link="l5"/>', '<child link="l4"/>'), "two-parents", "link 'l4' has two parent joints"),
    (('<child link="l5"/>', '<child link="l4"/>'), "two-roots", "these links have no parent: base, l5"),
]


SHAPE = '<cylinder radius="0.06" length="0.1"/>'
MENDED = [
    (
        J1,
        '<axis xyz="0 0 1"/>',
        "missing-limit",
        r"no <limit>; -3.142 ... 3.142 rad are taken; add .*\[rad\]",
        'lower="-3.14',
    ),
    (
        J1,
        '<limit velocity="1"/>',
        "missing-limit",
        "it lacks lower and upper .*; it is held still",
        'name="j1" type="fixed"',
    ),
    (
        J1,
        '<limit lower="1" upper="-1"/>',
        "missing-limit",
        "lower 1 isn't below .*they are swapped",
        'lower="-1.0" upper="1.0"',
    ),
    (
        J1,
        J1.replace("0 0 1", "0 0 0"),
        "zero-axis",
        "axis of joint 'j1' is 0 0 0; it is held",
        'name="j1" type="fixed"',
    ),
    (
        MASS,
        '<mass value="-1"/>',
        "no-mass",
        "'base' has a mass of -1 kg; its <inertial> is left out",
        'name="base"><collision',
    ),
    (MASS, "", "no-mass", "<inertial> of link 'base' has no <mass>; it is left out", 'name="base"><collision'),
    (SHAPE, "<cone/>", "bad-shape", "has <cone>, none of: box.*; it is left out", "</inertial></link>"),
    (
        SHAPE,
        SHAPE.replace("0.06", "0"),
        "bad-shape",
        "radius of a cylinder of link 'base' is '0'; it is",
        "</inertial></link>",
    ),
    (
        'joint="slide_left"',
        'joint="slide_lefd"',
        "unknown-joint",
        "mimics 'slide_lefd'.*'slide_left'.* leads itself",
        "</joint>",
    ),
    (
        'joint="slide_left"',
        'joint="wrist_to_palm"',
        "fixed-leader",
        "which never moves; it is held",
        'slide_right" type="fixed"',
    ),
]
"""What vendors ship -> what it is called, what is said, and what becomes of it."""


def inspected(folder, text=None, srdf=SRDF, **more):
    (folder / "r.urdf").write_text(urdf() if text is None else text)
    (folder / "r.srdf").write_text(srdf)
    return inspect_robot(RobotConfig(urdf="r.urdf", srdf="r.srdf", **more), folder)


@pytest.mark.parametrize(("change", "code", "says"), URDF_FAULTS)
def test_every_fault_of_a_urdf_is_told_with_its_place(tmp_path, change, code, says):
    text = urdf().replace(change[0], change[1])
    assert text != urdf()
    found = inspected(tmp_path, text)
    assert found.description is None
    mine = [f for f in found.findings if f.code == code and f.severity == "error"]
    assert mine
    assert any(re.search(says, f.message) for f in mine), mine
    assert all(f.source.endswith("r.urdf") and f.line is not None for f in mine)


@pytest.mark.parametrize(("old", "new", "code", "says", "becomes"), MENDED)
def test_what_vendors_ship_is_put_right_by_a_rule_and_told(tmp_path, old, new, code, says, becomes):
    found = inspected(tmp_path, urdf().replace(old, new, 1))
    (told,) = [f for f in found.findings if f.code == code]
    assert told.severity == "warning"
    assert re.search(says, told.message)
    assert told.line is not None
    assert becomes in found.description.urdf


@pytest.mark.parametrize("velocity", ["", ' velocity="0"'])
def test_a_joint_without_a_velocity_limit_gets_one_and_it_is_told(tmp_path, velocity):
    found = inspected(tmp_path, urdf().replace(J1, f'<limit lower="-1" upper="1"{velocity}/>'))
    (told,) = [f for f in found.findings if f.code == "no-speed"]
    assert "'j1' has no velocity limit above zero; 1 rad/s is taken" in told.message
    assert 'velocity="1.0"' in found.description.urdf


@pytest.mark.parametrize("value", ["0", "-0.01"])
def test_a_link_without_inertia_gets_that_of_a_small_ball_and_it_is_told(tmp_path, value):
    text = re.sub(r'i(xx|yy|zz)="[^"]*"', lambda found: f'i{found[1]}="{value}"', urdf(), count=3)
    found = inspected(tmp_path, text)
    (told,) = [f for f in found.findings if f.code == "no-inertia"]
    assert "those of a ball of its mass with a radius of 0.02 m are taken" in told.message
    assert f'ixx="{0.4 * 1 * 0.02**2!r}"' in found.description.urdf


@pytest.mark.parametrize(("effort", "weak"), [(0.5, True), (80, False)])
def test_efforts_that_cannot_move_the_robot_are_replaced_in_simulation_and_told(tmp_path, effort, weak):
    text = urdf().replace('effort="80"', f'effort="{effort}"', 2)  # j1 and j2, which carry all the others
    found = inspected(tmp_path, text)
    told = [f.message for f in found.findings if f.code == "no-effort"]
    assert bool(told) == weak
    assert [found.description.drives[j].limit for j in ("j1", "j2", "j3")] == ([1000, 1000, 80] if weak else [80] * 3)
    if weak:
        assert "the efforts of joints j1, j2 can't accelerate what they carry" in told[0]
    kept = inspected(tmp_path, text, drives={"manipulator": {"stiffness": 9, "damping": 1, "limit": effort / 2}})
    assert kept.description.drives["j1"].limit == effort / 2


def test_moments_of_inertia_that_a_tool_has_filled_in_ask_for_more_effort_too(tmp_path):
    for moment, told in [("0.01", False), ("1", True)]:
        text = urdf().replace('effort="80"', 'effort="40"').replace('"0.01"', f'"{moment}"')
        findings = inspected(tmp_path, text).findings
        assert any("can't accelerate what they carry" in f.message for f in findings) == told


def test_an_end_effector_of_a_group_that_is_not_there_is_left_out_and_told(tmp_path):
    ghost = '<end_effector name="ghost" parent_link="l6" group="nothing"/></robot>'
    found = inspected(tmp_path, srdf=SRDF.replace("</robot>", ghost))
    (told,) = [f for f in found.findings if f.code == "unknown-group"]
    assert "'ghost': there is no group 'nothing'; it is left out" in told.message
    assert "ghost" not in [end.name for end in found.description.end_effectors]


def test_all_faults_are_told_at_once_each_on_its_line(tmp_path):
    text = urdf().replace(J1, "").replace(MASS, '<mass value="-1"/>').replace('name="l2"', 'name="l1"')
    found = inspected(tmp_path, text)
    codes = {f.code for f in found.findings}
    assert {"missing-limit", "no-mass", "double-name", "unknown-link"} <= codes
    lines = text.splitlines()
    (missing,) = [f for f in found.findings if f.code == "missing-limit"]
    assert 'name="j1"' in lines[missing.line - 1]


@pytest.mark.parametrize(
    ("old", "new", "code", "says"),
    [
        ('tip_link="l6"', 'tip_link="l66"', "unknown-link", "group 'manipulator'.*there is no link 'l66'.*'l6'"),
        (
            'base_link="base" tip_link="l6"',
            'base_link="l6" tip_link="base"',
            "no-chain",
            "'l6' doesn't carry link 'base'",
        ),
        (
            '<joint name="slide_left"/>',
            '<joint name="slyde"/>',
            "unknown-joint",
            "group 'gripper': there is no joint 'slyde'",
        ),
        (
            '<group name="gripper"/>',
            '<group name="griper"/>',
            "unknown-group",
            "no group 'griper'; did you mean 'gripper'",
        ),
        ('<group name="gripper"/>', '<group name="all"/>', "cycle", "group 'all' contains itself"),
        ('parent_link="l6"', 'parent_link="l7"', "unknown-link", "end effector 'hand': there is no link 'l7'"),
        (
            'name="j5" value="1.2"',
            'name="j9" value="1.2"',
            "unknown-joint",
            "state 'home' of group 'manipulator'.*'j9'",
        ),
        ('group="manipulator">', 'group="arm">', "unknown-group", "named states: there is no group 'arm'"),
        ('<group name="all">', '<group name="gripper">', "double-name", "two groups are called 'gripper'; the first"),
    ],
)
def test_what_an_srdf_names_that_is_not_there_is_left_out_and_told(tmp_path, old, new, code, says):
    assert old in SRDF
    found = inspected(tmp_path, srdf=SRDF.replace(old, new))
    assert any(f.code == code and re.search(says, f.message) for f in found.findings), found.findings
    assert {f.severity for f in found.findings} == {"warning"}
    assert "manipulator" in found.description.groups


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('value="1.2"', 'value="nan"', "value='nan' of <joint> has to be a finite number"),
        ("</robot>", "", "isn't well-formed XML: no element found"),
        ("<robot name", "<robo name", "mismatched tag"),
    ],
)
def test_an_srdf_that_cannot_be_read_is_an_error(tmp_path, old, new, says):
    found = inspected(tmp_path, srdf=SRDF.replace(old, new))
    assert found.description is None
    assert any(f.code == "bad-file" and re.search(says, f.message) for f in found.findings), found.findings


def test_what_can_be_lived_with_is_a_warning_and_the_robot_is_there(tmp_path):
    srdf = SRDF.replace('link2="l3"', 'link2="l33"').replace('value="1.2"', 'value="9"')
    found = inspected(tmp_path, urdf().replace(MASS, '<mass value="0"/>'), srdf)
    assert {f.severity for f in found.findings} == {"warning"}
    assert {f.code for f in found.findings} == {"no-mass", "unknown-link", "out-of-limits"}
    assert found.description.named_state("manipulator", "home").as_mapping()["j5"] == 2.8


@pytest.mark.parametrize(
    ("mesh", "code", "says"),
    [
        ("meshes/arm.stl", "missing-mesh", r"link 'base': there is no mesh 'meshes/arm.stl' \(looked for /"),
        ("package://nowhere/arm.stl", "missing-package", "package 'nowhere' isn't available"),
        ("meshes/arm.step", "mesh-format", "isn't one of: .dae, .obj, .ply, .stl"),
        ("pointer.stl", "missing-mesh", "wasn't downloaded: .* is a pointer of Git LFS, or empty"),
    ],
)
@pytest.mark.parametrize("seen", [False, True])
def test_the_mesh_that_is_seen_takes_the_place_of_one_that_is_missing(tmp_path, mesh, code, says, seen):
    (tmp_path / "pointer.stl").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\n")
    (tmp_path / "seen.stl").write_text("solid s\nendsolid s\n")
    visual = '<visual><geometry><mesh filename="seen.stl"/></geometry></visual></link>' if seen else "</link>"
    found = inspected(tmp_path, urdf(mesh=mesh).replace("</link>", visual, 1))
    (told,) = found.findings
    assert (told.severity, told.code) == ("warning", code)
    assert re.search(says, told.message)
    assert ("the mesh that is seen is taken" if seen else "left out, and nothing keeps clear of it") in told.message
    assert ("<collision><geometry><mesh" in found.description.urdf) == seen


def test_a_mesh_that_is_only_seen_may_be_missing(tmp_path):
    visual = '<visual><geometry><mesh filename="nowhere.stl"/></geometry></visual>'
    found = inspected(tmp_path, urdf().replace('<link name="l1">', f'<link name="l1">{visual}'))
    assert [(f.severity, f.code) for f in found.findings] == [("warning", "missing-mesh")]
    assert "nowhere.stl" not in found.description.urdf


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "isn't well-formed XML: no element found"),
        ('<robot name="r"/>', "the robot has no links"),
        ("<robot", "unclosed token"),
        ("<model/>", "outermost element has to be <robot>, not <model>"),
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot/>', "declares an entity"),
        ("<robot>" + "<a>" * 300, "nested more than 200 deep"),
        ('<?xml version="1.0" encoding="nonsense"?><robot/>', "isn't well-formed XML: unknown encoding"),
    ],
)
def test_what_is_no_urdf_at_all_is_told_too(tmp_path, text, says):
    (finding,) = [f for f in inspected(tmp_path, text).findings if f.severity == "error"]
    assert says in finding.message


def test_loading_a_wrong_robot_raises_all_of_its_errors(tmp_path):
    (tmp_path / "r.urdf").write_text(urdf().replace('name="l2"', 'name="l1"').replace('"prismatic"', '"slides"'))
    with pytest.raises(InvalidRobotError, match=r"(?s)can't be used.*joint-type.*") as error:
        load_robot("r.urdf", tmp_path)
    assert len(error.value.findings) > 2


def test_a_chain_of_a_thousand_links_is_refused_not_recursed_into(tmp_path):
    links = "".join(f'<link name="k{k}"/>' for k in range(1001))
    joints = "".join(
        f'<joint name="f{k}" type="fixed"><parent link="k{k}"/><child link="k{k + 1}"/></joint>' for k in range(1000)
    )
    found = inspected(tmp_path, f'<robot name="long">{links}{joints}</robot>', '<robot name="long"/>')
    assert any(f.code == "cycle" and "more than 500 joints deep" in f.message for f in found.findings)


def test_an_xml_file_is_what_its_outermost_element_says(tmp_path):
    (tmp_path / "r.xml").write_text(urdf())
    found = inspect_robot("r.xml", tmp_path)
    assert not [f for f in found.findings if f.severity == "error"]
    (tmp_path / "r.xml").write_text("<mujoco/>")
    assert any("has to be <robot>, not <mujoco>" in f.message for f in inspect_robot("r.xml", tmp_path).findings)
