"""Building machines, and what they say about themselves, by the number of the probe."""

import copy
import pickle
import threading

import pytest
from smach_states import Returns, ok

from grip_bt.smach_compat import (
    Concurrence,
    InvalidConstructionError,
    InvalidStateError,
    InvalidTransitionError,
    Sequence,
    StateMachine,
    UserData,
)
from grip_bt.smach_compat.container import Container


def machine(state=None, transitions=None, outcomes=("ok",)):
    """Return a machine with one state A."""
    sm = StateMachine(list(outcomes))
    with sm:
        StateMachine.add("A", ok() if state is None else state, transitions)
    return sm


def test_an_empty_machine_executes_to_none(log):  # probe 21
    assert StateMachine(["ok"]).execute() is None
    assert log.at("err")


def test_an_unknown_target_is_logged_at_close_and_executes_to_none(log):  # probe 22
    sm = machine(transitions={"ok": "NOPE"})
    assert any("NOPE" in text for text in log.at("err"))
    assert sm.execute() is None


def test_a_transition_of_an_unregistered_outcome_is_refused():  # probe 23
    with pytest.raises(InvalidTransitionError, match="zzz"):
        machine(transitions={"zzz": "ok"})


def test_a_label_is_added_once():  # probe 24
    with StateMachine(["ok"]):
        StateMachine.add("A", ok())
        with pytest.raises(InvalidStateError, match="'A'"):
            StateMachine.add("A", ok())


def leave_by_an_error(sm, inside=lambda: None):
    with pytest.raises(ValueError, match="in the body"):
        fail_inside(sm, inside)


def fail_inside(sm, inside):
    with sm:
        inside()
        raise ValueError("in the body")


def test_an_error_in_the_body_closes_the_container(log, in_time):  # probe 25
    sm = StateMachine(["ok"])
    leave_by_an_error(sm)
    assert Container._construction_stack == []
    assert not sm.is_opened()
    assert any("in the body" in text for text in log.at("err"))
    with pytest.raises(InvalidStateError):
        StateMachine.add("LATE", ok())
    assert in_time(lambda: machine().execute()) == "ok", "the lock is free for other threads"


def test_an_error_in_the_body_also_closes_what_was_opened_inside():
    outer, inner = StateMachine(["ok"]), StateMachine(["ok"])
    leave_by_an_error(outer, inner.open)
    assert Container._construction_stack == []


def test_adding_needs_an_open_container():  # probe 26
    with pytest.raises(InvalidStateError):
        StateMachine.add("A", ok())


def test_adding_to_a_machine_needs_an_open_machine():  # probe 27
    with pytest.raises(InvalidStateError, match="Concurrence"), Concurrence(["a"], "a"):
        StateMachine.add("A", ok())


def test_unlisted_outcomes_are_added_to_the_callers_dict():  # probe 33
    transitions = {"ok": "done"}
    machine(Returns("ok", outcomes=["ok", "other"]), transitions, ["done", "other"])
    assert transitions == {"ok": "done", "other": None}


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda sm: pickle.loads(pickle.dumps(sm))])
def test_a_machine_can_be_copied(duplicate):  # probes 84 85
    sm = machine()
    sm.execute()
    twin = duplicate(sm)
    assert type(twin) is StateMachine
    assert twin["A"] is not sm["A"]
    assert twin.execute() == "ok"
    assert (twin["A"].runs, sm["A"].runs) == (2, 1)


def test_open_and_close_do_what_with_does():  # probe 86
    sm = StateMachine(["ok"])
    sm.open()
    sm.add("A", ok())
    sm.close()
    assert sm.execute() == "ok"


def test_only_the_innermost_container_can_be_closed():  # probe 87
    a, b = StateMachine(["ok"]), StateMachine(["ok"])
    a.open()
    b.open()
    with pytest.raises(InvalidStateError):
        a.close()


def test_an_unknown_label_is_a_key_error():  # probe 88
    with pytest.raises(KeyError):
        StateMachine(["ok"])["x"]


def test_an_idle_machine_describes_itself():  # probe 89
    sm = machine()
    assert sm.get_internal_edges() == [("ok", "A", None)]
    assert sm.get_active_states() == ["None"]
    assert sm.get_initial_states() == ["A"]


def test_a_container_may_be_opened_inside_itself():  # probe 90
    sm = StateMachine(["ok"])
    with sm, sm:
        StateMachine.add("A", ok())
    assert list(sm.get_children()) == ["A"]
    assert not sm.is_opened()


def test_add_returns_the_state():  # probe 91
    state = ok()
    with StateMachine(["ok"]):
        assert StateMachine.add("A", state) is state


def test_with_gives_no_name_to_the_container():  # probe 92
    with machine() as nothing:
        assert nothing is None


def test_opened_gives_a_name_and_adds_by_instance():
    sm = StateMachine(["ok"])
    with sm.opened() as same:
        same.add("A", ok())
        same.assert_opened()
    assert same is sm
    assert sm.execute() == "ok"
    with pytest.raises(InvalidConstructionError):
        sm.assert_opened("open it")


def test_an_empty_target_falls_through():  # probe 93
    assert machine(transitions={"ok": ""}).execute() == "ok"


def test_an_outcome_that_falls_nowhere_makes_the_machine_inconsistent(log):  # probe 94
    sm = machine(Returns("ok", outcomes=["ok", "other"]))
    assert sm.execute() is None
    assert any("other" in text for text in log.at("err"))


def test_the_first_label_is_initial_even_when_its_add_fails():
    sm = StateMachine(["ok"])
    with sm:
        with pytest.raises(InvalidTransitionError):
            StateMachine.add("A", ok(), {"zzz": "ok"})
        StateMachine.add("B", ok())
    assert sm.get_initial_states() == ["A"]
    assert sm.execute() is None


def test_a_connector_outcome_has_to_be_registered():  # probe 45
    sm = StateMachine(["ok"])
    with sm, pytest.raises(InvalidStateError, match="nope"):
        StateMachine.add_auto("A", ok(), ["nope"])
    assert list(sm.get_children()) == ["A"]


@pytest.mark.parametrize("explicit", [None, {"ok": "x"}])
def test_a_connector_leads_to_the_next_state_whatever_is_said(explicit):  # probes 46 47
    sm = StateMachine(["ok"])
    with sm:
        StateMachine.add_auto("A", ok(), ["ok"], explicit)
        StateMachine.add("B", ok())
    assert sm._transitions == {"A": {"ok": "B"}, "B": {"ok": None}}


def test_connectors_can_be_chained():
    sm = StateMachine(["ok"])
    with sm:
        for label in "AB":
            StateMachine.add_auto(label, ok(), ["ok"])
        StateMachine.add("C", ok())
        StateMachine.add("D", ok())
    assert [t["ok"] for t in sm._transitions.values()] == ["B", "C", None, None]


def test_the_initial_state_may_be_named_before_it_is_added():  # probe 48
    sm, more = StateMachine(["ok"]), UserData()
    more.x = 1
    sm.set_initial_state(["B"], more)
    with sm:
        StateMachine.add("A", ok())
        StateMachine.add("B", ok())
    assert sm.get_initial_states() == ["B"]
    assert sm.execute() == "ok"
    assert (sm["A"].runs, sm["B"].runs, sm.userdata.x) == (0, 1, 1)


def test_a_sequence_connects_and_keeps_what_is_bound():  # probe 51
    outcomes = ["ok", "fail"]
    seq = Sequence(outcomes, "ok")
    with seq:
        Sequence.add("A", Returns("ok", outcomes=outcomes))
        Sequence.add("B", Returns("ok", outcomes=outcomes), {"fail": "A"})
        Sequence.add("C", Returns("ok", outcomes=outcomes))
    assert seq._transitions == {
        "A": {"ok": "B", "fail": None},
        "B": {"fail": "A", "ok": "C"},
        "C": {"ok": None, "fail": None},
    }
    assert seq.execute() == "ok"


def test_a_sequence_stores_an_edge_for_an_outcome_that_the_state_lacks(log):  # probe 52
    seq = Sequence(["ok", "done"], "ok")
    with seq:
        Sequence.add("A", Returns("done"))
        Sequence.add("B", ok())
    assert seq._transitions == {"A": {"done": None, "ok": "B"}, "B": {"ok": None}}
    assert log.at("err")
    assert seq.execute() == "done"


def test_a_sequence_has_no_constants():  # probe 53
    with pytest.raises(TypeError), Sequence(["ok"], "ok"):
        Sequence.add("A", ok(), constants={"a": 1})


def test_a_plain_add_to_a_sequence_does_not_chain():
    seq = Sequence(["ok"], "ok")
    with seq:
        Sequence.add("A", ok())
        StateMachine.add("B", ok())
        Sequence.add("C", ok())
    assert [t["ok"] for t in seq._transitions.values()] == ["C", None, None]


def test_threads_that_build_machines_wait_for_each_other(in_time):
    opened, go_on = threading.Event(), threading.Event()
    slow, quick = StateMachine(["ok"]), StateMachine(["ok"])

    def build_slowly():
        with slow:
            opened.set()
            assert go_on.wait(120)
            StateMachine.add("SLOW", ok())

    def build_quickly():
        assert opened.wait(120)
        quick_is_waiting.set()
        with quick:
            StateMachine.add("QUICK", ok())

    quick_is_waiting = threading.Event()
    threads = [threading.Thread(target=work) for work in (build_slowly, build_quickly)]
    for thread in threads:
        thread.start()
    assert quick_is_waiting.wait(120)
    go_on.set()
    in_time(lambda: [thread.join() for thread in threads])
    assert (list(slow.get_children()), list(quick.get_children())) == (["SLOW"], ["QUICK"])
