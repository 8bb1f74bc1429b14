"""Message classes of the ROS 1 stand-in: slots and no `__dict__`, as those that genpy makes."""

import threading
from types import ModuleType

import standin_rospy as rospy


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

    name = type_.split("/")[1]
    return type(name, (), {"__slots__": list(defaults), "__init__": __init__, "_type": type_})


Header = message("std_msgs/Header", seq=0, stamp=rospy.Time, frame_id="")
Empty = message("std_msgs/Empty")
EmptyRequest = message("std_srvs/EmptyRequest")
EmptyResponse = message("std_srvs/EmptyResponse")
AddRequest = message("standin/AddRequest", a=0, b=0)
AddResponse = message("standin/AddResponse", sum=0)


class EmptySrv:
    _request_class, _response_class = EmptyRequest, EmptyResponse


class AddSrv:
    _request_class, _response_class = AddRequest, AddResponse


TestGoal = message("actionlib/TestGoal", goal=0)
TestResult = message("actionlib/TestResult", result=0)
TestFeedback = message("actionlib/TestFeedback", feedback=0)
_ActionGoal = message("actionlib/TestActionGoal", goal=TestGoal)
_ActionResult = message("actionlib/TestActionResult", result=TestResult)
_ActionFeedback = message("actionlib/TestActionFeedback", feedback=TestFeedback)
TestAction = message(
    "actionlib/TestAction", action_goal=_ActionGoal, action_result=_ActionResult, action_feedback=_ActionFeedback
)
for _class in (TestGoal, TestResult, TestFeedback, TestAction):
    _class.__test__ = False  # no test of pytest's, whatever their names

SmachContainerStatus = message(
    "smach_msgs/SmachContainerStatus",
    header=Header,
    path="",
    initial_states=list,
    active_states=list,
    local_data="",
    info="",
)
SmachContainerInitialStatusCmd = message(
    "smach_msgs/SmachContainerInitialStatusCmd", path="", initial_states=list, local_data=""
)
SmachContainerStructure = message(
    "smach_msgs/SmachContainerStructure",
    header=Header,
    path="",
    children=list,
    internal_outcomes=list,
    outcomes_from=list,
    outcomes_to=list,
    container_outcomes=list,
)


def _module(name, **names):
    module = ModuleType(name)
    vars(module).update(names)
    return module


def modules():
    """Return the stand-in's modules under the names that ROS 1 has for them."""
    import standin_actionlib as actionlib

    smach_msgs = {
        c.__name__: c for c in (SmachContainerStatus, SmachContainerInitialStatusCmd, SmachContainerStructure)
    }
    test = {c.__name__: c for c in (TestAction, TestGoal, TestResult, TestFeedback)}
    goal_status = actionlib.GoalStatus
    client = {"SimpleActionClient": actionlib.SimpleActionClient, "GoalStatus": goal_status}
    server = {"SimpleActionServer": actionlib.SimpleActionServer}
    raw = {"ActionServer": actionlib.ActionServer}

    def by_type(type_):
        return sorted({p.name for p in rospy.master.publishers if p.type._type == type_})

    return {
        "rospy": rospy,
        "roslib": _module("roslib", load_manifest=lambda package: None),
        "rostopic": _module("rostopic", find_by_type=by_type),
        "std_msgs": _module("std_msgs"),
        "std_msgs.msg": _module("std_msgs.msg", Header=Header, Empty=Empty),
        "std_srvs": _module("std_srvs"),
        "std_srvs.srv": _module("std_srvs.srv", Empty=EmptySrv, EmptyRequest=EmptyRequest, EmptyResponse=EmptyResponse),
        "smach_msgs": _module("smach_msgs"),
        "smach_msgs.msg": _module("smach_msgs.msg", **smach_msgs),
        "executive_python_msgs": _module("executive_python_msgs"),
        "executive_python_msgs.msg": _module("executive_python_msgs.msg"),
        "actionlib": _module("actionlib", threading=threading, **client, **server, **raw),
        "actionlib.msg": _module("actionlib.msg", **test),
        "actionlib.simple_action_client": _module("actionlib.simple_action_client", **client),
        "actionlib.simple_action_server": _module("actionlib.simple_action_server", **server),
        "actionlib.action_server": _module("actionlib.action_server", **raw),
    }
