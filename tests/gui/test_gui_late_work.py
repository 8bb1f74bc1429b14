"""What the server does after an edit, and what of it is dropped when another edit comes."""

from __future__ import annotations

from pathlib import Path
from threading import Event

import pytest
from starlette.testclient import TestClient

import grip_gui.editing.routes
from grip_bt.compilers.restructure import to_trees
from grip_bt.task.catalog import Catalog
from grip_bt.task.edit import command_of
from grip_gui.editing.conversion import forms_view
from grip_gui.editing.document_store import EditDesk
from grip_gui.project import ProjectFolder

TINY = "tasks/tiny.yaml"
PATIENCE = 120.0
"""What is waited for comes at once; a loaded machine may take this long [s]."""


def test_the_next_edit_is_prepared_once_after_the_last_of_several(
    page: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    prepared, done = [], Event()
    monkeypatch.setattr(EditDesk, "get_ready", lambda self, path: (prepared.append(path), done.set()))

    def edit(revision: int, doc: str) -> int:
        command = {"do": "set", "path": "", "key": ["doc"], "value": doc}
        answer = page.post("/api/document/edit", json={"path": TINY, "base": revision, "command": command})
        assert answer.status_code == 200, answer.text
        return answer.json()["revision"]

    monkeypatch.setattr(grip_gui.editing.routes, "QUIET", 3600.0)
    revision = page.get("/api/document", params={"path": TINY}).json()["revision"]
    for doc in ("one", "two", "three"):
        revision = edit(revision, doc)
    monkeypatch.setattr(grip_gui.editing.routes, "QUIET", 0.0)
    edit(revision, "four")
    assert done.wait(PATIENCE)
    assert prepared == [TINY]


def test_forms_of_a_document_that_has_changed_are_not_looked_for_any_more(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk, catalog, asked = EditDesk(ProjectFolder(project)), Catalog.builtin(), []
    monkeypatch.setattr(
        "grip_gui.editing.conversion.to_trees", lambda task, catalog: (asked.append(task), to_trees(task, catalog))[1]
    )
    with desk.reading(TINY) as sheet:
        revision, late, soon = sheet.revision, forms_view(sheet, catalog), forms_view(sheet, catalog)
    assert soon().forms
    assert len(asked) == 1
    with desk.changing(TINY) as sheet:
        sheet.do(command_of({"do": "set", "path": "", "key": ["doc"], "value": "new"}), revision)
    found = late()
    assert (found.revision, found.forms, len(asked)) == (revision, [], 1)
