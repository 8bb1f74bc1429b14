"""A task that runs other files: paths, values in and out, outcomes, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from py_trees.common import Status

from grip_bt.base.errors import InvalidTaskError, NodeError, NotExpressibleError, SubtaskError
from grip_bt.compilers import Rushing, to_machine, to_tree
from grip_bt.formats.pytrees import to_task, to_xml
from grip_bt.formats.standalone import export
from grip_bt.nodes import Leaf
from grip_bt.task import loads
from grip_bt.task.catalog import Catalog, Manifest, TaskFolder, TaskTexts

FACE = Manifest(
    id="test/add",
    doc="Adds.",
    implementation=f"{Path(__file__).resolve()}:Add",
    parameters={"fails": {"type": "str", "default": ""}},
    inputs={"a": {"type": "int", "required": False}},
    outputs={"x": {"type": "Any", "on": ["success", "failure"]}},
)
ADD = """
grip: 1
name: add
outcomes: {added: success, bad: failure, worse: failure}
inputs: {a: int}
outputs: {x: int, never: int}
data: {kept: {type: int, value: 0}}
root:
  kind: sequence
  on: {success: added, failure: bad, failure.no_ik: worse}
  children:
    one: {node: test/add, in: {a: a}, out: {x: x}}
    two: {node: test/add, in: {a: x}, out: {x: x}, with: {fails: FAILS}}
"""


class Add(Leaf):
    def update(self) -> Status:
        made = self.end(x=self.read("a") + 1 if self.readers else "text")
        return self.fail(self.params["fails"], x=self.read("a") + 1) if self.params["fails"] else made


class Context:
    preempt_requested = False

    def wake(self) -> None:
        """Nobody waits."""


class Watch:
    def __init__(self) -> None:
        self.events: list[Any] = []

    def entered(self, path: str) -> None:
        self.events.append(("enter", path))

    def ended(self, path: str, outcome: str, failure: Any) -> None:
        self.events.append((outcome, path))

    def interrupted(self, path: str) -> None:
        self.events.append(("interrupted", path))

    def message(self, path: str, text: str) -> None:
        """Nothing says anything."""

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        self.events.append(("wrote", path, variable, value))


def outer(node: str, fails: str = '""', **files: str) -> tuple[Any, Catalog]:
    task = loads(
        f"grip: 1\nname: outer\ndata: {{n: {{type: int, value: 3}}, m: {{type: int, value: 0}}}}\nroot: {node}\n"
    )
    texts = {"add.yaml": ADD.replace("FAILS", fails), **{f"{name}.yaml": text for name, text in files.items()}}
    return task, Catalog([FACE], TaskTexts({name: loads(text) for name, text in texts.items()}))


NODE = "{kind: sequence, children: {sub: {kind: subtask, task: add.yaml, in: {a: n}, out: {x: m, never: n}}}}"


def run(target: Any, task: Any, catalog: Catalog) -> tuple[Any, Watch, Any]:
    compiled, watch = target(task, catalog), Watch()
    compiled.observe(watch)
    compiled.prepare(Context())
    return compiled.execute(Rushing()), watch, compiled


@pytest.mark.parametrize("target", [to_tree, to_machine])
def test_values_go_in_on_entry_and_out_at_the_end_and_paths_go_on_inside(target: Any) -> None:
    end, watch, compiled = run(target, *outer(NODE))
    assert end.outcome == "success"
    assert watch.events == [
        ("enter", "/"),
        ("enter", "sub"),
        ("wrote", "sub", "a", 3),
        ("enter", "sub/"),
        ("enter", "sub/one"),
        ("wrote", "sub/one", "x", 4),
        ("success", "sub/one"),
        ("enter", "sub/two"),
        ("wrote", "sub/two", "x", 5),
        ("success", "sub/two"),
        ("success", "sub/"),
        ("wrote", "sub", "m", 5),
        ("added", "sub"),
        ("success", "/"),
    ]
    assert compiled.data.snapshot()["", "n"] == 3  # an output that wasn't written leaves what is there
    assert list(compiled.leaves) == ["sub/one", "sub/two"]


@pytest.mark.parametrize("target", [to_tree, to_machine])
@pytest.mark.parametrize(("code", "outcome"), [("no_plan", "bad"), ("no_ik", "worse")])
def test_it_ends_with_an_outcome_of_its_file_and_the_reason_is_carried_up(target: Any, code: str, outcome: str) -> None:
    end, watch, _ = run(target, *outer(NODE, code))
    assert (end.outcome, end.failure.code) == ("failure", code)
    assert (outcome, "sub") in watch.events
    assert ("wrote", "sub", "m", 5) in watch.events  # outputs are handed out whatever the outcome


@pytest.mark.parametrize("target", [to_tree, to_machine])
def test_an_input_that_was_never_written_is_an_error_of_the_subtask(target: Any) -> None:
    task, catalog = outer(NODE)
    task = task.model_copy(update={"data": {"n": "int", "m": "int"}})
    with pytest.raises(NodeError, match="sub: .*'n' was read before it was written"):
        run(target, task, catalog)


@pytest.mark.parametrize("target", [to_tree, to_machine])
def test_literals_are_given_anew_and_a_subtask_may_run_others(target: Any) -> None:
    middle = """
grip: 1
name: middle
inputs: {some: "list[int]", a: {type: int, value: 1}}
outputs: {x: int}
root: {kind: subtask, task: add.yaml, in: {a: a}, out: {x: x}, meaning: {bad: success}}
"""
    node = "{kind: repeat, times: 2, child: {sub: {kind: subtask, task: middle.yaml, with: {some: [1]}, out: {x: m}}}}"
    end, _, compiled = run(target, *outer(node, "no_plan", middle=middle))
    assert end.outcome == "success"
    assert list(compiled.leaves) == ["sub//one", "sub//two"]
    assert compiled.data.snapshot()["", "m"] == 3


def test_a_file_that_runs_itself_is_refused_with_the_chain() -> None:
    ring = "grip: 1\nname: x\nroot: {kind: subtask, task: OTHER.yaml}\n"
    task, catalog = outer("{kind: subtask, task: a.yaml}", a=ring.replace("OTHER", "b"), b=ring.replace("OTHER", "a"))
    with pytest.raises(InvalidTaskError, match=r"a task can't run itself: a.yaml -> b.yaml -> a.yaml"):
        to_tree(task, catalog)


@pytest.mark.parametrize(
    ("node", "why"),
    [
        ("{kind: subtask, task: ad.yaml, in: {a: n}}", "there is no such file; did you mean 'add.yaml'"),
        ("{kind: subtask, task: add.yaml}", "needs the input 'a'"),
        ("{kind: subtask, task: add.yaml, in: {a: n, b: n}}", "has no input 'b'"),
        ("{kind: subtask, task: add.yaml, with: {b: 1}, in: {a: n}}", "has no input 'b'"),
        ("{kind: subtask, task: add.yaml, in: {a: n}, out: {y: n}}", "has no output 'y'"),
        ("{kind: subtask, task: add.yaml, in: {a: nn}}", "bound to 'nn', which isn't declared"),
    ],
)
def test_a_subtask_that_does_not_fit_its_file_is_refused(node: str, why: str) -> None:
    with pytest.raises(InvalidTaskError, match=why):
        to_tree(*outer(node))


def test_the_tree_gives_the_subtask_back() -> None:
    task, catalog = outer(NODE)
    assert to_task(to_tree(task, catalog)).task == task


def test_files_outside_of_the_project_are_not_read(tmp_path: Path) -> None:
    project = tmp_path / "project"
    (project / "tasks").mkdir(parents=True)
    (tmp_path / "secret.yaml").write_text(ADD)
    (project / "tasks" / "link.yaml").symlink_to(tmp_path / "secret.yaml")
    (project / "tasks" / "add.yaml").write_text(ADD.replace("FAILS", '""'))
    (project / "tasks" / "bad.yaml").write_text("grip: 2\n")
    folder = TaskFolder(project)
    assert folder.read("tasks/add.yaml").name == "add"
    for file, why in {
        "../secret.yaml": "without `..`",
        str(tmp_path / "secret.yaml"): "from the project's folder on",
        "tasks/link.yaml": "outside of the project's folder",
        "tasks/adds.yaml": "did you mean 'tasks/add.yaml'",
        "tasks/bad.yaml": "it isn't a task",
        "tasks": "it isn't a task",
    }.items():
        with pytest.raises(SubtaskError, match=why):
            folder.read(file)


def test_a_file_is_read_again_when_it_has_changed(tmp_path: Path) -> None:
    file = tmp_path / "add.yaml"
    file.write_text(ADD.replace("FAILS", '""'))
    folder = TaskFolder(tmp_path)
    assert folder.read("add.yaml") is folder.read("add.yaml")
    file.write_text(ADD.replace("FAILS", '"changed"'))
    assert folder.read("add.yaml").root.children["two"].with_["fails"] == "changed"


def test_other_formats_refuse_it_by_name() -> None:
    task, catalog = outer(NODE)
    task = task.model_copy(update={"data": {"n": "int", "m": "int"}})
    for convert in (to_xml, export):
        with pytest.raises(NotExpressibleError, match="sub: a subtask can't be expressed"):
            convert(task, catalog)
