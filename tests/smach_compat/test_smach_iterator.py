"""Iterators, by the number of the probe."""

import pytest
from smach_states import Does, Returns, ok, raises

from grip_bt import smach_compat as smach
from grip_bt.smach_compat import InvalidUserCodeError, Iterator, UserData


def iterator(state, it=(1, 2, 3), outcomes=("ok",), **contained):
    result = Iterator(list(outcomes), [], [], it, "x", "done")
    with result:
        Iterator.set_contained_state("A", state, **contained)
    return result


def test_the_state_runs_once_an_item_on_the_raw_store():  # probe 73
    seen = []
    state = Does(lambda ud: seen.append((type(ud), ud.x)))
    it = iterator(state, [1, 2, 3], loop_outcomes=["ok"])
    assert it.execute() == "done"
    assert seen == [(UserData, 1), (UserData, 2), (UserData, 3)]
    assert it.get_registered_outcomes() == ("ok", "done")


def test_with_neither_list_every_outcome_breaks():  # probe 74
    state = ok()
    assert iterator(state).execute() == "ok"
    assert state.runs == 1


def test_items_that_fail_count_as_used_up():  # probe 75
    def items():
        yield 1
        raise RuntimeError

    state = ok()
    assert iterator(state, items, loop_outcomes=["ok"]).execute() == "done"
    assert state.runs == 1


def test_the_exhausted_outcome_is_added_to_the_callers_list():  # probe 76
    outcomes = ["ok"]
    Iterator(outcomes, [], [], exhausted_outcome="done")
    assert outcomes == ["ok", "done"]


def test_outcomes_have_to_be_a_list():  # probe 77
    with pytest.raises(AttributeError):
        Iterator(("ok",), [], [], exhausted_outcome="done")


def test_the_final_map_also_maps_the_exhausted_outcome():  # probe 78
    it = iterator(ok(), loop_outcomes=["ok"], final_outcome_map={"done": "d2"})
    assert it.execute() == "d2"


def test_a_preempt_stops_after_the_item_and_reaches_the_state():  # probe 79
    state = Does(lambda ud: it.request_preempt())
    runs = []
    it = iterator(state, loop_outcomes=["ok"])
    it.register_transition_cb(lambda *args: runs.append(args))
    assert it.execute() == "ok"
    assert it.userdata.x == 1
    assert runs == []
    assert state.preempt_requested()
    assert not it.preempt_requested()


def test_a_preempt_before_execution_stops_after_the_first_item():
    state = ok()
    it = iterator(state, loop_outcomes=["ok"])
    it.request_preempt()
    assert it.execute() == "ok"
    assert (state.runs, state.preempt_requested()) == (1, False)


def test_an_error_of_the_state_is_user_code_and_leaves_it_active():  # probe 80
    it = iterator(raises(RuntimeError()))
    with pytest.raises(InvalidUserCodeError):
        it.execute()
    assert it.get_active_states() == ["A"]


def test_the_state_may_write_what_it_has_not_declared():  # probe 81
    def write(ud):
        ud.undeclared = 7

    it = iterator(Does(write), [1, 2], loop_outcomes=["ok"])
    it.execute()
    assert it.userdata._data == {"x": 2, "undeclared": 7}


def test_break_outcomes_win_over_loop_outcomes():
    state = Returns("go", "stop", outcomes=["go", "stop"])
    it = iterator(state, loop_outcomes=["stop"], break_outcomes=["stop"])
    assert it.execute() == "stop"
    assert state.runs == 2
    assert it.get_internal_edges() == [("go", "A", "A"), ("stop", "A", "stop")]


@pytest.mark.parametrize(("loop", "runs"), [(["ok"], 1), ([], 3)])
def test_an_unregistered_outcome_breaks_unless_there_is_no_loop_set(loop, runs):
    state = Returns("weird", outcomes=["ok"] if loop else [])
    it = iterator(state, loop_outcomes=loop)
    it.execute()
    assert state.runs == runs


def test_an_error_of_the_items_function_is_not_wrapped():
    def items():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        iterator(ok(), items).execute()


def test_a_shutdown_before_the_first_item_counts_as_exhausted():
    smach.set_shutdown_check(lambda: True)
    assert iterator(ok()).execute() == "done"


def test_setting_the_state_twice_adds_to_what_was_derived():
    it = iterator(Returns("a", outcomes=["a"]))
    with it:
        Iterator.set_contained_state("B", Returns("b", outcomes=["b"]))
    assert it._break_outcomes == ["a", "b"]


def test_one_iterator_never_changes_another():
    first = iterator(ok())
    with first:
        Iterator.set_contained_state("A", Returns("x", outcomes=["x", "y"]), break_outcomes=["x"])
    assert iterator(ok())._loop_outcomes == []


def test_observers_are_called_only_while_it_goes_on():
    transitions, ends = [], []
    it = iterator(ok(), [1, 2], loop_outcomes=["ok"])
    it.register_transition_cb(lambda ud, active: transitions.append(active))
    it.register_termination_cb(lambda ud, label, outcome: ends.append((label, outcome)))
    it.execute()
    assert transitions == [["A"], ["A"]]
    assert ends == [("A", "done")]


def test_items_may_be_set_later():
    it, state = Iterator(["ok"], [], []), ok()
    it.set_iteritems([1, 2], "n")
    with it:
        Iterator.set_contained_state("A", state, loop_outcomes=["ok"])
    assert it.execute() == "exhausted"
    assert (state.runs, it.userdata.n) == (2, 2)


def test_an_iterator_without_a_state_is_noticed_at_close(log):
    with Iterator(["ok"], [], []):
        pass
    assert any("no contained state" in text for text in log.at("err"))
