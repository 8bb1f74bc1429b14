"""The referee's word beside the task's: what contradicts a success, and how every command says so."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from trial_project import grip

from grip_bt.app.runs.verdict import PLACE, Verdict, words
from grip_bt.base.errors import DocumentError, SimulatorLostError
from grip_bt.base.values import Pose
from grip_bt.cli.run import exit_status, sentence
from grip_sim.referee import ObjectTruth
from grip_sim.specs import WorldSpec


def verdict_over(
    states: dict[str, str] | None,
    goal: str = "",
    placing: int = 0,
    target: str = "crate",
    judge: dict[str, str] | None = None,
) -> Verdict:
    """Return a verdict over a world with a crate, after so many successes of `arm/place`."""
    truth = {
        name: ObjectTruth(name, status, Pose(), 0.0, ("crate",) if status == "placed" else ())  # type: ignore[arg-type]
        for name, status in (states or {}).items()
    }
    world = SimpleNamespace(spec=WorldSpec(judge=judge or {}))
    observers: list[Any] = []
    place = SimpleNamespace(manifest=SimpleNamespace(implementation=PLACE), params={"target": target})
    session = SimpleNamespace(
        resources=SimpleNamespace(
            referee=None if states is None else SimpleNamespace(truth=lambda: truth, measures=dict),
            world=None if states is None else world,
        ),
        project=SimpleNamespace(folder=Path(), file=SimpleNamespace(goals={"t": goal} if goal else {}, world="table")),
        document=SimpleNamespace(task=SimpleNamespace(name="t")),
        runner=SimpleNamespace(compiled=SimpleNamespace(leaves={"put": place}), observe=observers.append),
    )
    verdict = Verdict(session)  # type: ignore[arg-type]
    assert observers == [verdict]
    for _ in range(placing):
        verdict.ended("put", "success", None)
        verdict.ended("look", "success", None)
    return verdict


SUCCESS, FAILURE = SimpleNamespace(status="success"), SimpleNamespace(status="failure")
HALF = {"box_0": "placed", "box_1": "standing"}


@pytest.mark.parametrize(
    ("states", "goal", "placing", "contradicted"),
    [
        (HALF, "placed == objects", 0, True),
        (HALF, "placed == objects", 2, True),
        (HALF, "placed > 0 and held == 0", 0, False),
        ({"box_0": "placed"}, "placed == objects", 1, False),
        (HALF, "", 2, True),
        (HALF, "", 1, False),
        (HALF, "", 0, False),  # a tour: nothing was claimed
        ({}, "", 0, False),
    ],
)
def test_a_success_is_contradicted_by_the_goal_or_by_what_was_not_placed(states, goal, placing, contradicted):
    facts = verdict_over(states, goal, placing).facts(SUCCESS)
    assert facts["truth"] == states
    assert bool(facts.get("contradiction")) == contradicted
    assert ("message" in facts) == contradicted
    if contradicted:
        assert words(states) in facts["message"]
    assert "contradiction" not in verdict_over(states, goal, placing).facts(FAILURE), "it claims nothing"


def test_a_world_judges_by_its_regions_beside_the_task_that_has_succeeded_or_not():
    judge = {"cleared": "in_crate == objects", "begun": "in_crate > 0 and fallen == 0"}
    for end in (SUCCESS, FAILURE):
        assert verdict_over(HALF, judge=judge).facts(end)["judged"] == {"cleared": False, "begun": True}
    assert "judged" not in verdict_over(HALF).facts(SUCCESS)


def test_a_world_that_judges_by_what_is_not_there_is_refused():
    with pytest.raises(DocumentError, match=r"judge/cleared: unknown name 'in_crat'.*did you mean 'in_crate'"):
        verdict_over(HALF, judge={"cleared": "in_crat == 2"})


def test_what_was_put_at_a_position_is_not_looked_for_in_the_crate():
    assert "contradiction" not in verdict_over({"box_0": "standing"}, placing=1, target="").facts(SUCCESS)


def test_without_a_referee_or_a_simulator_there_is_no_word():
    assert verdict_over(None, "placed == objects").facts(SUCCESS) == {}
    verdict = verdict_over(HALF)

    def gone() -> Any:
        raise SimulatorLostError("gone")

    verdict._referee = SimpleNamespace(truth=gone)
    assert verdict.facts(SUCCESS) == {}


@pytest.mark.parametrize("goal", ["plcaed == objects", "placed ==", "placed", "placed + 'x' == 2"])
def test_a_goal_that_is_none_is_told_before_anything_moves(goal):
    with pytest.raises(DocumentError, match="goals/t"):
        verdict_over(HALF, goal)


def test_a_contradicted_success_is_shown_as_such():
    end = {"status": "success", "outcome": "cleared", **verdict_over(HALF, "placed == objects").facts(SUCCESS)}
    assert exit_status(end) == 3
    assert sentence(end) == (
        "success: cleared (the referee contradicts: `placed == objects` is false; placed: box_0; standing: box_1)"
    )
    assert exit_status({"status": "success"}) == 0


TASK = """grip: 1
name: {name}
root: {{node: arm/move_to, with: {{state: home}}}}
"""


@pytest.mark.sim
@pytest.mark.slow
@pytest.mark.parametrize("more", [(), ("--in-process",)])
def test_every_run_in_simulation_has_the_referees_word(tmp_path, more):
    (tmp_path / "grip.yaml").write_text(
        "grip: 1\nrobot: panda_allegro\narms: {right: {group: arm, hand: h}}\nhands: {h: {group: hand}}\nworld: table\n"
        "goals: {claims: placed == objects}\n"
    )
    for name, status in (("tour", 0), ("claims", 3)):
        (tmp_path / f"{name}.yaml").write_text(TASK.format(name=name))
        done = grip("run", str(tmp_path / f"{name}.yaml"), "--json", *more, timeout=300)
        said = json.loads(done.stdout.splitlines()[-1])
        assert (done.returncode, said["status"]) == (status, "success"), done.stderr
        assert set(said["truth"].values()) == {"standing"}
        assert ("contradiction" in said) == (name == "claims")
