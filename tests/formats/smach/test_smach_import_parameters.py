"""Machines whose shape hangs on parameters of ROS: the default in the text is taken, and told."""

import sys
from types import SimpleNamespace

import pytest
from smach_runs import build_legacy, run_legacy, run_task, write

from grip_bt.cli.__main__ import main
from grip_bt.formats.smach import import_file

HEAD = """
import rospy
import smach

class Go(smach.State):
    def __init__(self, name):
        smach.State.__init__(self, outcomes=['there', 'lost'])
        self.name = name
    def execute(self, userdata):
        return 'there'

"""
ROOMS = """
def build():
    rooms = rospy.get_param('~rooms', ['bath', 'attic'])
    last = rospy.get_param('~last', default='home')
    sm = smach.StateMachine(outcomes=['done', 'lost'])
    with sm:
        for i, room in enumerate(rooms):
            after = rooms[i + 1].upper() if i + 1 < len(rooms) else last.upper()
            smach.StateMachine.add(room.upper(), Go(room), {'there': after})
        smach.StateMachine.add(last.upper(), Go(last), {'there': 'done'})
    return sm
"""


def read(tmp_path, text):
    file = tmp_path / "legacy_rooms.py"
    file.write_text(HEAD + text)
    return file, import_file(file)


def told(imported):
    return "\n".join(str(issue) for container in imported.containers for issue in container.issues)


def test_loops_labels_and_edges_go_by_the_defaults_and_say_so(tmp_path):
    _, imported = read(tmp_path, ROOMS)
    (container,) = imported.containers
    assert container.verdict == "partial"
    assert {label: each.transitions["there"] for label, each in container.added.items()} == {
        "BATH": "ATTIC",
        "ATTIC": "HOME",
        "HOME": "done",
    }
    for text in (
        "state 'BATH' is added in a loop: assumes `enumerate(rooms)` = [(0, 'bath'), (1, 'attic')], its default",
        "a label: assumes `last.upper()` = 'HOME'",
        "the transitions of 'ATTIC': assumes `after` = 'HOME'",
        "other ROS parameters, known only at run time, would give another machine",
    ):
        assert text in told(imported)


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_where_nobody_sets_the_parameters_the_task_does_what_the_machine_does(tmp_path, monkeypatch, target):
    unset = SimpleNamespace(get_param=lambda name, default=None: default)
    monkeypatch.setitem(sys.modules, "rospy", unset)
    file, _ = read(tmp_path, ROOMS)
    imported, paths = write(file, tmp_path)
    ((name, path),) = paths.items()
    outcome, ends, _ = run_task(path, target)
    assert (outcome, ends) == run_legacy(build_legacy(imported, name))
    assert [label for label, _ in ends] == ["BATH", "ATTIC", "HOME"]


def test_the_command_succeeds_and_says_how_to_import_it_with_the_real_ones(tmp_path, capsys):
    file, _ = read(tmp_path, ROOMS)
    assert main(["import", str(file), "--from", "smach"]) == 0
    out = capsys.readouterr().out
    assert "legacy_rooms.py: 1 partial" in out
    assert "to do: some values are known only at run time; if you trust the file, import it again with --execute" in out


@pytest.mark.parametrize(
    "outcomes", ["rospy.get_param('~ends', ['there', 'lost'])", "list(rospy.get_param('e', 'tl'))"]
)
def test_outcomes_that_have_a_default_are_those(tmp_path, outcomes):
    text = f"def build():\n    return smach.StateMachine(outcomes={outcomes})\n"
    _, imported = read(tmp_path, text)
    assert imported.containers[0].outcomes == (["there", "lost"] if "ends" in outcomes else ["t", "l"])
    assert "the outcomes of StateMachine: assumes `" in told(imported)


def test_what_only_goes_to_a_state_is_asked_for_in_the_run_and_nothing_is_assumed(tmp_path):
    text = """
def build():
    speed = rospy.get_param('~speed', 0.5)
    sm = smach.StateMachine(outcomes=['done', 'lost'])
    with sm:
        smach.StateMachine.add('GO', Go(speed), {'there': 'done'})
    return sm
"""
    _, imported = read(tmp_path, text)
    (container,) = imported.containers
    assert container.verdict == "exact"


@pytest.mark.parametrize(
    "label", ["rospy.get_param('~label')", "label_of(rospy.get_param('~label', 'a'))", "rospy.get_param('~label', x)"]
)
def test_without_a_default_that_the_text_gives_a_label_stays_unknown_and_nothing_is_made_twice(tmp_path, label):
    text = f"""
def label_of(name):
    made = smach.StateMachine(outcomes=['x'])
    return name + unknown()

def build():
    sm = smach.StateMachine(outcomes=['done', 'lost'])
    with sm:
        smach.StateMachine.add({label}, Go('a'), {{'there': 'done'}})
    return sm
"""
    _, imported = read(tmp_path, text)
    made = [c for c in imported.containers if c.verdict == "failed" and c.outcomes == ["done", "lost"]]
    assert (len(made), len(imported.containers)) == (1, 2)
    assert "of a state is known only at run time" in told(imported)


COUNTING = """
@smach.cb_interface(input_keys=['index', 'total'], output_keys=['total'], outcomes=['next'])
def add(userdata):
    userdata.total = userdata.total + userdata.index
    return 'next'

def build():
    sm = smach.StateMachine(outcomes=['done'])
    sm.userdata.total = 0
    with sm:
        each = smach.Iterator(outcomes=['done'], input_keys=['total'], output_keys=['total'],
                              it=lambda: ITEMS, it_label='index', exhausted_outcome='done')
        with each:
            smach.Iterator.set_contained_state('ADD', smach.CBState(add), loop_outcomes=['next'])
        smach.StateMachine.add('COUNT', each, {'done': 'done'})
    return sm
"""


@pytest.mark.parametrize("items", ["range(0, 5)", "list(range(3))", "range(4, 0, -2)", "[7, 8]"])
def test_an_iterator_over_a_range_does_what_smach_does(tmp_path, monkeypatch, items):
    monkeypatch.setitem(sys.modules, "rospy", SimpleNamespace())
    file, imported = read(tmp_path, COUNTING.replace("ITEMS", items))
    assert [container.verdict for container in imported.containers] == ["exact", "exact"]
    imported, paths = write(file, tmp_path)
    ((name, path),) = paths.items()
    outcome, ends, _ = run_task(path, "bt")
    legacy_outcome, legacy_ends = run_legacy(build_legacy(imported, name))
    assert outcome == legacy_outcome
    added = [end for end in ends if end[0].endswith("ADD")]
    assert len(added) == len([end for end in legacy_ends if end[0].endswith("ADD")]) == len(eval(items))


def test_an_iterator_over_a_range_of_python_2_is_read(tmp_path):
    _, imported = read(tmp_path, COUNTING.replace("ITEMS", "xrange(4, 0, -2)") + "    print 'built'\n")
    assert [container.verdict for container in imported.containers] == ["exact", "exact"]


@pytest.mark.parametrize("items", ["range(n)", "range(0, 5, 0)", "range(99999)", "range(1.5)", "sorted([2, 1])"])
def test_an_iterator_over_what_only_a_run_knows_is_left(tmp_path, items):
    _, imported = read(tmp_path, COUNTING.replace("ITEMS", items))
    assert f"its items are `lambda: {items}`, known only at run time" in told(imported)
