"""Reads task files for the page. A file that is wrong still gives a view: with its problems."""

from __future__ import annotations

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.base.errors import DocumentError, GripError, SubtaskError, UnknownNameError
from grip_bt.base.issue import Issue
from grip_bt.base.yaml.tree import read_file
from grip_bt.task.catalog import Catalog, Manifest, manifest_of_task
from grip_bt.task.document import Document, read_text
from grip_bt.task.validation import validate
from grip_bt.task.validation.fixes import Fixer
from grip_gui.project import ProjectFolder
from grip_gui.view.projection import FindManifest, project_task
from grip_gui.wire.task import FixView, Problem, TaskView

FIXED = 100
"""Problems for which fixes are looked for; who has more begins with these."""


def task_view(folder: ProjectFolder, path: str) -> TaskView:
    """Return the view of a task file of the project.

    Raises:
        OutsideProjectError: the path leads elsewhere.
        DocumentError: there is no such file.
    """
    file = folder.task_file(path)
    try:
        text = read_file(file)
    except DocumentError as error:
        return unreadable_view(path, [problem_of("document", error)])
    return view_of_text(folder, text, path)


def view_of_text(folder: ProjectFolder, text: str, path: str) -> TaskView:
    """Return the view of a task's text, with what is wrong with it; the nodes are missing when it can't be read."""
    try:
        document = read_text(text, path)
    except GripError as error:
        return unreadable_view(path, [problem_of("document", error)])
    return view_of_document(folder, document, path)


def view_of_document(folder: ProjectFolder, document: Document, path: str) -> TaskView:
    """Return the view of a task, with what is wrong with it and what can be done about that."""
    view = unchecked_view(folder, document, path)
    return view.model_copy(update={"problems": problems_of(folder, document)})


def unchecked_view(folder: ProjectFolder, document: Document, path: str) -> TaskView:
    """Return the view of a task without its problems, which take longer than all the rest."""
    return project_task(document.task, path, finder(catalog_of(folder)[0]))


def problems_of(folder: ProjectFolder, document: Document) -> list[Problem]:
    """Return what is wrong with a task, and what can be done about that."""
    catalog, error = catalog_of(folder)
    if error is not None:
        # The project's other files are wrong; the task is still drawn, with the built-in nodes' faces.
        return [error]
    issues = validate(document.task, catalog, document).issues
    fixer = Fixer(document.task, catalog) if issues else None
    return [_problem(issue, fixer if number < FIXED else None) for number, issue in enumerate(issues)]


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


def _problem(issue: Issue, fixer: Fixer | None) -> Problem:
    fixes = fixer.fixes(issue) if fixer else ()
    return Problem(
        path=issue.path,
        code=issue.code,
        severity="error" if issue.severity == "error" else "warning",
        message=issue.message,
        fix=issue.fix,
        line=issue.line,
        column=issue.column,
        key=[str(key) for key in issue.key],
        fixes=[FixView(title=fix.title, command=fix.command.model_dump(mode="json")) for fix in fixes],
    )


def unreadable_view(path: str, problems: list[Problem]) -> TaskView:
    """Return the view of a file that isn't a task, with what is wrong with it."""
    return TaskView(path=path, name=path.rsplit("/", 1)[-1].rsplit(".", 1)[0], problems=problems)


def problem_of(code: str, error: GripError) -> Problem:
    """Return an error as a problem of the whole file, with its place where it has one."""
    line, column = getattr(error, "line", None), getattr(error, "column", None)
    return Problem(code=code, severity="error", message=str(error), line=line, column=column)
