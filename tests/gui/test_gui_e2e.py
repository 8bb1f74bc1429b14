"""The editor in a real browser, over real runs: `grip edit` and Chromium."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from http.cookiejar import CookieJar
from pathlib import Path
from urllib.request import HTTPCookieProcessor, Request, build_opener

import pytest
from study_world import write_greeter, write_world

E2E = Path(__file__).parents[2] / "gui" / "e2e"
SCENARIO = 1800.0
"""After this long a scenario hangs [s]: a loaded machine is slow, and a page that waits in vain ends it earlier."""
CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
SHORT = """\
grip: 1
name: short
doc: Waits, a failure that is mended, and a machine.
data: {reached: {type: int, value: 0}}
root:
  kind: sequence
  children:
    first: {node: flow/wait, with: {seconds: 0.5}}
    attempts:
      kind: fallback
      children:
        broken: {node: flow/fail, with: {code: no_plan, message: the way is blocked}}
        second: {node: test/count, in: {value: reached}, out: {value: reached}}
    machine:
      kind: state_machine
      initial: a
      outcomes: {done: success}
      children:
        a: {node: flow/wait, with: {seconds: 0.3}, on: {success: b}}
        b: {node: test/count, in: {value: reached}, out: {value: reached}, on: {success: done}}
"""
LONG = """\
grip: 1
name: long
root:
  kind: parallel
  children:
    one: {node: flow/wait, with: {seconds: 600}}
    two: {node: flow/wait, with: {seconds: 500}}
"""
MANIFEST = """\
id: test/count
doc: Add one.
implementation: count.py:Count
inputs: {value: {type: int}}
outputs: {value: {type: int}}
outcomes: {success: success}
"""
COUNT = """\
from grip_bt.nodes import Leaf


class Count(Leaf):
    def update(self):
        return self.end(value=self.read("value") + 1)
"""

ARM = """\
<robot name="small">
  <link name="base"/>
  <link name="one"><visual><geometry><box size="0.05 0.05 0.3"/></geometry></visual></link>
  <link name="two"><visual><geometry><box size="0.05 0.05 0.3"/></geometry></visual></link>
  <joint name="a" type="revolute">
    <parent link="base"/><child link="one"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/>
  </joint>
  <joint name="b" type="revolute">
    <parent link="one"/><child link="two"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/>
  </joint>
</robot>
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A project with a short task, a long one and a node of its own."""
    folder = tmp_path / "project"
    for name, text in {
        "grip.yaml": "grip: 1\n",
        "tasks/short.yaml": SHORT,
        "tasks/long.yaml": LONG,
        "nodes/count/manifest.yaml": MANIFEST,
        "nodes/count/count.py": COUNT,
    }.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@contextmanager
def editing(folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run `grip edit` on a free port; yield its process and the address that it printed."""
    command = [sys.executable, "-m", "grip_bt.cli", "edit", str(folder), "--no-browser"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        url = next((line.strip() for line in server.stdout if "http://" in line), None)
        assert url is not None, server.stderr.read() if server.stderr else ""
        yield server, url
    finally:
        if server.poll() is None:
            server.send_signal(signal.SIGINT)
        try:
            server.communicate(timeout=600)
        except subprocess.TimeoutExpired:
            server.kill()
            server.communicate()
            raise


def run_processes(server: subprocess.Popen[str]) -> list[int]:
    """Return the ids of processes that execute a task for a server."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0") if entry.name.isdigit() else []
            if b"grip_bt.app.runs.process" in words:
                parent = (entry / "stat").read_text().rpartition(")")[2].split()[1]
                found += [int(entry.name)] if int(parent) == server.pid else []
        except OSError:
            continue
    return found


def wait_for(condition: Callable[[], object], patience: float = 600.0) -> None:
    """Wait until something holds; fails after `patience` [s]."""
    deadline = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.02)


def browser(script: str, url: str, *more: str) -> list[str]:
    """Return the command that drives the page, or skip with the reason why it can't be."""
    if shutil.which("node") is None:
        pytest.skip("NOT RUN: Node isn't installed")
    if not Path(CHROMIUM).exists():
        pytest.skip(f"NOT RUN: no Chromium at {CHROMIUM}; apt install chromium, or set CHROMIUM")
    if not (E2E / "node_modules" / "playwright-core").is_dir():
        pytest.skip("NOT RUN: the browser driver isn't installed; npm ci in gui/e2e")
    return ["node", str(E2E / script), url, *more]


@pytest.mark.e2e
@pytest.mark.slow
@pytest.mark.parametrize(
    "script",
    [
        "run_and_scrub.mjs",
        "pause_and_stop.mjs",
        "debug.mjs",
        "control.mjs",
        "accessibility.mjs",
        "axe_everywhere.mjs",
        "touch.mjs",
        "presence.mjs",
        "panes.mjs",
        "by_ear.mjs",
    ],
)
def test_the_page_in_a_browser(folder: Path, script: str) -> None:
    with editing(folder) as (server, url):
        done = subprocess.run(browser(script, url), capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr
        wait_for(lambda: not run_processes(server))


@pytest.mark.e2e
@pytest.mark.slow
@pytest.mark.parametrize(
    "script",
    [
        "edit_tree.mjs",
        "edit_flow.mjs",
        "edit_text.mjs",
        "subtasks.mjs",
        "choices.mjs",
        "forms.mjs",
        "nested_flow.mjs",
        "near.mjs",
        "in_sight.mjs",
        "edit_while_paused.mjs",
        "typing.mjs",
        "scale.mjs",
    ],
)
def test_tasks_are_edited_in_a_browser(folder: Path, script: str) -> None:
    with editing(folder) as (_, url):
        done = subprocess.run(browser(script, url, str(folder)), capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.e2e
@pytest.mark.slow
@pytest.mark.sim
@pytest.mark.parametrize("script", ["first_run.mjs", "hand_on_arm.mjs"])
def test_a_newcomer_comes_from_an_empty_folder_to_a_hand_that_holds_something(tmp_path: Path, script: str) -> None:
    folder = tmp_path / "empty"
    folder.mkdir()
    with editing(folder) as (_, url):
        command = browser(script, url, str(folder))
        done = subprocess.run(command, capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.e2e
@pytest.mark.slow
@pytest.mark.sim
@pytest.mark.ros
def test_what_a_node_needs_is_offered_when_it_is_added(
    tmp_path: Path, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An arm, a hand and a component, from an empty project to a run."""
    folder = tmp_path / "project"
    folder.mkdir()
    write_greeter(tmp_path / "lab")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with editing(folder) as (_, url):
        done = subprocess.run(browser("offers.mjs", url, str(folder)), capture_output=True, text=True, timeout=SCENARIO)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.e2e
@pytest.mark.slow
@pytest.mark.sim
def test_every_screen_can_be_used_by_everybody_in_light_and_dark(tmp_path: Path) -> None:
    """With `SCREENS`, a folder, pictures of all of them are written there, at 1280x720 and 1920x1080."""
    folder, robots = tmp_path / "empty", tmp_path / "robots"
    folder.mkdir()
    robots.mkdir()
    (robots / "arm.urdf").write_text(ARM)
    with editing(folder) as (_, url):
        pictures = [os.environ["SCREENS"]] if "SCREENS" in os.environ else []
        command = browser("screens.mjs", url, str(folder), str(robots), *pictures)
        done = subprocess.run(command, capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.e2e
@pytest.mark.slow
@pytest.mark.sim
@pytest.mark.ros
@pytest.mark.parametrize("tasks", ["1,2", "3", "4"])
def test_the_user_study_is_done_within_its_actions(
    tmp_path: Path, tasks: str, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Task 3 by keys alone.

    With `STUDY_OUT`, a folder, all is done by mouse, and transcripts and pictures are written there, of which
    `docs/study.md` is made.
    """
    folder = tmp_path / "project"
    folder.mkdir()
    write_world(tmp_path / "lab")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with (
        subprocess.Popen([sys.executable, str(tmp_path / "lab" / "kinect2.py")]) as kinect,
        editing(folder) as (_, url),
    ):
        by_keys = ["keys"] if tasks == "3" and "STUDY_OUT" not in os.environ else []
        command = browser("study.mjs", url, str(folder), tasks, *by_keys)
        done = subprocess.run(command, capture_output=True, text=True, timeout=SCENARIO)
        kinect.terminate()
    assert done.returncode == 0, done.stdout + done.stderr
    if by_keys:
        heard, written = (
            heard_in(done.stdout),
            heard_in(STUDY.read_text().partition("```text\n")[2].partition("\n```")[0]),
        )
        assert heard[0] == written[0]
        assert written[1] <= heard[1]


STUDY = Path(__file__).parents[2] / "docs" / "study.md"


def heard_in(transcript: str) -> tuple[list[str], set[str]]:
    """Return what was pressed and said of where the focus is, in order, and what live regions told at some time.

    How a run goes on is told as often as the machine has time for.
    """
    lines = [line for line in transcript.splitlines() if not line.startswith("{")]
    told = {line for line in lines if line.startswith("  (") and "What works now" not in line}
    return [line for line in lines if not line.startswith("  (")], told


@pytest.mark.e2e
@pytest.mark.slow
def test_every_page_sees_a_run_and_its_sudden_death(folder: Path) -> None:
    with editing(folder) as (server, url):
        pages = subprocess.Popen(
            browser("two_pages.mjs", url), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert pages.stdout is not None
        if pages.stdout.readline().strip() == "RUNNING":
            (process,) = run_processes(server)
            os.kill(process, signal.SIGKILL)
        out, err = pages.communicate(timeout=SCENARIO)
        assert pages.returncode == 0, out + err


@pytest.mark.e2e
@pytest.mark.slow
def test_a_page_outlives_its_server(folder: Path) -> None:
    with editing(folder) as (server, url):
        page = subprocess.Popen(
            browser("server_gone.mjs", url),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert page.stdin is not None
        assert page.stdout is not None
        with ExitStack() as again:
            while page.stdout.readline().strip() == "READY":
                server.kill()
                server.wait()
                print("KILLED", file=page.stdin, flush=True)
                if page.stdout.readline().strip() != "WAITS":
                    break
                server, same = again.enter_context(editing(folder))
                assert same == url
                print("BACK", file=page.stdin, flush=True)
            out, err = page.communicate(timeout=SCENARIO)
        assert page.returncode == 0, out + err


@pytest.mark.slow
def test_ctrl_c_ends_the_editor_and_the_run_that_it_started(folder: Path) -> None:
    with editing(folder) as (server, url):
        origin = url.split("/?")[0]
        opener = build_opener(HTTPCookieProcessor(CookieJar()))
        opener.open(url).close()
        body = b'{"task": "tasks/long.yaml", "robot": "fake", "target": "bt", "seed": 0, "pace": 1}'
        headers = {"origin": origin, "content-type": "application/json"}
        opener.open(Request(f"{origin}/api/session", body, headers)).close()
        wait_for(lambda: run_processes(server))
        (process,) = run_processes(server)
        server.send_signal(signal.SIGINT)
        _, err = server.communicate(timeout=600)
        assert server.returncode == 0, err
        assert "Traceback" not in err
        assert not Path(f"/proc/{process}").exists()


@pytest.mark.e2e
@pytest.mark.slow
@pytest.mark.ros
def test_a_project_is_put_together_in_a_browser(folder: Path) -> None:
    with editing(folder) as (_, url):
        done = subprocess.run(browser("setup.mjs", url, str(folder)), capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr


SEER = """\
name: seer
doc: Says what lies where.
interface: std_srvs/srv/Trigger
server: /see
outcomes: [found, none]
meaning: {none: failure}
"""


@pytest.mark.e2e
@pytest.mark.slow
def test_each_page_of_a_project_marks_mistakes_and_saves_what_it_shows(folder: Path) -> None:
    (folder / "grip.yaml").write_text("grip: 1\n# the one in the lab\nrobot: panda_allegro\n", encoding="utf-8")
    (folder / "components" / "seer").mkdir(parents=True)
    (folder / "components" / "seer" / "component.yaml").write_text(SEER, encoding="utf-8")
    with editing(folder) as (_, url):
        done = subprocess.run(browser("pages.mjs", url, str(folder)), capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr


LEGACY = """\
import smach


class Step(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["done"])

    def execute(self, userdata):
        return "done"


def make():
    machine = smach.StateMachine(outcomes=["finished"])
    with machine:
        smach.StateMachine.add("FIRST", Step(), transitions={"done": "SECOND"})
        smach.StateMachine.add("SECOND", Step(), transitions={"done": "finished"})
    return machine
"""


@pytest.mark.e2e
@pytest.mark.slow
def test_a_legacy_machine_is_imported_converted_edited_and_run_in_a_browser(folder: Path, tmp_path: Path) -> None:
    legacy = tmp_path / "two_steps.py"
    legacy.write_text(LEGACY)
    with editing(folder) as (_, url):
        command = browser("import_smach.mjs", url, str(folder), str(legacy))
        done = subprocess.run(command, capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.e2e
@pytest.mark.slow
@pytest.mark.ros
@pytest.mark.sim
def test_a_first_task_from_nothing_takes_eighty_actions_at_most(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    examples = Path(__file__).parents[2] / "examples" / "components" / "antipodal_grasps"
    home = tmp_path / "project" / "components" / "antipodal_grasps"
    shutil.copytree(examples / "interfaces", home / "interfaces")
    for source in examples.glob("*.py"):
        shutil.copy(source, home)
    (tmp_path / "project" / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "project" / "tasks").mkdir()
    with editing(tmp_path / "project") as (_, url):
        command = browser("first_task.mjs", url, str(tmp_path / "project"))
        done = subprocess.run(command, capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr
        with capsys.disabled():
            sys.stdout.write(f"\na first task from nothing: {done.stdout.strip()}\n")


def test_a_wrong_path_is_told_and_ends_with_1(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "grip_bt.cli", "edit", str(tmp_path / "nothing"), "--no-browser"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 1
    assert "does not exist; give a project folder" in done.stderr
