"""`grip run --stand-ins`: a legacy task runs where its packages, servers and parameters are missing, and names them."""

import importlib
import itertools
import os
import re
import subprocess
import sys
import threading
import time

import pytest

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.nodes import dry_run as dry_run_module
from grip_bt.nodes.dry_run import dry_run
from grip_bt.nodes.smach_source import LegacyFinder, LegacySubmodules
from grip_bt.nodes.stand_ins import StandInFinder
from grip_bt.smach_compat import State, StateMachine

LEGACY = """
import numpy
import rospy
import smach
import smach_ros
from robot_of_ours.arms import NOT_SEEN, Arm, Rest
from robot_of_ours.msg import LiftAction, LiftGoal
from robot_of_ours.srv import Weigh


class Weighed(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["light", "heavy"], output_keys=["weight"])
        self.arm = Arm(rospy.get_param("/arm/side"))
        self.weigh = rospy.ServiceProxy("weigh", Weigh)

    def execute(self, userdata):
        rospy.wait_for_service("weigh")
        rospy.sleep(1000.0)
        userdata.weight = 3
        return "light" if self.weigh(self.arm.name).ok else "heavy"


class Aimed(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["lost", "aimed"])
        self.arm = Arm("right")

    def execute(self, userdata):
        assert list(numpy.array([self.arm.x, 1.0]) * 2) == [0.0, 2.0]
        return "aimed" if max(self.arm.scores) > 3 else "lost"


class Watched(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=[NOT_SEEN, "seen"])

    def execute(self, userdata):
        while not rospy.is_shutdown():
            pass
        return NOT_SEEN


def build():
    sm = smach.StateMachine(outcomes=["succeeded", "aborted", "preempted"])
    with sm:
        smach.StateMachine.add("REST", Rest(), {"failed": "aborted", "rested": "WEIGH"})
        smach.StateMachine.add("WEIGH", Weighed(), {"light": "AIM", "heavy": "aborted"})
        smach.StateMachine.add("AIM", Aimed(), {"lost": "aborted", "aimed": "WATCH"})
        smach.StateMachine.add("WATCH", Watched(), {NOT_SEEN: "aborted", "seen": "LIFT"})
        smach.StateMachine.add("LIFT", smach_ros.SimpleActionState("lift", LiftAction, goal=LiftGoal(speed=1)))
    return sm
"""
LEAVES = """
from pathlib import Path

from grip_bt.nodes.smach_construction import built_in
from grip_bt.nodes.smach_leaf import SmachLeaf
from grip_bt.nodes.smach_source import load_legacy

FILE = Path(__file__).parents[2] / "legacy.py"
legacy = load_legacy(FILE)


def machine():
    return built_in(FILE, LINE, legacy.build)


class Rest(SmachLeaf):
    def make(self):
        return self.built(machine)["REST"]


class Weigh(SmachLeaf):
    def make(self):
        return self.built(machine)["WEIGH"]


class Aim(SmachLeaf):
    def make(self):
        return self.built(machine)["AIM"]


class Watch(SmachLeaf):
    def make(self):
        return self.built(machine)["WATCH"]


class Lift(SmachLeaf):
    def make(self):
        return self.built(machine)["LIFT"]
"""
LEAVES = LEAVES.replace("LINE", str(LEGACY[: LEGACY.index("sm = smach")].count("\n") + 1))
MANIFEST = """
- id: smach/legacy/Rest
  doc: Rests.
  implementation: leaves.py:Rest
  outcomes: {failed: failure, rested: success}
- id: smach/legacy/Weigh
  doc: Weighs.
  implementation: leaves.py:Weigh
  outputs: {weight: {type: Any, on: [light, heavy]}}
  outcomes: {light: success, heavy: failure}
- id: smach/legacy/Aim
  doc: Aims.
  implementation: leaves.py:Aim
  outcomes: {lost: failure, aimed: success}
- id: smach/legacy/Watch
  doc: Watches.
  implementation: leaves.py:Watch
  outcomes: {_robot_of_ours_arms_NOT_SEEN_: failure, seen: success}
- id: smach/legacy/Lift
  doc: Lifts.
  implementation: leaves.py:Lift
  outcomes: {succeeded: success, aborted: failure, preempted: failure}
"""
TASK = """
grip: 1
name: lift
data: {weight: Any}
outcomes: {succeeded: success, aborted: failure, preempted: failure}
root:
  kind: state_machine
  initial: REST
  outcomes: {succeeded: success, aborted: failure, preempted: failure}
  children:
    REST: {node: smach/legacy/Rest, on: {failed: aborted, rested: WEIGH}}
    WEIGH: {node: smach/legacy/Weigh, out: {weight: weight}, on: {light: AIM, heavy: aborted}}
    AIM: {node: smach/legacy/Aim, on: {lost: aborted, aimed: WATCH}}
    WATCH: {node: smach/legacy/Watch, on: {_robot_of_ours_arms_NOT_SEEN_: aborted, seen: LIFT}}
    LIFT: {node: smach/legacy/Lift, on: {succeeded: succeeded, aborted: aborted, preempted: preempted}}
"""
STOOD_IN_FOR = ["action /lift", "package robot_of_ours", "parameter /arm/side", "service /weigh"]
WENT_ON = ["outcome aimed of Aimed: ValueError: ", "outcome seen of Watched: WaitingError: "]


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dry")
    (folder / "nodes" / "smach_legacy").mkdir(parents=True)
    for name, text in {
        "grip.yaml": "grip: 1\n",
        "legacy.py": LEGACY,
        "lift.yaml": TASK,
        "nodes/smach_legacy/leaves.py": LEAVES,
        "nodes/smach_legacy/manifest.yaml": MANIFEST,
    }.items():
        (folder / name).write_text(text)
    return folder


@pytest.mark.parametrize("words", [["--stand-ins"], ["--robot", "fake", "--as", "sm"]], ids=" ".join)
def test_a_legacy_task_runs_to_its_end_and_each_stand_in_is_named(project, words):
    command = [sys.executable, "-m", "grip_bt.cli", "run", "lift.yaml", "--in-process", *words]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].startswith("success: succeeded")
    named = re.findall(r"^  stand-in +(.+)$", done.stderr, re.MULTILINE)
    outcomes = [each for each in named if each.startswith("outcome")]
    assert sorted(each for each in named if each not in outcomes) == STOOD_IN_FOR
    assert [said.startswith(words) for said, words in zip(outcomes, WENT_ON, strict=True)] == [True, True]


def test_without_it_the_run_says_which_package_is_missing(project):
    command = [sys.executable, "-m", "grip_bt.cli", "run", "lift.yaml", "--in-process"]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, timeout=600)
    assert done.returncode != 0
    assert "it needs 'robot_of_ours', which isn't installed here; a dry run does without it: grip run" in done.stderr


def test_a_dry_run_leaves_the_process_as_it_was(project):
    before = list(sys.meta_path), set(sys.modules)
    with open_session(project / "lift.yaml", RunOptions(stand_ins=True, robot="fake")) as session:
        assert session.runner.run().status == "success"
    assert [f for f in sys.meta_path if f not in before[0] and not isinstance(f, LegacyFinder | LegacySubmodules)] == []
    assert not [name for name in set(sys.modules) - before[1] if name.startswith(("robot_of_ours", "rospy", "smach."))]


def test_a_mistake_of_a_states_own_stays_one_where_nothing_is_stood_in_for(capsys):
    told = []
    with dry_run(told.append):
        state = Mistaken(outcomes=["done"])
        with pytest.raises(ZeroDivisionError):
            state.execute(None)
        module = importlib.import_module("package_of_nobody")
        with pytest.raises(ZeroDivisionError):  # nothing of the package is near
            state.execute(None)
        state.arm = module.arm
        assert state.execute(None) == "done"
        del state.arm
        assert bool(module.arm)  # from now on, any value may come from it
        assert state.execute(None) == "done"
        state.bottles = None
        with pytest.raises(ImportError):
            state.execute(None)
    assert told[0] == "package package_of_nobody"
    assert told[1].startswith("outcome done of Mistaken: ZeroDivisionError")
    assert type(state).execute is Mistaken.execute


def test_a_state_that_waits_for_an_event_in_vain_ends_and_others_wait_as_always(monkeypatch):
    monkeypatch.setattr(dry_run_module, "LONGEST_WAIT", 0.01)
    told = []
    with dry_run(told.append):
        importlib.import_module("package_of_nobody")
        state = Waiting(outcomes=["timed_out", "opened"])
        assert state.execute(None) == "opened"
        threading.Timer(0.05, state.opened.set).start()
        assert state.opened.wait()
    assert told[1].startswith("outcome opened of Waiting: WaitingError")


def test_a_state_that_ends_alike_without_end_takes_another_outcome():
    told = []
    with dry_run(told.append):
        importlib.import_module("package_of_nobody")
        state = Closed(outcomes=["closed", "opened"])
        ends = [state.execute(None) for _ in range(dry_run_module.MOST_ALIKE + 1)]
    assert ends == ["closed"] * dry_run_module.MOST_ALIKE + ["opened"]
    assert told[1] == "outcome opened of Closed: it has ended 100 times with closed"


def test_states_that_go_round_take_every_way_in_time_and_sleep_without_taking_any():
    told, machine = [], StateMachine(outcomes=["finished"])
    with dry_run(told.append), machine:
        importlib.import_module("package_of_nobody")
        StateMachine.add("LOOK", Turning(["seen", "nothing", "left"]), {"seen": "GO", "nothing": "LOOK", "left": "GO"})
        StateMachine.add(
            "GO", Turning(["there", "back", "over"]), {"there": "LOOK", "back": "LOOK", "over": "finished"}
        )
        assert machine.execute() == "finished"
    assert any("times with" in each for each in told)


class Turning(State):
    def __init__(self, outcomes):
        super().__init__(outcomes=outcomes)
        self.turns = itertools.cycle(outcomes[:2])

    def execute(self, userdata):
        time.sleep(1000.0)
        return next(self.turns)


class Closed(State):
    def execute(self, userdata):
        return "closed"


class Waiting(State):
    def execute(self, userdata):
        self.opened = threading.Event()
        self.opened.wait()
        return "timed_out"


class Mistaken(State):
    bottles = 0

    def execute(self, userdata):
        if self.bottles is None:
            from json import bottles_of_nobody  # noqa: F401
        return "done" if 1 / self.bottles else "done"


def test_what_an_installed_library_can_do_without_stays_missing(tmp_path, monkeypatch):
    library = tmp_path / "site-packages" / "library_of_others.py"
    library.parent.mkdir()
    library.write_text("try:\n    import faster_of_others\n    FAST = True\nexcept ImportError:\n    FAST = False\n")
    (tmp_path / "code_of_ours.py").write_text("import driver_of_others\nimport library_of_others\n")
    finder = StandInFinder()
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, finder])
    monkeypatch.setattr(sys, "path", [str(tmp_path), str(library.parent), *sys.path])
    ours = importlib.import_module("code_of_ours")
    assert finder.packages == ["driver_of_others"]
    assert ours.library_of_others.FAST is False
    for name in ("code_of_ours", "library_of_others", "driver_of_others"):
        monkeypatch.delitem(sys.modules, name)


def test_a_package_of_python_2_runs_with_all_its_modules(project, tmp_path):
    package = tmp_path / "workspace" / "old_robot"
    (package / "src" / "old_robot" / "utils").mkdir(parents=True)
    (package / "manifest.xml").write_text("<package/>")
    for folder in ("old_robot", "old_robot/utils"):
        (package / "src" / folder / "__init__.py").write_text("")
    (package / "src" / "old_robot" / "utils" / "labels.py").write_text('print "labels"\nDONE = "done"\n')
    legacy = package / "nodes" / "run.py"
    legacy.parent.mkdir()
    legacy.write_text("from old_robot.utils.labels import DONE\n")
    script = "import sys; from pathlib import Path; from grip_bt.nodes.smach_source import load_legacy; "
    script += "sys.stdout.write(load_legacy(Path(sys.argv[1]), ros=False).DONE)"
    done = subprocess.run([sys.executable, "-c", script, str(legacy)], capture_output=True, text=True, timeout=600)
    assert done.stdout == "labels\ndone", done.stderr


def test_the_master_of_ros_1_has_an_address(monkeypatch):
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    with dry_run(lambda what: None):
        assert os.environ["ROS_MASTER_URI"].startswith("http://")
    assert "ROS_MASTER_URI" not in os.environ


def test_what_an_installed_package_of_messages_had_in_ros_1_is_stood_in_for(tmp_path, monkeypatch):
    package = tmp_path / "site-packages" / "ours_msgs"
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    monkeypatch.syspath_prepend(package.parent)
    told = []
    with dry_run(told.append):
        importlib.import_module("ours_msgs.point_cloud2").read_points()
    assert told == ["package ours_msgs"]
    for name in ("ours_msgs", "ours_msgs.point_cloud2"):
        sys.modules.pop(name, None)


def test_a_program_that_ends_by_a_shutdown_doesnt_end_the_run_before_it_begins_but_a_state_does():
    with dry_run(lambda what: None):
        rospy = importlib.import_module("rospy")
        rospy.spin()
        rospy.signal_shutdown("the program ended")
        assert not rospy.is_shutdown()

        class Off(State):
            def execute(self, ud):
                rospy.signal_shutdown("the state wants it")
                return "succeeded"

        assert Off(outcomes=["succeeded"]).execute(None) == "succeeded"
        assert rospy.is_shutdown()


def test_an_input_that_stands_in_ends_when_it_is_gone_through():
    with dry_run(lambda what: None):
        objects = importlib.import_module("robot_of_ours").objects

        class Counted(State):
            def execute(self, ud):
                return "one" if [each for each in itertools.islice(ud.objects, 9)] else "none"

        sm = StateMachine(outcomes=["one", "none"], input_keys=["objects"])
        with sm:
            StateMachine.add("COUNT", Counted(outcomes=["one", "none"], input_keys=["objects"]))
        sm.userdata.objects = objects
        assert sm.execute() == "none"
