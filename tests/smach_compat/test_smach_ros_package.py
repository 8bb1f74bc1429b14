"""The package in the place of `smach_ros`: names, profiles, conditions, on ROS within this process."""

import subprocess
import sys
from types import ModuleType

import pytest
import ros1_messages

from grip_bt import smach_compat
from grip_bt.nodes.stand_ins import stand_in
from grip_bt.smach_compat import UserData, ros1, smach_ros
from grip_bt.smach_compat.exceptions import InvalidStateError, InvalidUserCodeError
from grip_bt.smach_compat.ros1 import rospy
from grip_bt.smach_compat.smach_ros._port import Ros

NOETIC = """
    set_preempt_handler ActionServerWrapper IntrospectionClient IntrospectionServer
    SimpleActionState ServiceState MonitorState ConditionState
""".split()


@pytest.fixture(autouse=True)
def ros():
    connection = Ros()
    smach_ros.use(connection)
    yield connection
    smach_ros.use(None)


class Stamped:
    """A message as ROS 2 generates them, which checks its fields."""

    KINDS = {"x": "double", "count": "uint8", "name": "string", "there": "boolean", "path": "sequence<double>"}

    def __init__(self, **fields):
        for name, kind in self.KINDS.items():
            setattr(self, name, fields.get(name, [] if "<" in kind else {"string": "", "double": 0.0}.get(kind, 0)))

    @classmethod
    def get_fields_and_field_types(cls):
        return dict(cls.KINDS)

    @property
    def x(self):
        return self._x

    @x.setter
    def x(self, value):
        assert isinstance(value, float), "must be of type 'float'"
        self._x = value


def test_fields_take_whole_numbers_for_floats_and_stand_ins_for_anything():
    module = ModuleType("kitchen_msgs.msg")
    module.Stamped = type("Stamped", (Stamped,), {})
    ros1.give_names(module)
    assert module.Stamped(1, 2, "a", True, [1.0]).x == 1.0
    unknown = stand_in("arm.state")
    made = module.Stamped(unknown, unknown, unknown, unknown, unknown)
    assert vars(made) == {"_x": 0.0, "count": 0, "name": "", "there": True, "path": []}


@pytest.mark.parametrize(("profile", "more"), [("noetic", set()), ("ros2", {"RosState"})])
def test_a_star_import_gives_upstreams_names_of_the_profile(profile, more):
    smach_compat.configure(profile=profile)
    assert {*NOETIC, *more} == set(smach_ros.__all__) - {"SmachNode"}
    assert ("SmachNode" in smach_ros.__all__) == (profile == "ros2")


def test_sub_modules_are_found_under_upstreams_names_and_nothing_of_ros_is_loaded():
    code = (
        "from grip_bt import smach_compat; smach_compat.install()\n"
        "import sys, smach_ros.util\n"
        "from smach_ros.simple_action_state import SimpleActionState\n"
        "from smach_ros.introspection import IntrospectionServer\n"
        "sys.exit(bool({'rospy', 'rclpy'} & set(sys.modules)))"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=600)


@pytest.mark.parametrize(("profile", "checks"), [("noetic", 4), ("ros2", 3)])
def test_a_condition_is_checked_once_more_in_noetic(profile, checks):
    smach_compat.configure(profile=profile)
    seen = []
    rate = 1000 if profile == "ros2" else rospy.Duration(0.001)
    state = smach_ros.ConditionState(seen.append, poll_rate=rate, max_checks=3)
    assert (state.execute(UserData()), len(seen)) == ("false", checks)


def test_a_condition_ends_when_it_holds_is_preempted_runs_out_of_time_or_raises():
    assert smach_ros.ConditionState(lambda ud: True).execute(UserData()) == "true"
    state = smach_ros.ConditionState(lambda ud: False, max_checks=-1)
    state.request_preempt()
    assert (state.execute(UserData()), state.preempt_requested()) == ("preempted", False)
    state = smach_ros.ConditionState(lambda ud: False, poll_rate=0.001, timeout=0.02, max_checks=-1)
    assert state.execute(UserData()) == "false"
    with pytest.raises(InvalidUserCodeError, match="ZeroDivisionError"):
        smach_ros.ConditionState(lambda ud: 1 / 0).execute(UserData())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"goal": print}, "give it as goal_cb"),
        ({"goal_slots": ["speed"]}, "has \\['goal'\\]"),
        ({"result_slots": ["speed"]}, "has \\['result'\\]"),
        ({"goal_cb": 3}, "goal callback .* isn't a function"),
    ],
)
def test_wrong_arguments_of_an_action_state_are_refused_with_what_there_is(options, said):
    with pytest.raises(InvalidStateError, match=said):
        smach_ros.SimpleActionState("a", ros1_messages.TestAction, **options)


def test_a_service_state_aborts_without_what_its_request_needs_and_when_the_server_fails():
    rospy.Service("/add", ros1_messages.AddSrv, lambda request: 1 / 0)
    assert smach_ros.ServiceState("add", ros1_messages.AddSrv, request_key="r").execute(UserData()) == "aborted"
    assert smach_ros.ServiceState("add", ros1_messages.AddSrv).execute(UserData()) == "aborted"
    unknown = smach_ros.ServiceState("add", ros1_messages.AddSrv, request_cb=lambda ud, request: 1 / 0)
    assert unknown.execute(UserData()) == "aborted"


def test_a_shutdown_of_ros_1_preempts_the_machine():
    machine = smach_compat.StateMachine(["done"])
    smach_ros.set_preempt_handler(machine)
    rospy.signal_shutdown("test")
    assert machine.preempt_requested()
