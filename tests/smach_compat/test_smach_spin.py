"""The quick way through plain transitions does what the ordinary way does, whatever states do to their machine.

The ordinary way is a machine without `spin` and with a view of userdata made anew for each activation, as upstream.
"""

import itertools
import random

import pytest

import grip_bt.smach_compat as smach
from grip_bt.smach_compat import State, StateMachine, UserData, state_machine
from grip_bt.smach_compat._spin import OVER
from grip_bt.smach_compat._views import Views
from grip_bt.smach_compat.log import silent
from grip_bt.smach_compat.util import is_shutdown

LABELS = ["A", "B", "C", "D"]
OUTCOMES = ["o", "p"]
KEYS = ["i", "j", "k", "l"]


def read_key(ud, key):
    """Return what a state finds, or the name of the error."""
    try:
        return getattr(ud, key), ud[key], key in ud
    except (KeyError, smach.InvalidUserCodeError) as error:
        return type(error).__name__


class Meddling(State):
    """Follows a script of outcomes and of things to do to the machine that it is in."""

    def __init__(self, world, label, script, inputs=(), outputs=()):
        super().__init__(OUTCOMES, list(inputs), list(outputs))
        self.world, self.label, self.script = world, label, script

    def execute(self, ud):
        world = self.world
        machine = world["machine"]
        world["trace"].append((self.label, machine.get_active_states(), machine.is_running(), self.preempt_requested()))
        if len(world["trace"]) > 200:
            raise RuntimeError("enough")
        world["trace"].append([(key, read_key(ud, key)) for key in KEYS])
        for key in KEYS[:2]:
            ud[key] = len(world["trace"])
        ud.l = [len(world["trace"])]
        if not self.script:
            return "o"
        deed, outcome = self.script.pop(0)
        DEEDS[deed](world, self, ud)
        return outcome


def preempt(world, state, ud):
    world["machine"].request_preempt()


def obey(world, state, ud):
    if state.preempt_requested():
        state.service_preempt()


def lead_elsewhere(world, state, ud):
    world["machine"]._transitions[state.label]["o"] = "A"


def new_row(world, state, ud):
    world["machine"]._transitions[state.label] = {"o": "B" if "B" in world["machine"]._states else "x", "p": "x"}


def listen(world, state, ud):
    world["machine"].register_transition_cb(lambda ud, labels: world["trace"].append(("transition", labels)))


def listen_no_more(world, state, ud):
    world["machine"]._transition_cbs = []


def remap(world, state, ud):
    world["machine"]._remappings[state.label]["i"] = "j"


def remap_all(world, state, ud):
    for label in world["machine"]._remappings:
        world["machine"]._remappings[label] = {"j": "k", "k": "i"}


def constant(world, state, ud):
    world["machine"]._constants[state.label] = {"i": 5, "j": len(world["trace"])}


def no_constants(world, state, ud):
    world["machine"]._constants.clear()


def new_store(world, state, ud):
    world["machine"].userdata = UserData()
    world["machine"].userdata.i = -1


def new_values(world, state, ud):
    world["machine"].userdata._data = {"i": -2, "l": -3}


def odd_store(world, state, ud):
    class Store(UserData):
        def __getitem__(self, key):
            return key, super().__getitem__(key)

    world["machine"].userdata = Store()
    world["machine"].userdata.update(UserData())


def other_key(world, state, ud):
    state._input_keys.discard("i")
    state._input_keys.add("k")


def plain_sets(world, state, ud):
    state._input_keys = state._input_keys | {"k"}
    state._output_keys = {"k"}


def my_view(world, state, ud):
    ud._map = {"i": "l"}
    ud._input = frozenset(KEYS)


def unknown_outcome(world, state, ud):
    state._outcomes.discard("p")


def odd_outcome(world, state, ud):
    world["machine"]._transitions[state.label]["q"] = "A"


def patch_execute(world, state, ud):
    real = state.execute
    state.execute = lambda view: (world["trace"].append("patched"), real(view))[1]


def remove(world, state, ud):
    world["machine"]._states.pop(world["machine"].get_children() and sorted(world["machine"].get_children())[-1])


def stop(world, state, ud):
    world["machine"]._is_running = False


def hang_on(world, state, ud):
    object.__setattr__(ud, "note", state.label)


def grow_keys(world, state, ud):
    world["machine"].userdata.k = 1
    state.register_input_keys(["k"])


def read(world, state, ud):
    world["trace"].append(("read", state.label, ud.k if "k" in state._input_keys else None))


def no_dream(world, state, ud):
    state._outcomes = state._outcomes - {"p"}


def raises(world, state, ud):
    raise ValueError(state.label)


def shut_down(world, state, ud):
    smach.set_shutdown_check(lambda: True)


def log_again(world, state, ud):
    smach.loginfo = world["trace"].append


def swap(world, state, ud):
    world["machine"]._states[state.label] = Meddling(world, state.label + "'", state.script, KEYS[1:])


class Odd(Meddling):
    """Says only when it is asked what it may return."""

    def get_registered_outcomes(self):
        self.world["trace"].append("asked")
        return ("o",)


def twin(world, state, ud):
    keys = state._input_keys, state._output_keys
    world["machine"]._states[state.label] = Odd(world, state.label, state.script, *keys)


def other_output(world, state, ud):
    state._output_keys.discard("i")
    state._output_keys.add("k")


DEEDS = {
    deed.__name__: deed
    for deed in (
        preempt, obey, lead_elsewhere, new_row, listen, hang_on, grow_keys, read, no_dream, raises, shut_down, swap,
        listen_no_more, remap, remap_all, constant, no_constants, new_store, new_values, odd_store, other_key,
        plain_sets, my_view, unknown_outcome, odd_outcome, patch_execute, remove, stop, twin, other_output,
    )
}  # fmt: skip
DEEDS["nothing"] = lambda world, state, ud: None


def execute(seed, quickly, monkeypatch):
    """Return what happened in a random machine, as the states saw it, and how it ended."""
    rng = random.Random(seed)
    labels = LABELS[: rng.randint(1, 4)]
    deeds = ["nothing"] * 40 + list(DEEDS)
    world = {"trace": []}
    machine = world["machine"] = StateMachine(["x", "y"])
    machine.userdata.update(store(i=0, k=2))
    with machine:
        for label in labels:
            row = {outcome: rng.choice([*labels, *labels, "x", "y"]) for outcome in OUTCOMES}
            odd = [] if rng.random() < 0.97 else [("nothing", rng.choice(["never", None, [], "q"]))]
            script = [(rng.choice(deeds), rng.choice(OUTCOMES)) for _ in range(rng.randint(0, 24))] + odd
            row["o"] = rng.choice([*labels[labels.index(label) + 1 :], "x"])
            keys = [rng.sample(KEYS, rng.choice([0, 0, 1, 2])) for _ in range(2)]
            StateMachine.add(label, Meddling(world, label, script, *keys), row, dict([rng.sample(KEYS, 2)]))
    heard = rng.random() < 0.5
    with monkeypatch.context() as patch:
        patch.setattr(smach, "loginfo", world["trace"].append if heard else silent)
        patch.setattr(smach, "is_shutdown", is_shutdown)
        if not quickly:
            patch.setattr(state_machine, "spin", lambda machine: OVER)
            patch.setattr(Views, "row", lambda *args: None)
        ends = []
        for _ in range(2):
            try:
                ends.append(machine.execute())
            except smach.SmachError as error:
                ends.append((type(error).__name__, str(error.__cause__)))
            except (KeyError, AttributeError) as error:
                ends.append(repr(error))
    state = machine.get_active_states(), machine.preempt_requested(), machine.is_running()
    return world["trace"], ends, state, machine.userdata._data


def store(**values):
    """Return userdata with these values."""
    result = UserData()
    result._data.update(values)
    return result


@pytest.mark.parametrize("chunk", range(8))
def test_random_machines_do_the_same_quickly(chunk, monkeypatch):
    ends = set()
    for seed in range(chunk * 250, (chunk + 1) * 250):
        quick, ordinary = (execute(seed, quickly, monkeypatch) for quickly in (True, False))
        assert quick == ordinary, seed
        ends.update(map(str, ordinary[1]))
    assert len(ends) > 4


def test_loggers_that_are_put_in_meanwhile_hear_the_next_transition(monkeypatch):
    world = {"trace": []}
    machine = world["machine"] = StateMachine(["x"])
    with machine:
        for label, target in (("A", "B"), ("B", "C"), ("C", "x")):
            deeds = [("log_again", "o")] if label == "B" else []
            StateMachine.add(label, Meddling(world, label, deeds), {"o": target, "p": "x"})
    monkeypatch.setitem(DEEDS, "log_again", log_again)
    monkeypatch.setattr(smach, "is_shutdown", is_shutdown)
    monkeypatch.setattr(smach, "loginfo", silent)
    assert machine.execute() == "x"
    assert any("terminating 'C'" in str(entry) for entry in world["trace"])


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


@pytest.fixture
def quiet(monkeypatch):
    monkeypatch.setattr(smach, "is_shutdown", is_shutdown)
    monkeypatch.setattr(smach, "loginfo", silent)


def test_a_request_between_two_states_reaches_the_second_one(quiet):
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


def test_a_check_for_shutdown_is_asked_once_a_state(quiet):
    counts = {}
    for stop_after in range(2, 60, 7):
        for quickly in (True, False):
            calls = itertools.count(1)
            smach.set_shutdown_check(lambda calls=calls, last=stop_after: next(calls) > last)
            machine = ring(40)
            if not quickly:
                machine._update_once = lambda machine=machine: StateMachine._update_once(machine)
            assert machine.execute() is None
            counts[stop_after, quickly] = len(machine["A"].preempted), len(machine["B"].preempted), next(calls)
        assert sum(counts[stop_after, True][:2]) == stop_after
        assert counts[stop_after, True] == counts[stop_after, False]


def test_steps_that_a_program_replaces_are_used(quiet, monkeypatch):
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


def test_patched_userdata_is_asked_from_the_next_execution_on(quiet, monkeypatch):
    machine, seen = ring(20, input_keys=["i"]), []
    machine.userdata.i = 1
    for label in "AB":
        real = machine[label].execute
        machine[label].execute = lambda ud, real=real: (seen.append(ud.i), real(ud))[1]
    machine.execute()
    original = UserData.__getitem__
    monkeypatch.setattr(UserData, "__getitem__", lambda self, key: -original(self, key))
    machine["A"].times = machine["B"].times = 20
    machine.execute()
    assert seen == [1] * 39 + [-1] * 39


def test_a_state_that_spoils_its_view_each_time_gets_a_new_one(quiet):
    machine, views = ring(50, input_keys=["i"]), []
    for label in "AB":
        real = machine[label].execute

        def spoil(ud, real=real):
            assert not vars(ud)
            ud._note = 1
            views.append(ud)
            return real(ud)

        machine[label].execute = spoil
    machine.execute()
    assert len({id(view) for view in views}) == 99


def test_an_output_that_is_exchanged_in_place_is_seen_at_the_next_activation(quiet):
    machine = ring(40, output_keys=["i"])
    first = machine["A"]
    real = first.execute

    def exchange(ud):
        ud.i = ud.k = first.times
        if first.times == 20:
            first._output_keys.discard("i")
            first._output_keys.add("k")
        return real(ud)

    first.execute = exchange
    machine.execute()
    assert machine.userdata._data == {"i": 20, "k": 1}


def test_a_state_that_takes_the_place_of_another_is_asked_what_it_may_return(quiet):
    machine = ring(40)
    real = machine["A"].execute

    class Strict(Count):
        def get_registered_outcomes(self):
            return ("off",)

    strict = Strict(20)
    vars(strict).update({name: vars(machine["B"])[name] for name in ("_input_keys", "_output_keys")})

    def exchange(ud):
        if machine["A"].times == 20:
            machine._states["B"] = strict
        return real(ud)

    machine["A"].execute = exchange
    with pytest.raises(smach.InvalidTransitionError, match="State 'B' returned 'on'"):
        machine.execute()


def test_a_state_that_a_logger_takes_away_is_an_error(quiet, monkeypatch):
    machine = ring(40)

    def take(text):
        if machine["A"].times == 20:
            machine._states.pop(machine._current_label)

    monkeypatch.setattr(smach, "loginfo", take)
    with pytest.raises(smach.InvalidStateError, match="no state 'B'"):
        machine.execute()


def test_an_error_of_a_logger_or_of_the_shutdown_check_is_no_error_of_a_state(quiet, monkeypatch):
    def unwell(*text):
        raise ZeroDivisionError

    for name in ("loginfo", "is_shutdown"):
        machine = ring(40)
        real = machine["A"].execute

        def late(ud, machine=machine, real=real, name=name):
            if machine["A"].times == 20:
                monkeypatch.setattr(smach, name, unwell)
            return real(ud)

        machine["A"].execute = late
        with pytest.raises(ZeroDivisionError):
            machine.execute()
        monkeypatch.setattr(smach, "loginfo", silent)
        monkeypatch.setattr(smach, "is_shutdown", is_shutdown)
        machine["A"].times = machine["B"].times = 3
        assert machine.execute() == "off"  # its lock is as it was
