"""Actions, topics and other people's services as components: generated, and run against live servers."""

from __future__ import annotations

import shutil
import sys
import time

import pytest
from patience import PATIENCE, until
from py_trees.common import Status
from ros_bench import DATA, ended, gone

from grip_bt.base.failures import (
    BadReplyError,
    CanceledError,
    GoalAbortedError,
    GoalRejectedError,
    ServerLostError,
    ServerTimeOutError,
)
from grip_bt.cli.__main__ import main
from grip_bt.ros.components import start_components
from grip_bt.task.catalog.catalog import load_implementation
from grip_bt.task.catalog.manifest import read_manifests

pytestmark = pytest.mark.ros
ACTION = """\
name: worker
interface: trial_interfaces/action/Work
server: /work
outcomes: [done, partly]
meaning: {partly: failure}
start: {command: ["{python}", action_server.py, /work]}
timeouts: {call: 1000, ready: 400, cancel: 400}
"""


@pytest.fixture
def shop(tmp_path, trial):
    """Return a project with one action component; its interfaces are built already."""
    folder = tmp_path / "shop"
    folder.mkdir()
    (folder / "grip.yaml").write_text("grip: 1\n")
    home = folder / "components" / "worker"
    home.mkdir(parents=True)
    (home / "component.yaml").write_text(ACTION)
    shutil.copy(DATA / "action_server.py", home)
    shutil.copytree(DATA / "trial_interfaces", home / "interfaces" / "trial_interfaces")
    return folder


@pytest.fixture
def worker(shop, domain):
    with start_components(shop, ["worker"], domain) as components:
        yield components.client("worker")
    assert gone(components.process("worker").pid)


class Run:
    """The part of a run that a leaf needs."""

    def __init__(self, component):
        self.preempt_requested = False
        self.remote = component
        self.woken = 0

    def component(self, name):
        return self.remote

    def left(self, path, work):
        """Nothing here takes its time to stop."""

    def unfinished(self):
        return ()

    def wake(self):
        self.woken += 1


def leaf_of(shop, run, **inputs):
    assert main(["component", "add", str(shop / "components" / "worker")]) == 0
    (manifest,) = read_manifests(shop / "components" / "worker" / "node" / "manifest.yaml")
    leaf = load_implementation(manifest)("worker", "worker", manifest, {}, {})
    leaf.readers = {port: (lambda value=value: value) for port, value in inputs.items()}
    leaf.written = {}
    leaf.writers = {port: (lambda value, port=port: leaf.written.update({port: value})) for port in manifest.outputs}
    leaf.setup(context=run)
    return leaf


def run_to_end(leaf):
    def over() -> bool:
        leaf.tick_once()
        return leaf.status in (Status.SUCCESS, Status.FAILURE)

    until(over, "it doesn't end")
    return leaf.outcome


def test_a_generated_node_sends_a_goal_and_hands_out_result_and_feedback(shop, worker):
    leaf = leaf_of(shop, Run(worker), input="0", seconds=0.2)
    leaf.tick_once()
    assert leaf.status == Status.RUNNING
    assert run_to_end(leaf) == "done"
    assert leaf.written["returned_object"] == "did 0"
    assert 0 < leaf.written["feedback"].progress <= 1
    assert leaf.context.woken == 1


def test_the_number_of_the_result_is_the_outcome(shop, worker):
    assert run_to_end(leaf_of(shop, Run(worker), input="1", seconds=0.0)) == "partly"


def test_an_undeclared_number_is_a_bad_reply(shop, worker):
    leaf = leaf_of(shop, Run(worker), input="-1", seconds=0.0)
    assert run_to_end(leaf) == "failure"
    assert leaf.failure.code == "bad_reply"
    assert "outcome -1 isn't one of the declared ones (0 done, 1 partly)" in leaf.failure.message


@pytest.mark.parametrize(("how", "code"), [("abort", "aborted"), ("reject", "rejected"), ("die", "server_lost")])
def test_every_failure_of_a_goal_has_its_code_and_keeps_the_feedback(shop, worker, how, code):
    leaf = leaf_of(shop, Run(worker), input=how, seconds=0.1)
    assert run_to_end(leaf) == "failure"
    assert leaf.failure.code == code
    assert "feedback" in leaf.written
    if how == "abort":
        assert "returned_object: too heavy" in leaf.failure.message


def test_a_halted_node_cancels_its_goal_at_the_server(shop, worker, domain):
    from patient_bus import PatientBus
    from test_ros_action import comes, no_active_goal

    leaf = leaf_of(shop, Run(worker), input="0", seconds=600.0)
    with PatientBus("looks", domain_id=domain) as bus:
        leaf.tick_once()
        assert comes(bus, "active", 1)
        leaf.stop(Status.INVALID)
        assert no_active_goal(bus)


def test_a_preempted_node_ends_when_the_server_has_stopped(shop, worker, domain):
    from patient_bus import PatientBus
    from test_ros_action import comes

    run = Run(worker)
    leaf = leaf_of(shop, run, input="0", seconds=600.0)
    with PatientBus("looks", domain_id=domain) as bus:
        leaf.tick_once()
        assert comes(bus, "active", 1)
    run.preempt_requested = True
    assert run_to_end(leaf) == "failure"
    assert leaf.failure.code == "preempted"


def test_a_component_speaks_of_its_own_errors(worker):
    with pytest.raises(GoalAbortedError, match="component worker: the server aborted the goal"):
        ended(worker.call({"input": "abort", "seconds": 0.0}))
    with pytest.raises(GoalRejectedError):
        ended(worker.call({"input": "reject", "seconds": 0.0}))
    with pytest.raises(BadReplyError):
        ended(worker.call({"input": "7", "seconds": 0.0}))
    operation = worker.call({"input": "0", "seconds": 600.0})
    operation.cancel()
    with pytest.raises(CanceledError):
        ended(operation)


def test_the_end_of_its_process_fails_a_goal_with_its_status(worker):
    with pytest.raises(ServerLostError, match="'worker' ended with status 137"):
        ended(worker.call({"input": "die", "seconds": 0.0}))


def test_an_action_is_added_from_its_file_tested_and_listed(tmp_path, trial, capsys):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    file = DATA / "trial_interfaces" / "action" / "Work.action"
    command = ["component", "add", str(file), "--project", str(tmp_path), "--name", "worker", "--server", "/work"]
    assert main(command) == 1
    told = capsys.readouterr().err
    assert "their number and names are not declared; for instance: --outcomes 'done,failed'" in told
    assert main([*command, "--outcomes", "done,partly", "--failure", "partly"]) == 0
    home = tmp_path / "components" / "worker"
    assert (home / "interfaces" / "trial_interfaces" / "package.xml").is_file()
    assert main([*command, "--outcomes", "2"]) == 1
    assert "already exists" in capsys.readouterr().err
    shutil.copy(DATA / "action_server.py", home)
    text = (home / "component.yaml").read_text()
    started = 'start: {command: ["{python}", action_server.py, /work]}\n'
    (home / "component.yaml").write_text(text.split("# start:")[0] + started)
    assert main(["component", "add", str(home)]) == 0
    assert main(["component", "test", str(home)]) == 0
    assert "empty request: 'done' (0) after" in capsys.readouterr().out
    assert main(["component", "list", str(tmp_path)]) == 0
    assert "trial_interfaces/action/Work  /work  done, partly  (node up to date)" in capsys.readouterr().out


def test_what_runs_is_added_by_its_name(tmp_path, domain, trial, act, monkeypatch, capsys):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    act("/arm/work")
    monkeypatch.setenv("AMENT_PREFIX_PATH", sys.prefix)  # as in a shell that knows nothing of the type
    command = ["component", "add", "--from-graph", "arm/work", "--project", str(tmp_path), "--wait", "400"]
    assert main([*command, "--outcomes", "done,partly"]) == 1
    told = capsys.readouterr().err
    assert "/arm/work is of type trial_interfaces/action/Work, but no package 'trial_interfaces' is installed" in told
    assert "give the folder of its interface package: --interfaces FOLDER" in told
    assert main([*command, "--outcomes", "done,partly", "--interfaces", str(DATA / "trial_interfaces")]) == 0
    assert "action" in (tmp_path / "components" / "arm_work" / "node" / "README.md").read_text()
    assert main([*command[:2], "--from-graph", "/arm/work/counts", *command[4:]]) == 1
    assert "--outcomes 'done: success; failed: not success'" in capsys.readouterr().err
    assert main([*command[:2], "--from-graph", "/nobody", "--project", str(tmp_path), "--wait", "0.5"]) == 1
    assert "unknown service, action or topic '/nobody'" in capsys.readouterr().err


def test_somebody_elses_service_is_wrapped_by_rule(tmp_path, domain, serve):
    home = tmp_path / "components" / "switch"
    home.mkdir(parents=True)
    (home / "component.yaml").write_text(
        "name: switch\ninterface: std_srvs/srv/SetBool\nserver: /set\n"
        "outcomes: {on: success, off: not success}\nmeaning: {off: failure}\n"
        "fixed: {data: false}\nports: {said: {type: str, field: message}}\n"
    )
    serve("std_srvs/SetBool", "/set")
    assert main(["component", "add", str(home)]) == 0
    with start_components(tmp_path, ["switch"], domain) as components:
        assert ended(components.client("switch").call({})) == {"success": True, "said": ""}


def test_a_topic_is_waited_for_and_published(tmp_path, domain):
    for name, use in (("hear", "receive"), ("say", "publish")):
        home = tmp_path / "components" / name
        home.mkdir(parents=True)
        (home / "component.yaml").write_text(
            f"name: {name}\ninterface: geometry_msgs/msg/PointStamped\nserver: /point\nuse: {use}\n"
            "ports: {x: {type: float, field: point.x, unit: mm}, header: std_msgs/msg/Header}\ntimeouts: {call: 400}\n"
        )
        assert main(["component", "add", str(home)]) == 0
    with (
        start_components(tmp_path, ["hear"], domain) as hearing,
        start_components(tmp_path, ["say"], domain) as saying,
    ):
        heard = hearing.client("hear").call({})
        assert ended(saying.client("say").call({"x": 0.25})) == {}
        assert ended(heard)["x"] == pytest.approx(0.25)


def test_a_topic_that_nobody_publishes_times_out_and_says_so(bus):
    with pytest.raises(ServerTimeOutError, match=r"/silent: no message within 0\.2 s; it has no publisher"):
        ended(bus.reader("std_msgs/msg/String", "/silent").next(0.2))


def test_a_topic_of_another_type_says_so(bus):
    from std_msgs.msg import Bool

    bus.post(lambda: bus.node.create_publisher(Bool, "/talk", 1)).wait(PATIENCE)
    with pytest.raises(ServerTimeOutError, match="published as std_msgs/msg/Bool, not as std_msgs/msg/String"):
        ended(bus.reader("std_msgs/msg/String", "/talk").next(0.5))


@pytest.mark.parametrize(("reliable", "durable"), [(False, False), (True, False), (True, True)])
def test_a_reader_takes_what_the_publisher_offers(bus, reliable, durable):
    """Best-effort publishers are heard, and what was said before by those that keep it."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
    from std_msgs.msg import String

    profile = QoSProfile(
        depth=1,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if durable else DurabilityPolicy.VOLATILE,
    )
    publisher = bus.post(lambda: bus.node.create_publisher(String, "/talk", profile))
    talk = ended(publisher)
    if durable:
        ended(bus.post(lambda: talk.publish(String(data="before"))))
        assert ended(bus.reader("std_msgs/msg/String", "/talk").next(PATIENCE)).data == "before"
        return
    operation = bus.reader("std_msgs/msg/String", "/talk").next(PATIENCE)
    while not operation.done():
        ended(bus.post(lambda: talk.publish(String(data="now"))))
        time.sleep(0.02)
    assert ended(operation).data == "now"
    assert bus.reader("std_msgs/msg/String", "/talk").latest.message.data == "now"
