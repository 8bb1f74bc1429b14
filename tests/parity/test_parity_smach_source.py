"""The SMACH source of a task does what its compiled machine does."""

from __future__ import annotations

import os
from dataclasses import replace

import pytest
from parity_generate import make_case
from parity_smach_source import run_exported
from parity_world import compare, run_machine

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "240"))
CHUNKS = 4
ALWAYS = {"StateMachine", "Count", "BehaviourTree"}
OUTCOMES = ("success", "failure", "other")
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_the_smach_source_of_random_tasks_does_what_their_machine_does(chunk: int) -> None:
    whole, size = 0, max(1, TASKS // CHUNKS)
    kinds: set[str] = set()
    for seed in range(FIRST + chunk * size, FIRST + (chunk + 1) * size):
        case = make_case(seed)
        machine = run_machine(case)
        exported, source = run_exported(case)
        if any(value == "-" for _, _, seen, *_ in machine.trace for _, value in seen):
            continue  # it reads what nobody has written, which `grip check` refuses
        # An outcome in SMACH has no failure code, nobody watches containers, and an error leaves values inside of them.
        own = {key: value for key, value in machine.data.items() if key[0] == "" and machine.end[0] in OUTCOMES}
        theirs = {key: exported.data.get(key) for key in own}
        machine = replace(machine, events=[], end=machine.end[:2], data=own)
        exported = replace(exported, data=theirs, end=exported.end[:2])
        found = compare(case, {"machine": machine, "source": exported})
        assert not found, f"seed {seed}: {found}\n{source}"
        whole += found is None
        kinds |= {kind for kind in ("StateMachine", "Choose", "Count", "BehaviourTree") if kind in source}
    assert whole > size // 3
    assert kinds >= ALWAYS
    assert size < 240 or kinds == {*ALWAYS, "Choose"}
