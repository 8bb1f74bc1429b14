"""Interfaces built here are those of a real Jazzy: the same type hashes, from the files of the wheels and from ours."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import pytest

from grip_bt.base.errors import MissingPartError, UnknownNameError
from grip_bt.ros.interfaces import InterfaceBuildError, build_interfaces, read_package
from grip_bt.ros.interfaces.build import DEPENDENCIES, FOLDER, ensure_package
from grip_bt.ros.interfaces.compiler import compilers
from grip_bt.ros.interfaces.generate import hash_types
from grip_bt.ros.interfaces.packages import search_path

DOCUMENTED = {
    "tf2_msgs/msg/TFMessage": "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    "object_recognition_msgs/msg/ObjectType": "RIHS01_5eb3ee3976403366d7c50d7dbee8bec96b3bced1e752674a7194a35841632134",
    "octomap_msgs/msg/OctomapWithPose": "RIHS01_e65f8760aa96a2acef86b6d206175cfc78420082b6159dd3fa6ebf93f5f81979",
    "moveit_msgs/msg/CollisionObject": "RIHS01_74b0acd6d56be032bf4f764b2c2633f50588b5fb2bd71e97206c59052747cf7e",
    "moveit_msgs/msg/Constraints": "RIHS01_71718200459ae8fecdc4f2c9631215f7eba5ff686c701a32e231ba8b11b3592b",
    "moveit_msgs/msg/GenericTrajectory": "RIHS01_b38b4942aba82576ec047a9278c47785022ce66ca86d91827aba06cdc97793c6",
    "moveit_msgs/msg/MotionPlanRequest": "RIHS01_f82ed20da5f8f93146999c1a3cfe34b56b97fc10333b40cac69782a1210888d7",
    "moveit_msgs/msg/MoveItErrorCodes": "RIHS01_dcda8a9950cf6dd6ac221c2c0d2509f52f136afa0403dd19beacdf07e83e4a07",
    "moveit_msgs/msg/PlanningScene": "RIHS01_0f58540ad5eab4b9ea827d53b763c793d8cabd202b3b301fcee25afa4ce1bd80",
    "moveit_msgs/msg/RobotState": "RIHS01_7c516dc15713e545cb2836c5ca745fbdcfcc10de4855a41c83e6b4bf1afc3f83",
    "moveit_msgs/msg/RobotTrajectory": "RIHS01_af1dc87fb94d13e5f233e9c210d2662fa06143a8b3c6aec47c57ad45074fcce8",
}
"""Hashes that others have published of Jazzy's types."""


def hashes(folder: Path) -> dict[str, str]:
    """Return the hash of every type that the .json files below a folder tell of."""
    found = {}
    for file in folder.rglob("*.json"):
        for entry in json.loads(file.read_text()).get("type_hashes", []):
            found[entry["type_name"]] = entry["hash_string"]
    return found


@pytest.mark.parametrize("name", ["std_srvs", "geometry_msgs", "sensor_msgs"])
def test_definitions_of_the_wheels_get_the_hashes_that_the_wheels_have(tmp_path, name):
    share = Path(sys.prefix) / "share" / name
    generated = hash_types(read_package(share), tmp_path, search_path())
    ours, theirs = hashes(tmp_path / "hash"), hashes(share)
    assert len(theirs) >= len(generated.package.files)
    assert {t: ours[t] for t in theirs} == theirs


def hashed_here(name: str, folder: Path, share: Path) -> dict[str, str]:
    """Return the hashes of a package of ours, after laying what it needs of ours out as an installed prefix."""
    for needed in DEPENDENCIES[name]:
        hashed_here(needed, folder, share)
    hash_types(read_package(FOLDER / name), folder / name, [share.parent, *search_path()])
    for kind in ("idl", "hash"):
        shutil.copytree(folder / name / kind / name, share / name, dirs_exist_ok=True)
    return hashes(folder / name / "hash")


@pytest.mark.parametrize("name", [n for n in DEPENDENCIES if n not in ("grip_msgs",)])
def test_a_package_that_is_written_here_can_be_generated_and_has_the_documented_hashes(tmp_path, name):
    package = read_package(FOLDER / name)
    ours = hashed_here(name, tmp_path, tmp_path / "prefix" / "share")
    assert {f"{package.name}/{f.parent.name}/{f.stem}" for f in package.files} <= set(ours)
    documented = {t: h for t, h in DOCUMENTED.items() if t in ours or t.startswith(f"{name}/")}
    assert {t: ours.get(t) for t in documented} == documented


def test_a_definition_that_is_not_here_is_named():
    with pytest.raises(UnknownNameError, match="did you mean 'control_msgs'"):
        ensure_package("control_msg")


def test_what_is_installed_is_taken_as_it_is(monkeypatch):
    monkeypatch.setitem(DEPENDENCIES, "std_msgs", ())
    assert ensure_package("std_msgs") == []


@pytest.fixture
def package(tmp_path) -> Path:
    """Return a package of every kind of field."""
    folder = tmp_path / "kinds_interfaces"
    shutil.copytree(FOLDER / "tf2_msgs", folder)
    text = (folder / "package.xml").read_text().replace("tf2_msgs", "kinds_interfaces")
    (folder / "package.xml").write_text(text)
    shutil.rmtree(folder / "msg")
    for kind in ("msg", "srv", "action"):
        (folder / kind).mkdir()
    (folder / "msg" / "Inner.msg").write_text("float64 x 1.5\nstring<=8 label 'none'\nint32[3] three [1, 2, 3]\n")
    (folder / "msg" / "Outer.msg").write_text(
        "uint8 RED=1\nstring NAME='cell'\nInner inner\nInner[] many\nInner[<=2] few\nInner[2] pair\n"
        "geometry_msgs/Pose pose\nuint8[<=4] short_bytes\nwstring wide\nbool flag true\nstring[<=2] words\n"
    )
    (folder / "srv" / "Ask.srv").write_text("Outer question\n---\nint8 outcome\nOuter[] returned_object\n")
    (folder / "action" / "Do.action").write_text("Outer goal\n---\nint32 OK=0\nint32 code\n---\nInner progress\n")
    return folder


@pytest.mark.slow
def test_nested_bounded_fixed_defaulted_and_constant_fields_are_as_ros_has_them(package, tmp_path):
    from grip_bt.ros.interfaces.packages import activate

    (built,) = build_interfaces(package, tmp_path / "cache")
    activate(built.prefix)
    from kinds_interfaces.action import Do
    from kinds_interfaces.msg import Inner, Outer
    from kinds_interfaces.srv import Ask

    made = Outer()
    assert (Outer.RED, Outer.NAME, Do.Result.OK) == (1, "cell", 0)
    assert (made.inner.x, made.inner.label, list(made.inner.three), made.flag) == (1.5, "none", [1, 2, 3], True)
    assert (len(made.pair), len(made.many), made.pair[1].x) == (2, 0, 1.5)
    assert type(Ask.Response().returned_object) is list
    assert isinstance(Do.Feedback().progress, Inner)
    for field, value in (
        ("few", [Inner()] * 3),
        ("pair", [Inner()]),
        ("short_bytes", b"12345"),
        ("words", ["a", "b", "c"]),
    ):
        with pytest.raises(AssertionError, match=field):
            setattr(made, field, value)
    with pytest.raises(AssertionError, match="label"):
        made.inner.label = "longer than 8"
    (again,) = build_interfaces(package, tmp_path / "cache")
    assert again.cached


def test_without_a_compiler_it_says_how_to_get_one(package, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no-such-gcc")
    with pytest.raises(MissingPartError, match="the compiler 'no-such-gcc' isn't available here.*apt install"):
        build_interfaces(package, tmp_path / "cache")
    assert not list((tmp_path / "cache").glob("kinds_interfaces-*/share"))


def test_a_compiler_that_fails_is_quoted(package, tmp_path, monkeypatch):
    for part in ("srv", "action", "msg/Outer.msg"):
        path = package / part
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    broken = tmp_path / "cc"
    broken.write_text("#!/bin/sh\necho 'error: no space left' >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    with pytest.raises(InterfaceBuildError, match="kinds_interfaces: cc failed:\nerror: no space left"):
        build_interfaces(package, tmp_path / "cache")
    assert compilers()[0] == str(broken)


@pytest.mark.slow
def test_a_colcon_workspace_is_used_as_it_is(package, tmp_path):
    """A built prefix laid out as colcon isolates packages: install/<package>/."""
    from grip_bt.ros.interfaces.packages import activate, child_paths, package_prefixes

    shutil.move(package, package.with_name("colcon_interfaces"))
    folder = package.with_name("colcon_interfaces")
    (folder / "package.xml").write_text((folder / "package.xml").read_text().replace("kinds_", "colcon_"))
    shutil.rmtree(folder / "action")
    shutil.rmtree(folder / "srv")
    (built,) = build_interfaces(folder, tmp_path / "cache")
    install = tmp_path / "ws" / "install"
    install.mkdir(parents=True)
    shutil.copytree(built.prefix, install / "colcon_interfaces")
    assert package_prefixes(install) == [install / "colcon_interfaces"]
    activate(install)
    from colcon_interfaces.msg import Outer

    assert Path(sys.modules[Outer.__module__].__file__).is_relative_to(install)
    assert child_paths([install])["LD_LIBRARY_PATH"] == [install / "colcon_interfaces" / "lib"]


def test_an_action_gets_the_hash_that_ros_prints_of_it(tmp_path):
    (tmp_path / "action").mkdir()
    (tmp_path / "package.xml").write_text("<package><name>turtlesim_msgs</name></package>")
    (tmp_path / "action" / "RotateAbsolute.action").write_text(
        "# The heading [rad]\nfloat32 theta\n---\nfloat32 delta\n---\nfloat32 remaining\n"
    )
    hash_types(read_package(tmp_path), tmp_path / "out", search_path())
    published = "RIHS01_bef10993e1ee82b35f99f7e390bac1e6cc64e2a3090536887832e122aa71f1b5"
    assert hashes(tmp_path / "out")["turtlesim_msgs/action/RotateAbsolute_FeedbackMessage"] == published
