"""Two tasks are the same when they say the same, to the letter and in the same order."""

from __future__ import annotations

from pathlib import Path

import pytest

from grip_bt.task import loads
from grip_bt.task.edit.documents import alike

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").rglob("tasks/*.yaml"))
TEXT = "grip: 1\nname: t\nroot: {kind: sequence, children: {a: {node: flow/wait, with: WITH}}}\n"


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("{s: 1}", "{s: 1.0}"),
        ("{s: 1}", "{s: true}"),
        ("{s: 0.0}", "{s: -0.0}"),
        ("{s: '1'}", "{s: 1}"),
        ("{s: 1, t: 2}", "{t: 2, s: 1}"),
        ("{s: [1, 2]}", "{s: [2, 1]}"),
        ("{s: [1]}", "{s: [1, 1]}"),
        ("{s: 1}", "{s: null}"),
    ],
)
def test_what_is_written_differently_is_not_alike(one: str, other: str) -> None:
    assert not alike(loads(TEXT.replace("WITH", one)), loads(TEXT.replace("WITH", other)))
    assert alike(loads(TEXT.replace("WITH", one)), loads(TEXT.replace("WITH", one)))


def test_order_of_children_counts() -> None:
    text = "grip: 1\nname: t\nroot: {kind: sequence, children: {%s: {node: flow/fail}, %s: {node: flow/fail}}}\n"
    assert not alike(loads(text % ("a", "b")), loads(text % ("b", "a")))


def test_values_that_are_not_numbers_are_alike() -> None:
    empty = loads(TEXT.replace("WITH", "{s: [null, null]}"))
    for strange in (".nan", ".inf", "-.inf"):
        said = loads(TEXT.replace("WITH", f"{{s: [{strange}, null]}}"))
        assert alike(said, empty)
