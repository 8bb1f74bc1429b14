"""Who looks on: the pages that are connected, what they are called, their colours, and what is selected on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import count

from grip_gui.run_messages import Introduce, Onlooker, Selected, Selection

COLOURS = 8
"""How many colours there are; with more pages some look alike, and their names tell them apart."""
REMEMBERED = 100
"""How many pages that have gone are known again when they come back."""


@dataclass
class _Page:
    name: str
    colour: int
    task: str = ""
    connections: int = 0
    selected: Selected | None = None


class Presence:
    """The pages that are connected. A page that comes back, as at a reload, is called as before.

    Args:
        changed: called after each change.
    """

    def __init__(self, changed: Callable[[], None]):
        self._changed = changed
        self._pages: dict[str, _Page] = {}
        self._gone: dict[str, _Page] = {}
        self._nameless = 0

    @property
    def viewers(self) -> int:
        """How many connections look on."""
        return self._nameless + sum(page.connections for page in self._pages.values())

    @property
    def onlookers(self) -> list[Onlooker]:
        """Who looks on, in the order in which they came; without those that haven't said which page they are."""
        return [
            Onlooker(page=page, name=each.name, colour=each.colour, task=each.task)
            for page, each in self._pages.items()
        ]

    def selections(self, but: str = "") -> dict[str, Selected]:
        """Return what is selected on each page but one, where anything is."""
        pages = self._pages.items()
        return {page: each.selected for page, each in pages if each.selected is not None and page != but}

    def come(self, page: str) -> None:
        """Note that a page looks on; empty for somebody without a page."""
        if not page:
            self._nameless += 1
        else:
            if page not in self._pages:
                self._pages[page] = self._known(page)
            self._pages[page].connections += 1
        self._changed()

    def go(self, page: str) -> None:
        """Note that a page has gone."""
        if not page:
            self._nameless -= 1
        else:
            self._pages[page].connections -= 1
            if not self._pages[page].connections:
                self._gone[page] = self._pages.pop(page)
                self._gone[page].selected = None
                if len(self._gone) > REMEMBERED:
                    del self._gone[next(iter(self._gone))]
        self._changed()

    def introduce(self, page: str, said: Introduce) -> None:
        """Note what a page says of itself; a name that another one has gets a number."""
        known = self._pages.get(page)
        if known is None:
            return
        wanted = " ".join(said.name.split())
        if wanted and wanted != known.name:
            known.name = ""
            known.name = self._free(wanted)
        known.task = said.task
        self._changed()

    def select(self, page: str, said: Selection) -> None:
        """Note what is selected on a page; nobody is told when it is what was selected before."""
        known = self._pages.get(page)
        selected = Selected(task=said.task, nodes=said.nodes) if said.nodes else None
        if known is None or known.selected == selected:
            return
        known.selected = selected
        self._changed()

    def _known(self, page: str) -> _Page:
        before = self._gone.pop(page, None)
        if before is None:
            return _Page(self._free("Viewer", first=1), self._free_colour())
        before.name = self._free(before.name)
        return before

    def _free(self, wanted: str, first: int = 0) -> str:
        taken = {page.name for page in self._pages.values()}
        names: Iterable[str] = (f"{wanted} {number}" if number else wanted for number in _numbers(first))
        return next(name for name in names if name not in taken)

    def _free_colour(self) -> int:
        uses = [page.colour for page in self._pages.values()]
        return min(range(COLOURS), key=lambda colour: (uses.count(colour), colour))


def _numbers(first: int) -> Iterable[int]:
    """Yield `first` and what follows; after 0, which is no number, 2: the first one is called as it is."""
    yield first
    yield from count(max(first + 1, 2))
