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
from grip_gui.editing.files import ChangedOnDiskError, StaleEditError, UnfinishedTextError
from grip_gui.editing.routes import DocumentStore
from grip_gui.project import ProjectFolder

PATH = "tasks/tiny.yaml"
EDITS = int(os.environ.get("GRIP_FUZZ_EDITS", "300"))
IN_BROWSERS = int(os.environ.get("GRIP_FUZZ_BROWSER_EDITS", "60"))
SEED = int(os.environ.get("GRIP_FUZZ_SEED", "0"))


class Pages:
    """Two pages that edit one file at random, and what must stay true of it."""

    def __init__(self, folder: Path, seed: int):
        self.folder, self.random = folder, Random(seed)
        self.desk = DocumentStore(ProjectFolder(folder))
        self.seen = [1, 1]
        self.texts: dict[int, str] = {0: TASK}
        self.done = 0

    def act(self) -> None:
        page = self.random.randrange(2)
        with self.desk.held(PATH) as opened:
            before, revision = opened.text, opened.revision
            try:
                self._one(opened, page)
                self.done += 1
            except (EditError, StaleEditError, UnfinishedTextError, ChangedOnDiskError):
                assert opened.text == before
                assert opened.revision == revision
            if self.random.random() < 0.7:
                self.seen[page] = opened.revision
        self.check()

    def _one(self, opened, page: int) -> None:
        base, what = self.seen[page], self.random.random()
        if what < 0.6 and opened.history is not None:
            opened.do(command_of(random_command(self.random, opened.history.document.task)), base)
        elif what < 0.72:
            opened.write(random_typing(self.random, opened.text), base)
        elif what < 0.85:
            opened.undo() if self.random.random() < 0.6 else opened.redo()
        elif what < 0.9 and opened.history is not None:
            opened.go(self.random.randrange(len(opened.history.moments)))
        elif what < 0.93:
            opened.pin("flow", {"first": (self.random.random() * 500, 3.0)}, "place first")
        elif what < 0.97:
            opened.save(over=self.random.random() < 0.5)
        elif what < 0.985:
            (self.folder / PATH).write_text(random_typing(self.random, opened.text))
        else:
            opened.take_from_disk()

    def check(self) -> None:
        with self.desk.held(PATH) as opened:
            if opened.history is not None:
                document = opened.history.document
                assert self.texts.setdefault(opened.history.at.number, document.text) == document.text
                assert read_text(document.text).task == document.task
            if opened.saved and not opened.file.change():
                assert (self.folder / PATH).read_text() == opened.text

    def restart(self) -> None:
        """Let the server die and come again: what wasn't saved is there."""
        with self.desk.held(PATH) as opened:
            text = opened.text
            if opened.file.change() and not [*(self.folder / ".grip" / "unsaved").glob("*")]:
                text = (self.folder / PATH).read_text()  # all was saved, and then somebody else wrote over it
        self.desk = DocumentStore(ProjectFolder(self.folder))
        with self.desk.held(PATH) as opened:
            assert opened.text == text
            self.seen, self.texts = [opened.revision] * 2, {}


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
    desk = DocumentStore(ProjectFolder(project))
    with desk.held(PATH) as opened:
        while len(opened.history.moments) < min(EDITS // 6, LIMIT):
            try:
                if random.random() < 0.8:
                    opened.do(command_of(random_command(random, opened.history.document.task)), opened.revision)
                else:
                    text = random_typing(random, opened.text)
                    read_text(text)
                    opened.write(text, opened.revision)
            except (EditError, DocumentError):
                continue
        last = opened.text
        while opened.can_undo:
            opened.undo()
        assert opened.text == TASK
        while opened.can_redo:
            opened.redo()
        assert opened.text == last
        opened.save()
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
