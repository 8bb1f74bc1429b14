"""Reads task files for the page. A file that is wrong still gives a view: with its problems."""

from __future__ import annotations

from grip_bt.app.project import project_catalog
from grip_bt.catalog import Catalog
from grip_bt.errors import DocumentError, GripError, UnknownNameError
from grip_bt.graph.document import read_file, read_text
from grip_bt.validation import Issue, validate

from .messages import Problem, TaskView
from .project import ProjectFolder
from .projection import FindManifest, project_task


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
        return _unreadable(path, [_trouble("document", error)])
    return view_of_text(folder, text, path)


def view_of_text(folder: ProjectFolder, text: str, path: str) -> TaskView:
    """Return the view of a task's text, with what is wrong with it; the nodes are missing when it can't be read."""
    try:
        document = read_text(text, path)
    except GripError as error:
        return _unreadable(path, [_trouble("document", error)])
    try:
        catalog = project_catalog(folder.folder)
    except GripError as error:
        # The project's other files are wrong; the task can still be drawn, with the built-in nodes' faces.
        return project_task(document.task, path, _finder(Catalog.builtin()), [_trouble("project", error)])
    problems = [_problem(issue) for issue in validate(document.task, catalog, document).issues]
    return project_task(document.task, path, _finder(catalog), problems)


def _finder(catalog: Catalog) -> FindManifest:
    def find(node: str) -> object:
        try:
            return catalog.get(node)
        except UnknownNameError:
            return None

    return find  # type: ignore[return-value]


def _problem(issue: Issue) -> Problem:
    return Problem(
        path=issue.path,
        code=issue.code,
        severity=issue.severity,
        message=issue.message,
        fix=issue.fix,
        line=issue.line,
    )


def _unreadable(path: str, problems: list[Problem]) -> TaskView:
    return TaskView(path=path, name=path.rsplit("/", 1)[-1].rsplit(".", 1)[0], problems=problems)


def _trouble(code: str, error: GripError) -> Problem:
    return Problem(code=code, severity="error", message=str(error))
