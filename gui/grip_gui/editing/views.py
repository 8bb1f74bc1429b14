"""Open documents as the page shows them, and the checks that it asks for while a person types."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from grip_bt.base.errors import DocumentError, EditError, GripError
from grip_bt.task import read_text, walk
from grip_bt.task.edit import Set, apply, clip_of, comment_of
from grip_bt.task.validation import validate
from grip_gui.editing.open_document import OpenDocument
from grip_gui.project import ProjectFolder
from grip_gui.view.documents import (
    catalog_of,
    problem_of,
    problems_of,
    unchecked_view,
    unreadable_view,
    view_of_document,
)
from grip_gui.wire import editing as wire
from grip_gui.wire.task import Problem, TaskView

SHOWN = 200
"""Moments of a history that a page gets."""


def document_view(folder: ProjectFolder, opened: OpenDocument, since: int | None = None) -> wire.DocumentView:
    """Return a document as it is now.

    A page that has the revision `since` is told what has moved, and asks for the problems by themselves, which take
    longer than all the rest.
    """
    history = opened.history
    moments = history.moments[-SHOWN:] if history else ()
    return wire.DocumentView(
        path=opened.file.name,
        revision=opened.revision,
        text=opened.text,
        saved=opened.saved,
        draft=opened.draft is not None,
        change=opened.file.change(),
        history=wire.HistoryView(
            at=history.at.number if history else 0,
            moments=[wire.HistoryEntry(number=m.number, parent=m.parent, title=m.title) for m in moments],
            can_undo=opened.can_undo,
            can_redo=opened.can_redo,
        ),
        layout=wire.LayoutView(**{view: dict(spots) for view, spots in opened.layout.pinned.items()}),
        task=_task(folder, opened, checked=since is None),
        moved={} if since is None else opened.moved_since(since),
        checked=since is None or opened.draft is not None,
    )


def problems_view(folder: ProjectFolder, opened: OpenDocument) -> Callable[[], wire.ProblemsView]:
    """Return what finds the problems of a document as it is now; it needs nobody to wait for it."""
    revision, history = opened.revision, opened.history
    if history is None or opened.draft is not None:
        fault = _fault(opened)
        return lambda: wire.ProblemsView(revision=revision, problems=[fault])
    document = history.document
    return lambda: wire.ProblemsView(revision=revision, problems=problems_of(folder, document))


def _task(folder: ProjectFolder, opened: OpenDocument, checked: bool) -> TaskView:
    name = opened.file.name
    if opened.draft is None and opened.history is not None:
        return (view_of_document if checked else unchecked_view)(folder, opened.history.document, name)
    fault = _fault(opened)
    if opened.history is None:
        return unreadable_view(name, [fault])
    stale = unchecked_view(folder, opened.history.document, name)
    return stale.model_copy(update={"problems": [fault]})


def _fault(opened: OpenDocument) -> Problem:
    try:
        read_text(opened.text, opened.file.name)
    except DocumentError as error:
        return problem_of("document", error)
    return Problem(code="document", severity="error", message="this text cannot be edited here; run `grip fmt` on it")


def places_view(opened: OpenDocument) -> wire.PlacesView:
    """Return where the nodes stand in the text; nothing while it isn't a task."""
    if opened.history is None or opened.draft is not None:
        return wire.PlacesView(revision=opened.revision, lines={})
    document = opened.history.document
    places = ((path, document.position(path)) for path, _ in walk(document.task.root))
    return wire.PlacesView(revision=opened.revision, lines={path: place[0] for path, place in places if place})


def comment_view(opened: OpenDocument, path: str) -> wire.CommentView:
    """Return the comment of a node, of the last task that the text was."""
    comment = None
    # Who asks may not have heard yet that the node is gone: that is no mistake.
    with suppress(EditError):
        comment = comment_of(opened.history.document, path) if opened.history else None
    return wire.CommentView(revision=opened.revision, node=path, comment=comment)


def parts_view(opened: OpenDocument, paths: list[str]) -> list[wire.Part]:
    """Return copies of nodes, to be pasted elsewhere.

    Raises:
        EditError: there is no such node.
    """
    if opened.history is None:
        return []
    task = opened.history.document.task
    return [wire.Part(**clip_of(task, path).model_dump(mode="json")) for path in paths]


def check_expression(folder: ProjectFolder, opened: OpenDocument, request: wire.ExpressionRequest) -> list[str]:
    """Return what the validation would say about an expression at a key of a node."""
    if opened.history is None:
        return []
    task = opened.history.document.task
    try:
        after = apply(task, Set(path=request.node, key=tuple(request.key), value=request.text)).task
        issues = validate(after, catalog_of(folder)[0]).issues
    except (EditError, GripError) as error:
        return [str(error)]
    mine = [issue for issue in issues if issue.path == request.node and issue.severity == "error"]
    return [issue.message for issue in mine if issue.key[:1] == tuple(request.key)[:1]]
