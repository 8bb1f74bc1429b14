"""The quick way through plain transitions does what the ordinary way does, whatever states do to their machine."""

import random

import pytest

import grip_bt.smach_compat as smach
from grip_bt.smach_compat import State, StateMachine
from grip_bt.smach_compat.log import silent
from grip_bt.smach_compat.util import is_shutdown

LABELS = ["A", "B", "C", "D"]
OUTCOMES = ["o", "p"]


class Meddling(State):
    """Follows a script of outcomes and of things to do to the machine that it is in."""

    def __init__(self, world, label, script):
        super().__init__(OUTCOMES)
        self.world, self.label, self.script = world, label, script

    def execute(self, ud):
        world = self.world
        machine = world["machine"]
        world["trace"].append((self.label, machine.get_active_states(), machine.is_running(), self.preempt_requested()))
        if len(world["trace"]) > 200:
            raise RuntimeError("enough")
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
    world["machine"]._states[state.label] = Meddling(world, state.label + "'", state.script)


DEEDS = {
    deed.__name__: deed
    for deed in (
        preempt, obey, lead_elsewhere, new_row, listen, hang_on, grow_keys, read, no_dream, raises, shut_down, swap,
    )
}  # fmt: skip
DEEDS["nothing"] = lambda world, state, ud: None


def execute(seed, quickly, monkeypatch):
    """Return what happened in a random machine, as the states saw it, and how it ended."""
    rng = random.Random(seed)
    labels = LABELS[: rng.randint(1, 4)]
    deeds = ["nothing"] * 12 + list(DEEDS)
    world = {"trace": []}
    machine = world["machine"] = StateMachine(["x", "y"])
    with machine:
        for label in labels:
            row = {outcome: rng.choice([*labels, *labels, "x", "y"]) for outcome in OUTCOMES}
            odd = [] if rng.random() < 0.97 else [("nothing", rng.choice(["never", None, []]))]
            script = [(rng.choice(deeds), rng.choice(OUTCOMES)) for _ in range(rng.randint(0, 12))] + odd
            row["o"] = rng.choice([*labels[labels.index(label) + 1 :], "x"])
            StateMachine.add(label, Meddling(world, label, script), row)
    with monkeypatch.context() as patch:
        patch.setattr(smach, "loginfo", silent if quickly else lambda text: None)
        patch.setattr(smach, "is_shutdown", is_shutdown)
        try:
            end = machine.execute()
        except smach.SmachError as error:
            end = type(error).__name__, str(error.__cause__)
    return world["trace"], end, machine.get_active_states(), machine.preempt_requested(), machine.is_running()


@pytest.mark.parametrize("chunk", range(8))
def test_random_machines_do_the_same_quickly(chunk, monkeypatch):
    ends = set()
    for seed in range(chunk * 250, (chunk + 1) * 250):
        quick, ordinary = (execute(seed, quickly, monkeypatch) for quickly in (True, False))
        assert quick == ordinary, seed
        ends.add(str(ordinary[1]))
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
