"""Real components in processes of their own, behind the port that leaves call."""

from __future__ import annotations

import shutil
import sys
import threading
import time

import numpy as np
import pytest
from patience import until
from py_trees.common import Status
from ros_bench import EXAMPLE, ended, gone, kill, session_of

from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.base.failures import BadReplyError, IncompatibleServerError, ServerLostError, ServerTimeOutError
from grip_bt.base.ports import Component
from grip_bt.base.values import Grasp, PointCloud
from grip_bt.ros.client.types import ConversionError
from grip_bt.ros.command import child_environment
from grip_bt.ros.components import start_components
from grip_bt.ros.interfaces import build_interfaces
from grip_bt.ros.process import Process
from grip_bt.task.catalog.catalog import load_implementation
from grip_bt.task.catalog.manifest import read_manifests

pytestmark = pytest.mark.ros
EMPTY = PointCloud(np.zeros((0, 3)))


def cylinder(x=0.5, y=0.1, radius=0.03, height=0.15, n=4000):
    rng = np.random.default_rng(1)
    angle, z = rng.uniform(0, 2 * np.pi, n), rng.uniform(0, height, n)
    return PointCloud(np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle), z], axis=1))


def wish(text):
    return {"input": PointCloud(np.zeros((1, 3)), frame=text)}


@pytest.fixture
def odd(project, domain):
    with start_components(project, ["odd"], domain) as components:
        yield components
    assert gone(components.process("odd").pid)


def test_a_component_answers_with_values(project, domain):
    with start_components(project, ["antipodal_grasps"], domain) as components:
        client = components.client("antipodal_grasps")
        assert isinstance(client, Component)
        assert ended(client.call({"input": EMPTY})) == {"outcome": 2, "returned_object": []}
        reply = ended(client.call({"input": cylinder()}))
        assert reply["outcome"] == 1
        assert all(isinstance(g, Grasp) and g.pose.frame == "world" for g in reply["returned_object"])
        best = reply["returned_object"][0]
        assert np.hypot(*(best.pose.position[:2] - [0.5, 0.1])) < 0.05
        session = components.process("antipodal_grasps").pid
        assert len(session_of(session)) == 2
    assert gone(session)


class Run:
    """As much of a run as a component's leaf asks for."""

    preempt_requested = False

    def __init__(self, components):
        self.component = components.client

    def left(self, path, work):
        """Nothing here takes its time to stop."""

    def unfinished(self):
        return ()

    def wake(self):
        pass


def test_the_generated_node_runs_against_the_live_server(project, domain):
    (manifest,) = read_manifests(EXAMPLE / "node" / "manifest.yaml")
    written = {}
    with start_components(project, ["antipodal_grasps"], domain) as components:
        for cloud, outcome, status in ((cylinder(), "several", Status.SUCCESS), (EMPTY, "none", Status.FAILURE)):
            leaf = load_implementation(manifest)("propose", "propose", manifest, {}, {})
            leaf.readers = {"input": lambda cloud=cloud: cloud}
            leaf.writers = {"returned_object": lambda grasps: written.update(grasps=grasps)}
            leaf.setup(context=Run(components))
            leaf.tick_once()
            until(lambda leaf=leaf: leaf.tick_once() or leaf.status is not Status.RUNNING, "it doesn't end")
            assert (leaf.outcome, leaf.status) == (outcome, status)
    assert len(written["grasps"]) > 5


def test_a_component_that_dies_in_the_middle_of_a_call_is_lost_at_once_with_its_last_words(odd):
    client = odd.client("odd")
    with pytest.raises(ServerLostError, match=r"'odd' ended with status 7; its last output.*\n.*that was too much"):
        ended(client.call(wish("die")))
    with pytest.raises(ServerLostError, match="status 7"):
        ended(client.call(wish("die")))


def test_a_component_that_dies_is_started_again_as_its_file_says(project, domain):
    file = project / "components" / "odd" / "component.yaml"
    file.write_text(file.read_text().replace("start:\n", "start:\n  restart: on_failure\n  restarts: 1\n"))
    with start_components(project, ["odd"], domain) as components:
        client, first = components.client("odd"), components.process("odd").pid
        with pytest.raises(ServerLostError, match="ended with status 7; start 2 follows; its last output"):
            ended(client.call(wish("die")))
        assert ended(client.call(wish("outcome2"))) == {"outcome": 2}
        assert components.process("odd").pid != first
        with pytest.raises(ServerLostError, match="ended with status 7 after 2 starts"):
            ended(client.call(wish("die")))
        with pytest.raises(ServerLostError, match="after 2 starts"):
            ended(client.call(wish("outcome2")))


def test_a_component_that_is_killed_in_the_middle_of_a_call_is_lost_at_once(odd):
    operation = odd.client("odd").call(wish("hang"))
    (server,) = set(session_of(odd.process("odd").pid)) - {odd.process("odd").pid}
    time.sleep(0.1)
    kill(server)
    with pytest.raises(ServerLostError, match="ended with status 137"):
        ended(operation)


@pytest.mark.parametrize("number", [3, -1, 100000])
def test_an_undeclared_outcome_is_a_bad_reply(odd, number):
    with pytest.raises(BadReplyError, match=rf"outcome {number} isn't one of the declared ones \(0 one, 1 several"):
        ended(odd.client("odd").call(wish(f"outcome{number}")))


def test_an_answer_that_is_no_value_is_a_bad_reply_with_its_field(odd):
    with pytest.raises(BadReplyError, match=r"response.returned_object\[0\]: the poses of a grasp"):
        ended(odd.client("odd").call(wish("two_frames")))


def test_what_comes_with_a_failure_outcome_need_not_be_a_value(odd):
    assert ended(odd.client("odd").call(wish("outcome2"))) == {"outcome": 2}


def test_a_component_that_hangs_times_out(odd, ahead):
    operation = odd.client("odd").call(wish("hang"))
    until(lambda: odd.client("odd").client.in_flight, "it isn't called")
    ahead.skip(1000.0)
    with pytest.raises(ServerTimeOutError, match="no response"):
        ended(operation)


def test_a_request_that_does_not_fit_names_the_field(odd):
    with pytest.raises(ConversionError, match="component odd: request.input: a int can't be made a sensor_msgs"):
        ended(odd.client("odd").call({"input": 3}))
    with pytest.raises(ConversionError, match=r"request.inptu.*did you mean 'input'"):
        ended(odd.client("odd").call({"inptu": EMPTY}))


def test_a_component_that_never_serves_is_lost_with_the_end_of_its_log(project, domain, ahead):
    server = project / "components" / "odd" / "server.py"
    server.write_text("print('warming up'); import time; time.sleep(600)")
    file, log = project / "components" / "odd" / "component.yaml", project / ".grip" / "logs" / "odd.log"
    file.write_text(file.read_text().replace("ready: 600", "ready: 1000"))

    def wait_then_skip() -> None:
        until(lambda: log.exists() and "warming up" in log.read_text())
        ahead.skip(1000.0)

    threading.Thread(target=wait_then_skip).start()
    with pytest.raises(ServerLostError, match=r"component odd: /odd: no server within 1000.0 s.*\nwarming up"):
        start_components(project, ["odd"], domain)


def test_a_component_that_ends_while_starting_is_lost_at_once_with_its_error(project, domain):
    (project / "components" / "odd" / "server.py").write_text("import no_such_module")
    with pytest.raises(ServerLostError, match="(?s)ended with status 1.*No module named 'no_such_module'"):
        start_components(project, ["odd"], domain)


def test_one_that_fails_to_start_takes_the_others_down(project, domain):
    (project / "components" / "odd" / "server.py").write_text("raise SystemExit(1)")
    with pytest.raises(ServerLostError, match="component odd"):
        start_components(project, ["antipodal_grasps", "odd"], domain)
    log = project / ".grip" / "logs" / "antipodal_grasps.log"
    assert log.exists()


@pytest.mark.slow
def test_a_server_built_from_another_definition_is_refused_at_once(project, domain, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(EXAMPLE / "interfaces", other)
    service = other / "antipodal_interfaces" / "srv" / "ProposeGrasps.srv"
    service.write_text(service.read_text().replace("int32 outcome", "int64 outcome"))
    (built,) = build_interfaces(other, tmp_path / "cache")
    home = project / "components" / "odd"
    file = home / "component.yaml"
    file.write_text(file.read_text().replace('start:\n  command: ["{python}", server.py]\n', ""))
    command = [sys.executable, "server.py"]
    process = Process("foreign", command, home, child_environment([built.prefix], domain), tmp_path / "log")
    try:
        with pytest.raises(IncompatibleServerError, match="a different definition of the response of antipodal"):
            start_components(project, ["odd"], domain)
    finally:
        process.stop()


def test_what_one_project_has_built_another_finds(project, domain):
    begun = list[str]()
    with start_components(project, ["odd"], domain, progress=lambda _, said: begun.append(said)) as components:
        assert components.build_seconds == 0.0
    assert begun == []


def test_an_unknown_component_is_named_with_those_there_are(project, domain):
    with pytest.raises(UnknownNameError, match=r"'antipodal_grasp'; did you mean 'antipodal_grasps'"):
        start_components(project, ["antipodal_grasp"], domain)


@pytest.mark.slow
def test_two_packages_of_one_name_that_differ_are_refused_before_anything_starts(project, domain):
    service = project / "components" / "odd" / "interfaces" / "antipodal_interfaces" / "srv" / "ProposeGrasps.srv"
    service.write_text(service.read_text() + "int32 more\n")
    told = r"'antipodal_interfaces', or one that it needs, differs from that of the component 'antipodal_grasps'"
    with pytest.raises(DocumentError, match=told):
        start_components(project, ["antipodal_grasps", "odd"], domain)
    assert not (project / ".grip" / "logs").exists()
