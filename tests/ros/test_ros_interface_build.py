"""Interface packages are built with gcc alone, and are what a ROS installation would have built."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from importlib import import_module
from unittest import mock

import pytest
from ros_bench import EXAMPLE
from test_ros_interface_definitions import make_package

from grip_bt.ros.command import child_environment
from grip_bt.ros.interfaces import build_interfaces
from grip_bt.ros.interfaces.compiler import InterfaceBuildError, _compile
from grip_bt.ros.interfaces.generate import Generated, generate
from grip_bt.ros.interfaces.packages import OverlayError, Package, activate, read_package, search_path, share_folder

USE = """
import sys
from grip_bt.ros.interfaces.packages import activate
for prefix in sys.argv[1:]:
    activate(prefix)
from upper_pkg.action import Move
from upper_pkg.msg import Move as Moved, Pair
from upper_pkg.srv import Pair as PairService
assert PairService.Request(input=Pair(home=2)).input.home == Moved(pair=Pair(home=2)).pair.home == 2
from lower_pkg.msg import Item
pair = Pair(items=[Item(weight=2.5, tags=["a"])], home=Pair.HOME)
goal = Move.Goal(input=pair)
assert (goal.input.items[0].weight, goal.input.home, Item().count) == (2.5, 4, 7)
from rclpy.serialization import deserialize_message, serialize_message
assert deserialize_message(serialize_message(pair), Pair) == pair
"""


def test_a_build_is_found_in_the_cache_the_second_time(antipodal, interface_cache):
    begun = []
    (again,) = build_interfaces(EXAMPLE / "interfaces", interface_cache, begun=begun.append)
    assert again.cached
    assert begun == []
    assert again.prefix == antipodal


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the parser
def test_each_file_is_parsed_once_for_all_generators(tmp_path):
    parser = import_module("rosidl_parser.parser")
    home = make_package(tmp_path, "words", {"msg/Word.msg": "string text\n", "srv/Say.srv": "Word word\n---\n"})
    with mock.patch.object(parser, "get_ast_from_idl_string", wraps=parser.get_ast_from_idl_string) as parsed:
        generated = generate(read_package(home), tmp_path / "build", search_path())
    assert len(parsed.mock_calls) == 2
    assert generated.sources("rosidl_generator_py")
    assert generated.sources("rosidl_typesupport_fastrtps_c")


def test_a_built_package_is_usable_at_once(antipodal):
    from antipodal_interfaces.srv import ProposeGrasps

    assert ProposeGrasps.Response().outcome == 0
    with pytest.raises(AssertionError):
        ProposeGrasps.Response(outcome=0.5)


@pytest.mark.slow
def test_type_hashes_are_those_of_a_ros_installation(tmp_path):
    installed = share_folder("std_srvs", search_path())
    home = make_package(tmp_path, "std_srvs", {})
    for file in installed.glob("srv/*.srv"):
        (home / "srv").mkdir(exist_ok=True)
        shutil.copy(file, home / "srv" / file.name)
    (built,) = build_interfaces(home, tmp_path / "cache")
    assert not list((tmp_path / "cache").glob(".*")), "nothing is left behind"
    for file in installed.glob("srv/*.json"):
        ours = json.loads((built.prefix / "share" / "std_srvs" / "srv" / file.name).read_text())
        assert ours["type_hashes"] == json.loads(file.read_text())["type_hashes"]


@pytest.mark.slow
def test_what_a_killed_build_left_is_gone_after_the_next_one(tmp_path):
    home = make_package(tmp_path, "words", {"msg/Word.msg": "string text\n"})
    (built,) = build_interfaces(home, tmp_path / "cache")
    left = built.prefix.rename(built.prefix.with_name(f".{built.prefix.name}-killed"))
    assert not build_interfaces(home, tmp_path / "cache")[0].cached
    assert not left.exists()


@pytest.mark.slow
def test_packages_may_nest_each_other_and_a_child_process_may_import_them(tmp_path):
    make_package(
        tmp_path / "src",
        "upper_pkg",
        {
            "msg/Pair.msg": "int8 HOME=4\nlower_pkg/Item[] items\nint8 home\n",
            "action/Move.action": "Pair input\n---\nint32 outcome\nPair returned_object\n---\nfloat32 progress\n",
            "srv/Pair.srv": "Pair input\n---\nint32 outcome\n",
            "msg/Move.msg": "Pair pair\n",
        },
        ("lower_pkg",),
    )
    make_package(tmp_path / "src", "lower_pkg", {"msg/Item.msg": "float64 weight\nstring[<=3] tags\nint32 count 7\n"})
    built = build_interfaces(tmp_path / "src", tmp_path / "cache")
    assert [b.package for b in built] == ["lower_pkg", "upper_pkg"]
    prefixes = [b.prefix for b in built]
    activated = [sys.executable, "-c", USE, *map(str, prefixes)]
    by_environment = [sys.executable, "-c", USE]
    for command, env in ((activated, None), (by_environment, child_environment(prefixes))):
        done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_what_an_overlay_changes_is_built_anew(tmp_path):
    upper = make_package(tmp_path / "upper", "upper_pkg", {"msg/Pair.msg": "lower_pkg/Item item\n"}, ("lower_pkg",))
    lower = make_package(tmp_path / "lower", "lower_pkg", {"msg/Item.msg": "float64 weight\n"})
    overlay, prefixes, begun = tmp_path / "overlay", [], []
    for text in ("float64 weight\n", "float64 weight\nint32 count\n"):
        (lower / "msg" / "Item.msg").write_text(text)
        shutil.rmtree(overlay, ignore_errors=True)
        shutil.copytree(build_interfaces(lower, tmp_path / "cache")[0].prefix, overlay)
        prefixes.append(build_interfaces(upper, tmp_path / "cache", [overlay], begun.append)[0].prefix)
    assert prefixes[0] != prefixes[1]
    assert begun == ["upper_pkg", "upper_pkg"]


def test_sources_that_cannot_stand_together_are_compiled_one_by_one(tmp_path):
    sources = [tmp_path / f"{name}.c" for name in "ab"]
    for source in sources:
        source.write_text(f"static int same(void) {{ return 1; }}\nint {source.stem}(void) {{ return same(); }}\n")
    generated = Generated(Package("pkg", tmp_path, (), frozenset()), tmp_path, (), {})
    assert len(_compile(generated, "lib", sources, [])) == 2
    sources[1].write_text("int b(void) { return 2; }\n")
    assert len(_compile(generated, "lib", sources, [])) == 1
    sources[1].write_text("int b(void) { return nothing; }\n")
    with pytest.raises(InterfaceBuildError, match="nothing"):
        _compile(generated, "lib", sources, [])


def test_a_folder_that_is_no_prefix_is_refused(tmp_path):
    with pytest.raises(OverlayError, match="isn't a ROS prefix"):
        activate(tmp_path)


def test_a_prefix_of_another_python_is_refused(tmp_path):
    (tmp_path / "share" / "ament_index").mkdir(parents=True)
    (tmp_path / "lib" / "python3.8" / "site-packages" / "my_pkg").mkdir(parents=True)
    with pytest.raises(OverlayError, match="another Python"):
        activate(tmp_path)


def test_a_library_that_does_not_load_is_named(tmp_path):
    (tmp_path / "share" / "ament_index").mkdir(parents=True)
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "libx__rosidl_generator_c.so").write_bytes(b"no library")
    path = sys.path.copy()
    with pytest.raises(OverlayError, match="don't load.*libx__rosidl"):
        activate(tmp_path)
    assert sys.path == path
