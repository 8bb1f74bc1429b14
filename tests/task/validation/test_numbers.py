"""Numbers that aren't finite are told with their line, also deep within a literal."""

from __future__ import annotations

import pytest

from grip_bt.task import read_text
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate

LEAF = "{node: arm/move_straight, with: {offset: OFFSET}}"


def said(text: str) -> list[tuple[str, str, int | None]]:
    document = read_text(text, "t.yaml")
    return [
        (i.code, i.message.partition(":")[0], i.line)
        for i in validate(document.task, Catalog.builtin(), document).issues
        if i.code in ("not-a-number", "infinite-number")
    ]


def task(root: str, data: str = "") -> str:
    return f"grip: 1\nname: demo\n{data}root:\n  {root}\n"


def test_a_number_within_a_list_is_told_with_its_place():
    assert said(task(LEAF.replace("OFFSET", "[.nan, 0.0, -.inf]"))) == [
        ("not-a-number", "with/offset/0", 4),
        ("infinite-number", "with/offset/2", 4),
    ]


def test_a_number_within_a_mapping_is_told():
    root = "{node: arm/move_to, with: {state: home, keep: {orientation: now, tolerance: [0.1, 0.1, .nan]}}}"
    assert said(task(root)) == [("not-a-number", "with/keep/tolerance/2", 4)]


@pytest.mark.parametrize("kind", ["timeout", "cooldown"])
def test_seconds_without_an_end_are_told(kind):
    root = f"{{kind: {kind}, seconds: .inf, child: {{a: {LEAF.replace('OFFSET', '[0.0, 0.0, 0.1]')}}}}}"
    assert said(task(root)) == [("infinite-number", "seconds", 4)]


def test_a_case_that_nothing_equals_is_told():
    leaf = LEAF.replace("OFFSET", "[0.0, 0.0, 0.1]")
    root = f"{{kind: switch, on_value: x, cases: {{a: [1.0, .nan], b: .inf}}, children: {{a: {leaf}, b: {leaf}}}}}"
    assert said(task(root, "data: {x: {type: float, value: .inf}}\n")) == [("not-a-number", "cases/a/1", 5)]


def test_a_variable_may_begin_with_infinity_but_not_with_nan():
    data = "data:\n  least: {type: float, value: .inf}\n  most: {type: 'list[float]', value: [-.inf, .nan]}\n"
    assert said(task(LEAF.replace("OFFSET", "[0.0, 0.0, 0.1]"), data)) == [("not-a-number", "data/most/value/1", 5)]


def test_finite_numbers_are_no_issue():
    assert said(task(LEAF.replace("OFFSET", "[0.0, 1.0e+300, -2]"))) == []
