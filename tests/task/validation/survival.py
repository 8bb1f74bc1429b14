"""Everything that can be done with a task file, in this process: what comes of it is a result or a sentence."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.issue import Report
from grip_bt.cli.convert import FORMS, converted
from grip_bt.cli.shell import run_verb
from grip_bt.task import Document, fmt, read_text
from grip_bt.task.validation import validate

MOST_EVENTS = 60
"""After so many events a run is stopped."""


class Stopper:
    """Stops a run that goes on and on."""

    def __init__(self, runner: Any):
        self.runner, self.seen = runner, 0

    def __getattr__(self, name: str) -> Any:
        return self._noted

    def _noted(self, *_: Any, **__: Any) -> None:
        self.seen += 1
        if self.seen > MOST_EVENTS:
            self.runner.stop()


def project(folder: Path) -> Path:
    """Write a project with an arm, a hand and a camera; return where its task file goes."""
    (folder / "tasks").mkdir(parents=True, exist_ok=True)
    (folder / "grip.yaml").write_text(
        "grip: 1\nrobot: panda_allegro\narms: {right: {hand: palm}}\nhands: {palm: {}}\n"
        "sensors: {overhead: {camera: overhead}}\nworld: table\n"
    )
    (folder / "tasks" / "fetch.yaml").write_text(
        "grip: 1\nname: fetch\ninputs: {x: {type: int, value: 1}}\noutputs: {x: int}\nroot: {node: flow/succeed}\n"
    )
    return folder / "tasks" / "made.yaml"


def read(data: Mapping[str, Any], file: Path) -> Document | None:
    """Write a document to its file, and read it; None where it isn't one."""
    text = json.dumps(data)
    file.write_text(text)
    try:
        return read_text(text, str(file))
    except DocumentError:
        return None


def looked_at(document: Document, file: Path, catalog: Any) -> Report:
    """Check, format and convert to everything; what raises but a GripError goes through."""
    report = validate(document.task, catalog, document)
    assert fmt(fmt(document.text)) == fmt(document.text)
    for to in FORMS:
        for view in ("tree", "flow") if to in ("svg", "dot", "mermaid") else ("tree",):
            args = SimpleNamespace(to=to, view=view, strict=False, task=str(file), output="-")
            with contextlib.suppress(GripError), contextlib.redirect_stderr(io.StringIO()):
                converted(document, catalog, args)  # type: ignore[arg-type]
    return report


def run(file: Path, form: str) -> str:
    """Run it with parts that do as asked; return how it ended, or the sentence that refused it.

    Raises:
        Exception: whatever isn't told in a sentence.
    """
    options = RunOptions(target=form, robot="fake", journal=file.parent / "runs.sqlite")  # type: ignore[arg-type]
    try:
        with open_session(file, options) as session:
            session.runner.observe(Stopper(session.runner))
            return session.runner.run().status
    except GripError as error:
        return str(error)


def asked(page: Any, path: str) -> Iterator[tuple[str, int, str]]:
    """Ask the page about the file in every way that changes nothing; yield what was asked, status and answer."""
    questions: list[tuple[str, dict[str, Any]]] = [
        *(("document", {}), ("document/forms", {}), ("document/problems", {}), ("document/places", {}), ("task", {})),
        *(("document/parts", {"node": ["/"]}), ("document/comment", {"node": "/"})),
        *(("document/conversion", {"node": "/", "form": form}) for form in ("tree", "machine")),
    ]
    for question, more in questions:
        answer = page.get(f"/api/{question}", params={"path": path, **more})
        yield question, answer.status_code, answer.text


def verb(words: list[str]) -> tuple[int, str]:
    """Run `grip WORDS` in this process; return exit status and what was said."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        return run_verb(words), said.getvalue()


__all__ = ["asked", "looked_at", "project", "project_catalog", "read", "run", "validate", "verb"]
