#!/usr/bin/env python
"""Tests written as a ROS 1 program: nothing in here knows where it runs."""
# ruff: noqa: F403, F405, E402 - as such programs are

import roslib

roslib.load_manifest("smach_ros")

import unittest

import rospy
import rostest
import std_srvs.srv as std_srvs
from actionlib import *
from actionlib.msg import *
from smach import *
from smach_ros import *
from std_msgs.msg import Empty

GOOD, BAD, ODD = TestGoal(1), TestGoal(2), TestGoal(3)


def action(**options):
    return SimpleActionState("reference_action", TestAction, **options)


class Writes(State):
    def __init__(self, key, value):
        State.__init__(self, ["done"], output_keys=[key])
        self.key, self.value = key, value

    def execute(self, userdata):
        userdata[self.key] = self.value
        return "done"


class WaitsForPreempt(State):
    def __init__(self):
        State.__init__(self, ["succeeded", "aborted", "preempted"])

    def execute(self, userdata):
        began = rospy.Time.now()
        while rospy.Time.now() - began < rospy.Duration(20.0):
            rospy.sleep(0.01)
            if self.preempt_requested():
                self.service_preempt()
                return "preempted"
        return "succeeded"


class TestProgram(unittest.TestCase):
    def test_actions_in_a_row(self):
        sm = StateMachine(["succeeded", "aborted", "preempted", "done"])
        with sm:
            StateMachine.add_auto("FIRST", action(goal=GOOD), ["succeeded"])
            StateMachine.add("SECOND", action(goal=GOOD), {"succeeded": "done"})
        assert sm.execute() == "done"

    def test_every_way_to_a_goal(self):
        @cb_interface(input_keys=["good"])
        def from_userdata(ud, goal):
            return ud.good

        ways = {
            "KEY": {"goal_key": "good"},
            "SLOTS": {"goal_slots": ["goal"]},
            "CB": {"goal_cb": lambda ud, goal: TestGoal(1)},
            "CB_UD": {"goal_cb": lambda ud, goal: ud.good, "input_keys": ["good"]},
            "CB_DECORATED": {"goal_cb": from_userdata},
            "CB_ARGS": {
                "goal_cb": lambda ud, goal, a, b: TestGoal(a - b),
                "goal_cb_args": [3],
                "goal_cb_kwargs": {"b": 2},
            },
            "SLOT_WINS": {"goal": TestGoal(2), "goal_slots": ["goal"]},
            "CB_WINS": {"goal": TestGoal(2), "goal_cb": lambda ud, goal: setattr(goal, "goal", 1)},
        }
        sq = Sequence(["succeeded", "aborted", "preempted"], "succeeded")
        sq.userdata.good, sq.userdata.goal = GOOD, 1
        with sq:
            for label, options in ways.items():
                Sequence.add(label, action(**options))
        assert sq.execute() == "succeeded"

    def test_every_way_from_a_result(self):
        sq = Sequence(["succeeded", "aborted", "preempted", "special"], "succeeded")
        keep = CBInterface(lambda ud, status, result: setattr(ud, "seen", status), output_keys=["seen"])
        with sq:
            Sequence.add("KEY", action(goal=GOOD, result_key="whole"))
            Sequence.add("SLOTS", action(goal=GOOD, result_slots=["result"]), remapping={"result": "number"})
            Sequence.add("CB", action(goal=GOOD, result_cb=keep))
            special = CBInterface(lambda ud, status, result: "special", outcomes=["special"])
            Sequence.add("OUTCOME", action(goal=GOOD, result_cb=special))
        assert sq.execute() == "special"
        assert (sq.userdata.whole.result, sq.userdata.number) == (10, 10)
        assert sq.userdata.seen == GoalStatus.SUCCEEDED

    def test_aborted_and_rejected_goals_abort(self):
        for goal in (BAD, ODD):
            sm = StateMachine(["succeeded", "aborted", "preempted"])
            with sm:
                StateMachine.add("A", action(goal=goal))
            assert sm.execute() == "aborted"

    def test_no_server_in_time_aborts(self):
        sm = StateMachine(["succeeded", "aborted", "preempted"])
        with sm:
            state = SimpleActionState("nobody", TestAction, server_wait_timeout=rospy.Duration(0.2))
            StateMachine.add("A", state)
        assert sm.execute() == "aborted"

    def test_a_machine_is_an_action_server(self):
        sq = Sequence(["succeeded", "aborted", "preempted"], "succeeded")
        sq.register_input_keys(["goal", "action_goal", "action_result"])
        sq.register_output_keys(["action_result"])
        with sq:

            @cb_interface(input_keys=["action_result"], output_keys=["action_result"])
            def add_one(ud, status, result):
                ud.action_result.result = result.result + 1

            Sequence.add("BY_KEY", action(goal_key="action_goal"))
            Sequence.add("BY_SLOT", action(goal_slots=["goal"]))
            Sequence.add("RESULT", action(goal=GOOD, result_cb=add_one))
        wrapper = ActionServerWrapper(
            "machine", TestAction, sq, ["succeeded"], ["aborted"], ["preempted"], expand_goal_slots=True
        )
        wrapper.run_server()
        client = SimpleActionClient("machine", TestAction)
        assert client.wait_for_server(rospy.Duration(120))
        assert client.send_goal_and_wait(GOOD, rospy.Duration(120)) == GoalStatus.SUCCEEDED
        assert client.get_result().result == 11

    def test_canceling_a_machines_goal_preempts_it(self):
        sm = StateMachine(["succeeded", "aborted", "preempted"])
        with sm:
            StateMachine.add("WAIT", WaitsForPreempt())
        wrapper = ActionServerWrapper("slow", TestAction, sm, ["succeeded"], ["aborted"], ["preempted"])
        wrapper.run_server()
        client = SimpleActionClient("slow", TestAction)
        client.send_goal(GOOD)
        while not sm.is_running():
            rospy.sleep(0.01)
        client.cancel_goal()
        assert client.wait_for_result(rospy.Duration(120))
        assert client.get_state() == GoalStatus.PREEMPTED

    def test_a_service(self):
        rospy.Service("/empty", std_srvs.Empty, lambda request: std_srvs.EmptyResponse())

        def on_response(userdata, response):
            userdata.out = "called"
            return "succeeded"

        sm = StateMachine(["succeeded", "aborted", "preempted", "done"])
        with sm:
            StateMachine.add(
                "CALL",
                ServiceState("/empty", std_srvs.Empty, response_cb=on_response, output_keys=["out"]),
                transitions={"succeeded": "done"},
                remapping={"out": "kept"},
            )
        assert sm.execute() == "done"
        assert sm.userdata.kept == "called"

    def test_a_monitor(self):
        def ping():
            publisher, rate = rospy.Publisher("/ping", Empty), rospy.Rate(100.0)
            while not ended.is_set():
                publisher.publish(Empty())
                rate.sleep()

        def condition(ud, message):
            ud.out = ud.given
            return False

        ended = threading.Event()  # actionlib's star import brings it
        threading.Thread(target=ping).start()
        userdata = UserData()
        userdata.given = "A"
        sm = StateMachine(["valid", "invalid", "preempted"])
        sm.set_initial_state(["MONITOR"], userdata=userdata)
        with sm:
            monitor = MonitorState("/ping", Empty, condition, input_keys=["given"], output_keys=["out"])
            StateMachine.add("MONITOR", monitor)
        try:
            outcome = sm.execute()
        finally:
            ended.set()
        assert (outcome, sm.userdata.out) == ("invalid", "A")

    def test_a_condition_sees_what_a_nested_machine_gets(self):
        sm = StateMachine(["done", "aborted", "preempted"])
        inner = StateMachine(["done", "aborted", "preempted"], input_keys=["a"])
        with sm:
            StateMachine.add("WRITE", Writes("a", "A"), {"done": "INNER"})
            with inner:
                condition = ConditionState(lambda ud: "a" in ud, input_keys=["a"])
                StateMachine.add("ASSERT", condition, {"true": "done", "false": "aborted"})
            StateMachine.add("INNER", inner)
        assert sm.execute() == "done"

    def test_a_concurrence_of_actions(self):
        cc = Concurrence(["good", "bad"], "bad", outcome_map={"good": {"A": "succeeded", "B": "aborted"}})
        with cc:
            Concurrence.add("A", action(goal=GOOD))
            Concurrence.add("B", action(goal=BAD))
        assert cc.execute() == "good"

    def test_introspection(self):
        sm, inner = StateMachine(["done"]), StateMachine(["done"])
        with sm:
            StateMachine.add("FIRST", Writes("a", "A"), {"done": "INNER"})
            with inner:
                StateMachine.add("WRITE", Writes("b", "B"))
            StateMachine.add("INNER", inner)
        server = IntrospectionServer("watched", sm, "/SM_ROOT")
        server.start()
        client = IntrospectionClient()
        assert client.get_servers() == ["/watched"]
        userdata = UserData()
        userdata.given = [1, 2]
        ten = rospy.Duration(10.0)
        assert client.set_initial_state("watched", "/SM_ROOT", ["INNER"], userdata, timeout=ten)
        assert sm.execute() == "done"
        assert sm.userdata.keys() == ["given"]
        server.stop()


def main():
    rospy.init_node("program", log_level=rospy.DEBUG)
    rostest.rosrun("smach", "program", TestProgram)


if __name__ == "__main__":
    main()
