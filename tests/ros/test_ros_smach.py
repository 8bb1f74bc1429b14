"""`smach_ros` over real rclpy: servers in another process, preempts, time-outs, introspection as a viewer sees it."""

import pickle
import queue
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from patience import PATIENCE, until

from grip_bt import smach_compat as smach
from grip_bt.smach_compat import smach_ros
from grip_bt.smach_compat._settings import Settings, settings

pytestmark = pytest.mark.ros
DATA = Path(__file__).parent / "data"
LIMIT = PATIENCE  # [s]
OUTCOMES = ["succeeded", "aborted", "preempted"]


@pytest.fixture(scope="module")
def counting(interface_cache):
    from grip_bt.ros.interfaces import build_interfaces
    from grip_bt.ros.interfaces.packages import activate

    (built,) = build_interfaces(DATA / "counting", interface_cache)
    activate(built.prefix)
    return built.prefix


@pytest.fixture
def count(counting):
    from counting_interfaces.action import Count

    return Count


@pytest.fixture
def ros(domain, interface_cache, monkeypatch):
    """Connect smach_ros to the test's domain; its logs are collected."""
    from grip_bt.ros.smach_rclpy import connect

    said = []
    for level in ("info", "warn", "debug", "err"):
        monkeypatch.setattr(smach, f"log{level}", lambda text, level=level: said.append((level, str(text))))
    monkeypatch.setattr(smach, "is_shutdown", lambda: False)
    connection = connect(domain, interface_cache)
    connection.said = said
    smach_ros.use(connection)
    yield connection
    smach_ros.use(None)
    connection.close()
    vars(settings).update(vars(Settings()))


@pytest.fixture
def server(start_server, counting):
    return start_server("count_server.py", overlays=[counting])


def machine_of(state, **options):
    machine = smach.StateMachine(OUTCOMES)
    with machine:
        smach.StateMachine.add("S", state, **options)
    return machine


def run_aside(work):
    """Start work in a thread; return the thread and where its result comes."""
    results = queue.Queue()
    thread = threading.Thread(target=lambda: results.put(work()), daemon=True)
    thread.start()
    return results


def test_goals_end_as_the_server_of_another_process_says(ros, server, count):
    for number, outcome in ((1, "succeeded"), (2, "aborted"), (3, "aborted")):
        state = smach_ros.SimpleActionState("count", count, goal=count.Goal(goal=number), result_slots=["result"])
        machine = machine_of(state)
        assert machine.execute() == outcome
        if number == 1:
            assert machine.userdata.result == 10


def test_feedback_and_results_reach_the_callbacks_with_their_userdata(ros, server, count):
    heard = []

    @smach.cb_interface(output_keys=["kept"], outcomes=["special"])
    def on_result(ud, status, result):
        ud.kept = (status, result.result)
        return "special"

    state = smach_ros.SimpleActionState(
        "count",
        count,
        goal_slots=["goal"],
        result_cb=on_result,
        feedback_cb=lambda ud, message: heard.append((ud.goal, message.feedback)),
        input_keys=["goal"],
    )
    machine = smach.StateMachine([*OUTCOMES, "special"])
    machine.userdata.goal = 1
    with machine:
        smach.StateMachine.add("S", state)
    assert machine.execute() == "special"
    assert machine.userdata.kept == (4, 10)
    assert set(heard) <= {(1, 1)}  # what is sent just before a result may be lost


def test_a_preempt_cancels_the_goal_and_waits_for_its_end(ros, server, count):
    state = smach_ros.SimpleActionState("count", count, goal=count.Goal(goal=4))
    machine = machine_of(state)
    results = run_aside(machine.execute)
    until(lambda: state._status == state.ACTIVE)
    time.sleep(0.2)  # on its way, at the server or accepted: all the same
    machine.request_preempt()
    assert results.get(timeout=LIMIT) == "preempted"
    assert not state.preempt_requested()


def test_a_preempt_that_comes_first_sends_nothing(ros, server, count):
    state = smach_ros.SimpleActionState("count", count, goal=count.Goal(goal=5))
    state.request_preempt()
    assert machine_of(state).execute() == "preempted"


def test_a_goal_that_takes_too_long_is_canceled_and_aborts(ros, server, count):
    state = smach_ros.SimpleActionState("count", count, goal=count.Goal(goal=4), exec_timeout=0.3)
    assert machine_of(state).execute() == "aborted"


@pytest.mark.parametrize("changes", [{"honour_preempt_timeout": True}, {"profile": "ros2"}], ids=str)
def test_a_server_that_never_stops_is_given_up_only_when_asked_for(ros, server, count, changes):
    smach.configure(**changes)
    state = smach_ros.SimpleActionState("count", count, goal=count.Goal(goal=5), preempt_timeout=0.3)
    machine = machine_of(state)
    results = run_aside(machine.execute)
    until(lambda: state._status == state.ACTIVE)
    machine.request_preempt()
    assert results.get(timeout=LIMIT) == ("preempted" if settings.ros2 else "aborted")


def test_a_server_that_dies_aborts_its_goal(ros, server, count):
    state = smach_ros.SimpleActionState("count", count, goal=count.Goal(goal=5))
    results = run_aside(machine_of(state).execute)
    until(lambda: state._status == state.ACTIVE)
    time.sleep(0.3)
    server.kill()
    assert results.get(timeout=LIMIT) == "aborted"


def test_without_server_an_action_aborts_after_its_time_out(ros, count):
    state = smach_ros.SimpleActionState("nobody", count, server_wait_timeout=0.3)
    assert machine_of(state).execute() == "aborted"
    assert any("no server" in text for _, text in ros.said)


def test_a_service_of_another_process_is_called_with_userdata_and_its_answer_kept(ros, server):
    from std_srvs.srv import SetBool

    state = smach_ros.ServiceState("answer", SetBool, request_slots=["data"], response_slots=["success"])
    machine = machine_of(state, remapping={"data": "given", "success": "answer"})
    machine.userdata.given = True
    assert (machine.execute(), machine.userdata.answer) == ("succeeded", True)


def test_a_preempt_ends_the_waiting_for_a_service(ros):
    from std_srvs.srv import SetBool

    machine = machine_of(smach_ros.ServiceState("nobody", SetBool))
    results = run_aside(machine.execute)
    until(machine.is_running)
    machine.request_preempt()
    assert results.get(timeout=LIMIT) == "preempted"


def test_a_monitor_judges_messages_of_a_topic(ros):
    from std_msgs.msg import Int32

    publisher = ros.advertise("/numbers", Int32)
    for limit, checks, outcome in ((3, -1, "invalid"), (100, 4, "valid")):
        seen = []
        state = smach_ros.MonitorState(
            "numbers",
            Int32,
            lambda ud, message, seen=seen, limit=limit: seen.append(message.data) or len(seen) < limit,
            checks,
        )
        machine = smach.StateMachine(["valid", "invalid", "preempted"])
        with machine:
            smach.StateMachine.add("S", state)
        results = run_aside(machine.execute)
        number = 0
        while results.empty():
            publisher.publish(Int32(data=number))
            number += 1
            time.sleep(0.01)
        assert results.get() == outcome
        assert len(seen) == 3


def test_a_preempt_ends_a_monitor_that_hears_nothing(ros):
    from std_msgs.msg import Empty

    state = smach_ros.MonitorState("silence", Empty, lambda ud, message: True)
    machine = smach.StateMachine(["valid", "invalid", "preempted"])
    with machine:
        smach.StateMachine.add("S", state)
    results = run_aside(machine.execute)
    until(machine.is_running)
    machine.request_preempt()
    assert results.get(timeout=LIMIT) == "preempted"


class Work(smach.State):
    """Succeeds with twice the goal, aborts at 2, and at 4 waits until it is preempted."""

    def __init__(self):
        super().__init__(OUTCOMES, ["action_goal", "action_result"], ["action_result"])

    def execute(self, ud):
        ud.action_result.result = 2 * ud.action_goal.goal
        while ud.action_goal.goal == 4:
            if self.preempt_requested():
                self.service_preempt()
                return "preempted"
            time.sleep(0.005)
        return "aborted" if ud.action_goal.goal == 2 else "succeeded"


@pytest.mark.parametrize("profile", ["noetic", "ros2"])
def test_a_machine_serves_an_action_and_is_preempted_by_a_cancel(ros, domain, count, profile):
    from grip_bt.ros.client.bus import Bus

    smach.configure(profile=profile)
    machine = smach.StateMachine(OUTCOMES, ["action_goal", "action_result"], ["action_result"])
    with machine:
        smach.StateMachine.add("WORK", Work())
    wrapper = smach_ros.ActionServerWrapper("work", count, machine, ["succeeded"], ["aborted"], ["preempted"])
    wrapper.run_server()
    with Bus("client", domain_id=domain) as other:
        client = other.action(count, "/work")
        for goal, status in ((1, "succeeded"), (2, "aborted")):
            end = client.send(count.Goal(goal=goal))
            assert end.wait(LIMIT)
            assert (end.result().status, end.result().result.result) == (status, 2 * goal)
        waiting = client.send(count.Goal(goal=4))
        until(machine.is_running)
        waiting.cancel()
        assert waiting.wait(LIMIT)
        assert waiting.result().status == "canceled"


def watched():
    inner = machine_of(smach.CBState(lambda ud: "succeeded", outcomes=["succeeded"]))
    machine = smach.StateMachine(OUTCOMES)
    with machine:
        smach.StateMachine.add(
            "FIRST", smach.CBState(lambda ud: "succeeded", outcomes=["succeeded"]), {"succeeded": "INNER"}
        )
        smach.StateMachine.add("INNER", inner)
    machine.userdata.thing = "mug"
    return machine


def test_a_viewer_sees_structure_status_and_each_transition(ros, domain):
    from grip_bt.ros.smach_rclpy import connect

    machine = watched()
    viewer = connect(domain)
    messages = ros.introspection()
    structures, statuses = queue.Queue(), queue.Queue()
    viewer.subscribe("/watch/smach/container_structure", messages.Structure, structures.put)
    viewer.subscribe("/watch/smach/container_status", messages.Status, statuses.put)
    server = smach_ros.IntrospectionServer("watch", machine, "/SM_ROOT")
    server.start()
    try:
        seen = {}
        while len(seen) < 2:
            message = structures.get(timeout=LIMIT)
            seen[message.path] = message
        root = seen["/SM_ROOT"]
        assert list(root.children) == ["FIRST", "INNER"]
        edges = set(zip(root.internal_outcomes, root.outcomes_from, root.outcomes_to, strict=True))
        assert {("succeeded", "FIRST", "INNER"), ("aborted", "INNER", "None")} <= edges
        assert list(root.container_outcomes) == OUTCOMES
        assert list(seen["/SM_ROOT/INNER"].children) == ["S"]
        machine.execute()
        while True:
            status = statuses.get(timeout=LIMIT)
            if list(status.active_states) == ["INNER"]:
                break
        assert (status.path, list(status.initial_states)) == ("/SM_ROOT", ["FIRST"])
        assert pickle.loads(bytes(status.local_data)) == {"thing": "mug"}
    finally:
        server.stop()
        viewer.close()


def test_a_client_sets_where_a_container_begins_and_pickles_are_read_only_when_allowed(ros):
    machine = watched()
    server = smach_ros.IntrospectionServer("watch", machine, "/SM_ROOT")
    server.start()
    client = smach_ros.IntrospectionClient()
    until(lambda: client.get_servers() == ["/watch"])
    assert client.set_initial_state("/watch", "/SM_ROOT", ["INNER"], timeout=LIMIT) is True
    assert machine.get_initial_states() == ["INNER"]

    userdata = smach.UserData()
    userdata.thing = "plate"
    with pytest.raises(smach.InvalidStateError.__mro__[2], match="unpickle_userdata"):
        client.set_initial_state("/watch", "/SM_ROOT", ["FIRST"], userdata, timeout=1.0)
    client.set_initial_state("/watch", "/SM_ROOT", ["FIRST"], userdata)
    until(lambda: any(level == "err" and "unpickle_userdata" in text for level, text in ros.said))
    assert (machine.get_initial_states(), machine.userdata.thing) == (["INNER"], "mug")

    smach.configure(unpickle_userdata=True)
    assert client.set_initial_state("/watch", "/SM_ROOT", ["FIRST"], userdata, timeout=LIMIT) is True
    assert (machine.get_initial_states(), machine.userdata.thing) == (["FIRST"], "plate")
    assert client.set_initial_state("/watch", "/SM_ROOT", ["NOWHERE"], timeout=0.5) is False
    server.stop()


def test_states_take_a_node_first_as_in_ros_2_and_resolve_names_by_it(ros, domain, server, count):
    import rclpy
    from rclpy.context import Context
    from rclpy.node import Node

    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    node = Node("mine", context=context, namespace="/robot", enable_rosout=False, start_parameter_services=False)
    try:
        state = smach_ros.SimpleActionState(node, "/count", count, goal=count.Goal(goal=1))
        assert (state.node, state._full_name("arm")) == (node, "/robot/arm")
        assert machine_of(state).execute() == "succeeded"
        named = smach_ros.ConditionState(cond_cb=lambda ud: True, node=node)
        assert (named.node, named.execute(smach.UserData())) == (node, "true")
    finally:
        node.destroy_node()
        context.try_shutdown()


def test_an_interrupt_preempts_the_machine_and_the_program_ends_by_itself(domain, tmp_path):
    program = tmp_path / "program.py"
    program.write_text((DATA / "interrupted.py").read_text())
    from grip_bt.ros.command import child_environment

    process = subprocess.Popen(
        [sys.executable, str(program)], env=child_environment((), domain), stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout.readline() == "waiting\n"
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=LIMIT)
        assert (said.splitlines()[-1], process.returncode) == ("preempted", 0)
    finally:
        process.kill()
        process.wait()


LEGACY = """
import smach
import smach_ros
from std_srvs.srv import SetBool


def build():
    sm = smach.StateMachine(outcomes=["succeeded", "aborted", "preempted"])
    sm.userdata.given = True
    with sm:
        ask = smach_ros.ServiceState("answer", SetBool, request_slots=["data"], response_slots=["success"])
        smach.StateMachine.add("ASK", ask, {"succeeded": "CHECK"}, remapping={"data": "given", "success": "said"})
        smach.StateMachine.add(
            "CHECK",
            smach_ros.ConditionState(lambda ud: ud.said, input_keys=["said"]),
            {"true": "succeeded", "false": "aborted"},
        )
    return sm
"""


def test_a_legacy_file_that_calls_a_service_is_imported_and_run_by_the_commands(domain, server, tmp_path):
    from grip_bt.ros.command import child_environment

    (tmp_path / "legacy_ask.py").write_text(LEGACY)
    for words in (
        ["import", "legacy_ask.py", "--from", "smach", "--execute", "-o", "tasks/ask.yaml"],
        ["run", "tasks/ask.yaml"],
    ):
        done = subprocess.run(
            [sys.executable, "-m", "grip_bt.cli", *words],
            env=child_environment((), domain),
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=LIMIT,
        )
        assert done.returncode == 0, (words, done.stdout, done.stderr)
    assert "succeeded" in done.stdout
