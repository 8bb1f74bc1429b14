"""Comments in the file of a task, of nodes and of the task as a whole: read, and the command that writes them."""

from __future__ import annotations

from grip_bt.base.yaml.tree import YamlMapping

from ..document import Document
from .commands import Comment
from .editing import Editing
from .head import head_at
from .regions import is_tidy
from .remarks import found_at, lines_of_comment
from .steps import HEAD, Place, Remark


def comment_of(document: Document, path: str) -> str:
    """Return the comment of a node, of the task for an empty path, without its signs; empty where it has none.

    Raises:
        EditError: there is no such node.
    """
    if path == "":
        return head_at(document.text, document.tree).text
    *above, key = Editing(document.task).place(path)
    inside = document.tree
    for step in above:
        inner = inside.entries[step].value
        if not isinstance(inner, YamlMapping):
            return ""
        inside = inner
    return found_at(document.text, inside, key).text if is_tidy(document.text, inside) else ""


def comment(editing: Editing, command: Comment) -> None:
    """Write the comment of a node, or of the task, anew.

    Raises:
        EditError: there is no such node, or no file can hold the text.
    """
    place: Place = editing.place(command.path) or (HEAD,)
    lines_of_comment(command.path, command.text)
    editing.take(Remark(at=place[:-1], key=place[-1], text=command.text))
