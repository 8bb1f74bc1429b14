"""The pages that are connected: who they are, what is selected on them, and which of them holds control."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count

from grip_bt.base.errors import GripError
from grip_gui.wire.runs import Introduce, Selected, Selection, Viewer

GRACE = 5.0  # how long control waits for a page that has gone away, which a reload does for a moment [s]
COLOURS = 8  # how many colours there are; with more pages some look alike, and their names tell them apart


class ControlTakenError(GripError):
    """Another page is in control."""

    def __init__(self) -> None:
        super().__init__("another page is in control; take over, or keep watching. STOP always works")


@dataclass
class _Page:
    page: str
    name: str
    colour: int
    task: str = ""
    connections: int = 0
    selected: Selected | None = None


class Presence:
    """The pages that are connected, and control of the runs, held by one of them or by nobody.

    Whoever controls something while nobody holds control gets it. It becomes free when its page has been away for
    `GRACE`. `changed` is called after each change.
    """

    def __init__(self, changed: Callable[[], None]):
        self.holder: str | None = None
        self._changed = changed
        self._pages: dict[str, _Page] = {}
        self._nameless = 0
        self._waiting: asyncio.TimerHandle | None = None

    @property
    def connections(self) -> int:
        """How many connections look on."""
        return self._nameless + sum(page.connections for page in self._pages.values())

    @property
    def viewers(self) -> list[Viewer]:
        """Who looks on, in the order in which they came; without those that haven't said which page they are."""
        return [Viewer.model_validate(each) for each in self._pages.values()]

    def selections(self, but: str = "") -> dict[str, Selected]:
        """Return what is selected on each page but one, where anything is."""
        pages = self._pages.items()
        return {page: each.selected for page, each in pages if each.selected is not None and page != but}

    # --- control ---

    def require(self, page: str) -> None:
        """Check that a page may control, and give it control where nobody has it; empty for somebody without a page.

        Raises:
            ControlTakenError: another page holds it.
        """
        if self.holder not in (None, page):
            raise ControlTakenError
        if page and self.holder is None:
            self._hold(page)

    def take(self, page: str, over: bool = False) -> None:
        """Give control to a page, with `over` also from a page that holds it."""
        if not over:
            self.require(page)
        elif self.holder != page:
            self._hold(page)

    def give(self, page: str) -> None:
        """Free what a page holds; nothing happens where it holds nothing."""
        if self.holder == page:
            self._hold(None)

    def _hold(self, page: str | None) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
        self.holder, self._waiting = page, None
        if page and page not in self._pages:
            self._await_return(page)
        self._changed()

    def _await_return(self, page: str) -> None:
        def gone() -> None:
            if self.holder == page and page not in self._pages:
                self._hold(None)

        self._waiting = asyncio.get_running_loop().call_later(GRACE, gone)

    # --- who looks on ---

    def come(self, page: str) -> None:
        """Note that a page looks on; empty for somebody without a page."""
        if not page:
            self._nameless += 1
        else:
            if page not in self._pages:
                uses = [page.colour for page in self._pages.values()]
                colour = min(range(COLOURS), key=lambda colour: (uses.count(colour), colour))
                self._pages[page] = _Page(page, self._free("Viewer", first=1), colour)
            self._pages[page].connections += 1
        self._changed()

    def go(self, page: str) -> None:
        """Note that a page has gone; the control that it holds waits a moment for its return."""
        if not page:
            self._nameless -= 1
        else:
            self._pages[page].connections -= 1
            if not self._pages[page].connections:
                del self._pages[page]
                if page == self.holder:
                    self._await_return(page)
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

    def _free(self, wanted: str, first: int = 0) -> str:
        """Return a name that nobody has: with a number, or, where `first` is 0, as it is wanted before `NAME 2`."""
        taken = {page.name for page in self._pages.values()}
        if not first and wanted not in taken:
            return wanted
        return next(name for number in count(first or 2) if (name := f"{wanted} {number}") not in taken)
