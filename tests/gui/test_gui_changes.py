"""What a page is sent after an edit: the difference to what it has, which makes of it what the whole would be."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from played import TASK
from starlette.testclient import TestClient

from grip_gui.editing.changes import KEPT, splice_of

TINY = "tasks/tiny.yaml"
Answer = dict[str, Any]


def put(text: str, splice: dict[str, Any] | None) -> str:
    """Do to a text what the page does, which counts in UTF-16 units."""
    if splice is None:
        return text
    units = text.encode("utf-16-le")
    start, end = 2 * splice["start"], 2 * (splice["start"] + splice["removed"])
    return (units[:start] + splice["new"].encode("utf-16-le") + units[end:]).decode("utf-16-le")


def patched(document: Answer, change: Answer) -> Answer:
    """Return a document after a change, as the page makes it."""
    assert change["type"] == "change"
    assert change["since"] == document["state"]
    same = {key: change[key] for key in ("state", "revision", "saved", "change", "history")}
    task = document["task"] if change["task"] is None else patched_task(document["task"], change["task"])
    layout = change["layout"] if change["layout"] is not None else document["layout"]
    return {**document, **same, "text": put(document["text"], change["splice"]), "layout": layout, "task": task}


def patched_task(task: Answer, change: Answer) -> Answer:
    nodes = {node["path"]: node for node in task["nodes"]}
    for path in change["gone"]:
        del nodes[path]
    nodes |= {node["path"]: node for node in change["nodes"]}
    order: list[str] = []
    waiting = ["/"]
    while waiting:
        order.append(waiting.pop())
        waiting.extend(reversed(nodes[order[-1]]["children"]))
    variables = task["variables"] if change["variables"] is None else change["variables"]
    faces = {key: change[key] for key in ("name", "doc", "outcomes")}
    return {**task, **faces, "nodes": [nodes[path] for path in order], "variables": variables}


class Follower:
    """A page that is told of differences alone, once it has the whole."""

    def __init__(self, client: TestClient):
        self.client = client
        self.document: Answer = self.whole()

    def whole(self) -> Answer:
        answer: Answer = self.client.get("/api/document", params={"path": TINY, "since": 0}).json()
        assert answer["type"] == "document"
        return answer

    def post(self, what: str, **wish: Any) -> Answer:
        params = {"since": self.document["state"]}
        answer = self.client.post(f"/api/document/{what}", params=params, json={"path": TINY, **wish})
        assert answer.status_code == 200, answer.text
        change: Answer = answer.json()
        self.document = patched(self.document, change) if change["type"] == "change" else change
        return change

    def edit(self, **command: Any) -> Answer:
        return self.post("edit", base=self.document["revision"], command=command)

    def step(self, step: str) -> Answer:
        return self.post("step", base=self.document["revision"], step=step)


@pytest.fixture
def follower(page: TestClient) -> Follower:
    return Follower(page)


def test_an_edit_sends_the_nodes_that_changed_and_no_others(follower: Follower) -> None:
    change = follower.edit(do="add", parent="/", name="coffee", node={"node": "flow/succeed"})
    assert {node["path"] for node in change["task"]["nodes"]} == {"/", "machine", "coffee"}
    assert change["task"]["variables"] is None
    assert follower.document == follower.whole()
    assert len(change["splice"]["new"]) < len(TASK)


def test_a_save_and_a_place_draw_no_node_anew(follower: Follower) -> None:
    first = follower.document["task"]["nodes"][1]["path"]
    assert follower.post("pin", view="flow", positions={first: (16, 32)})["task"] is None
    assert follower.document["layout"]["flow"] == {first: [16, 32]}
    assert follower.post("save")["task"] is None
    assert follower.document == follower.whole()


def test_every_way_through_edits_ends_with_the_document_that_the_whole_would_be(follower: Follower) -> None:
    random = Random(8)
    for number in range(40):
        paths = [node["path"] for node in follower.document["task"]["nodes"]]
        history = follower.document["history"]
        kind = random.choice(["add", "add", "rename", "remove", "undo", "redo", "doc"])
        some = random.choice(paths[1:])
        made = [path for path in paths if path.startswith(("new", "other")) and "/" not in path]
        if kind == "add":
            follower.edit(do="add", parent="/", name=f"new{number}", node={"node": "flow/succeed"}, index=0)
        elif kind == "rename":
            follower.edit(do="rename", path=some, name=f"other{number}")
        elif kind == "remove" and made:
            follower.edit(do="remove", path=random.choice(made))
        elif kind == "undo" and history["can_undo"]:
            follower.step("undo")
        elif kind == "redo" and history["can_redo"]:
            follower.step("redo")
        else:
            follower.edit(do="set", path="", key=["doc"], value=f"Says {number} and 🤖.")
        assert follower.document == follower.whole()


def test_a_text_that_is_no_task_is_sent_whole_and_so_is_what_follows(follower: Follower) -> None:
    broken = follower.post("text", base=follower.document["revision"], text="grip: [")
    assert broken["type"] == "document"
    assert broken["checked"]
    assert broken["task"]["problems"]
    assert follower.post("text", base=broken["revision"], text=TASK)["type"] == "document"
    assert not follower.document["checked"]


def test_who_has_a_state_that_nobody_remembers_gets_the_whole(follower: Follower, page: TestClient) -> None:
    late = Follower(page)
    for number in range(KEPT + 1):
        follower.edit(do="set", path="", key=["doc"], value=f"{number}")
    assert late.post("save")["type"] == "document"
    assert late.document == follower.whole()


def test_problems_of_a_revision_are_asked_for_by_themselves(follower: Follower, page: TestClient) -> None:
    follower.edit(do="add", parent="/", name="odd", node={"node": "no/such_node"})
    assert follower.document["task"]["problems"] == []
    found = page.get("/api/document/problems", params={"path": TINY}).json()
    assert found["revision"] == follower.document["revision"]
    assert [p["path"] for p in found["problems"] if p["code"] == "unknown-node"] == ["odd"]
    assert found["problems"] == page.get("/api/document", params={"path": TINY}).json()["task"]["problems"]


TEXTS = st.text(alphabet="ab\n é🤖", max_size=30)


@given(TEXTS, TEXTS)
def test_a_splice_makes_one_text_of_another(before: str, now: str) -> None:
    splice = splice_of(before, now)
    assert (splice is None) == (before == now)
    assert put(before, splice.model_dump() if splice else None) == now


def test_what_an_edit_takes_elsewhere_is_said_with_the_way_there(follower: Follower) -> None:
    wrapped = follower.edit(do="wrap", paths=["machine"], kind="timeout", name="late", fields={"seconds": 9})
    assert set(wrapped["task"]["gone"]) == {"machine", "machine/a", "machine/b"}
    assert wrapped["task"]["moved"] == {"machine": "late/machine"}  # and what is below it
    group = [{"do": "rename", "path": "late", "name": "l"}, {"do": "move", "path": "late/machine/b", "parent": "/"}]
    moved = follower.edit(do="group", commands=[group[1], group[0]])["task"]["moved"]
    assert moved == {"late": "l", "late/machine/b": "b"}
    assert follower.edit(do="remove", path="b")["task"]["moved"] == {}
    back = follower.step("undo")["task"]
    assert (back["gone"], back["moved"]) == ([], {})
    assert follower.step("undo")["task"]["moved"] == {"l": "late", "b": "late/machine/b"}
