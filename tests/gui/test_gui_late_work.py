"""What the server does after an answer is dropped when another edit comes."""

from __future__ import annotations

from pathlib import Path

import pytest

from grip_bt.compilers.restructure import to_trees
from grip_bt.task.catalog import Catalog
from grip_bt.task.edit import command_of
from grip_gui.editing.conversion import forms_view
from grip_gui.editing.routes import DocumentStore
from grip_gui.project import ProjectFolder

TINY = "tasks/tiny.yaml"


def test_forms_of_a_document_that_has_changed_are_not_looked_for_any_more(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk, catalog, asked = DocumentStore(ProjectFolder(project)), Catalog.builtin(), []
    monkeypatch.setattr(
        "grip_gui.editing.conversion.to_trees", lambda task, catalog: (asked.append(task), to_trees(task, catalog))[1]
    )
    with desk.held(TINY) as opened:
        revision, late, soon = opened.revision, forms_view(opened, catalog), forms_view(opened, catalog)
    assert soon().forms
    assert len(asked) == 1
    with desk.held(TINY) as opened:
        opened.do(command_of({"do": "set", "path": "", "key": ["doc"], "value": "new"}), revision)
    found = late()
    assert (found.revision, found.forms, len(asked)) == (revision, [], 1)
