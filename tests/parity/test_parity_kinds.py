"""What the kinds say without a run: every end that happens was foreseen, and short cuts are as exploration."""

from __future__ import annotations

import os
from typing import Any

import parity_world as world
import pytest
from parity_generate import make_case

from grip_bt.base.errors import InvalidTaskError
from grip_bt.task import Task
from grip_bt.task.exploration import UNKNOWN, Labels, Oracle, TooManyError, explore
from grip_bt.task.kind_analysis import flow, possible
from grip_bt.task.kinds import KINDS
from grip_bt.task.kinds.base import Kind
from grip_bt.task.kinds.control import Control
from grip_bt.task.kinds.once import Once
from grip_bt.task.parts import Edges
from grip_bt.task.validation.analysis import TaskAnalysis
from grip_bt.task.validation.possible import PossibleOutcomes

LOOKS = ("equal", "less", "true", "length", "order")
SEEDS = range(int(os.environ.get("GRIP_FUZZ_KINDS", "150")))


@pytest.fixture(scope="module")
def analyses() -> list[tuple[dict[str, Any], TaskAnalysis, PossibleOutcomes]]:
    found = []
    for seed in SEEDS:
        case = make_case(seed)
        try:
            analysis = TaskAnalysis(Task.model_validate(case["task"]), world.catalog_of(case))
        except (InvalidTaskError, ValueError, KeyError):
            continue
        found.append((case, analysis, PossibleOutcomes(analysis)))
    return found


def containers(analyses):
    for _, analysis, ends in analyses:
        for placed in analysis.nodes:
            if placed.path in ends.ends:
                yield placed.node, ends.ends[placed.path]


def found_of(kind, labels):
    """Return the outcomes of a container with the children that may run, and what is written then: a bit a child."""

    def after(child: str, before: int) -> dict[str, int]:
        return {end.outcome: before | 2 << labels.names.index(child) for end in labels.of(child)}

    return possible(kind, labels), flow(kind, labels, 1, after, lambda key: 0, lambda key, here: None)


def test_every_end_of_a_run_was_foreseen(analyses) -> None:
    seen = 0
    for case, analysis, ends in analyses:
        labels = {placed.path: ends.labels(placed) for placed in analysis.nodes}
        try:
            run = world.run_tree(case)
        except InvalidTaskError:
            continue
        for path, *event in run.events:
            if event[0] == "exit" and path in labels:
                seen += 1
                assert event[1] in labels[path], f"{path} of {case} ended with {event[1]}"
    assert seen > len(SEEDS)


def test_what_is_worked_out_by_hand_is_what_exploration_finds(analyses, monkeypatch) -> None:
    compared = set()
    for kind, labels in list(containers(analyses)):
        if type(kind).possible is Kind.possible or not kind.explorable(labels.all):
            continue

        explored = found_of(kind, labels)
        with monkeypatch.context() as patch:
            patch.setattr(type(kind), "explorable", lambda self, ends: False)
            by_hand = found_of(kind, labels)
        assert explored[0][0] <= by_hand[0][0]
        assert explored[0][1] <= by_hand[0][1]
        for outcome, written in explored[1].items():
            assert by_hand[1][outcome] & ~written == 0, f"{kind!r} ends with {outcome}"
        compared.add(kind.kind)
    assert compared == {"parallel"}


def test_a_kind_asks_before_it_puts(analyses, monkeypatch) -> None:
    ask, put = Oracle._ask, Oracle.put

    def asked(self, *answers: str) -> int:
        assert not self.puts, "a resumed run may ask twice, and must not write twice"
        return ask(self, *answers)

    monkeypatch.setattr(Oracle, "_ask", asked)
    puts = set()
    monkeypatch.setattr(Oracle, "put", lambda self, key, value: (puts.add(key), put(self, key, value)))
    explored = set()
    once = Once.model_validate({"kind": "once", "policy": "any", "child": {"a": {"node": "flow/succeed"}}})
    control = Control.model_validate({"kind": "control", "children": {name: {"node": "a/b"} for name in "ab"}})
    ends = {name: [("success", "success"), ("failure", "failure")] for name in "ab"}
    alone = [(once, Labels({"a": ends["a"]}, Edges(), Edges())), (control, Labels(ends, Edges(), Edges()))]
    for kind, labels in [*containers(analyses), *alone]:
        try:
            for _ in explore(kind, labels):
                pass
        except TooManyError:
            assert not kind.explorable(labels.all)
        explored.add(kind.kind)
    assert puts
    assert explored == KINDS.keys() - {"subtask", "foreign"}  # code of others decides in these


@pytest.mark.parametrize("look", [lambda x: x == 1, lambda x: x < 1, bool, len, lambda x: x >= x], ids=LOOKS)
def test_a_kind_that_looks_at_data_is_found_out(look) -> None:
    with pytest.raises(TypeError, match="asks about data"):
        look(UNKNOWN)
    assert f"{UNKNOWN - 1:g}" == "?"
