"""Nobody answers: what is served instead, and what to do, is told with it."""

from __future__ import annotations

from pathlib import Path

import pytest
from patience import PATIENCE, until
from ros_bench import ended

import grip_bt.ros  # noqa: F401 - its settings come before any message package
from grip_bt.catalog.component_file import ComponentFile
from grip_bt.catalog.component_parts import Start
from grip_bt.errors import ServerLostError, ServerTimeOutError, UnfitServerError
from grip_bt.ros.advice import advice
from grip_bt.ros.components import start_components
from grip_bt.ros.goal import Goal, Patience
from grip_bt.ros.others import instead
from grip_bt.ros.packages import PackageError
from grip_bt.ros.starting import command_of

pytestmark = pytest.mark.ros
SET, TRIGGER = "std_srvs/srv/SetBool", "std_srvs/srv/Trigger"


def component(**more):
    file = {"name": "c", "interface": SET, "server": "/set", "outcomes": {"done": "success"}, **more}
    return ComponentFile.model_validate(file)


@pytest.mark.parametrize(
    ("services", "actions", "said"),
    [
        ([], [], " (services in ROS_DOMAIN_ID 7: none)"),
        ([("/sett", [SET])], [], f"; {SET} is served in ROS_DOMAIN_ID 7 as /sett"),
        ([("/sett", [TRIGGER])], [], "; did you mean '/sett'? (services in ROS_DOMAIN_ID 7: /sett)"),
        ([], [("/set", ["p/action/Set"])], "; /set is an action, of type p/action/Set"),
        ([(f"/other{i}", [TRIGGER]) for i in range(12)], [], "/other4, /other5 and 4 more)"),
    ],
)
def test_what_is_served_instead_is_told(services, actions, said):
    assert instead("/set", SET, services, actions, 7).endswith(said)


def test_an_action_that_is_a_service_is_told_so():
    said = instead("/plan", "p/action/Plan", [("/plan", ["p/srv/Plan"])], [], 0)
    assert said == "; /plan is a service, of type p/srv/Plan"


def test_who_waits_in_vain_is_told_who_serves_the_type(bus, serve):
    serve("std_srvs/SetBool", "/other/set")
    ended(bus.service(SET, "/other/set").wait_ready(PATIENCE))
    with pytest.raises(ServerLostError, match=rf"/set: no server within 0\.2 s; {SET} is served in .* as /other/set"):
        ended(bus.service(SET, "/set").wait_ready(0.2))


def test_a_goal_that_waits_in_vain_is_told_that_its_name_is_a_service(bus, serve, trial):
    serve("std_srvs/SetBool", "/set")
    ended(bus.service(SET, "/set").wait_ready(PATIENCE))
    client = bus.action("trial_interfaces/action/Work", "/set")
    with pytest.raises(ServerLostError, match=rf"/set: no server within 0\.2 s; /set is a service, of type {SET}"):
        ended(client.wait_ready(0.2))


def test_a_time_out_names_the_key_that_limits_it(bus, serve, ahead):
    serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    client.limit = " (`timeouts: {call: 0.2}` in component.yaml of c)"
    ended(client.wait_ready(PATIENCE))
    operation = client.call(client.type.Request(data=True), timeout=1000.0)
    until(lambda: client.in_flight, "it isn't sent")
    ahead.skip(1000.0)
    with pytest.raises(ServerTimeOutError, match=r"/set: no answer after .* s \(`timeouts: \{call: 0\.2\}` in comp"):
        ended(operation)
    goal = Goal("/act", Patience(server=2.0, result=1.0, limit=" (said there)"), 0.0)
    assert str(goal.tick(1.5)[0].end) == "/act: the goal wasn't sent after 1.5 s (said there)"


LOST, ENDED = ServerLostError("", server="/set", waited=3.0), ServerLostError("", server="/set")
OURS, THEIRS = {"command": ["{python}", "server.py"]}, {"command": ["python3", "server.py"]}


@pytest.mark.parametrize(
    ("start", "error", "alive", "said", "todo"),
    [
        (None, LOST, False, "", ". Start it, or say under `start` how it is started (component.yaml of c)"),
        ({**OURS, "run": False}, LOST, False, "", "take `run: false` out of its `start`"),
        (OURS, LOST, True, "", "Its process runs: does it serve /set (`server`), as std_srvs/srv/SetBool"),
        (None, UnfitServerError("", serves=TRIGGER), False, "", f". If that is meant: `interface: {TRIGGER}`"),
        (None, UnfitServerError("", serves=SET), False, "", ""),
        (THEIRS, ENDED, False, "No module named 'rclpy'", "'python3' is a Python without ROS or the built interfaces"),
        (OURS, ENDED, False, "No module named 'torch'", "'torch' isn't installed for the Python that runs it"),
        (OURS, ENDED, False, "", "A server runs until it is stopped; this one ended by itself."),
        (OURS, ENDED, False, "ValueError: no model", ""),
    ],
)
def test_what_to_do_follows_from_how_it_is_started_and_what_it_said(start, error, alive, said, todo):
    made = advice(component(start=start), error, alive, said)
    assert (todo in made) if todo else made == ""


def test_a_component_that_nobody_started_says_how_to(tmp_path, domain):
    home = tmp_path / "components" / "set_it"
    home.mkdir(parents=True)
    (home / "component.yaml").write_text(
        f"name: set_it\ninterface: {SET}\nserver: /set\noutcomes: {{done: success}}\ntimeouts: {{ready: 0.2}}\n"
    )
    said = r"component set_it: /set: no server within 0\.2 s \(services in .*: none\)\. Start it, or say under `start`"
    with pytest.raises(ServerLostError, match=said):
        start_components(tmp_path, ["set_it"], domain)


def test_a_misspelt_placeholder_is_told_when_the_file_is_read():
    with pytest.raises(ValueError, match=r"command: \{pyton\} isn't known; `\{python\}` is the Python that runs GRIP"):
        component(start={"command": ["{pyton}", "server.py"]})


def test_a_launch_file_that_is_not_there_is_told_before_anything_starts(tmp_path):
    (tmp_path / "launch").mkdir()
    (tmp_path / "launch" / "start.launch.xml").write_text("<launch/>")
    with pytest.raises(PackageError, match=r"no launch file 'start.launch.xml' in .*did you mean 'launch/start"):
        command_of(Start(launch="start.launch.xml"), Path(tmp_path))
