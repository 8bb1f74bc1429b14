"""Tasks as the page shows them, open or of a run, and the checks that it asks for while a person types.

A text that is wrong still gives a view: with its problems.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.base.errors import DocumentError, EditError, GripError, SubtaskError, UnknownNameError
from grip_bt.task import read_text, walk
from grip_bt.task.catalog import Catalog, Manifest, manifest_of_task
from grip_bt.task.document import Document
from grip_bt.task.edit import Set, apply, clip_of, comment_of
from grip_bt.task.validation import validate
from grip_bt.task.validation.fixes import Fixer
from grip_gui.editing.open_document import OpenDocument
from grip_gui.editing.projection import FindManifest, project_task
from grip_gui.project import ProjectFolder
from grip_gui.wire import editing as wire
from grip_gui.wire.task import FixView, Problem, TaskView

SHOWN = 200  # moments of a history that a page gets
FIXED = 100  # problems for which fixes are looked for; who has more begins with these


def view_of_text(folder: ProjectFolder, text: str, path: str) -> TaskView:
    """Return the view of a task's text, with what is wrong with it; the nodes are missing when it can't be read."""
    try:
        document = read_text(text, path)
    except GripError as error:
        return _unreadable(path, problem_of("document", error))
    return _view(folder, document, path)


def _view(folder: ProjectFolder, document: Document, path: str, checked: bool = True) -> TaskView:
    view = project_task(document.task, path, finder(catalog_of(folder)[0]))
    return view.model_copy(update={"problems": problems_of(folder, document)}) if checked else view


def problems_of(folder: ProjectFolder, document: Document) -> list[Problem]:
    """Return what is wrong with a task, and what can be done about that."""
    catalog, error = catalog_of(folder)
    if error is not None:
        # The project's other files are wrong; the task is still drawn, with the built-in nodes' faces.
        return [error]
    issues = validate(document.task, catalog, document).issues
    problems = [Problem.model_validate(issue) for issue in issues]
    if issues:
        fixer = Fixer(document.task, catalog)
        for number, issue in enumerate(issues[:FIXED]):
            fixes = [FixView(title=f.title, command=f.command.model_dump(mode="json")) for f in fixer.fixes(issue)]
            problems[number] = problems[number].model_copy(update={"fixes": fixes})
    return problems


def catalog_of(folder: ProjectFolder) -> tuple[Catalog, Problem | None]:
    """Return the nodes that exist in the project, and why they are only the built-in ones."""
    try:
        return project_catalog(folder.folder), None
    except GripError as error:
        return Catalog.builtin(), problem_of("project", error)


def finder(catalog: Catalog) -> FindManifest:
    """Return what finds the face of a leaf by its id, and of a subtask by its file."""

    def find(node: str) -> Manifest | None:
        try:
            if node.endswith((".yaml", ".yml")):
                return manifest_of_task(node, catalog.tasks.read(node))
            return catalog.get(node)
        except (UnknownNameError, SubtaskError):
            return None

    return find


def _unreadable(path: str, problem: Problem) -> TaskView:
    return TaskView(path=path, name=path.rsplit("/", 1)[-1].rsplit(".", 1)[0], problems=[problem])


def problem_of(code: str, error: GripError) -> Problem:
    """Return an error as a problem of the whole file, with its place where it has one."""
    line, column = getattr(error, "line", None), getattr(error, "column", None)
    return Problem(code=code, severity="error", message=str(error), line=line, column=column)


# --- open documents ---------------------------------------------------------------------------------------------------


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
            moments=[wire.HistoryEntry.model_validate(moment) for moment in moments],
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
    revision, document = opened.revision, opened.document
    if document is None:
        fault = _fault(opened)
        return lambda: wire.ProblemsView(revision=revision, problems=[fault])
    return lambda: wire.ProblemsView(revision=revision, problems=problems_of(folder, document))


def _task(folder: ProjectFolder, opened: OpenDocument, checked: bool) -> TaskView:
    name = opened.file.name
    if opened.document is not None:
        return _view(folder, opened.document, name, checked)
    fault = _fault(opened)
    if opened.history is None:
        return _unreadable(name, fault)
    stale = _view(folder, opened.history.document, name, checked=False)
    return stale.model_copy(update={"problems": [fault]})


def _fault(opened: OpenDocument) -> Problem:
    try:
        read_text(opened.text, opened.file.name)
    except DocumentError as error:
        return problem_of("document", error)
    return Problem(code="document", severity="error", message="this text cannot be edited here; run `grip fmt` on it")


def places_view(opened: OpenDocument) -> wire.PlacesView:
    """Return where the nodes stand in the text; nothing while it isn't a task."""
    document = opened.document
    places = ((path, document.position(path)) for path, _ in walk(document.task.root)) if document else ()
    return wire.PlacesView(revision=opened.revision, lines={path: place[0] for path, place in places if place})


def comment_view(opened: OpenDocument, path: str) -> wire.CommentView:
    """Return the comment of a node, of the last task that the text was."""
    comment = None
    # Who asks may not have heard yet that the node is gone: that is no mistake.
    with suppress(EditError):
        comment = comment_of(opened.history.document, path) if opened.history else None
    return wire.CommentView(revision=opened.revision, node=path, comment=comment)


def parts_view(opened: OpenDocument, paths: list[str]) -> list[wire.Part]:
    """Return copies of nodes, to be pasted elsewhere."""
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
    except GripError as error:
        return [str(error)]
    mine = [issue for issue in issues if issue.path == request.node and issue.severity == "error"]
    return [issue.message for issue in mine if issue.key[:1] == tuple(request.key)[:1]]
