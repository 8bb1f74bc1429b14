"""What has changed in a document since a page saw it: an edit of a large task sends a few nodes, not all of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from itertools import count
from secrets import randbelow
from weakref import WeakKeyDictionary

from grip_bt.task import join
from grip_bt.task.edit import path_after
from grip_bt.task.edit.steps import Step
from grip_gui.editing.open_document import Sheet
from grip_gui.project import ProjectFolder
from grip_gui.wire.editing import DocumentChange, DocumentView, TaskChange, TextSplice
from grip_gui.wire.task import NodeView, TaskView

from .views import document_view

KEPT = 16
"""So many states of each document are remembered; who has an older one gets the whole."""


class Shown:
    """The states of open documents that pages have been sent. To be asked while the sheet is held.

    Args:
        folder: the project.
    """

    def __init__(self, folder: ProjectFolder):
        self._folder = folder
        self._states: WeakKeyDictionary[Sheet, deque[DocumentView]] = WeakKeyDictionary()
        # A page may have a number of a server that is gone: two servers hardly ever give the same ones.
        self._numbers = count(randbelow(2**40) + 1)

    def answer(self, sheet: Sheet, since: int) -> DocumentView | DocumentChange:
        """Return what a page is sent that has the state `since`: what changed, or the whole where that isn't known.

        Problems aren't looked for here: they take longer than an edit and its drawing.
        """
        states = self._states.setdefault(sheet, deque(maxlen=KEPT))
        now = document_view(self._folder, sheet, checked=False)
        if states:
            now = now.model_copy(update={"task": _sharing(now.task, states[-1].task)})
        if not states or not _alike(states[-1], now):
            states.append(now.model_copy(update={"state": next(self._numbers)}))
        now = now.model_copy(update={"state": states[-1].state})
        before = next((state for state in states if state.state == since and not state.draft), None)
        return now if before is None or now.draft else _change(before, now, sheet.steps_since(before.revision))


def _alike(one: DocumentView, other: DocumentView) -> bool:
    """Tell whether two states are equal in all that a change leaves out where it is equal."""
    same = (one.revision, one.draft, one.text, one.layout) == (other.revision, other.draft, other.text, other.layout)
    return same and _task_change(one.task, other.task) is None


def _sharing(now: TaskView, before: TaskView) -> TaskView:
    """Return a view whose nodes are the objects of an earlier one where they are equal: kept once, told apart fast."""
    known = {node.path: node for node in before.nodes}
    nodes = [_same(node, known.get(node.path)) for node in now.nodes]
    return now.model_copy(update={"nodes": nodes})


def _same(node: NodeView, known: NodeView | None) -> NodeView:
    return known if known is not None and known.__dict__ == node.__dict__ else node


def _change(before: DocumentView, now: DocumentView, steps: Sequence[Step]) -> DocumentChange:
    return DocumentChange(
        path=now.path,
        since=before.state,
        state=now.state,
        revision=now.revision,
        splice=splice_of(before.text, now.text),
        saved=now.saved,
        change=now.change,
        history=now.history,
        layout=now.layout if now.layout != before.layout else None,
        task=_task_change(before.task, now.task, steps),
    )


def _task_change(before: TaskView, now: TaskView, steps: Sequence[Step] = ()) -> TaskChange | None:
    known = {node.path: node for node in before.nodes}
    there = {node.path for node in now.nodes}
    nodes = [node for node in now.nodes if known.get(node.path) is not node]
    gone = [path for path in known if path not in there]
    variables = None if now.variables == before.variables else now.variables
    same = (now.name, now.doc, now.outcomes) == (before.name, before.doc, before.outcomes)
    if same and variables is None and not nodes and not gone:
        return None
    moved = _moved(gone, there, steps)
    return TaskChange(
        name=now.name,
        doc=now.doc,
        outcomes=now.outcomes,
        nodes=nodes,
        gone=gone,
        moved=moved,
        variables=variables,
    )


def _moved(gone: list[str], there: set[str], steps: Sequence[Step]) -> dict[str, str]:
    """Return where nodes are that steps have taken elsewhere; parents come first, and take along what is below them."""
    moved: dict[str, str] = {}
    along: dict[str, str] = {}
    for path in gone if steps else ():
        above, _, name = path.rpartition("/")
        now: str | None = join(along[above], name) if above in along else None
        if now not in there:
            now = path_after(path, steps)
            if now is None or now not in there:
                continue
            moved[path] = now
        along[path] = now
    return moved


def splice_of(before: str, now: str) -> TextSplice | None:
    """Return the one piece that makes a text of another; None where they are equal. Counted in UTF-16 units."""
    if before == now:
        return None
    start = _common(before, now)
    end = min(_common(before[::-1], now[::-1]), len(before) - start, len(now) - start)
    removed, new = before[start : len(before) - end], now[start : len(now) - end]
    return TextSplice(start=_units(before[:start]), removed=_units(removed), new=new)


def _common(one: str, other: str) -> int:
    """Return how many characters two texts have in common at the beginning, by halving."""
    low, high = 0, min(len(one), len(other))
    while low < high:
        middle = (low + high + 1) // 2
        if one[low:middle] == other[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low


def _units(text: str) -> int:
    return len(text) if text.isascii() else len(text.encode("utf-16-le", "surrogatepass")) // 2
