"""What a page is sent after an edit: the whole document, unchecked, and where its nodes have moved."""

from __future__ import annotations

from typing import Any

import pytest
from played import TASK
from starlette.testclient import TestClient

TINY = "tasks/tiny.yaml"
Answer = dict[str, Any]


class Follower:
    """A page that says which revision it has."""

    def __init__(self, client: TestClient):
        self.client = client
        self.document: Answer = client.get("/api/document", params={"path": TINY, "since": 0}).json()

    def post(self, what: str, **request: Any) -> Answer:
        params = {"since": self.document["revision"]}
        answer = self.client.post(f"/api/document/{what}", params=params, json={"path": TINY, **request})
        assert answer.status_code == 200, answer.text
        self.document = answer.json()
        return self.document

    def edit(self, **command: Any) -> Answer:
        return self.post("edit", base=self.document["revision"], command=command)

    def step(self, step: str) -> Answer:
        return self.post("step", base=self.document["revision"], step=step)


@pytest.fixture
def follower(page: TestClient) -> Follower:
    return Follower(page)


def test_problems_of_a_revision_are_asked_for_by_themselves(follower: Follower, page: TestClient) -> None:
    follower.edit(do="add", parent="/", name="odd", node={"node": "no/such_node"})
    assert (follower.document["task"]["problems"], follower.document["checked"]) == ([], False)
    found = page.get("/api/document/problems", params={"path": TINY}).json()
    assert found["revision"] == follower.document["revision"]
    assert [p["path"] for p in found["problems"] if p["code"] == "unknown-node"] == ["odd"]
    assert found["problems"] == page.get("/api/document", params={"path": TINY}).json()["task"]["problems"]


def test_what_is_wrong_with_a_text_that_is_no_task_is_said_at_once(follower: Follower) -> None:
    broken = follower.post("text", base=follower.document["revision"], text="grip: [")
    assert broken["checked"]
    assert broken["task"]["problems"]
    assert broken["moved"] == {}
    assert not follower.post("text", base=broken["revision"], text=TASK)["checked"]


def test_where_an_edit_moves_nodes_is_said(follower: Follower) -> None:
    assert follower.edit(do="add", parent="/", name="coffee", node={"node": "flow/succeed"})["moved"] == {}
    wrapped = follower.edit(do="wrap", paths=["machine"], kind="timeout", name="late", fields={"seconds": 9})
    below = {f"machine{name}": f"late/machine{name}" for name in ("", "/a", "/b")}
    assert wrapped["moved"] == below
    group = [{"do": "rename", "path": "late", "name": "l"}, {"do": "move", "path": "late/machine/b", "parent": "/"}]
    moved = follower.edit(do="group", commands=[group[1], group[0]])["moved"]
    inside = {f"late{name}": f"l{name}" for name in ("", "/machine", "/machine/a")}
    assert moved == {**inside, "late/machine/b": "b"}
    assert follower.edit(do="remove", path="b")["moved"] == {}
    assert follower.step("undo")["moved"] == {}
    assert follower.step("undo")["moved"] == {**{new: old for old, new in inside.items()}, "b": "late/machine/b"}


def test_a_page_that_is_late_is_told_of_all_moves_since(follower: Follower, page: TestClient) -> None:
    late = Follower(page)
    follower.edit(do="rename", path="machine/a", name="x")
    follower.edit(do="rename", path="machine", name="m")
    assert late.post("save")["moved"] == {"machine": "m", "machine/a": "m/x", "machine/b": "m/b"}
