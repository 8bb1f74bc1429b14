"""A container, or the whole task, in the other form: looked at first, with what was found by comparing both."""

from __future__ import annotations

from collections.abc import Callable

from grip_bt.base.errors import EditError, InvalidTaskError, NodeError
from grip_bt.compilers.restructure import Restructured, compare, to_state_machines, to_trees
from grip_bt.compilers.restructure.as_edit import expanded
from grip_bt.task import Task, walk
from grip_bt.task.catalog import Catalog
from grip_bt.task.edit import Convert
from grip_gui.edit_messages import ConversionView, ConvertWish, Form

from .playing import plays
from .sheet import Sheet


def conversion_view(
    sheet: Sheet, catalog: Catalog, path: str, form: Form, approximate: bool
) -> Callable[[], ConversionView]:
    """Return what finds what a conversion would do, and whether both forms do the same; nobody needs to wait for it.

    Raises:
        EditError: there is nothing to convert, or the task has errors; the second also from what is returned.
    """
    task, file = _task(sheet), sheet.file.name
    if path not in dict(walk(task.root)):
        raise EditError(path, "there is no such node")
    return lambda: _view(task, file, catalog, path, form, approximate)


def _view(task: Task, file: str, catalog: Catalog, path: str, form: Form, approximate: bool) -> ConversionView:
    try:
        result = _converted(task, catalog, path, form, approximate)
        comparison = compare(task, result, catalog)
    except InvalidTaskError as error:
        raise EditError(path, f"the task has errors, mend them first: {error.issues[0]}") from error
    except NodeError as error:
        raise EditError(path, f"the two forms can't be compared: {error}") from error
    kept = [str(note) for note in result.notes if not note.by_design]
    if result.task == task:
        raise EditError(path, "; ".join(kept) or f"it has the form of a {form} already")
    difference = comparison.difference
    return ConversionView(
        before=_outline(task, path),
        after=_outline(result.task, result.paths.get(path, path)),
        kept=kept,
        same=difference is None,
        compared=str(comparison),
        script=[str(end) for end in difference.script] if difference else [],
        does_before=list(difference.before) if difference else [],
        does_after=list(difference.after) if difference else [],
        plays=plays(task, result, difference, catalog, file) if difference else [],
    )


def convert(sheet: Sheet, catalog: Catalog, wish: ConvertWish) -> None:
    """Convert as one edit; what stays keeps its lines and comments.

    Raises:
        EditError: there is nothing to convert, or the task has errors.
        StaleEditError: the task has changed since it was looked at.
    """
    command = Convert(path=wish.node, to="bt" if wish.form == "tree" else "sm", approximate=wish.approximate)
    sheet.do(expanded(command, _task(sheet), catalog), wish.base)  # what was looked at is that state alone


def _task(sheet: Sheet) -> Task:
    if sheet.history is None or sheet.draft is not None:
        raise EditError("", "the text isn't a task at the moment; mend it first")
    return sheet.history.document.task


def _converted(task: Task, catalog: Catalog, path: str, form: Form, approximate: bool) -> Restructured:
    if form == "tree":
        return to_trees(task, catalog, path)
    return to_state_machines(task, catalog, approximate, path)


def _outline(task: Task, path: str) -> list[str]:
    """Return a part of a task in lines: kinds and names, indented."""
    lines = []
    for each, node in walk(task.root):
        if path == "/" or each == path or each.startswith(f"{path}/"):
            names = [] if each == "/" else each.split("/")
            depth = len(names) - (0 if path == "/" else len(path.split("/")))
            kind = getattr(node, "kind", None) or getattr(node, "node", "")
            lines.append(f"{'  ' * depth}{names[-1] if names else task.name}: {kind}")
    return lines
