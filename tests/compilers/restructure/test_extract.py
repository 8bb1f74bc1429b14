"""A part of a task to a file of its own: the text that comes of it, and what is refused."""

import pytest

from grip_bt.base.errors import EditError
from grip_bt.compilers.restructure import extracted
from grip_bt.task import loads, read_text
from grip_bt.task.catalog import Catalog, TaskTexts
from grip_bt.task.edit import Extract, apply, apply_to_document, command_of
from grip_bt.task.validation import validate

TEXT = """\
grip: 1
name: demo
data: {start: {type: int, value: 1}, reached: int, unused: {type: int, value: 0}}
root:
  kind: state_machine
  initial: count
  outcomes: {done: success, lost: failure}
  on: {done: success, lost: failure}
  children:
    # how far it goes
    count:
      kind: sequence  # one after the other
      precondition: unused < 3
      on: {success: say, failure: lost, failure.loop_limit: lost}
      children:
        begin: {node: flow/compute, with: {expression: a}, in: {a: start}, out: {value: reached}}
        # and on
        add: {node: flow/compute, with: {expression: a + 1}, in: {a: reached}, out: {value: reached}}
    say: {node: flow/log, with: {message: there}, in: {value: reached}, on: {success: done}}
"""
PART = """\
grip: 1
name: count
inputs: {start: int}
outputs: {reached: int}
root:
  kind: sequence  # one after the other
  children:
    begin: {node: flow/compute, with: {expression: a}, in: {a: start}, out: {value: reached}}
    # and on
    add: {node: flow/compute, with: {expression: a + 1}, in: {a: reached}, out: {value: reached}}
"""
LEFT = """\
    count:
      kind: subtask
      precondition: unused < 3
      task: tasks/count.yaml
      in: {start: start}
      out: {reached: reached}
      on: {success: say, failure: lost, failure.loop_limit: lost}
"""
CATALOG = Catalog.builtin()
TAKE = Extract(path="count", file="tasks/count.yaml")


def with_files(**texts):
    return CATALOG.with_(tasks=TaskTexts({f"tasks/{name}.yaml": loads(text) for name, text in texts.items()}))


def test_a_part_goes_to_a_file_with_its_comments_and_its_ports():
    document = read_text(TEXT)
    made = extracted(TAKE, document, CATALOG)
    assert made.text == PART
    done = apply_to_document(document, made.edit)
    assert LEFT in done.document.text
    assert not validate(done.document.task, with_files(count=made.text)).issues


def test_the_command_has_a_wire_form():
    assert command_of(TAKE.model_dump(mode="json")) == TAKE


def test_it_needs_a_catalogue():
    with pytest.raises(EditError, match=r"needs a catalogue: apply what .*\.extracted"):
        apply(loads(TEXT), TAKE)


HEAD = "grip: 1\nname: a\n"
INNER = "{kind: sequence, children: {b: {node: flow/compute, with: {expression: '1'}, out: {value: v}}}}"
READER = "{kind: sequence, children: {b: {node: flow/log, with: {message: b}, in: {value: v}}}}"
WRITER = "{node: flow/compute, with: {expression: '2'}, out: {value: v}}"


@pytest.mark.parametrize(
    ("text", "path", "words"),
    [
        (f"{HEAD}root: {{kind: sequence, children: {{n: {INNER}}}}}\n", "/", "the root is the task already"),
        (f"{HEAD}root: {{kind: sequence, children: {{n: {INNER}}}}}\n", "m", "there is no such node"),
        (f"{HEAD}root: {{kind: sequence, children: {{n: {{node: a/b}}}}}}\n", "n", "the catalogue doesn't know"),
        (
            f"{HEAD}data: {{v: int}}\nroot: {{kind: sequence, children: {{n: {READER}}}}}\n",
            "n",
            "'v' may be read in it before it is written",
        ),
        (
            f"{HEAD}data: {{v: int}}\nroot: {{kind: timeout, seconds: 3, child: {{n: {INNER}}}}}\n",
            "n",
            "it writes v, and the timeout / may halt it, after which a subtask hands nothing out; take all of",
        ),
        (
            f"{HEAD}data: {{v: {{type: int, value: 1}}}}\n"
            f"root: {{kind: parallel, order: declared, children: {{w: {WRITER}, n: {READER}}}}}\n",
            "n",
            "it reads v, which another child of the parallel / may write while it runs",
        ),
    ],
)
def test_a_part_that_would_do_something_else_is_refused(text, path, words):
    with pytest.raises(EditError, match=words):
        extracted(Extract(path=path, file="tasks/n.yaml"), loads(text), CATALOG)


def test_an_inexact_part_is_taken_out_when_that_is_asked_for():
    text = f"{HEAD}data: {{v: int}}\nroot: {{kind: timeout, seconds: 3, child: {{n: {INNER}}}}}\n"
    made = extracted(Extract(path="n", file="tasks/n.yaml", approximate=True), loads(text), CATALOG)
    assert loads(made.text).outputs == {"v": "int"}


@pytest.mark.parametrize("file", ["/tmp/a.yaml", "../a.yaml", "a.py"])
def test_a_file_outside_of_the_project_is_refused(file):
    with pytest.raises(EditError, match="isn't a task file of the project"):
        extracted(Extract(path="count", file=file), loads(TEXT), CATALOG)


def test_what_is_read_only_where_nothing_leads_to_is_declared_all_the_same():
    never = "{node: flow/log, with: {message: b}, in: {value: v}}"
    inner = f"{{kind: sequence, children: {{stop: {{node: flow/fail}}, b: {never}}}}}"
    task = loads(f"{HEAD}data: {{v: int}}\nroot: {{kind: sequence, children: {{n: {inner}}}}}\n")
    made = extracted(Extract(path="n", file="tasks/n.yaml"), task, CATALOG)
    catalog = with_files(n=made.text)
    assert not validate(loads(made.text), catalog).errors
