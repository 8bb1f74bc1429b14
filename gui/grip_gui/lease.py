"""Who holds control: one page at a time starts, pauses and steps runs; all look on, and anybody may stop."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable

from grip_bt.base.errors import GripError

GRACE = 5.0
"""How long control waits for a page that has gone away, which a reload does for a moment [s]."""


class HeldElsewhereError(GripError):
    """Another page holds control."""

    def __init__(self) -> None:
        super().__init__("another page holds control; take it over there, or look on. STOP always works")


class Lease:
    """Control of the runs, held by one of the pages or by nobody.

    Whoever controls something while nobody holds it gets it. It becomes free when its page has been away for `GRACE`;
    a page that comes back later than that, as by a slow reload, holds it again unless another one has had it.

    Args:
        changed: called after each change.
    """

    def __init__(self, changed: Callable[[], None]):
        self.holder: str | None = None
        self._changed = changed
        self._here: Counter[str] = Counter()
        self._waiting: asyncio.TimerHandle | None = None
        self._missed: str | None = None
        """The page that held it last, and was away for too long."""

    def require(self, page: str) -> None:
        """Check that a page may control, and give it control where nobody has it.

        Args:
            page: its id; empty for somebody without a page, who may as long as nobody holds control.

        Raises:
            HeldElsewhereError: another page holds it.
        """
        if self.holder not in (None, page):
            raise HeldElsewhereError
        if page and self.holder is None:
            self._hold(page)

    def take(self, page: str, over: bool = False) -> None:
        """Give control to a page.

        Args:
            page: its id.
            over: also from a page that holds it.

        Raises:
            HeldElsewhereError: another page holds it.
        """
        if not over:
            self.require(page)
        elif self.holder != page:
            self._hold(page)

    def give(self, page: str) -> None:
        """Free what a page holds; nothing happens where it holds nothing."""
        if self.holder == page:
            self._hold(None)

    def come(self, page: str) -> None:
        """Note that a page looks on."""
        self._here[page] += 1
        if page and self.holder is None and page == self._missed:
            self._hold(page)

    def go(self, page: str) -> None:
        """Note that a page has gone; what it holds waits a moment for its return."""
        self._here[page] -= 1
        if page and page == self.holder and not self._here[page]:
            self._await_return(page)

    def _hold(self, page: str | None) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
        self.holder, self._waiting, self._missed = page, None, None
        if page and not self._here[page]:
            self._await_return(page)
        self._changed()

    def _await_return(self, page: str) -> None:
        def gone() -> None:
            if self.holder == page and not self._here[page]:
                self._hold(None)
                self._missed = page

        self._waiting = asyncio.get_running_loop().call_later(GRACE, gone)
