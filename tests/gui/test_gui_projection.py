"""What the page is told about a task."""

from __future__ import annotations

from pathlib import Path

from played import TestClient

from grip_bt.base.errors import UnknownNameError
from grip_bt.task import load, loads
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import walk
from grip_gui.editing.projection import project_task

EXAMPLE = Path(__file__).parents[2] / "examples" / "tasks" / "reactive_pick.yaml"


def find(node: str):
    try:
        return Catalog.builtin().get(node)
    except UnknownNameError:
        return None


def test_nodes_come_parents_first_in_document_order() -> None:
    task = load(EXAMPLE)
    view = project_task(task, "tasks/reactive_pick.yaml", find)
    assert [node.path for node in view.nodes] == [path for path, _ in walk(task.root)]
    seen: set[str | None] = {None}
    for node in view.nodes:
        assert node.parent in seen
        seen.add(node.path)


def test_children_and_parents_agree() -> None:
    view = project_task(load(EXAMPLE), "x.yaml", find)
    assert {(n.path, c) for n in view.nodes for c in n.children} == {
        (n.parent, n.path) for n in view.nodes if n.parent is not None
    }


def test_edges_of_a_machine_say_whether_they_leave_it() -> None:
    nodes = {node.path: node for node in project_task(load(EXAMPLE), "x.yaml", find).nodes}
    approach = nodes["next_object/attempt/pick/approach"]
    assert approach.initial
    assert [(e.outcome, e.target, e.ends) for e in approach.on] == [
        ("success", "close", False),
        ("failure.no_plan", "remember", False),
        ("failure", "back_off", False),
    ]
    assert [(e.target, e.ends) for e in nodes["next_object/attempt/pick/remember"].on] == [("missed", True)]
    assert not nodes["next_object/attempt/pick/close"].initial


DERIVED = """\
grip: 1
name: derived
root:
  kind: sequence
  children:
    a: {node: flow/succeed}
    either:
      kind: fallback
      children:
        b: {node: flow/succeed}
        c: {node: flow/succeed}
    again: {kind: retry, times: 3, child: {d: {node: flow/succeed}}}
    inverted: {kind: invert, child: {e: {node: flow/succeed}}}
    failing: {kind: force, as: failure, child: {f: {node: flow/succeed}}}
    both:
      kind: parallel
      children:
        g: {node: flow/succeed}
        h: {node: flow/succeed}
    chosen:
      kind: switch
      on_value: "1"
      cases: {i: 0, j: 1}
      children:
        i: {node: flow/succeed}
        j: {node: flow/succeed}
"""


def test_what_follows_from_a_kind_is_said_at_the_child() -> None:
    nodes = project_task(loads(DERIVED), "x.yaml", find).nodes
    leads = {n.name: [(e.outcome, e.target, e.ends) for e in n.derived] for n in nodes if n.derived}
    assert leads == {
        "a": [("success", "either", False)],
        "either": [("success", "again", False)],
        "again": [("success", "inverted", False)],
        "inverted": [("success", "failing", False)],
        "failing": [("success", "both", False)],
        "both": [("success", "chosen", False)],
        "b": [("failure", "c", False)],
        "d": [("failure", "d", False)],
        "e": [("success", "failure", True), ("failure", "success", True)],
        "f": [("success", "failure", True)],
    }
    assert {n.name for n in nodes if n.initial} == {"a", "b", "d", "e", "f"}


def test_exits_are_shown_at_the_child_they_belong_to() -> None:
    nodes = {node.path: node for node in project_task(load(EXAMPLE), "x.yaml", find).nodes}
    assert [(e.outcome, e.target, e.ends) for e in nodes["next_object/attempt/todo"].on] == [
        ("nothing_left", "nothing_left", True)
    ]


def test_outcomes_carry_the_meaning_that_the_task_gives_them() -> None:
    text = "grip: 1\nname: t\nroot: {node: flow/wait, with: {seconds: 1}, meaning: {success: failure}}\n"
    (leaf,) = project_task(loads(text), "t.yaml", find).nodes
    assert leaf.outcomes["success"] == "failure"


def test_variables_keep_their_scope_type_and_start_value() -> None:
    view = project_task(load(EXAMPLE), "x.yaml", find)
    found = {(v.scope, v.name): v for v in view.variables}
    assert found["", "tried"].initial == "[]"
    assert found["next_object/attempt", "grasp"].type == "Grasp"
    assert found["next_object/attempt", "grasp"].initial is None


def test_containers_say_their_settings() -> None:
    labels = {node.path: node.label for node in project_task(load(EXAMPLE), "x.yaml", find).nodes}
    assert labels["next_object"] == "at most 5 attempts"
    assert labels["next_object/attempt/propose"] == "at most 30 s"
    assert labels["next_object/attempt/ready/away"] == "arm/clear_view"


def test_a_broken_file_is_shown_with_the_reason_and_its_line(page: TestClient, project: Path) -> None:
    (project / "tasks" / "broken.yaml").write_text("grip: 1\nname: broken\nroot: {kind: sequenz, children: {}}\n")
    view = page.get("/api/document", params={"path": "tasks/broken.yaml"}).json()["task"]
    assert view["nodes"] == []
    (problem,) = view["problems"]
    assert "tasks/broken.yaml:3" in problem["message"]


def test_a_wrong_task_is_still_drawn(page: TestClient, project: Path) -> None:
    (project / "tasks" / "wrong.yaml").write_text("grip: 1\nname: wrong\nroot: {node: no/such_node}\n")
    view = page.get("/api/document", params={"path": "tasks/wrong.yaml"}).json()["task"]
    assert [node["label"] for node in view["nodes"]] == ["no/such_node"]
    assert any(p["severity"] == "error" and "no/such_node" in p["message"] for p in view["problems"])


def test_a_broken_project_file_is_a_problem_and_not_a_dead_page(page: TestClient, project: Path) -> None:
    (project / "grip.yaml").write_text("grip: 1\nrobbot: x\n")
    view = page.get("/api/document", params={"path": "tasks/tiny.yaml"}).json()["task"]
    assert view["nodes"]
    assert any(p["code"] == "project" and "robbot" in p["message"] for p in view["problems"])


def test_a_task_file_that_is_not_there_is_named(page: TestClient) -> None:
    answer = page.get("/api/document", params={"path": "tasks/other.yaml"})
    assert answer.status_code == 404
    assert "tasks/other.yaml" in answer.json()["detail"]


def test_ports_of_the_task_are_variables_that_say_so_and_values_come_whole() -> None:
    text = (
        "grip: 1\nname: t\ninputs: {a: {type: 'list[int]', value: [1, 2]}, b: Pose}\noutputs: {b: Pose, c: str}\n"
        "data: {d: {type: str, value: " + "x" * 3000 + "}}\nroot: {kind: sequence, children: {}}\n"
    )
    views = {view.name: view for view in project_task(loads(text), "t.yaml", lambda _: None).variables}
    ports = {"a": ["input"], "b": ["input", "output"], "c": ["output"], "d": []}
    assert {name: view.ports for name, view in views.items()} == ports
    assert (views["a"].initial, views["a"].whole) == ("[1, 2]", True)
    assert (len(views["d"].initial or ""), views["d"].whole) == (2000, False)


MIXED = """\
grip: 1
name: mixed
outcomes: {done: success}
root:
  kind: sequence
  exits: {}
  on: {success: done, failure: done}
  children:
    group: {kind: fallback, exits: {one.failure: success}, children: {one: {node: flow/fail}, two: {node: own/leaf}}}
    part: {kind: subtask, task: tasks/part.yaml}
    machine:
      kind: state_machine
      initial: a
      outcomes: {success: success, failure: failure}
      children:
        a: {node: flow/succeed, on: {success: b}}
        b: {node: flow/succeed, on: {success: success}}
"""


def test_a_leaf_and_a_subtask_show_what_their_manifests_say() -> None:
    made = {"id": "own/leaf", "implementation": "own:Leaf", "outcomes": {"success": "success"}}
    manifests = {"own/leaf": Manifest(doc="a leaf", **made), "tasks/part.yaml": Manifest(doc="a part", **made)}
    view = project_task(loads(MIXED), "x.yaml", manifests.get)
    assert {node.path: node.doc for node in view.nodes}["group/two"] == "a leaf"
    assert {node.path: list(node.outcomes) for node in view.nodes}["part"] == ["success"]
