"""Extract over the server: the new file, the edit, its undo, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

TINY = "tasks/tiny.yaml"
PART = "tasks/machine.yaml"


def edit(page: TestClient, status: int = 200, base: int | None = None, **command: Any) -> dict[str, Any]:
    """Send a command on the newest state, or on `base`; return the answer."""
    newest = page.get("/api/document", params={"path": TINY}).json()["revision"]
    request = {"path": TINY, "base": base or newest, "command": command}
    answer = page.post("/api/document/edit", json=request)
    assert answer.status_code == status, answer.text
    return dict(answer.json())


def nodes(view: dict[str, Any]) -> list[str]:
    return [node["path"] for node in view["task"]["nodes"]]


def text_of(page: TestClient) -> str:
    return str(page.get("/api/document", params={"path": TINY}).json()["text"])


def test_a_part_goes_to_a_file_which_stays_when_that_is_undone(page: TestClient, project: Path) -> None:
    before = text_of(page)
    view = edit(page, do="extract", path="machine", file=PART)
    assert nodes(view) == ["/", "first", "machine"]
    assert "kind: state_machine" in (project / PART).read_text()
    assert not [problem for problem in view["task"]["problems"] if problem["severity"] == "error"]
    base = page.get("/api/document", params={"path": TINY}).json()["revision"]
    page.post("/api/document/step", json={"path": TINY, "base": base, "step": "undo"})
    assert text_of(page) == before
    assert (project / PART).exists()


@pytest.mark.parametrize(
    ("file", "status", "reason"),
    [
        (TINY, 404, "a file of this name already exists"),
        ("machine.yaml", 403, "isn't a place for a task"),
        ("../machine.yaml", 400, "isn't a task file of the project"),
        ("tasks/machine.layout.yaml", 403, "isn't a place for a task"),
    ],
)
def test_a_part_goes_over_nothing_and_nowhere_else(
    page: TestClient, project: Path, file: str, status: int, reason: str
) -> None:
    before, files = text_of(page), sorted(project.parent.rglob("*.yaml"))
    assert reason in edit(page, status, do="extract", path="machine", file=file)["detail"]
    assert text_of(page) == before
    assert sorted(project.parent.rglob("*.yaml")) == files


def test_a_late_extraction_follows_a_rename(page: TestClient, project: Path) -> None:
    base = page.get("/api/document", params={"path": TINY}).json()["revision"]
    edit(page, do="rename", path="machine", name="steps")
    assert nodes(edit(page, base=base, do="extract", path="machine", file=PART)) == ["/", "first", "steps"]
    assert "kind: state_machine" in (project / PART).read_text()


def test_who_could_tell_is_named_and_the_part_goes_out_all_the_same_when_asked(page: TestClient, project: Path) -> None:
    written = (
        "grip: 1\nname: tiny\ndata: {words: str}\nroot:\n  kind: timeout\n  seconds: 5\n  child:\n"
        "    note: {kind: sequence, children: {ask: {node: test/write, out: {value: words}}}}\n"
    )
    manifest = (
        "id: test/write\ndoc: Writes.\nimplementation: write.py:Write\noutputs: {value: {type: str}}\n"
        "outcomes: {success: success}\n"
    )
    (project / "nodes" / "write").mkdir(parents=True, exist_ok=True)
    (project / "nodes" / "write" / "manifest.yaml").write_text(manifest)
    (project / TINY).write_text(written)
    refused = edit(page, status=409, do="extract", path="note", file=PART)
    assert refused["kind"] == "approximate"
    assert "it writes words, and the timeout / may halt it" in refused["detail"]
    assert not (project / PART).exists()
    edit(page, do="extract", path="note", file=PART, approximate=True)
    assert "outputs: {words: str}" in (project / PART).read_text()
