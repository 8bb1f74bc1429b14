"""What an imported task says where SMACH stumbles over a preempt, and what is different in the ROS 2 profile."""

import threading

import pytest
from smach_lowerings import FORMS, PacedActivation, _await_arrival, _runner
from smach_probe_machines import HEAD
from smach_runs import write

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.cli.__main__ import main
from grip_bt.nodes import smach_leaf
from grip_bt.nodes.smach_source import load_legacy
from grip_bt.runtime import JournalReader
from grip_bt.smach_compat import configure
from grip_bt.smach_compat._settings import Settings, settings

TWO_TASKS = """def build():
    sm = smach.StateMachine({outcomes})
    with sm:
        smach.StateMachine.add('BOTH', both(), transitions={transitions})
    return sm


"""
TOGETHER = """def both():
    cc = smach.Concurrence({outcomes}, 'ok', outcome_map={{'ok': {{'A': 'ok'}}}})
    with cc:
        smach.Concurrence.add('A', Does(asks_and_serves))
        smach.Concurrence.add('B', Does(serve_ok))
    return cc


"""
EACH = """def both():
    it = smach.Iterator(['ok'], [], [], it=[1, 2, 3], it_label='x', exhausted_outcome='done')
    with it:
        smach.Iterator.set_contained_state('A', Does(asks, ['more', 'ok']), loop_outcomes=['ok']{final})
    return it


"""


@pytest.fixture(autouse=True)
def paced(monkeypatch):
    monkeypatch.setattr(smach_leaf, "Activation", PacedActivation)
    yield
    vars(settings).update(vars(Settings()))


def ended(folder, source, form):
    """Return how a task ends in which a state asks for a preempt."""
    file = folder / "asked.py"
    file.write_text(HEAD + source)
    _, paths = write(file, folder / "out")
    runner, leaves = _runner(paths["build"], form, 0)

    def request(state):
        runner.request_preempt()
        _await_arrival(runner, leaves)

    load_legacy(file).QUIRKS["request"] = request
    return runner.run()


def machine(both, outcomes, transitions):
    return both + TWO_TASKS.format(outcomes=outcomes, transitions=transitions)


@pytest.mark.parametrize("form", FORMS)
def test_a_preempted_concurrence_without_that_outcome_ends_the_task_with_what_to_do(form, tmp_path):
    source = machine(TOGETHER.format(outcomes=["ok"]), ["ok"], {})
    result = ended(tmp_path, source, form)
    assert "'preempted', which is none of its outcomes; add it to them" in str(result.error)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("profile", "wanted"), [("noetic", "preempted"), ("ros2", "ok")])
def test_a_concurrence_that_has_obeyed_is_preempted_and_goes_by_its_map_in_ros2(form, profile, wanted, tmp_path):
    configure(profile=profile)
    source = machine(TOGETHER.format(outcomes=["ok", "preempted"]), ["ok", "preempted"], {})
    result = ended(tmp_path, source, form)
    assert (result.error, result.outcome) == (None, wanted)


@pytest.mark.parametrize("form", FORMS)
def test_a_preempted_iterator_whose_state_ends_with_none_of_its_outcomes_says_so(form, tmp_path):
    source = EACH.replace("['ok']", "['done']", 1).replace("['more', 'ok']", "['ok']")
    result = ended(tmp_path, machine(source.format(final=""), ["done"], {}), form)
    assert "'ok', which is none of the Iterator's; say what it means in its final_outcome_map" in str(result.error)


@pytest.mark.parametrize("form", FORMS)
def test_a_preempted_iterator_ends_as_its_map_says(form, tmp_path):
    source = machine(EACH.format(final=", final_outcome_map={'ok': 'done', 'more': 'ok'}"), ["ok", "done"], {})
    result = ended(tmp_path, source, form)
    assert (result.error, result.outcome) == (None, "done")


RECOVERS = """
import threading
import smach

BEGUN = threading.Event()

class Work(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['done', 'preempted'])
        self.asked = threading.Event()
    def request_preempt(self):
        smach.State.request_preempt(self)
        self.asked.set()
    def execute(self, userdata):
        BEGUN.set()
        assert self.asked.wait(120)
        self.service_preempt()
        return 'preempted'

class Tidy(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['tidy', 'asked'])
    def execute(self, userdata):
        return 'asked' if self.preempt_requested() else 'tidy'

def build():
    sm = smach.StateMachine(outcomes=['succeeded', 'preempted'])
    with sm:
        smach.StateMachine.add('WORK', Work(), {'done': 'succeeded', 'preempted': 'TIDY'})
        smach.StateMachine.add('TIDY', Tidy(), {'tidy': 'preempted', 'asked': 'succeeded'})
    return sm
"""


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_a_request_that_was_obeyed_is_not_asked_again_in_a_fork(target, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "legacy_recovers.py").write_text(RECOVERS)
    assert main(["import", "legacy_recovers.py", "--from", "smach", "-o", "build.yaml"]) == 0
    journal = tmp_path / ".grip" / "runs.sqlite"
    with open_session(tmp_path / "build.yaml", RunOptions(robot="fake", target=target, journal=journal)) as session:
        begun = load_legacy(tmp_path / "legacy_recovers.py").BEGUN

        def ask():
            assert begun.wait(120)
            session.runner.request_preempt()

        asker = threading.Thread(target=ask)
        asker.start()
        assert session.runner.run().outcome == "preempted"
        asker.join(120)
    assert main(["run", "--fork", "last", "--at", "TIDY:enter", "--in-process"]) == 3
    with JournalReader(journal) as reader:
        new, _ = reader.runs()
        ends = [(e.path, e.outcome) for e in reader.events(new.id) if e.event == "exit"]
    assert ("TIDY", "tidy") in ends
