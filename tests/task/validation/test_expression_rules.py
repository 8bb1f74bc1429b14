"""Expressions, cases and rules against what a task declares."""

from __future__ import annotations

import pytest

from grip_bt.task import read_text
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.validation import validate

ENDS = {"success": "success", "none": "success", "failure": "failure"}
CATALOG = Catalog([Manifest(id="demo/leaf", doc="Does it.", implementation="demo:Leaf", outcomes=ENDS)])
DATA = (
    "{n: {type: int, value: 1}, t: {type: str, value: a}, items: {type: 'list[int]', value: []},"
    " g: {type: 'Grasp | None', value: null}, pose: Pose, any: {type: Any, value: 1}}"
)


def issues(root: str) -> list[tuple[str, str]]:
    text = f"grip: 1\nname: t\ndata: {DATA}\nroot: {root}\n"
    document = read_text(text, "t.yaml")
    found = [i for i in validate(document.task, CATALOG, document).issues if i.code != "never-read"]
    assert all(i.line is not None for i in found)
    return [(i.code, i.message) for i in found]


def guard(condition: str) -> list[tuple[str, str]]:
    return issues(f'{{kind: guard, if: "{condition}", child: {{a: {{node: demo/leaf}}}}}}')


@pytest.mark.parametrize(
    "condition",
    ["n > 0", "n + 0.5 < 2", "t == 'a'", "n in items", "len(items) > max(n, 2)", "g is not None and g.quality > 0.5",
     "any", "any.what", "max(items) > 1", "t in ['a', 'b']", "not (n == 1)", "abs(n) / 2 >= 0.5",
     "any > 3", "g == null"],
)  # fmt: skip
def test_a_condition_whose_parts_fit_has_no_issue(condition: str) -> None:
    assert guard(condition) == []


@pytest.mark.parametrize(
    ("condition", "words"),
    [
        ("n", "gives a int"),
        ("items and n > 1", "`items` is a list[int], not true or false"),
        ("t + 1 > 0", "`t` is a str, not a number"),
        ("t < n", "a str can't be compared with a int"),
        ("t == 1", "can't be compared"),
        ("n in n", "which nothing can be in"),
        ("len(n) > 1", "which has no length"),
        ("g.qualty > 1", "did you mean 'quality'"),
        ("t.size > 1", "which has no attributes"),
        ("min(n) > 1", "takes a list"),
        ("abs(t) > 1", "not a number"),
    ],
)
def test_a_part_that_doesnt_fit_is_told_with_its_type(condition: str, words: str) -> None:
    ((code, message),) = guard(condition)
    assert code == "wrong-expression-type"
    assert words in message


def test_an_unknown_variable_of_an_expression_names_the_nearest_one() -> None:
    ((code, message),) = guard("itms == 3")
    assert code == "undeclared-variable"
    assert "did you mean 'items'" in message


def test_an_expression_reads_what_it_names_and_may_do_so_too_early() -> None:
    assert [code for code, _ in guard("pose == pose")] == ["read-before-write"]


def test_a_precondition_sees_what_is_around_its_node_and_not_its_own_variables() -> None:
    found = issues(
        "{kind: sequence, precondition: own > 1, data: {own: {type: int, value: 2}}, children: {a: {node: demo/leaf}}}"
    )
    assert [code for code, _ in found] == ["undeclared-variable"]


def test_a_precondition_needs_failure_to_mean_failure_and_adds_it_to_the_ends_of_a_state() -> None:
    found = issues("{node: demo/leaf, precondition: n > 1, meaning: {failure: success}}")
    assert "contradictory-outcome" in [code for code, _ in found]
    machine = (
        "{kind: state_machine, initial: a, outcomes: {done: success}, on: {done: success}, children:"
        " {a: {kind: state_machine, precondition: n > 1, initial: b, outcomes: {ok: success}, on: {ok: done},"
        " children: {b: {node: demo/leaf, on: {success: ok, none: ok, failure: ok}}}}}}"
    )
    assert [code for code, _ in issues(machine) if code.startswith("missing")] == ["missing-target"]


def parallel(more: str) -> list[tuple[str, str]]:
    return issues(f"{{kind: parallel, {more}, children: {{a: {{node: demo/leaf}}, b: {{node: demo/leaf}}}}}}")


@pytest.mark.parametrize(
    ("more", "code"),
    [
        ("rules: [{when: {c: success}, then: success}]", "unknown-child"),
        ("rules: [{when: {a: [success, odd]}, then: success}]", "unknown-outcome"),
        ("rules: [{then: odd}]", "unknown-target"),
        ("wait_for: [a, c]", "unknown-child"),
        ("rules: [{when: {a: success.no_ik}, then: success}]", "unknown-code"),
        ("outcomes: {odd: success}, rules: [{then: success}]", "unused-outcome"),
    ],
)
def test_rules_of_a_parallel_are_about_what_is_there(more: str, code: str) -> None:
    assert [code for code, _ in parallel(more) if code != "missing-target"] == [code]


def test_rules_use_outcomes_and_order_declared_allows_shared_variables() -> None:
    assert parallel("outcomes: {odd: success}, on: {odd: success}, rules: [{when: {a: none}, then: odd}]") == []
    both = "children: {a: {kind: guard, if: n > 0, child: {l: {node: demo/leaf}}}, b: {node: demo/leaf}}"
    assert issues(f"{{kind: parallel, order: declared, {both}}}") == []


@pytest.mark.parametrize(
    ("more", "code"),
    [
        ("cases: {a: 1, c: 2}", "unknown-child"),
        ("cases: {a: 1}, default: c", "unknown-child"),
        ("cases: {a: 1, b: [2, 1.0]}", "ambiguous-case"),
    ],
)
def test_cases_name_children_once_each(more: str, code: str) -> None:
    found = issues(
        f"{{kind: switch, on_value: n, {more}, children: {{a: {{node: demo/leaf}}, b: {{node: demo/leaf}}}}}}"
    )
    assert [c for c, _ in found if c != "unreachable-node"] == [code]


def test_a_child_without_a_case_is_unreachable() -> None:
    both = "children: {a: {node: demo/leaf}, b: {node: demo/leaf}}"
    assert [c for c, _ in issues(f"{{kind: switch, on_value: n, cases: {{a: 1}}, {both}}}")] == ["unreachable-node"]
    assert issues(f"{{kind: switch, on_value: n, cases: {{a: 1}}, default: b, {both}}}") == []


def test_a_for_each_takes_a_list_and_its_item_has_the_type_of_the_lists_items() -> None:
    child = "child: {a: {kind: guard, if: one > 1, child: {l: {node: demo/leaf}}}}"
    assert issues(f"{{kind: for_each, items: items, item: one, {child}}}") == []
    assert [c for c, _ in issues(f"{{kind: for_each, items: n, item: one, {child}}}")] == ["wrong-variable-type"]
    wrong = child.replace("one > 1", "one == 'a'")
    assert [c for c, _ in issues(f"{{kind: for_each, items: items, item: one, {wrong}}}")] == ["wrong-expression-type"]
    assert "shadowed-variable" in [c for c, _ in issues(f"{{kind: for_each, items: items, item: n, {child}}}")]


@pytest.mark.parametrize(
    ("leaf", "expression", "code"),
    [
        ("flow/compute", "a + 1", None),
        ("flow/wait_until", "a > 1 and true", None),
        ("flow/compute", "a[0]", "bad-expression"),
        ("flow/compute", "a + n", "undeclared-variable"),
        ("flow/wait_until", "b > 1", "undeclared-variable"),
    ],
)
def test_an_expression_among_parameters_reads_the_inputs_that_are_bound(
    leaf: str, expression: str, code: str | None
) -> None:
    root = f"{{node: {leaf}, with: {{expression: '{expression}'}}, in: {{a: n}}}}"
    text = f"{{grip: 1, name: t, data: {DATA}, root: {root}}}"
    document = read_text(text, "t.yaml")
    found = validate(document.task, Catalog.builtin(), document).issues
    assert [(issue.code, issue.line) for issue in found if issue.severity == "error"] == (
        [] if code is None else [(code, 1)]
    )
