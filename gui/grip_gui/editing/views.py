"""Open documents as the page shows them, and the checks that it asks for while a person types."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import get_args

from grip_bt.base.errors import DocumentError, EditError, GripError
from grip_bt.task import read_text, walk
from grip_bt.task.edit import Set, apply, clip_of, comment_of
from grip_bt.task.validation import validate
from grip_gui.editing.open_document import Sheet
from grip_gui.project import ProjectFolder
from grip_gui.view.documents import (
    catalog_of,
    problems_of,
    trouble_of,
    unchecked_view,
    unreadable_view,
    view_of_document,
)
from grip_gui.wire.editing import (
    Change,
    CommentView,
    DocumentView,
    ExpressionView,
    ExpressionWish,
    HistoryView,
    LayoutView,
    MomentView,
    Part,
    PartsView,
    PlacesView,
    ProblemsView,
)
from grip_gui.wire.task import Problem, TaskView

SHOWN = 200
"""Moments of a history that a page gets."""


def document_view(folder: ProjectFolder, sheet: Sheet, since: int | None = None) -> DocumentView:
    """Return a document as it is now.

    Args:
        folder: the project.
        sheet: the open file.
        since: the revision that the page has; it is told what has moved, and asks for the problems by themselves,
            which take longer than all the rest.
    """
    change = sheet.file.change()
    assert change in get_args(Change)
    return DocumentView(
        path=sheet.file.name,
        revision=sheet.revision,
        text=sheet.text,
        saved=sheet.saved,
        draft=sheet.draft is not None,
        change=change,
        history=_history(sheet),
        layout=LayoutView(**{view: dict(spots) for view, spots in sheet.layout.pinned.items()}),
        task=_task(folder, sheet, checked=since is None),
        moved={} if since is None else sheet.moved_since(since),
        checked=since is None or sheet.draft is not None,
    )


def problems_view(folder: ProjectFolder, sheet: Sheet) -> Callable[[], ProblemsView]:
    """Return what finds the problems of a document as it is now; it needs nobody to wait for it."""
    revision, history = sheet.revision, sheet.history
    if history is None or sheet.draft is not None:
        fault = _fault(sheet)
        return lambda: ProblemsView(revision=revision, problems=[fault])
    document = history.document
    return lambda: ProblemsView(revision=revision, problems=problems_of(folder, document))


def _history(sheet: Sheet) -> HistoryView:
    history = sheet.history
    moments = history.moments[-SHOWN:] if history else ()
    return HistoryView(
        at=history.at.number if history else 0,
        moments=[MomentView(number=m.number, parent=m.parent, title=m.title) for m in moments],
        can_undo=sheet.can_undo,
        can_redo=sheet.can_redo,
    )


def _task(folder: ProjectFolder, sheet: Sheet, checked: bool) -> TaskView:
    name = sheet.file.name
    if sheet.draft is None and sheet.history is not None:
        return (view_of_document if checked else unchecked_view)(folder, sheet.history.document, name)
    fault = _fault(sheet)
    if sheet.history is None:
        return unreadable_view(name, [fault])
    stale = unchecked_view(folder, sheet.history.document, name)
    return stale.model_copy(update={"problems": [fault]})


def _fault(sheet: Sheet) -> Problem:
    try:
        read_text(sheet.text, sheet.file.name)
    except DocumentError as error:
        return trouble_of("document", error)
    return Problem(code="document", severity="error", message="this text can't be taken over; run `grip fmt` on it")


def places_view(sheet: Sheet) -> PlacesView:
    """Return where the nodes stand in the text; nothing while it isn't a task."""
    if sheet.history is None or sheet.draft is not None:
        return PlacesView(revision=sheet.revision, lines={})
    document = sheet.history.document
    places = ((path, document.position(path)) for path, _ in walk(document.task.root))
    return PlacesView(revision=sheet.revision, lines={path: place[0] for path, place in places if place})


def comment_view(sheet: Sheet, path: str) -> CommentView:
    """Return the comment of a node, of the last task that the text was."""
    comment = None
    # Who asks may not have heard yet that the node is gone: that is no mistake.
    with suppress(EditError):
        comment = comment_of(sheet.history.document, path) if sheet.history else None
    return CommentView(revision=sheet.revision, node=path, comment=comment)


def parts_view(sheet: Sheet, paths: list[str]) -> PartsView:
    """Return copies of nodes, to be pasted elsewhere.

    Raises:
        EditError: there is no such node.
    """
    if sheet.history is None:
        return PartsView(parts=[])
    task = sheet.history.document.task
    clips = [clip_of(task, path) for path in paths]
    return PartsView(parts=[Part(**clip.model_dump(mode="json")) for clip in clips])


def check_expression(folder: ProjectFolder, sheet: Sheet, wish: ExpressionWish) -> ExpressionView:
    """Return what the validation would say about an expression at a key of a node."""
    if sheet.history is None:
        return ExpressionView(faults=[])
    task = sheet.history.document.task
    try:
        after = apply(task, Set(path=wish.node, key=tuple(wish.key), value=wish.text)).task
        issues = validate(after, catalog_of(folder)[0]).issues
    except (EditError, GripError) as error:
        return ExpressionView(faults=[str(error)])
    here = [i for i in issues if i.path == wish.node and i.key[:1] == tuple(wish.key)[:1] and i.severity == "error"]
    return ExpressionView(faults=[issue.message for issue in here])
