"""Another form of a task, or of part of it: conversions tried, compared by running both, and applied."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import NamedTuple

from grip_bt.base.errors import EditError, GripError, InvalidTaskError, NodeError
from grip_bt.compilers.restructure import compare, moved, play, to_state_machines, to_trees
from grip_bt.compilers.restructure.equivalence import End
from grip_bt.runtime import Journal, JournalReader
from grip_bt.runtime.observers import Recorder
from grip_bt.task import Fallback, Sequence, StateMachine, Task, walk
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import Leaf, join, outcomes_of
from grip_gui.editing.open_document import OpenDocument
from grip_gui.editing.projection import project_task
from grip_gui.editing.views import finder
from grip_gui.wire.editing import ConversionView, CounterexampleView, Form, FormsView, FormView
from grip_gui.wire.runs import RunEvent


def conversion_view(
    opened: OpenDocument, catalog: Catalog, path: str, form: Form, approximate: bool
) -> Callable[[], ConversionView]:
    """Return what finds what a conversion would do, and whether both forms do the same; nobody needs to wait for it.

    Raises:
        EditError: there is nothing to convert, or the task has errors; the second also from what is returned.
    """
    document, file = opened.document, opened.file.name
    if document is None:
        raise EditError("", "the text is not a valid task; fix it first")
    task = document.task
    if path not in dict(walk(task.root)):
        raise EditError(path, "there is no such node")
    return lambda: _view(task, file, catalog, path, form, approximate)


def _view(task: Task, file: str, catalog: Catalog, path: str, form: Form, approximate: bool) -> ConversionView:
    try:
        trees = form == "tree"
        result = to_trees(task, catalog, path) if trees else to_state_machines(task, catalog, approximate, path)
        comparison = compare(task, result, catalog)
    except InvalidTaskError as error:
        raise EditError(path, f"the task has errors; fix them first: {error.issues[0]}") from error
    except NodeError as error:
        raise EditError(path, f"the two forms can't be compared: {error}") from error
    kept = [str(note) for note in result.notes if not note.by_design]
    if result.task == task:
        raise EditError(path, "; ".join(kept) or f"it has the form of a {form} already")
    difference, shown = comparison.difference, {}
    if difference:
        plays = (task, difference.script), (result.task, moved(difference.script, result.paths))
        shown = {
            "script": [str(end) for end in difference.script],
            "does_before": list(difference.before),
            "does_after": list(difference.after),
            "plays": [_play(each, script, catalog, file) for each, script in plays],
        }
    return ConversionView(
        before=_outline(task, path),
        after=_outline(result.task, result.paths.get(path, path)),
        kept=kept,
        same=difference is None,
        compared=str(comparison),
        **shown,
    )


def _outline(task: Task, path: str) -> list[str]:
    """Return a part of a task in lines: kinds and names, indented."""
    lines = []
    for each, node in walk(task.root):
        if path == "/" or each == path or each.startswith(f"{path}/"):
            depth = len(PurePosixPath("/", each).parts) - len(PurePosixPath("/", path).parts)
            kind = getattr(node, "kind", None) or getattr(node, "node", "")
            lines.append(f"{'  ' * depth}{each.rpartition('/')[2] or task.name}: {kind}")
    return lines


class _PlayClock(NamedTuple):
    now: Callable[[], float]


def _play(task: Task, script: tuple[End, ...], catalog: Catalog, file: str) -> CounterexampleView:
    """Return how one form goes, in a journal of its own that nobody else sees."""
    recorders: list[Recorder] = []
    with TemporaryDirectory() as folder:
        with Journal(Path(folder) / "played.sqlite") as journal:
            log = journal.begin(task.name, file, "", "bt", 0)

            def observe(now: Callable[[], float]) -> Recorder:
                recorders.append(Recorder(log, _PlayClock(now)))
                return recorders[-1]

            end = play(task, catalog, script, observe)
            outcome = end[0] if end and end[0] != "error" else None
            root = task.root.meaning if isinstance(task.root, Leaf) else outcomes_of(task.root)
            meaning = {**root, **task.outcomes}
            status = "stopped" if not end else end[0] if outcome is None else meaning.get(outcome, "failure")
            recorders[-1].finished(outcome, status)
        with JournalReader(journal.file) as reader:
            events = [RunEvent.model_validate(event) for event in reader.iterate(log.id)]
    view = project_task(task, file, finder(catalog))
    return CounterexampleView(task=view, status=status, outcome=outcome, events=events)


def forms_view(opened: OpenDocument, catalog: Catalog) -> Callable[[], FormsView]:
    """Return what finds the forms of a document's composites and state machines; it needs nobody to wait for it.

    Once the document has changed, nobody asks about this one: the rest isn't looked for, so that edits have the time.
    """
    revision, document = opened.revision, opened.document

    def found() -> FormsView:
        forms, why = [], "the text is not a valid task"
        if document is not None:
            try:
                forms, why = _forms(document.task, catalog, lambda: opened.revision == revision), ""
            except InvalidTaskError:
                why = "known once the task has no errors"
            except GripError as error:
                why = str(error)
        return FormsView(revision=revision, forms=forms, error=why)

    return found


def _forms(task: Task, catalog: Catalog, wanted: Callable[[], bool]) -> list[FormView]:
    notes = {}
    for convert in (to_trees, to_state_machines):
        if not wanted():
            return []
        notes.update({note.path: note for note in convert(task, catalog).notes})
    forms = []
    for path, node in walk(task.root):
        if isinstance(node, StateMachine | Sequence | Fallback):
            note = notes.get(path)
            ends = [label.partition(" -> ")[0].partition(".") for label in note.edges] if note else []
            edges = [(join(path, state), outcome) for state, _, outcome in ends]
            forms.append(FormView(path=path, both=note is None, reason=note.reason if note else "", edges=edges))
    return forms
