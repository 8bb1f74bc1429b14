"""Messages that take their fields by position (slots, no `__dict__`), and actionlib's server of any number of goals."""

from types import ModuleType, SimpleNamespace

from grip_bt.smach_compat.ros1 import actionlib, rospy
from grip_bt.smach_compat.smach_ros import _connection


def message(type_, **defaults):
    """Return a message class; a default that can be called is called for each message."""

    def __init__(self, *args, **kwargs):
        if args and len(args) != len(defaults):
            raise TypeError(f"{type_} takes {len(defaults)} positional fields or none, not {len(args)}")
        given = dict(zip(defaults, args, strict=False)) | kwargs
        unknown = given.keys() - defaults.keys()
        if unknown:
            raise AttributeError(f"{type_} has no fields {sorted(unknown)}")
        for name, default in defaults.items():
            setattr(self, name, given.get(name, default() if callable(default) else default))

    name, fields = type_.split("/")[1], classmethod(lambda cls: dict.fromkeys(defaults))
    return type(name, (), {"__slots__": list(defaults), "__init__": __init__, "get_fields_and_field_types": fields})


Header = message("std_msgs/Header", seq=0, stamp=rospy.Time, frame_id="")
Empty = message("std_msgs/Empty")
EmptyRequest = message("std_srvs/EmptyRequest")
EmptyResponse = message("std_srvs/EmptyResponse")
AddRequest = message("standin/AddRequest", a=0, b=0)
AddResponse = message("standin/AddResponse", sum=0)


class EmptySrv:
    Request, Response = EmptyRequest, EmptyResponse


class AddSrv:
    Request, Response = AddRequest, AddResponse


TestGoal = message("actionlib/TestGoal", goal=0)
TestResult = message("actionlib/TestResult", result=0)
TestFeedback = message("actionlib/TestFeedback", feedback=0)


class TestAction:
    Goal, Result, Feedback = TestGoal, TestResult, TestFeedback


for _class in (TestGoal, TestResult, TestFeedback, TestAction):
    _class.__test__ = False  # no test of pytest's, whatever their names


class GoalHandle:
    """One goal, as its server has it."""

    def __init__(self, goal, result_class):
        self._sent, self._result_class = goal, result_class

    def get_goal(self):
        return self._sent.message

    def publish_feedback(self, feedback):
        self._sent.feedback(feedback)

    def set_accepted(self, text=""):
        pass

    def _end(self, ending, result):
        self._sent.end(ending, self._result_class() if result is None else result)

    def set_succeeded(self, result=None, text=""):
        self._end("succeeded", result)

    def set_aborted(self, result=None, text=""):
        self._end("aborted", result)

    def set_rejected(self, result=None, text=""):
        self._end("rejected", result)

    def set_canceled(self, result=None, text=""):
        self._end("preempted", result)


class ActionServer:
    def __init__(self, ns, ActionSpec, goal_cb, cancel_cb=None, auto_start=True):
        self._name, self._goal_cb, self._cancel_cb = rospy.resolve_name(ns), goal_cb, cancel_cb
        self._result_class, self._handles = ActionSpec.Result, {}
        if auto_start:
            self.start()

    def start(self):
        _connection.ros().actions[self._name] = SimpleNamespace(take=self._take, canceled=self._canceled)

    def _take(self, goal):
        self._handles[id(goal)] = GoalHandle(goal, self._result_class)
        self._goal_cb(self._handles[id(goal)])

    def _canceled(self, goal):
        if self._cancel_cb is not None:
            self._cancel_cb(self._handles[id(goal)])


def _module(name, **names):
    module = ModuleType(name)
    vars(module).update(names)
    return module


def modules():
    """Return the packages of messages that programs import, under the names that ROS 1 has for them."""
    test = {c.__name__: c for c in (TestAction, TestGoal, TestResult, TestFeedback)}
    actionlib.ActionServer = ActionServer
    actionlib.__all__ += ["ActionServer"]
    return {
        "std_msgs": _module("std_msgs"),
        "std_msgs.msg": _module("std_msgs.msg", Header=Header, Empty=Empty),
        "std_srvs": _module("std_srvs"),
        "std_srvs.srv": _module("std_srvs.srv", Empty=EmptySrv, EmptyRequest=EmptyRequest, EmptyResponse=EmptyResponse),
        "executive_python_msgs": _module("executive_python_msgs"),
        "executive_python_msgs.msg": _module("executive_python_msgs.msg"),
        "actionlib.msg": _module("actionlib.msg", **test),
        "actionlib.action_server": _module("actionlib.action_server", ActionServer=ActionServer),
    }
