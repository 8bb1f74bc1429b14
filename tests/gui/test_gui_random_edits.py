"""Whatever two pages do to a task file, no text is lost, and every moment keeps its very bytes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from random import Random

import pytest
from played import TASK
from random_edits import random_command, random_typing
from test_gui_e2e import browser, editing

from grip_bt.base.errors import DocumentError, EditError
from grip_bt.task import read_text
from grip_bt.task.edit import command_of
from grip_bt.task.edit.history import LIMIT
from grip_gui.editing.document_store import EditDesk
from grip_gui.editing.files import ChangedOnDiskError, StaleEditError, UnfinishedTextError
from grip_gui.project import ProjectFolder

PATH = "tasks/tiny.yaml"
EDITS = int(os.environ.get("GRIP_FUZZ_EDITS", "600"))
IN_BROWSERS = int(os.environ.get("GRIP_FUZZ_BROWSER_EDITS", "60"))
SEED = int(os.environ.get("GRIP_FUZZ_SEED", "0"))


class Pages:
    """Two pages that edit one file at random, and what must stay true of it."""

    def __init__(self, folder: Path, seed: int):
        self.folder, self.random = folder, Random(seed)
        self.desk = EditDesk(ProjectFolder(folder))
        self.seen = [1, 1]
        self.texts: dict[int, str] = {0: TASK}
        self.done = 0

    def act(self) -> None:
        page = self.random.randrange(2)
        with self.desk.changing(PATH) as sheet:
            before, revision = sheet.text, sheet.revision
            try:
                self._one(sheet, page)
                self.done += 1
            except (EditError, StaleEditError, UnfinishedTextError, ChangedOnDiskError):
                assert sheet.text == before
                assert sheet.revision == revision
            if self.random.random() < 0.7:
                self.seen[page] = sheet.revision
        self.check()

    def _one(self, sheet, page: int) -> None:
        base, what = self.seen[page], self.random.random()
        if what < 0.6 and sheet.history is not None:
            sheet.do(command_of(random_command(self.random, sheet.history.document.task)), base)
        elif what < 0.72:
            sheet.write(random_typing(self.random, sheet.text), base)
        elif what < 0.85:
            sheet.undo() if self.random.random() < 0.6 else sheet.redo()
        elif what < 0.9 and sheet.history is not None:
            sheet.go(self.random.randrange(len(sheet.history.moments)))
        elif what < 0.93:
            sheet.pin("flow", {"first": (self.random.random() * 500, 3.0)}, "place first")
        elif what < 0.97:
            sheet.save(over=self.random.random() < 0.5)
        elif what < 0.985:
            (self.folder / PATH).write_text(random_typing(self.random, sheet.text))
        else:
            sheet.take_from_disk()

    def check(self) -> None:
        with self.desk.reading(PATH) as sheet:
            if sheet.history is not None:
                document = sheet.history.document
                assert self.texts.setdefault(sheet.history.at.number, document.text) == document.text
                assert read_text(document.text).task == document.task
            if sheet.saved and not sheet.file.change():
                assert (self.folder / PATH).read_text() == sheet.text

    def restart(self) -> None:
        """Let the server die and come again: what wasn't saved is there."""
        with self.desk.reading(PATH) as sheet:
            text = sheet.text
            if sheet.file.change() and not [*(self.folder / ".grip" / "unsaved").glob("*")]:
                text = (self.folder / PATH).read_text()  # all was saved, and then somebody else wrote over it
        self.desk = EditDesk(ProjectFolder(self.folder))
        with self.desk.reading(PATH) as sheet:
            assert sheet.text == text
            self.seen, self.texts = [sheet.revision] * 2, {}


@pytest.mark.parametrize("seed", range(SEED, SEED + 3))
def test_random_edits_in_two_pages_lose_and_corrupt_nothing(project: Path, seed: int) -> None:
    pages = Pages(project, seed)
    for number in range(EDITS // 3):
        pages.act()
        if number % 97 == 96:
            pages.restart()
    assert pages.done > EDITS // 3 / 4


def test_undo_and_redo_of_everything_is_the_identity_on_bytes(project: Path) -> None:
    random = Random(SEED)
    desk = EditDesk(ProjectFolder(project))
    with desk.changing(PATH) as sheet:
        while len(sheet.history.moments) < min(EDITS // 6, LIMIT):
            try:
                if random.random() < 0.8:
                    sheet.do(command_of(random_command(random, sheet.history.document.task)), sheet.revision)
                else:
                    text = random_typing(random, sheet.text)
                    read_text(text)
                    sheet.write(text, sheet.revision)
            except (EditError, DocumentError):
                continue
        last = sheet.text
        while sheet.can_undo:
            sheet.undo()
        assert sheet.text == TASK
        while sheet.can_redo:
            sheet.redo()
        assert sheet.text == last
        sheet.save()
    assert (project / PATH).read_text() == last


@pytest.mark.e2e
@pytest.mark.slow
@pytest.mark.timeout(4 * 3600)
def test_two_browsers_that_edit_at_random_show_what_the_server_has(project: Path) -> None:
    before = (project / PATH).read_text()
    with editing(project) as (_, url):
        command = browser("random_edits.mjs", url, PATH, str(IN_BROWSERS), str(SEED))
        done = subprocess.run(command, capture_output=True, text=True, timeout=4 * 3600)
        assert done.returncode == 0, done.stdout + done.stderr
    sys.stdout.write(done.stdout)
    text = (project / PATH).read_text()
    assert read_text(text).task
    if IN_BROWSERS < LIMIT - 100:  # further back than that no history reaches
        assert text == before, "undoing everything gives back the very bytes"
