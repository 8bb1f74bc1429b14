"""Concurrences, by the number of the probe. Everything runs under a time limit: where upstream hangs, this must not."""

import sys
import threading

import pytest
from smach_states import Does, Returns, WaitsForPreempt, ok, raises

from grip_bt.smach_compat import (
    Concurrence,
    InvalidStateError,
    InvalidUserCodeError,
    StateMachine,
    UserData,
    configure,
)


def concurrence(children, outcomes=("a",), default="a", **kwargs):
    cc = Concurrence(list(outcomes), default, **kwargs)
    with cc:
        for label, state in children.items():
            Concurrence.add(label, state)
    return cc


@pytest.mark.parametrize(
    "arguments",
    [
        {"default_outcome": None},  # probe 54
        {"default_outcome": "b"},  # probe 55
        {"default_outcome": "a", "outcome_map": {"z": {}}},  # probe 56
        {"default_outcome": "a", "outcome_cb": "not callable"},
        {"default_outcome": "a", "child_termination_cb": "not callable"},
    ],
)
def test_a_policy_that_cannot_work_is_refused(arguments):
    with pytest.raises(InvalidStateError):
        Concurrence(["a"], **arguments)


def test_a_map_of_an_unknown_child_is_a_key_error_at_close():  # probe 57
    with pytest.raises(KeyError):
        concurrence({"A": ok()}, outcome_map={"a": {"NOPE": "x"}})


def test_a_map_of_an_unknown_outcome_is_logged_and_never_holds(log, in_time):  # probe 58
    cc = concurrence({"A": ok()}, ["a", "b"], outcome_map={"b": {"A": "zz"}})
    assert any("zz" in text for text in log.at("err"))
    assert in_time(cc.execute) == "a"


@pytest.mark.parametrize("profile", ["noetic", "ros2"])
def test_a_concurrence_without_children_cannot_be_executed(profile, in_time):  # probe 59
    configure(profile=profile)
    with pytest.raises(InvalidStateError):
        in_time(concurrence({}).execute)


def test_an_error_of_a_child_stops_the_others_and_is_raised(in_time, log):  # probe 60
    a, b = raises(RuntimeError("boom")), WaitsForPreempt()
    cc = concurrence({"A": a, "B": b})
    cc.register_output_keys(["x"])
    cc.userdata.x, parent = 1, UserData()
    ended = []
    cc.register_termination_cb(lambda *args: ended.append(args))
    with pytest.raises(InvalidStateError, match="boom"):
        in_time(lambda: cc.execute(parent))
    assert (parent._data, ended) == ({}, [])
    assert sum("boom" in text for text in log.at("err")) == 1
    assert a.preempt_requested(), "its own flag is set too, and not taken back"
    assert in_time(concurrence({"A": ok(), "B": ok()}).execute) == "a"


def test_an_error_of_a_child_is_user_code_for_the_parent(in_time):
    sm = StateMachine(["a"])
    with sm:
        StateMachine.add("C", concurrence({"A": raises(RuntimeError()), "B": ok()}))
    with pytest.raises(InvalidUserCodeError):
        in_time(sm.execute)


def test_a_child_that_returns_none_is_an_error_and_no_hang(in_time):  # probe 61
    b = WaitsForPreempt()
    cc = concurrence({"A": Returns(None, outcomes=["ok"]), "B": b})
    with pytest.raises(InvalidStateError, match="'A'"):
        in_time(cc.execute)
    assert not b.preempt_requested()


def test_an_error_of_the_termination_callback_is_raised_and_no_hang(in_time):  # probe 62
    def fail(outcomes):
        raise RuntimeError("in the callback")

    cc = concurrence({"A": ok(), "B": WaitsForPreempt()}, child_termination_cb=fail)
    with pytest.raises(InvalidUserCodeError, match="in the callback"):
        in_time(cc.execute)


@pytest.mark.parametrize("interrupt", [KeyboardInterrupt, SystemExit])
def test_an_interrupt_of_a_child_passes_through(interrupt, in_time):
    cc = concurrence({"A": raises(interrupt()), "B": WaitsForPreempt()})
    with pytest.raises(interrupt):
        in_time(cc.execute)


def test_children_may_return_what_they_have_not_registered(in_time):  # probe 63
    assert in_time(concurrence({"A": Returns("weird", outcomes=["ok"])}).execute) == "a"


@pytest.mark.parametrize(("chosen", "outcome"), [("zzz", "zzz"), (None, "a"), ("", "a"), (5, "a")])  # probe 64
def test_the_outcome_callback_has_the_last_word_if_it_says_a_name(chosen, outcome, in_time):
    assert in_time(concurrence({"A": ok()}, outcome_cb=lambda outcomes: chosen).execute) == outcome


def test_an_error_of_the_outcome_callback_is_user_code(in_time):  # probe 65
    cc = concurrence({"A": ok()}, outcome_cb=lambda outcomes: outcomes["NOPE"])
    with pytest.raises(InvalidUserCodeError):
        in_time(cc.execute)


def test_any_true_value_of_the_termination_callback_stops_all(in_time):  # probe 66
    final = []
    b, c = WaitsForPreempt(), WaitsForPreempt()
    cc = concurrence(
        {"A": ok(), "B": b, "C": c},
        child_termination_cb=lambda outcomes: ["B"],
        outcome_cb=lambda outcomes: final.append(outcomes),
    )
    assert in_time(cc.execute) == "a"
    assert final == [{"A": "ok", "B": "pre", "C": "pre"}]


def test_the_termination_callback_sees_the_outcomes_so_far(in_time):
    release, seen = threading.Event(), []

    def note(outcomes):
        seen.append(dict(outcomes))
        release.set()
        return False

    late = Does(lambda ud: None if release.wait(120) else "never")
    assert in_time(concurrence({"A": ok(), "B": late}, child_termination_cb=note).execute) == "a"
    assert seen == [{"A": "ok", "B": None}, {"A": "ok", "B": "ok"}]


def test_a_label_added_twice_is_replaced(in_time):  # probe 67
    cc = Concurrence(["a"], "a")
    first, second = ok(), ok()
    with cc:
        Concurrence.add("A", first)
        Concurrence.add("A", second)
    assert list(cc.get_children()) == ["A"]
    in_time(cc.execute)
    assert (first.runs, second.runs) == (0, 1)


@pytest.mark.parametrize(("profile", "outcome"), [("noetic", "preempted"), ("ros2", "a")])
def test_a_preempt_that_no_child_holds_is_serviced(profile, outcome, in_time):  # probe 68
    configure(profile=profile)
    cc = concurrence({"A": ok()})
    cc.request_preempt()
    assert in_time(cc.execute) == outcome
    assert not cc.preempt_requested()


def test_a_preempt_that_a_child_ignores_stays(in_time):  # probe 69
    state = WaitsForPreempt(services=False)
    cc = concurrence({"A": state})
    preempter = threading.Thread(target=lambda: (state.begun.wait(120), cc.request_preempt()))
    preempter.start()
    assert in_time(cc.execute) == "a"
    preempter.join(120)
    assert cc.preempt_requested()
    assert not state.preempt_requested(), "it was taken back"


@pytest.mark.parametrize(
    ("profile", "order", "outcome"),
    [("noetic", "bc", "c"), ("noetic", "cb", "c"), ("ros2", "bc", "c"), ("ros2", "cb", "b")],
)
def test_the_most_constrained_entry_of_the_map_wins(profile, order, outcome, in_time):  # probe 70
    configure(profile=profile)
    entries = {"b": {"A": "ok"}, "c": {"A": "ok", "B": "ok"}}
    cc = concurrence({"A": ok(), "B": ok()}, "abc", outcome_map={name: entries[name] for name in order})
    assert in_time(cc.execute) == outcome


@pytest.mark.parametrize(("profile", "outcome"), [("noetic", "a"), ("ros2", "b")])
def test_an_entry_without_constraints_never_holds(profile, outcome, in_time):  # probe 71
    configure(profile=profile)
    assert in_time(concurrence({"A": ok()}, "ab", outcome_map={"b": {}}).execute) == outcome


def test_userdata_can_be_set_for_the_next_execution(log):  # probe 72
    cc, more = concurrence({"A": ok()}), UserData()
    more.x = 1
    cc.set_initial_state(["x"], more)
    assert cc.userdata.x == 1
    assert log.at("warn")


def test_an_unserviced_request_of_the_termination_callback_outlives_the_execution(in_time):
    waits = WaitsForPreempt(services=False)
    cc = concurrence({"A": ok(), "B": waits}, child_termination_cb=lambda outcomes: True)
    assert in_time(cc.execute) == "a"
    assert waits.preempt_requested()


def test_children_share_one_userdata_through_their_remappings(in_time):
    def write(ud):
        ud.out = ud.x + 1

    cc = Concurrence(["a"], "a", input_keys=["x"], output_keys=["p", "q"])
    with cc:
        for label, key in (("A", "p"), ("B", "q")):
            Concurrence.add(label, Does(write, input_keys=["x"], output_keys=["out"]), remapping={"out": key})
    parent = UserData()
    parent.x = 1
    assert in_time(lambda: cc.execute(parent)) == "a"
    assert parent._data == {"x": 1, "p": 2, "q": 2}


def test_children_run_in_named_threads_and_observers_see_who_is_active(in_time):
    names, starts, ends = [], [], []
    note = Does(lambda ud: names.append(threading.current_thread().name))
    cc = concurrence({"A": note}, outcome_map={"a": {"A": "ok"}})
    cc.register_start_cb(lambda ud, labels: starts.append(labels))
    cc.register_termination_cb(lambda ud, labels, outcome: ends.append((labels, outcome)))
    in_time(cc.execute)
    assert names == ["concurrent_split:A"]
    assert (starts, ends) == ([["A"]], [(["A"], "a")])
    assert cc.get_internal_edges() == [("ok", "A", "a")]
    assert cc.get_active_states() == []


@pytest.mark.noetic
def test_a_request_from_the_termination_callback_is_not_lost(in_time):
    b = WaitsForPreempt()
    cc = concurrence({"A": ok(), "B": b}, child_termination_cb=lambda outcomes: cc.request_preempt())
    assert in_time(cc.execute) == "preempted"


@pytest.mark.noetic
def test_a_preempt_of_the_parent_gets_through_while_a_callback_runs(in_time):
    def preempt_from_another_thread(outcomes):
        other = threading.Thread(target=sm.request_preempt)
        other.start()
        other.join(120)
        assert not other.is_alive(), "the request waits for the callback"

    children = {"A": ok(), "B": WaitsForPreempt()}
    sm = StateMachine(["a", "preempted"])
    with sm:
        cc = concurrence(children, ["a", "preempted"], child_termination_cb=preempt_from_another_thread)
        StateMachine.add("C", cc)
    assert in_time(sm.execute, limit=60) == "preempted"
    assert not sm.preempt_requested()


@pytest.mark.slow
def test_many_executions_under_hasty_switching_always_end(in_time):
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        for _ in range(500):
            cc = concurrence(
                {"A": ok(), "B": WaitsForPreempt(), "C": ok()},
                child_termination_cb=lambda outcomes: True,
            )
            assert in_time(cc.execute) == "a"
    finally:
        sys.setswitchinterval(before)
