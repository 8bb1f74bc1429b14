"""Nobody answers: what is served instead, and what to do, is told with it."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import pytest
from patience import PATIENCE, until
from ros_bench import ended

import grip_bt.ros  # noqa: F401 - its settings come before any message package
from grip_bt.base.failures import IncompatibleServerError, ServerLostError, ServerTimeOutError
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.goal import Ask, Goal, GoalTimeouts
from grip_bt.ros.client.graph import in_words
from grip_bt.ros.client.types import load_type
from grip_bt.ros.command import advice, command_of
from grip_bt.ros.components import start_components
from grip_bt.ros.interface import RosInterface
from grip_bt.ros.interfaces.packages import PackageError
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.start import Start

pytestmark = pytest.mark.ros
SET, TRIGGER = "std_srvs/srv/SetBool", "std_srvs/srv/Trigger"


def component(**more):
    file = {"name": "c", "interface": SET, "server": "/set", "outcomes": {"done": "success"}, **more}
    return ComponentFile.model_validate(file)


def test_who_waits_in_vain_is_told_who_serves_the_type(bus, serve):
    serve("std_srvs/SetBool", "/other/set")
    ended(bus.service(SET, "/other/set").wait_ready(PATIENCE))
    with pytest.raises(ServerLostError, match=rf"/set: no server within 0\.2 s; served in .*: /other/set \({SET}\)"):
        ended(bus.service(SET, "/set").wait_ready(0.2))


def test_a_goal_that_waits_in_vain_is_told_that_its_name_is_a_service(bus, serve, trial):
    serve("std_srvs/SetBool", "/set")
    ended(bus.service(SET, "/set").wait_ready(PATIENCE))
    client = bus.action("trial_interfaces/action/Work", "/set")
    with pytest.raises(ServerLostError, match=rf"/set: no server within 0\.2 s; served in .*: /set \({SET}\)"):
        ended(client.wait_ready(0.2))
    with pytest.raises(ServerLostError, match=rf"; served in .*: /set \({SET}\)"):
        ended(bus.service(TRIGGER, "/sett").wait_ready(0.2))


def test_a_time_out_names_the_key_that_limits_it(bus, serve, ahead):
    serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    limit = " (`timeouts: {call: 0.2}` in component.yaml of c)"
    ended(client.wait_ready(PATIENCE))
    operation = client.call(client.type.Request(data=True), timeout=1000.0, limit=limit)
    until(lambda: client.in_flight, "it isn't sent")
    ahead.skip(1000.0)
    with pytest.raises(ServerTimeOutError, match=r"/set: no response after .* s \(`timeouts: \{call: 0\.2\}` in comp"):
        ended(operation)
    goal = Goal("/act", GoalTimeouts(result=1.0, cancel=1.0, limit=" (said there)"), 0.0, 0.0)
    assert goal.tick(1.5) == [Ask.CANCEL]
    assert "/act: the server did not accept the goal after 1.0 s (said there), and" in str(goal.tick(2.5)[0].end)


LOST, ENDED = ServerLostError("", server="/set", waited=3.0), ServerLostError("", server="/set")
OURS, THEIRS = {"command": ["{python}", "server.py"]}, {"command": ["python3", "server.py"]}


@pytest.mark.parametrize(
    ("start", "error", "alive", "said", "todo"),
    [
        (
            None,
            LOST,
            False,
            "",
            "say under `start` how it is started, without `run: false` (component.yaml of c)",
        ),
        ({**OURS, "run": False}, LOST, False, "", "without `run: false`"),
        (OURS, LOST, True, "", "Its process runs: does it serve /set (`server`), as std_srvs/srv/SetBool"),
        (None, IncompatibleServerError("", serves=TRIGGER), False, "", f". If that is meant: `interface: {TRIGGER}`"),
        (None, IncompatibleServerError("", serves=SET), False, "", ""),
        (THEIRS, ENDED, False, "No module named 'rclpy'", "'rclpy' isn't installed for the Python in `command`"),
        (OURS, ENDED, False, "No module named 'torch'", "'torch' isn't installed for the Python in `command`"),
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
    said = r"/set: no server within 0\.2 s; nothing of its kind is served in .*\. Start it, or say under `start`"
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


IMAGE, STRING = "sensor_msgs/msg/Image", "std_msgs/msg/String"


@pytest.mark.parametrize(
    ("wanted", "there", "said"),
    [
        (IMAGE, [], "; nothing of its kind is published in ROS_DOMAIN_ID 7"),
        (
            IMAGE,
            [("/z", [IMAGE]), ("/cam/color/image", [IMAGE]), ("/s", [STRING])],
            f"; published in ROS_DOMAIN_ID 7: /cam/color/image ({IMAGE}), /z ({IMAGE}), /s ({STRING})",
        ),
        (
            IMAGE,
            [("/a", [STRING]), ("/cam/imag", [STRING]), ("/z", [IMAGE])],
            f": /z ({IMAGE}), /cam/imag ({STRING}), /a ({STRING})",
        ),
        (IMAGE, [(f"/q{i}", [STRING]) for i in range(12)], f"/q7 ({STRING}) and 4 more"),
        (STRING, [("/z", [STRING]), ("/cam/image", ["std_srvs/srv/Trigger"])], f"Trigger), /z ({STRING})"),
        ("", [("/a", [IMAGE]), ("/cam/image_raw", [IMAGE])], f": /cam/image_raw ({IMAGE}), /a ({IMAGE})"),
    ],
)
def test_which_topics_there_are_instead_is_told_the_likeliest_first(wanted, there, said):
    assert in_words("/cam/image", wanted, there, "published", 7).endswith(said)


def test_of_what_is_heard_the_words_are_others():
    assert in_words("/a", IMAGE, [("/q", [STRING])], "heard", 7) == (f"; heard in ROS_DOMAIN_ID 7: /q ({STRING})")


@pytest.fixture
def published(domain):
    """Return a function that publishes a topic in a context of its own, and waits until a bus sees it."""
    with ExitStack() as stack:

        def publish(bus: Bus, type_: str, name: str) -> None:
            kind, count = load_type(type_), lambda: bus.node.count_publishers(name)
            before, other = ended(bus.post(count)), stack.enter_context(Bus("other", domain_id=domain))
            ended(other.post(lambda: other.node.create_publisher(kind, name, 1)))
            until(lambda: ended(bus.post(count)) > before, f"{name} isn't seen")

        yield publish


def test_who_waits_for_a_topic_that_nobody_publishes_is_told_those_that_are(bus, published):
    published(bus, STRING, "/cam/words")
    published(bus, "std_msgs/msg/Bool", "/lamp")
    ros = RosInterface(bus)
    said = r"no message within 0\.2 s; it has no publisher; published in .*: /cam/words \(std_msgs/msg/String\), "
    with pytest.raises(ServerTimeOutError, match=f"/words: {said}"):
        ended(ros.next("/words", STRING, "Any", 0.2))
    with pytest.raises(ServerTimeOutError, match=r"no publisher; published in .*: /cam/words \(std_msgs/msg/Str"):
        ended(ros.recent("/cam/wrds", IMAGE, "Any", 0.0, 0.2))
    several = r"on /a/far \(it has no publisher; published in .*: /.*\), /lam \(it has no .*: .*/lamp"
    with pytest.raises(ServerTimeOutError, match=several):
        ended(ros.together({"/a/far": IMAGE, "/lam": STRING}, 0.1, 0.2))


def test_a_topic_of_another_type_is_told_with_what_to_do(bus, published):
    published(bus, STRING, "/cam/words")
    published(bus, IMAGE, "/cam/image")
    wrong = "/cam/image: .*it is published as sensor_msgs/msg/Image, not as std_msgs/msg/String; name that type, or ano"
    with pytest.raises(ServerTimeOutError, match=wrong + r"ther topic; published in .*: /cam/words \(std_"):
        ended(RosInterface(bus).next("/cam/image", STRING, "Any", 0.2))
    published(bus, STRING, "/cam/image")
    with pytest.raises(ServerTimeOutError, match="but no message arrived; others publish it as sensor_msgs/msg/Image$"):
        ended(RosInterface(bus).next("/cam/image", STRING, "Any", 0.2))


def test_a_topic_that_is_a_service_is_told_so(bus, serve):
    serve("std_srvs/SetBool", "/set")
    ended(bus.service(SET, "/set").wait_ready(PATIENCE))
    with pytest.raises(ServerTimeOutError, match=rf"no publisher; /set itself is {SET}; nothing of its kind is pub"):
        ended(RosInterface(bus).next("/set", STRING, "Any", 0.2))


def test_who_publishes_to_nobody_is_told_what_is_heard(bus, domain):
    with Bus("hearer", domain_id=domain) as hearer:
        kind = load_type(STRING)
        ended(hearer.post(lambda: hearer.node.create_subscription(kind, "/say", print, 1)))
        until(lambda: ended(bus.post(lambda: bus.node.count_subscribers("/say"))), "the subscriber isn't seen")
        ros = RosInterface(bus)
        with pytest.raises(ServerTimeOutError, match=rf"1 are needed; heard in .*: /say \({STRING}\)"):
            ended(ros.publish("/sya", STRING, {"data": "x"}, 1, 0.2))
        with pytest.raises(ServerTimeOutError, match=f"; it is subscribed to as {STRING}, not as std_msgs/msg/Bool"):
            ended(ros.publish("/say", "std_msgs/msg/Bool", {"data": True}, 1, 0.2))
