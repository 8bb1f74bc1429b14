"""What an imported task says where SMACH stumbles over a preempt, and what is different in the ROS 2 profile."""

import pytest
from smach_lowerings import FORMS, PacedActivation, _await_arrival, _runner
from smach_probe_machines import HEAD
from smach_runs import write

from grip_bt.nodes import smach_leaf
from grip_bt.nodes.smach_source import load_legacy
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
