"""Two forms that do the same are found to; two that don't are told apart by a script that shows it."""

from collections.abc import Callable
from random import Random

import pytest
from parity_flows import make_flow
from parity_world import catalog_of
from restructure_tasks import CATALOG, leaf, machine, task

from grip_bt.compilers.restructure import Restructured, compare, moved, play, to_state_machines, to_trees
from grip_bt.compilers.restructure.equivalence import End, _Run
from grip_bt.nodes.node import Observer
from grip_bt.task import Task, walk

STATES = {
    "look": {"success": "take", "failure": "look"},
    "take": {"success": "success", "failure.no_ik": "look", "failure": "failure"},
}


def same_paths(before: Task, after: Task) -> Restructured:
    return Restructured(after, {path: path for path, _ in walk(before.root)}, ())


def test_a_conversion_is_the_same_and_says_how_much_was_tried() -> None:
    before = task(machine("look", STATES))
    found = compare(before, to_trees(before, CATALOG), CATALOG)
    assert (found.difference, found.runs) == (None, 200)
    assert found.length is not None
    assert found.length >= 2
    assert str(found).startswith(
        "the same in 200 runs of both forms with scripted leaves (every way in which the first"
    )


def test_where_few_scripts_exist_all_are_tried() -> None:
    before = task({"kind": "sequence", "children": {"a": leaf()}})
    found = compare(before, to_state_machines(before, CATALOG), CATALOG)
    assert (found.runs, found.length, found.difference) == (4, None, None)
    assert "every script there is" in str(found)


@pytest.mark.parametrize(
    ("state", "on"),
    [
        ("look", {"success": "success", "failure": "look"}),
        ("take", {"success": "success", "failure.no_ik": "failure", "failure": "failure"}),
        ("take", {"success": "failure", "failure.no_ik": "look", "failure": "failure"}),
    ],
)
def test_one_wrong_edge_is_shown_by_a_script_that_can_be_played(state: str, on: dict[str, str]) -> None:
    before = task(machine("look", STATES))
    after = task(machine("look", {**STATES, state: on}))
    found = compare(before, same_paths(before, after), CATALOG).difference
    assert found is not None
    assert len(found.script) <= 4
    assert tuple(_Run(before, CATALOG, None, found.script, {}).did()) == found.before
    assert tuple(_Run(after, CATALOG, None, found.script, {}).did()) == found.after
    assert found.before != found.after
    assert "with leaves that end like this:\n  look: " in str(found)


class Heard(Observer):
    """Notes who began and when."""

    def __init__(self) -> None:
        self.begun: list[tuple[float, str]] = []

    def by(self, now: Callable[[], float]) -> "Heard":
        self.now = now
        return self

    def entered(self, path: str) -> None:
        self.begun.append((self.now(), path))


def test_a_script_is_played_with_every_node_heard_in_both_forms() -> None:
    before = task(machine("look", STATES))
    result = to_trees(before, CATALOG)
    script = (End("look", 0, "failure"), End("look", 1, "success"), End("take", 0, "failure", "no_ik"))
    one, other = Heard(), Heard()
    assert play(before, CATALOG, script, one.by) == play(result.task, CATALOG, moved(script, result.paths), other.by)
    leaves = [(t, path) for t, path in one.begun if path != "/"]
    assert leaves == [(0.0, "look"), (1.0, "look"), (2.0, "take"), (3.0, "look"), (4.0, "take")]
    back = {new: old for old, new in result.paths.items()}
    assert [(t, back[path]) for t, path in other.begun if back.get(path) in ("look", "take")] == leaves


def test_what_was_approximated_is_shown_to_differ() -> None:
    root = {"kind": "sequence", "memory": False, "children": {"a": leaf(), "b": leaf()}}
    before = task(root)
    exact, rough = to_state_machines(before, CATALOG), to_state_machines(before, CATALOG, approximate=True)
    assert exact.task == before
    assert rough.task.root.kind == "state_machine"
    assert rough.notes[0].approximated
    assert compare(before, exact, CATALOG).difference is None
    found = compare(before, rough, CATALOG).difference
    assert found is not None
    assert any(end.ticks for end in found.script), "only a leaf that runs for a while is looked past"


def test_random_machines_and_their_trees_are_found_to_be_the_same() -> None:
    runs = 0
    for seed in Random(7).sample(range(10_000), 25):
        case = make_flow(seed)
        before, catalog = Task.model_validate(case["task"]), catalog_of(case)
        found = compare(before, to_trees(before, catalog), catalog, runs=20)
        assert found.difference is None, f"seed {seed}: {found}"
        runs += found.runs
    assert runs > 400


def test_a_leaf_that_a_sibling_interrupts_runs_as_long_in_both_forms() -> None:
    children = {"ready": {"kind": "parallel", "children": {"open": leaf(), "home": leaf()}}, "look": leaf()}
    before = task({"kind": "sequence", "children": children})
    found = compare(before, to_state_machines(before, CATALOG), CATALOG)
    assert found.difference is None
    interrupted = (End("ready/open", 0, "failure"), End("ready/home", 0, "success", ticks=1))
    run = _Run(before, CATALOG, None, interrupted, {})
    assert run.log == [interrupted[0]]
    assert run.played() == interrupted
