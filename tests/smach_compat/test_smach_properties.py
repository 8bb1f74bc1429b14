"""Properties of random machines: they follow their table, and so do copies of them and machines that contain them."""

import copy

from hypothesis import given
from hypothesis import strategies as st
from smach_states import Returns

from grip_bt.smach_compat import Sequence, State, StateMachine

LABELS = ["A", "B", "C", "D"]
EXITS = ["x", "y"]
OUTCOMES = ["o", "p"]


class Noting(State):
    """Follows a script of outcomes, and writes its label down in its machine's userdata."""

    def __init__(self, label, script):
        super().__init__(OUTCOMES, io_keys=["visited"])
        self.label, self.script = label, list(script)

    def execute(self, ud):
        ud.visited = [*ud.visited, self.label]
        return self.script.pop(0) if self.script else "o"


@st.composite
def tables(draw):
    """Return (label -> outcome -> target, label -> script); the outcome `o` always leads forward, so that all end."""
    labels = LABELS[: draw(st.integers(1, 4))]
    table = {}
    for position, label in enumerate(labels):
        forward = [*labels[position + 1 :], *EXITS]
        table[label] = {"o": draw(st.sampled_from(forward)), "p": draw(st.sampled_from([*labels, *EXITS]))}
    scripts = {label: draw(st.lists(st.sampled_from(OUTCOMES), max_size=5)) for label in labels}
    return table, scripts


def walk(table, scripts):
    """Return (labels visited, exit) by the table alone."""
    scripts = {label: list(script) for label, script in scripts.items()}
    here, visited = next(iter(table)), []
    while here in table:
        visited.append(here)
        outcome = scripts[here].pop(0) if scripts[here] else "o"
        here = table[here][outcome]
    return visited, here


def build(table, scripts):
    machine = StateMachine(EXITS, output_keys=["visited"])
    machine.userdata.visited = []
    with machine:
        for label, row in table.items():
            StateMachine.add(label, Noting(label, scripts[label]), dict(row))
    return machine


def run(machine):
    return machine.execute(), machine.userdata.visited


@given(tables())
def test_a_machine_follows_its_table(case):
    visited, end = walk(*case)
    assert run(build(*case)) == (end, visited)


@given(tables())
def test_a_copy_does_what_the_original_would_have_done(case):
    machine = build(*case)
    twin = copy.deepcopy(machine)
    assert run(twin) == run(machine)


@given(tables())
def test_a_machine_inside_another_does_the_same(case):
    visited, end = walk(*case)
    outer = StateMachine(EXITS)
    with outer:
        StateMachine.add("IN", build(*case), {"x": "x"}, remapping={"visited": "path"})
    assert outer.execute() == end
    assert outer.userdata.path == visited


@given(st.lists(st.sampled_from(["on", "out"]), min_size=1, max_size=6))
def test_a_sequence_stops_at_the_first_outcome_that_does_not_connect(returned):
    sequence = Sequence(["on", "out"], "on")
    states = [Returns(outcome, outcomes=["on", "out"]) for outcome in returned]
    with sequence:
        for number, state in enumerate(states):
            Sequence.add(f"S{number}", state)
    executed = returned.index("out") + 1 if "out" in returned else len(returned)
    assert sequence.execute() == returned[executed - 1]
    assert [state.runs for state in states] == [1] * executed + [0] * (len(states) - executed)
