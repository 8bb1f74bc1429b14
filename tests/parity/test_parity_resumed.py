"""A run that is killed after any event, and gone on with, does what it would have done."""

from __future__ import annotations

import os
from random import Random
from typing import Any

import pytest
from parity_generate import make_case
from parity_resumed import Life, live, resume
from parity_world import projections

TASKS = int(os.environ.get("GRIP_FUZZ_RESUMED", "100"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
CHUNKS = 5


def facts(life: Life) -> list[tuple[Any, ...]]:
    """Return a run's events without their numbers; values of writes included."""
    return [(e.path, e.event, e.outcome, e.code, e.t, str(e.data)) for e in life.events]


def quiet(case: dict[str, Any], target: str) -> dict[str, Any]:
    """Return a case without stops from outside, which nobody repeats.

    Requests to come to an end are repeated; among threads, which of them sees one first isn't fixed.
    """
    if target == "sm" and case.get("concurrent"):
        case = {key: value for key, value in case.items() if key != "preempt_at"}
    for steps in case["scripts"].values():
        for step in steps:
            step.pop("stops", None)
    return case


def difference(case: dict[str, Any], target: str, kill_at: int, whole: Life) -> str | None:
    """Kill a run after so many events, go on with it, and return how it then differs from the whole run."""
    ended, world = live(case, target, kill_at)
    if ended is not None:
        return None  # threads came to the end of the run first
    resumed = resume(case, target, world)
    if resumed is None:
        return "it wasn't gone on with"
    left, right = facts(whole), facts(resumed)
    if target == "sm" and case.get("concurrent"):
        # siblings in threads share a clock that each of them moves, so that times are those of the order of that day
        left, right = ([(*e[:4], e[5]) for e in side if e[1] != "message"] for side in (left, right))
        if whole.end[0] == "error":  # what it finds the others at isn't fixed
            return None if resumed.end[0] == "error" else f"{whole.end} is {resumed.end}"
        agreed = projections(left) == projections(right) and whole.end == resumed.end
        return None if agreed else f"\n  whole:   {left}\n  resumed: {right}"
    if left != right:
        at = next((i for i, (a, b) in enumerate(zip(left, right, strict=False)) if a != b), min(len(left), len(right)))
        return f"event {at + 1}\n  whole:   {left[at : at + 3]}\n  resumed: {right[at : at + 3]}"
    for key in whole.asked.keys() & resumed.asked.keys():
        was, now = whole.asked[key], resumed.asked[key]
        if was != now and (now != "soon" or was == "before"):
            return f"{key} was asked to end {was}, and now {now}"
    if whole.end != resumed.end or whole.data != resumed.data:
        return f"ends\n  whole:   {whole.end} {whole.data}\n  resumed: {resumed.end} {resumed.data}"
    return None


def places_to_die(case: dict[str, Any], whole: Life) -> list[int]:
    """Return the events after which going on is exact.

    Not after what a leaf says in the middle of a tick, nor, among siblings, between what it writes and its end, which
    is made again: the next tick begins with its first sibling. And not while everything is interrupted because a leaf
    has raised: that leaf is asked anew.
    """
    siblings = case.get("concurrent") or case.get("embedded")
    events = list(whole.events)
    while whole.end[0] == "error" and events[-1].event in ("interrupted", "message"):
        events.pop()
    return [e.seq for e in events if e.event != "message" and not (siblings and e.event == "write")]


@pytest.mark.parametrize("target", ["bt", "sm"])
@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_a_killed_run_goes_on_as_if_nothing_had_been(chunk: int, target: str) -> None:
    size = max(1, TASKS // CHUNKS)
    compared = 0
    for seed in range(FIRST + chunk, FIRST + 10 * max(TASKS, CHUNKS), CHUNKS):
        case = quiet(make_case(seed), target)
        if target == "sm" and case.get("concurrent") and case.get("embedded"):
            continue
        whole, _ = live(case, target)
        assert whole is not None
        if not whole.whole:
            continue
        random = Random(seed)
        places = places_to_die(case, whole)
        for kill_at in {places[0], places[-1], *random.sample(places, min(4, len(places)))}:
            found = difference(case, target, kill_at, whole)
            assert found is None, f"seed {seed}, {target}, killed after event {kill_at}: {found}"
        compared += 1
        if compared == size:
            break
    assert compared == size
