"""Editing over the server: what pages send, what they get, and what is on disk afterwards."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from played import BASE, TASK, PlayedLauncher
from starlette.testclient import TestClient

from grip_gui.server import create_app

TINY = "tasks/tiny.yaml"


class Pen:
    """A page that edits one task file."""

    def __init__(self, client: TestClient, path: str = TINY):
        self.client, self.path = client, path
        self.view: dict[str, Any] = self.open()

    def open(self) -> dict[str, Any]:
        self.view = self.client.get("/api/document", params={"path": self.path}).json()
        return self.view

    def post(self, what: str, status: int = 200, **request: Any) -> dict[str, Any]:
        answer = self.client.post(f"/api/document/{what}", json={"path": self.path, **request})
        assert answer.status_code == status, answer.text
        if status == 200:
            self.view = answer.json()
        return answer.json()

    def edit(self, status: int = 200, base: int | None = None, **command: Any) -> dict[str, Any]:
        return self.post("edit", status, base=base or self.view["revision"], command=command)

    def step(self, step: str, status: int = 200, number: int | None = None) -> dict[str, Any]:
        return self.post("step", status, base=self.view["revision"], step=step, number=number)

    def type(self, text: str, status: int = 200, base: int | None = None, over: bool = False) -> dict[str, Any]:
        return self.post("text", status, base=base or self.view["revision"], text=text, over=over)

    def names(self) -> list[str]:
        return [node["path"] for node in self.view["task"]["nodes"]]


@pytest.fixture
def pen(page: TestClient) -> Pen:
    return Pen(page)


@pytest.fixture
def file(project: Path) -> Path:
    return project / TINY


def test_an_edit_is_seen_at_once_and_saved_when_asked(pen: Pen, file: Path) -> None:
    assert pen.view["saved"]
    assert pen.view["text"] == TASK
    pen.edit(do="rename", path="first", name="wait a bit")
    assert pen.names() == ["/", "wait a bit", "machine", "machine/a", "machine/b"]
    assert not pen.view["saved"]
    assert file.read_text() == TASK
    assert pen.post("save")["saved"]
    assert "wait a bit: {node: flow/wait" in file.read_text()


def test_a_comment_is_read_and_written_as_an_edit(pen: Pen) -> None:
    def said(node: str) -> dict[str, Any]:
        answer = pen.client.get("/api/document/comment", params={"path": TINY, "node": node})
        assert answer.status_code == 200, answer.text
        view: dict[str, Any] = answer.json()
        return view

    assert said("first")["comment"] == ""
    pen.edit(do="comment", path="first", text="why\nit waits")
    assert pen.view["text"] == TASK.replace("    first:", "    # why\n    # it waits\n    first:")
    assert said("first") == {"revision": pen.view["revision"], "node": "first", "comment": "why\nit waits"}
    assert pen.view["history"]["moments"][-1]["title"] == "comment on first"
    # While the text is no task, it is that of the last one that it was.
    pen.type(pen.view["text"] + "\noops")
    assert said("first")["comment"] == "why\nit waits"
    pen.step("undo")
    assert pen.step("undo")["text"] == TASK
    assert said("gone")["comment"] is None
    refused = pen.edit(400, do="comment", path="first", text="a\0b")
    assert "can't have the character" in refused["detail"]


def test_the_comment_of_the_task_is_that_at_the_top_of_its_file(pen: Pen) -> None:
    def said() -> Any:
        answer = pen.client.get("/api/document/comment", params={"path": TINY, "node": ""})
        assert answer.status_code == 200, answer.text
        return answer.json()["comment"]

    assert said() == ""
    pen.edit(do="comment", path="", text="why\n\nit is there")
    assert pen.view["text"] == "# why\n#\n# it is there\n" + TASK
    assert said() == "why\n\nit is there"
    # An edit of a page that is late by that one is still about the task.
    pen.edit(base=pen.view["revision"] - 1, do="comment", path="", text="else")
    assert pen.view["text"] == "# else\n" + TASK
    pen.step("undo")
    assert pen.step("undo")["text"] == TASK


def test_undo_and_redo_give_the_bytes_back(pen: Pen, file: Path) -> None:
    pen.edit(do="remove", path="first")
    pen.edit(do="wrap", paths=["machine"], kind="retry", name="again", fields={"times": 2})
    after = pen.view["text"]
    pen.step("undo")
    assert pen.step("undo")["text"] == TASK
    assert pen.view["saved"]
    assert not pen.view["history"]["can_undo"]
    pen.step("redo")
    assert pen.step("redo")["text"] == after
    assert "nothing to redo" in pen.step("redo", status=400)["detail"]


def test_a_branch_that_was_left_is_reached_again(pen: Pen) -> None:
    pen.edit(do="rename", path="first", name="one")
    one = pen.view["history"]["at"]
    pen.step("undo")
    pen.edit(do="rename", path="first", name="two")
    assert pen.step("go", number=one)["task"]["nodes"][1]["name"] == "one"
    titles = [m["title"] for m in pen.view["history"]["moments"]]
    assert titles == ["opened", "rename first to one", "rename first to two"]


def test_what_cannot_be_done_says_why_and_changes_nothing(pen: Pen) -> None:
    before = pen.view["revision"]
    assert "there is no such node" in pen.edit(400, do="remove", path="frist")["detail"]
    assert "not a command" in pen.edit(400, do="dance")["detail"]
    assert "not a command" in pen.edit(400, do="add", parent="/", name="a.b", node={})["detail"]
    assert pen.open()["revision"] == before
    assert pen.view["text"] == TASK


def test_an_edit_that_is_many_revisions_late_reaches_the_node_that_it_was_made_for(pen: Pen) -> None:
    base = pen.view["revision"]
    for number in range(40):
        pen.edit(do="rename", path=f"n{number}" if number else "first", name=f"n{number + 1}")
    for late in (39, 38, 20, 1, 0):
        pen.edit(
            base=base + late, do="set", path=f"n{late}" if late else "first", key=[f"x-{late}"], value=f"late by {late}"
        )
        assert f"x-{late}: late by {late}" in pen.view["text"]


def test_a_late_edit_follows_a_rename_and_is_refused_after_a_removal(page: TestClient) -> None:
    one, two = Pen(page), Pen(page)
    one.edit(do="rename", path="machine", name="steps")
    two.edit(do="set", path="machine/a", key=["with", "seconds"], value=7)
    assert two.view["text"].count("seconds: 7") == 1
    assert "steps" in two.names()
    one.open()
    one.edit(do="remove", path="first")
    refused = two.edit(409, base=two.view["revision"], do="rename", path="first", name="x")
    assert refused["kind"] == "stale"
    assert "removed elsewhere" in refused["detail"]
    assert two.open()["text"] == one.view["text"]


def test_of_two_who_set_one_thing_the_second_is_told_and_others_are_not_in_the_way(page: TestClient) -> None:
    one, two = Pen(page), Pen(page)
    one.edit(do="set", path="first", key=["with", "seconds"], value=7)
    refused = two.edit(409, do="set", path="first", key=["with", "seconds"], value=9)
    assert refused["kind"] == "stale"
    assert "with seconds of first was just set elsewhere" in refused["detail"]
    two.edit(base=two.view["revision"], do="set", path="first", key=["doc"], value="Waits.")
    assert "seconds: 7" in two.view["text"]
    assert "Waits." in two.view["text"]
    two.edit(do="set", path="first", key=["with", "seconds"], value=9)
    assert "seconds: 9" in two.view["text"]


def test_a_late_undo_or_text_takes_nothing_of_others_back(page: TestClient) -> None:
    one, two = Pen(page), Pen(page)
    one.edit(do="rename", path="first", name="one")
    assert two.step("undo", status=409)["kind"] == "stale"
    assert two.type(TASK + "# mine\n", status=409)["kind"] == "stale"
    assert one.open()["text"].count("one:") == 1
    two.type(TASK + "# mine\n", over=True)
    assert two.view["text"] == TASK + "# mine\n"
    two.step("undo")
    assert two.view["text"] == one.view["text"]


def test_every_page_is_told_of_a_new_revision(page: TestClient) -> None:
    with page.websocket_connect("ws://127.0.0.1:8765/api/socket", headers={"origin": BASE}) as socket:
        pen = Pen(page)
        pen.edit(do="rename", path="first", name="one")
        wanted = {"type": "revisions", "revisions": {TINY: pen.view["revision"]}}
        assert any(socket.receive_json() == wanted for _ in range(5))


def test_text_that_is_no_task_is_kept_shown_and_saved(pen: Pen, file: Path) -> None:
    broken = TASK.replace("kind: sequence", "kind: seq")
    pen.type(broken)
    assert pen.view["draft"]
    assert pen.view["text"] == broken
    assert len(pen.view["task"]["nodes"]) == 5
    (problem,) = pen.view["task"]["problems"]
    assert problem["line"] == 7
    refused = pen.edit(409, do="rename", path="first", name="x")
    assert refused["kind"] == "unfinished"
    pen.post("save")
    assert file.read_text() == broken
    pen.step("undo")
    assert pen.view["text"] == TASK
    pen.step("redo")
    assert pen.view["text"] == broken
    pen.type(TASK.replace("first:", "start:"))
    assert not pen.view["draft"]
    assert "start" in pen.names()


def test_a_file_that_is_no_task_is_opened_and_mended(page: TestClient, project: Path) -> None:
    (project / "tasks" / "odd.yaml").write_text("grip: 1\nname: odd\n")
    pen = Pen(page, "tasks/odd.yaml")
    assert pen.view["draft"]
    assert pen.view["task"]["problems"]
    pen.type("grip: 1\nname: odd\nroot: {node: flow/wait, with: {seconds: 1}}\n")
    assert pen.names() == ["/"]


def test_a_file_changed_by_somebody_else_is_never_lost(pen: Pen, file: Path) -> None:
    pen.edit(do="rename", path="first", name="mine")
    theirs = TASK.replace("first:", "theirs:")
    file.write_text(theirs)
    assert pen.open()["change"] == "changed"
    refused = pen.post("save", status=409)
    assert refused["kind"] == "disk"
    assert file.read_text() == theirs
    assert pen.post("disk")["text"] == theirs
    assert pen.view["saved"]
    assert "mine:" in pen.step("undo")["text"]
    pen.post("save", over=True)
    assert "mine:" in file.read_text()


def test_a_file_without_edits_follows_what_is_on_disk(pen: Pen, file: Path) -> None:
    theirs = TASK.replace("first:", "theirs:")
    file.write_text(theirs)
    assert pen.open()["text"] == theirs
    assert pen.view["saved"]
    assert pen.view["change"] == ""
    assert pen.step("undo")["text"] == TASK
    assert pen.view["change"] == ""
    assert not pen.view["saved"]


def test_a_deleted_file_is_told_and_written_again(pen: Pen, file: Path) -> None:
    file.unlink()
    assert pen.open()["change"] == "deleted"
    assert "deleted outside" in pen.post("save", status=409)["detail"]
    pen.post("save", over=True)
    assert file.read_text() == TASK


def test_unsaved_edits_outlive_the_server(project: Path) -> None:
    def served() -> TestClient:
        client = TestClient(
            create_app(project, PlayedLauncher(), token="right"), base_url=BASE, headers={"origin": BASE}
        )
        client.get("/?token=right")
        return client

    first = Pen(served())
    first.edit(do="rename", path="first", name="unsaved")
    again = Pen(served())
    assert again.view["text"] == first.view["text"]
    assert not again.view["saved"]
    assert again.view["history"]["moments"][-1]["title"] == "recover unsaved changes"
    again.post("save")
    assert not [*(project / ".grip" / "unsaved").iterdir()]


def test_undo_reaches_back_over_a_restart(project: Path) -> None:
    def served() -> TestClient:
        client = TestClient(
            create_app(project, PlayedLauncher(), token="right"), base_url=BASE, headers={"origin": BASE}
        )
        client.get("/?token=right")
        return client

    first = Pen(served())
    first.post("pin", view="flow", positions={"machine/a": [8.0, 16.0]})
    first.edit(do="rename", path="machine", name="m")
    first.post("save")
    again = Pen(served())
    assert again.view["saved"]
    assert again.view["layout"]["flow"] == {"m/a": [8, 16]}
    again.step("undo")
    again.step("undo")
    assert again.view["text"] == TASK
    assert again.view["layout"]["flow"] == {"machine/a": [8, 16]}
    again.post("save")
    (project / "tasks" / ".grip" / "history" / "tiny.yaml.json").write_text("damaged")
    assert Pen(served()).view["history"]["moments"][-1]["title"] == "opened"


def test_windows_line_ends_and_marks_of_byte_order_stay(page: TestClient, project: Path) -> None:
    path = project / "tasks" / "dos.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + TASK.replace("\n", "\r\n").encode())
    pen = Pen(page, "tasks/dos.yaml")
    pen.edit(do="rename", path="first", name="one")
    pen.post("save")
    assert path.read_bytes() == b"\xef\xbb\xbf" + TASK.replace("first:", "one:").replace("\n", "\r\n").encode()


def test_new_tasks_go_below_tasks_and_over_nothing(page: TestClient, project: Path) -> None:
    made = page.post("/api/document/new", json={"path": "tasks/deep/new one.yaml"})
    assert made.status_code == 201
    assert made.json()["task"]["name"] == "new one"
    assert (project / "tasks/deep/new one.yaml").exists()
    for path, status in {
        TINY: 404,
        "../out.yaml": 403,
        "grip2.yaml": 403,
        "tasks/.x.yaml": 403,
        "tasks/x.txt": 403,
    }.items():
        assert page.post("/api/document/new", json={"path": path}).status_code == status, path
    assert not (project.parent / "out.yaml").exists()


@pytest.mark.parametrize("what", ["edit", "text", "step", "pin", "save", "disk", "new", "expression"])
def test_no_request_reaches_a_file_outside_or_breaks_the_server(page: TestClient, project: Path, what: str) -> None:
    requests = {
        "edit": {"base": 1, "command": {"do": "remove", "path": "/"}},
        "text": {"base": 1, "text": "x"},
        "step": {"base": 1, "step": "undo"},
        "pin": {"view": "flow", "positions": {"first": [0, 0]}},
        "new": {"text": "grip: 1"},
        "expression": {"node": "/", "key": ["if"], "text": "1"},
    }
    (project / "tasks" / "link.yaml").symlink_to(project.parent / "secret.yaml")
    for path in [
        "../secret.yaml",
        "/etc/passwd",
        "tasks/../../secret.yaml",
        "tasks/link.yaml",
        "grip\0.yaml",
        ".grip/x.yaml",
    ]:
        answer = page.post(f"/api/document/{what}", json={"path": path, **requests.get(what, {})})
        assert answer.status_code == 403, (path, answer.text)
    for junk in [{}, {"path": 3}, {"path": TINY, "extra": 1}, [], {"path": "tasks/none.yaml", "base": "x"}]:
        assert page.post(f"/api/document/{what}", json=junk).status_code == 422
    assert (project.parent / "secret.yaml").read_text() == "grip: 1\nname: secret\n"
    assert page.get("/api/project").status_code == 200


def test_pins_are_undone_and_follow_a_rename_and_lie_beside_the_task(pen: Pen, project: Path) -> None:
    pen.post("pin", view="flow", positions={"machine/a": [101.0, 42.0]})
    assert pen.view["layout"]["flow"] == {"machine/a": [104, 40]}
    assert not pen.view["saved"]
    pen.edit(do="rename", path="machine", name="m")
    assert pen.view["layout"]["flow"] == {"m/a": [104, 40]}
    pen.post("save")
    assert (project / "tasks/tiny.layout.yaml").read_text() == "flow:\n  m/a: [104, 40]\n"
    pen.step("undo")
    pen.step("undo")
    assert pen.view["layout"]["flow"] == {}
    pen.post("save")
    assert not (project / "tasks/tiny.layout.yaml").exists()
    assert (project / TINY).read_text() == TASK


def test_problems_bring_fixes_that_are_edits(pen: Pen) -> None:
    pen.edit(do="set", path="first", key=["node"], value="flow/wiat")
    (problem,) = [p for p in pen.view["task"]["problems"] if p["code"] == "unknown-node"]
    fix = next(f for f in problem["fixes"] if f["title"] == "Use flow/wait")
    pen.edit(**fix["command"])
    assert pen.view["text"] == TASK


def test_an_expression_is_checked_where_it_would_stand(pen: Pen) -> None:
    def faults(text: str) -> list[str]:
        return pen.post("expression", node="machine", key=["precondition"], text=text)

    pen_view = pen.view
    assert faults("count > 2") == []
    assert "counts" in faults("counts > 2")[0]
    assert faults("count +")
    pen.view = pen_view
    assert pen.open()["text"] == TASK


def test_the_palette_has_every_node_and_kind(page: TestClient) -> None:
    from grip_bt.task import KINDS
    from grip_bt.task.catalog import Catalog

    catalog = page.get("/api/catalog").json()
    assert [node["id"] for node in catalog["nodes"]] == list(Catalog.builtin().ids())
    kinds = {kind["kind"]: kind for kind in page.get("/api/project").json()["kinds"]}
    assert list(kinds) == list(KINDS)
    retry = kinds["retry"]
    assert (retry["holds"], retry["needs_child"], retry["edges"]) == ("one", True, False)
    assert (kinds["state_machine"]["edges"], kinds["parallel"]["concurrent"]) == (True, True)
    assert {f["key"]: f["type"] for f in kinds["switch"]["fields"]}["cases"] == "cases"
    assert {"key": "times", "type": "int", "required": False} == {
        k: retry["fields"][-1][k] for k in ("key", "type", "required")
    }


def test_containers_say_whether_both_forms_edit_them(pen: Pen) -> None:
    answer = pen.client.get("/api/document/forms", params={"path": TINY}).json()
    assert {form["path"]: form["both"] for form in answer["forms"]} == {"/": True, "machine": True}


TANGLED = """\
grip: 1
name: tangled
root:
  kind: state_machine
  # the first
  initial: a
  outcomes: {success: success}
  children:
    a: {node: flow/fail, with: {code: x, message: m}, on: {failure: b, failure.failed: c}}
    b: {node: flow/wait, with: {seconds: 1}, on: {success: c}}
    c: {node: flow/fail, with: {code: x, message: m}, on: {failure: b, failure.failed: success}}
"""


def test_a_tangled_machine_says_which_edges_are_in_the_way(page: TestClient, project: Path) -> None:
    (project / "tasks/tangled.yaml").write_text(TANGLED)
    (form,) = page.get("/api/document/forms", params={"path": "tasks/tangled.yaml"}).json()["forms"]
    assert not form["both"]
    assert form["edges"]
    names = {node["path"] for node in Pen(page, "tasks/tangled.yaml").view["task"]["nodes"]}
    assert all(path in names for path, _ in form["edges"])
    refused = page.get("/api/document/conversion", params={"path": "tasks/tangled.yaml", "node": "/", "form": "tree"})
    assert refused.status_code == 400
    assert "more than one state" in refused.json()["detail"]


def test_a_conversion_is_shown_first_and_undone_to_the_byte(pen: Pen) -> None:
    query = {"path": TINY, "node": "machine", "form": "tree"}
    shown = pen.client.get("/api/document/conversion", params=query).json()
    assert shown["before"][0] == "machine: state_machine"
    assert shown["after"][0] == "machine: sequence"
    assert pen.open()["text"] == TASK
    pen.edit(do="convert", path="machine", to="bt")
    assert next(n for n in pen.view["task"]["nodes"] if n["path"] == "machine")["kind"] == "sequence"
    assert not [p for p in pen.view["task"]["problems"] if p["severity"] == "error"]
    assert pen.step("undo")["text"] == TASK
    assert pen.edit(409, base=1, do="convert", path="machine", to="bt")["kind"] == "stale"


REACTIVE = """\
grip: 1
name: tiny
root:
  kind: sequence
  memory: false
  children:
    look: {node: flow/wait, with: {seconds: 0.1}}
    arm: {node: flow/wait, with: {seconds: 0.1}}
"""


def test_a_conversion_that_would_not_be_exact_is_refused(page: TestClient, project: Path) -> None:
    (project / TINY).write_text(REACTIVE)
    exact = page.get("/api/document/conversion", params={"path": TINY, "node": "/", "form": "machine"})
    assert exact.status_code == 400
    assert "stays" in Pen(page).edit(400, do="convert", path="/", to="sm")["detail"]
