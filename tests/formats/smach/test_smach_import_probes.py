"""The probes of SMACH's corner cases, on imported machines in each form, whatever number of ticks a leaf takes."""

import pytest
from smach_lowerings import FORMS, PacedActivation, run_imported
from smach_probe_machines import ELSEWHERE, ERROR, HEAD, PROBES
from smach_runs import write

from grip_bt import smach_compat
from grip_bt.nodes import smach_leaf
from grip_bt.nodes.smach_source import load_legacy

ALL = 95


@pytest.fixture(autouse=True)
def paced(monkeypatch):
    monkeypatch.setattr(smach_leaf, "Activation", PacedActivation)


def compat(file, before):
    """Return what the machine itself ends with, None after an error, and what its states have seen."""
    quiet = lambda text: None  # noqa: E731
    smach_compat.set_loggers(quiet, quiet, quiet, quiet)
    legacy = load_legacy(file)
    legacy.SEEN.clear()
    machine = legacy.build()

    def request(state):
        machine.request_preempt()
        while not state.preempt_requested():  # a Concurrence asks from its own thread
            pass

    legacy.QUIRKS["request"] = request
    for _ in range(before):
        machine.request_preempt()
    try:
        outcome = machine.execute()
    except Exception:  # noqa: BLE001 - the classes are tested with smach_compat
        outcome = None
    return outcome, list(legacy.SEEN)


@pytest.mark.parametrize("number", range(len(PROBES)), ids=lambda n: "-".join(map(str, PROBES[n][0])))
def test_a_probe_ends_as_upstream_does_in_each_form(number, tmp_path):
    _, before, wanted, source = PROBES[number]
    file = tmp_path / "probe.py"
    file.write_text(HEAD + source)
    _, paths = write(file, tmp_path / "out")
    outcome, seen = compat(file, before)
    assert outcome == wanted
    for form in FORMS:
        for pace in (0, 1, 2):
            legacy = load_legacy(file)
            legacy.SEEN.clear()
            ended = run_imported(
                paths["build"], form, pace, before, lambda ask, legacy=legacy: legacy.QUIRKS.update(request=ask)
            )
            assert ended == wanted, (form, pace)
            what, ran = sorted(map(repr, seen)), sorted(map(repr, legacy.SEEN))
            # an error ends a task at once, and a Concurrence when the others have ended
            assert ran == what or (wanted is ERROR and set(ran) <= set(what)), (form, pace)


def test_every_probe_is_run_here_or_has_a_reason_why_no_task_can_show_it():
    run = {row for rows, *_ in PROBES for row in rows}
    told = [row for rows in ELSEWHERE.values() for row in rows]
    assert run | set(told) == set(range(1, ALL + 1))
    assert not run & set(told)
    assert len(told) == len(set(told))
