"""Packages as Python 2 had them: modules import their neighbours by name, and strings have functions."""

import pytest
from smach_runs import record, texts, write_recorded

from grip_bt.cli.__main__ import main

CHECK = """
import smach


class Check(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes={!r})

    def execute(self, ud):
        return {!r}
"""
PICK = """
import rospy, smach
from checks import Check
import names, tools.grippers


class Pick(smach.StateMachine):
    def __init__(self):
        smach.StateMachine.__init__(self, outcomes=['done'])
        with self:
            smach.StateMachine.add('CHECK', Check(), {'done': names.NEXT})
            smach.StateMachine.add('TAKE', Check(), {'done': 'done'})
"""
BOTH = """
import smach
from one.pick import Pick
from checks import Check
from two.names import NEXT


def build():
    sm = smach.StateMachine(outcomes=['done', 'lost'])
    with sm:
        smach.StateMachine.add('PICK', Pick(), {'done': NEXT})
        smach.StateMachine.add('LOOK', Check(), {'seen': 'done', 'lost': 'lost'})
    return sm
"""


def package(folder, name, **files):
    """Write a package of ROS with a package of Python of the same name."""
    inner = folder / name / "src" / name
    for each in (inner, inner / "tools"):
        each.mkdir(parents=True)
        (each / "__init__.py").touch()
    (folder / name / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (inner / "tools" / "grippers.py").touch()
    for module, text in files.items():
        (inner / f"{module}.py").write_text(text)
    return inner


@pytest.fixture
def two(tmp_path):
    """The second package's machine holds the first one's; modules have the same names, one that of its package."""
    lab = tmp_path / "lab"  # the folders of other tests aren't of one workspace with it
    package(lab, "one", pick=PICK, checks=CHECK.format(["done"], "done"), names="NEXT = 'TAKE'\n", one="")
    checks = CHECK.format(["seen", "lost"], "seen")
    return package(lab, "two", both=BOTH, checks=checks, names="NEXT = 'LOOK'\n", two="")


@pytest.mark.parametrize("whole", [False, True], ids=["around the file", "the folder that is given"])
def test_modules_of_one_name_in_two_packages_stay_apart(two, whole, tmp_path):
    found = record(two / "both.py", root=tmp_path / "lab" if whole else None)
    assert [(each.cls, each.verdict) for each in found.containers] == [("StateMachine", "exact"), ("Pick", "exact")]
    outer, pick = found.containers
    assert pick.added["CHECK"].state.outcomes == ["done"]
    assert outer.added["LOOK"].state.outcomes == ["seen", "lost"]


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_they_stay_apart_when_the_task_runs(two, target, tmp_path):
    _, written = write_recorded(two / "both.py", tmp_path / "tasks")
    (task,) = written.values()
    assert main(["run", str(task), "--as", target, "--robot", "fake"]) == 0


def test_a_folder_in_a_workspace_finds_what_lies_in_others(two, tmp_path, capsys):
    assert main(["import", str(tmp_path / "lab/two"), "--from", "smach", "--execute", "--report"]) == 0
    assert capsys.readouterr().out.startswith("both.py: 2 exact")


OLD = """
import string
import roslib, rosparam, rospy, smach
from smach_ros.simple_action_state import SimpleActionState
from std_msgs.msg import String

for values, ns in rosparam.load_file(roslib.packages.get_pkg_dir('old') + '/rooms.yaml', default_namespace='/old'):
    rosparam.upload_params(ns, values)


class Old(smach.StateMachine):
    def __init__(self, what='go to'):
        smach.StateMachine.__init__(self, outcomes=['succeeded', 'preempted', 'aborted'])
        with self:
            for room in rospy.get_param('/old/rooms'):
                name = string.replace(what, ' ', '_') + room if string.find(what, ' ') > 0 else room
                smach.StateMachine.add(name, SimpleActionState(room, String), {'succeeded': 'succeeded'})
"""


def test_names_that_were_elsewhere_or_are_gone_are_there(tmp_path):
    inner = package(tmp_path / "lab", "old", machine=OLD)
    (tmp_path / "lab/old/rooms.yaml").write_text("rooms: [hall, bath]\n")
    found = record(inner / "machine.py")
    assert [(each.verdict, list(each.added)) for each in found.containers] == [("exact", ["go_tohall", "go_tobath"])], (
        texts(found)
    )


INNER = """
import smach


class Looks(smach.StateMachine):
    def __init__(self):
        smach.StateMachine.__init__(self, outcomes=['done'])

    def execute(self, ud):
        return 'done'


class All(smach.Concurrence):
    def __init__(self):
        smach.Concurrence.__init__(self, outcomes=['done'], default_outcome='done', child_termination_cb=self.ended)
        with self:
            smach.Concurrence.add('LOOKS', Looks())

    def ended(self, outcomes):
        return True
"""


def test_what_smach_would_refuse_matters_only_where_a_task_takes_its_place(tmp_path):
    """A machine without states whose class has an `execute` of its own, in one that runs as it is."""
    file = tmp_path / "inner.py"
    file.write_text(INNER)
    found = record(file)
    verdicts = [(each.cls, each.verdict) for each in found.containers]
    assert verdicts == [("All", "exact"), ("Looks", "exact")], texts(found)
    _, written = write_recorded(file, tmp_path / "tasks")
    (task,) = written.values()
    assert main(["run", str(task), "--robot", "fake"]) == 0
