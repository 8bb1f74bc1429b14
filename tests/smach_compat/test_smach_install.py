"""The package in the place of `smach`: names, sub-modules, going in and out, what it may import."""

import importlib
import subprocess
import sys
from types import ModuleType, SimpleNamespace

import pytest

from grip_bt import smach_compat
from grip_bt.base.errors import GripError
from grip_bt.smach_compat import smach_ros
from grip_bt.smach_compat._settings import settings
from grip_bt.smach_compat.smach_ros._port import Ros

UPSTREAM = """
    set_loggers loginfo logwarn logerr logdebug
    InvalidTransitionError InvalidStateError InvalidConstructionError InvalidUserCodeError
    State CBState UserData Remapper Container
    is_shutdown set_shutdown_check has_smach_interface cb_interface CBInterface
    StateMachine Sequence Concurrence Iterator
    log exceptions state user_data container util state_machine sequence concurrence iterator
""".split()


@pytest.fixture
def installed():
    smach_compat.install()
    yield
    smach_compat.uninstall()


def test_a_star_import_gives_upstreams_names_and_smach_error(installed):
    names = {}
    exec("from smach import *", names)
    assert set(names) - {"__builtins__"} == {*UPSTREAM, "SmachError"}


def test_sub_modules_are_found_under_upstreams_names(installed):
    import smach.container
    from smach.state import CBState, State
    from smach.user_data import Const, get_const
    from smach.util import has_smach_interface

    assert smach.container.Container is smach_compat.Container
    assert (State, CBState) == (smach_compat.State, smach_compat.CBState)
    assert has_smach_interface is smach_compat.has_smach_interface
    assert type(get_const(State())) is Const


def test_loggers_set_by_the_program_are_those_that_machines_use(installed, log):
    import smach

    heard = []
    smach.loginfo = heard.append
    machine = smach.StateMachine(["ok"])
    with machine:
        smach.StateMachine.add("A", smach.CBState(lambda ud: "ok", outcomes=["ok"]))
    machine.execute()
    assert any("'A'" in text for text in heard)
    assert log.at("info") == []


def test_it_is_gone_after_uninstall():
    smach_compat.install(profile="ros2")
    smach_compat.install(honour_preempt_timeout=True)
    assert (settings.profile, settings.honour_preempt_timeout) == ("ros2", True)
    smach_compat.uninstall()
    assert not [name for name in sys.modules if name.split(".")[0] == "smach"]
    assert (settings.profile, settings.honour_preempt_timeout) == ("noetic", False)


def test_another_smach_is_not_replaced(monkeypatch):
    other = ModuleType("smach")
    monkeypatch.setitem(sys.modules, "smach", other)
    with pytest.raises(GripError, match="imported already"):
        smach_compat.install()
    smach_compat.uninstall()
    assert sys.modules["smach"] is other


@pytest.mark.parametrize(("changes", "error"), [({"profile": "kinetic"}, ValueError), ({"colour": 1}, TypeError)])
def test_unknown_settings_are_refused_with_what_there_is(changes, error):
    with pytest.raises(error, match="available"):
        smach_compat.configure(**changes)


def test_importing_it_installs_nothing_and_loads_neither_ros_nor_py_trees():
    code = (
        "import sys, grip_bt.smach_compat\n"
        "bad = {'smach', 'rospy', 'rclpy', 'py_trees', 'numpy'} & set(sys.modules)\n"
        "sys.exit(f'loaded: {bad}' if bad else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=600)


def test_the_default_loggers_print_with_a_level(capsys):
    for name in ("loginfo", "logwarn", "logdebug", "logerr"):
        getattr(smach_compat.log, name)("text")
    assert capsys.readouterr().out.splitlines() == [
        "[  INFO ] : text",
        "[  WARN ] : text",
        "[ DEBUG ] : text",
        "[ ERROR ] : text",
    ]


@pytest.fixture
def ros_1():
    """ROS 1's modules, over ROS within this process."""
    smach_compat.install(rospy=True)
    smach_ros.use(Ros())
    yield
    smach_ros.use(None)
    smach_compat.uninstall()


def test_modules_of_ros_1_are_there_when_they_are_asked_for_and_gone_afterwards(ros_1):
    assert not settings.rospy
    import actionlib.simple_action_client
    import roslib.packages
    import rospy.core
    from tf.transformations import quaternion_matrix

    roslib.load_manifest("anything")
    assert (settings.rospy, quaternion_matrix((0, 0, 0, 1)).shape, rospy.core.is_initialized()) == (True, (4, 4), False)
    assert actionlib.simple_action_client.GoalStatus.SUCCEEDED == 3
    with pytest.raises(roslib.packages.InvalidROSPkgException, match="nowhere"):
        roslib.packages.get_pkg_dir("nowhere")
    smach_compat.uninstall()
    with pytest.raises(ImportError):
        importlib.import_module("rospy")


def test_a_module_that_a_unit_test_has_put_there_stays(ros_1, monkeypatch):
    bare = ModuleType("rospy")
    monkeypatch.setitem(sys.modules, "rospy", bare)
    with pytest.raises(ImportError):
        importlib.import_module("rospy.core")
    assert importlib.import_module("rospy") is bare


def test_parameters_are_kept_in_the_process_and_read_from_a_file(ros_1, tmp_path):
    import rospy

    (tmp_path / "p.yaml").write_text("arm: {speed: 0.5}\nmine: {who: me}\n")
    smach_compat.configure(parameters=str(tmp_path / "p.yaml"))
    rospy.init_node("mine")
    assert (rospy.get_param("/arm/speed"), rospy.get_param("~who"), rospy.get_param("none", 3)) == (0.5, "me", 3)
    rospy.set_param("~deep/x", [1])
    assert rospy.get_param("/mine/deep") == {"x": [1]}
    rospy.delete_param("/mine/deep/x")
    assert not rospy.has_param("~deep/x")
    with pytest.raises(KeyError, match="GRIP_ROS_PARAMETERS"):
        rospy.get_param("colour")


def test_times_and_durations_are_reckoned_with_as_in_ros_1(ros_1):
    from rospy import Duration, Time

    assert (Time(3) - Time(1.5)).to_sec() == 1.5
    assert Time(1) + Duration(0.5) == Time.from_sec(1.5) > Time(1, 10)
    assert (Duration(-0.25).to_nsec(), (Duration(3) * 2).to_sec(), Duration(3) / Duration(2)) == (
        -250_000_000,
        6.0,
        1.5,
    )
    with pytest.raises(TypeError, match="can't be compared"):
        assert Time(1) < Duration(2)


def test_smach_msgs_is_found_and_a_star_import_gives_what_the_program_uses(ros_1, monkeypatch):
    for name in ("smach_msgs", "smach_msgs.msg"):  # though another may be there
        monkeypatch.setitem(sys.modules, name, smach_compat._install.smach_msgs().makers[name]())
    used, unused = {"__name__": "program"}, {"__name__": "program"}
    exec("from smach_msgs.msg import *\nmessage = SmachContainerStatus(path='/SM')", used)
    exec("from smach_msgs.msg import *", unused)
    assert (used["message"].path, set(unused) - {"__builtins__"}) == ("/SM", {"__name__"})


def test_in_a_dry_run_what_nobody_offers_is_made_up_and_told_once(ros_1):
    import actionlib
    import rospy

    class Trigger:
        class Request(SimpleNamespace):
            pass

        class Response(SimpleNamespace):
            _fields_and_field_types = {"success": "boolean", "message": "string"}

    told = []
    smach_ros.use(Ros(lambda name: f"<{name}>", told.append))
    began = rospy.get_time()
    rospy.sleep(1000.0)
    assert rospy.get_time() - began >= 1000.0
    assert [rospy.ServiceProxy("open", Trigger)(a=1).success for _ in range(2)] == [True, True]
    client = actionlib.SimpleActionClient("go", SimpleNamespace(Goal=dict, Result=dict))
    assert client.send_goal_and_wait({}) == actionlib.GoalStatus.SUCCEEDED
    assert rospy.wait_for_message("heard", dict) == {}
    assert rospy.get_param("/speed") == "<parameter /speed>"
    assert told == ["service /open", "action /go", "topic /heard", "parameter /speed"]


def test_machines_outlive_a_connection_that_was_closed(monkeypatch):
    monkeypatch.setattr(smach_compat, "is_shutdown", smach_compat._settings.is_shutdown)
    connection = Ros()
    smach_ros.use(connection)
    assert smach_compat.is_shutdown == connection.is_shutdown
    connection.close()
    smach_ros.use(None)
    machine = smach_compat.StateMachine(["ok"])
    with machine:
        smach_compat.StateMachine.add("A", smach_compat.CBState(lambda ud: "ok", outcomes=["ok"]))
    assert machine.execute() == "ok"
