"""A machine looks at everything at each transition: what programs rewire, replace and request takes effect at once."""

import itertools

import pytest

import grip_bt.smach_compat as smach
from grip_bt.smach_compat import State, StateMachine, UserData


class Count(State):
    """Leads on `times` times; sees what it is given."""

    def __init__(self, times, **keys):
        super().__init__(["on", "off"], **keys)
        self.times, self.preempted = times, []

    def execute(self, ud):
        self.times -= 1
        self.preempted.append(self.preempt_requested())
        return "on" if self.times > 0 else "off"


def ring(times, kind=StateMachine, **keys):
    """Return a machine of two states that lead to each other `times` times each."""
    machine = kind(["off"])
    with machine:
        StateMachine.add("A", Count(times, **keys), {"on": "B"})
        StateMachine.add("B", Count(times, **keys), {"on": "A"})
    return machine


def during(machine, label, deed):
    """Have `deed(view)` done each time before a state is executed."""
    real = machine[label].execute
    machine[label].execute = lambda ud: (deed(ud), real(ud))[1]


def test_loggers_that_are_put_in_meanwhile_hear_the_next_transition():
    machine, heard = ring(2), []
    during(machine, "B", lambda ud: setattr(smach, "loginfo", heard.append))
    assert machine.execute() == "off"
    assert [line.split("'")[1] for line in heard] == ["B", "A"]


def test_a_request_between_two_states_reaches_the_second_one():
    machine = ring(40)

    class Table(dict):
        looked_up = 0

        def __getitem__(self, label):
            self.looked_up += 1
            if self.looked_up == 21:  # on the way from one state to the next
                machine.request_preempt()
            return super().__getitem__(label)

    machine._transitions = Table(machine._transitions)
    assert machine.execute() == "off"
    seen = [machine["A"].preempted, machine["B"].preempted]
    order = [flag for pair in itertools.zip_longest(*seen) for flag in pair if flag is not None]
    assert order == [False] * 20 + [True] + [True] * (len(order) - 21)


def test_a_check_for_shutdown_is_asked_once_a_state():
    for stop_after in range(2, 60, 7):
        calls = itertools.count(1)
        smach.set_shutdown_check(lambda calls=calls, last=stop_after: next(calls) > last)
        machine = ring(40)
        assert machine.execute() is None
        assert len(machine["A"].preempted) + len(machine["B"].preempted) == stop_after
        assert next(calls) == stop_after + 2


def test_steps_that_a_program_replaces_are_used(monkeypatch):
    steps = []
    original, notice = StateMachine._update_once, StateMachine.call_transition_cbs

    def step(self):
        steps.append(self._current_label)
        return original(self)

    def hear(self):
        steps.append("heard")
        return notice(self)

    machine = ring(10)
    machine._update_once = step.__get__(machine)
    machine.execute()
    assert len(steps) == 19
    ring(10, type("Stepping", (StateMachine,), {"_update_once": step})).execute()
    assert len(steps) == 38
    ring(10, type("Hearing", (StateMachine,), {"call_transition_cbs": hear})).execute()
    assert steps.count("heard") == 18
    monkeypatch.setattr(StateMachine, "_update_once", step)
    ring(10).execute()
    assert len(steps) == 38 + 18 + 19


def test_patched_userdata_is_asked_from_the_next_access_on(monkeypatch):
    machine, seen = ring(20, input_keys=["i"]), []
    machine.userdata.i = 1
    original = UserData.__getitem__

    def look(ud):
        seen.append(ud.i)
        if len(seen) == 10:
            monkeypatch.setattr(UserData, "__getitem__", lambda self, key: -original(self, key))

    for label in "AB":
        during(machine, label, look)
    machine.execute()
    assert seen == [1] * 10 + [-1] * 29


def test_what_a_state_leaves_on_its_view_is_gone_at_the_next_activation():
    machine, views = ring(50, input_keys=["i"]), []

    def spoil(ud):
        assert not hasattr(ud, "_note")
        ud._note, ud._map = 1, {"i": "k"}
        views.append(ud)

    for label in "AB":
        during(machine, label, spoil)
    machine.execute()
    assert len({id(view) for view in views}) == 99


def test_an_output_that_is_exchanged_in_place_is_seen_at_the_next_activation():
    machine = ring(40, output_keys=["i"])
    first = machine["A"]

    def exchange(ud):
        ud.i = ud.k = first.times
        if first.times == 20:
            first._output_keys.discard("i")
            first._output_keys.add("k")

    during(machine, "A", exchange)
    machine.execute()
    assert machine.userdata._data == {"i": 20, "k": 1}


def test_tables_that_a_state_rewires_are_followed_at_once():
    machine, seen = ring(9, input_keys=["i"]), []
    machine.userdata.i = 0

    def rewire(ud):
        machine.userdata = UserData()
        machine.userdata.k = 7
        machine._remappings["A"] = {"i": "k"}
        machine._constants["A"] = {"j": 5}
        machine._transitions["A"] = {"on": "off"}

    during(machine, "A", lambda ud: seen.append(ud.i))
    during(machine, "B", rewire)
    assert machine.execute() == "off"
    assert seen == [0, 7]
    assert machine.userdata._data == {"k": 7, "j": 5}


def test_a_state_that_registers_less_meanwhile_may_not_return_it():
    machine = ring(9)
    during(machine, "B", lambda ud: machine["B"]._outcomes.discard("on"))
    with pytest.raises(smach.InvalidTransitionError, match="State 'B' returned 'on'"):
        machine.execute()


def test_a_state_that_takes_the_place_of_another_is_asked_what_it_may_return():
    machine = ring(40)

    class Strict(Count):
        def get_registered_outcomes(self):
            return ("off",)

    def exchange(ud):
        if machine["A"].times == 20:
            machine._states["B"] = Strict(20)

    during(machine, "A", exchange)
    with pytest.raises(smach.InvalidTransitionError, match="State 'B' returned 'on'"):
        machine.execute()


def test_a_state_that_a_logger_takes_away_is_an_error(monkeypatch):
    machine = ring(40)

    def take(text):
        if machine["A"].times == 20:
            machine._states.pop(machine._current_label)

    monkeypatch.setattr(smach, "loginfo", take)
    with pytest.raises(smach.InvalidStateError, match="no state 'B'"):
        machine.execute()


def test_an_error_of_a_logger_or_of_the_shutdown_check_is_no_error_of_a_state(monkeypatch):
    def unwell(*text):
        raise ZeroDivisionError

    for name in ("loginfo", "is_shutdown"):
        machine, before = ring(40), getattr(smach, name)

        def break_late(ud, name=name, first=machine["A"]):
            if first.times == 20:
                setattr(smach, name, unwell)

        during(machine, "A", break_late)
        with pytest.raises(ZeroDivisionError):
            machine.execute()
        setattr(smach, name, before)
        machine["A"].times = machine["B"].times = 3
        assert machine.execute() == "off"  # its lock is as it was
