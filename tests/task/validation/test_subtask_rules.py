"""Subtasks and the files that they run: ports, outcomes, what is written when, and recursion."""

from __future__ import annotations

import pytest

from grip_bt.task import loads, read_text
from grip_bt.task.catalog import Catalog, TaskTexts
from grip_bt.task.validation import validate

FETCH = """
grip: 1
name: fetch
outcomes: {found: success, empty: failure}
inputs: {n: int, by: {type: int, value: 1}}
outputs: {made: int}
root:
  kind: sequence
  on: {success: found, failure: empty}
  children:
    look: {kind: guard, if: n > by, child: {go: {node: flow/succeed}}}
    make: {node: flow/compute, with: {expression: a}, in: {a: n}, out: {value: made}}
"""


def issues(
    root: str, data: str = "{n: {type: int, value: 1}, m: int, s: {type: str, value: a}}", **files: str
) -> list[str]:
    texts = {"fetch": FETCH, **files}
    catalog = Catalog.builtin().with_(tasks=TaskTexts({f"{k}.yaml": loads(v) for k, v in texts.items()}))
    document = read_text(f"grip: 1\nname: t\ndata: {data}\nroot: {root}\n", "t.yaml")
    return [
        str(issue)
        for issue in validate(document.task, catalog, document).issues
        if issue.code not in ("never-read", "unused-outcome")
    ]


def subtask(rest: str) -> str:
    return f"{{kind: subtask, task: fetch.yaml, {rest}}}"


@pytest.mark.parametrize(
    ("rest", "code", "said"),
    [
        ("in: {n: s}", "wrong-variable-type", "the port 'n' reads int, but 's' holds str"),
        ("in: {n: n}, out: {made: s}", "wrong-variable-type", "the port 'made' writes int, but 's' holds str"),
        ("in: {n: n, m: n}", "unknown-input", "fetch.yaml has no input 'm' (available: n, by)"),
        ("in: {n: n}, out: {mad: m}", "unknown-output", "fetch.yaml has no output 'mad'; did you mean 'made'?"),
        ("in: {n: n}, meaning: {lost: success}", "unknown-outcome", "fetch.yaml has no outcome 'lost'"),
        ("in: {n: x}", "undeclared-variable", "the port 'n' is bound to 'x', which isn't declared"),
        ("with: {n: many}", "wrong-parameter-type", "the input 'n' of fetch.yaml"),
        ("with: {by: 2}", "missing-input", "fetch.yaml needs the input 'n' (int)"),
        ("in: {n: m}", "read-before-write", "the port 'n' reads 'm', which isn't written on every path"),
    ],
)
def test_a_port_that_does_not_fit_is_named_with_its_place(rest: str, code: str, said: str) -> None:
    (issue,) = issues(subtask(rest))
    assert issue.startswith("t.yaml:4:")
    assert f"error[{code}]" in issue
    assert said in issue


def test_an_output_is_written_with_the_outcomes_with_which_the_file_has_written_it() -> None:
    after = "last: {node: flow/log, with: {message: x}, in: {value: m}}"
    fetch = subtask("in: {n: n}, out: {made: m}")
    assert issues(f"{{kind: sequence, children: {{f: {fetch}, {after}}}}}") == []
    (issue,) = issues(f"{{kind: fallback, children: {{f: {fetch}, {after}}}}}")
    assert "read-before-write" in issue


def test_its_outcomes_are_those_of_the_file() -> None:
    states = "outcomes: {ok: success}, children: {f: {kind: subtask, task: fetch.yaml, in: {n: n}, on: {found: ok%s}}}"
    machine = f"{{kind: state_machine, initial: f, {states}}}"
    assert issues(machine % ", empty: f") == []
    (issue,) = issues(machine % "")
    assert "f: its outcome 'empty' isn't connected" in issue
    assert "unknown-outcome" in "".join(issues(machine % ", empty: f, success: ok"))


def test_children_of_a_parallel_share_what_their_subtasks_write_and_read() -> None:
    one, two = subtask("in: {n: n}, out: {made: n}"), subtask("in: {n: n}")
    (issue,) = issues(f"{{kind: parallel, children: {{a: {one}, b: {two}}}}}")
    assert "error[parallel-read-write]" in issue
    assert issues(f"{{kind: parallel, order: declared, children: {{a: {one}, b: {two}}}}}") == []


def test_a_ring_of_files_is_shown_as_a_chain_wherever_one_enters_it() -> None:
    files = {
        "a": "grip: 1\nname: a\nroot: {kind: subtask, task: b.yaml}\n",
        "b": "grip: 1\nname: b\nroot: {kind: subtask, task: a.yaml}\n",
    }
    (issue,) = issues("{kind: subtask, task: a.yaml}", **files)
    assert "error[recursive-subtask]" in issue
    assert "a.yaml -> b.yaml -> a.yaml" in issue


def test_an_input_that_nobody_reads_is_named_in_the_file_that_declares_it() -> None:
    document = read_text(FETCH.replace("n > by", "n > 1"), "fetch.yaml")
    (issue,) = validate(document.task, Catalog.builtin(), document).issues
    assert (issue.code, issue.line) == ("never-read", 5)
    assert "the input 'by' is never used" in issue.message


def test_a_file_that_many_subtasks_run_is_checked_once() -> None:
    class Counting(TaskTexts):
        read_files = 0

        def read(self, file):
            Counting.read_files += 1
            return super().read(file)

    children = ", ".join(f"c{i}: {subtask('in: {n: n}')}" for i in range(50))
    catalog = Catalog.builtin().with_(tasks=Counting({"fetch.yaml": loads(FETCH)}))
    task = loads(
        f"grip: 1\nname: t\ndata: {{n: {{type: int, value: 1}}}}\nroot: {{kind: sequence, children: {{{children}}}}}\n"
    )
    assert validate(task, catalog).issues == ()
    assert Counting.read_files == 1
