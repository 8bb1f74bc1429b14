"""Another form of a task, or of part of it: conversions tried, compared by running both, and applied."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePosixPath

from grip_bt.base.errors import EditError, GripError, InvalidTaskError, NodeError
from grip_bt.base.values import Failure
from grip_bt.compilers.restructure import compare, moved, play, to_state_machines, to_trees
from grip_bt.compilers.restructure.equivalence import End
from grip_bt.nodes.node import Observer
from grip_bt.runtime.value_codec import preview
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


def _play(task: Task, script: tuple[End, ...], catalog: Catalog, file: str) -> CounterexampleView:
    events = _Events()
    end = play(task, catalog, script, events.by)
    outcome = end[0] if end and end[0] != "error" else None
    root = task.root.meaning if isinstance(task.root, Leaf) else outcomes_of(task.root)
    meaning = {**root, **task.outcomes}
    status = "stopped" if not end else end[0] if outcome is None else meaning.get(outcome, "failure")
    events.add("/", "run_ended", outcome, status=status)
    return CounterexampleView(
        task=project_task(task, file, finder(catalog)), status=status, outcome=outcome, events=events.all
    )


class _Events(Observer):
    """The observer that notes what happens as the journal would."""

    def __init__(self) -> None:
        self.all: list[RunEvent] = []
        self._now: Callable[[], float] = lambda: 0.0

    def by(self, now: Callable[[], float]) -> _Events:
        """Take the run's clock [s]; return the observer."""
        self._now = now
        return self

    def add(self, path: str, event: str, outcome: str | None = None, code: str | None = None, **data: object) -> None:
        """Note one event, as the journal would."""
        seq = len(self.all)
        self.all.append(RunEvent(seq=seq, t=self._now(), path=path, event=event, outcome=outcome, code=code, data=data))

    def entered(self, path: str) -> None:
        self.add(path, "enter")

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        said = {"message": failure.message} if failure and failure.message else {}
        self.add(path, "exit", outcome, failure.code if failure else None, **said)

    def interrupted(self, path: str) -> None:
        self.add(path, "interrupted")

    def message(self, path: str, text: str) -> None:
        self.add(path, "message", text=text)

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        self.add(path, "write", variable=variable, type=type_name, preview=preview(value))


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
