"""Whether there is one server that fits, and knows us: looked at before anything is sent, trusted for a moment."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from .preflight import gids_of

TRUST = 0.5
"""How long a check of the server holds [s]; a query per call would double the price of a call."""
SETTLE = 0.1
"""How long a server must be known before it is sent anything [s]: it has to know our ear too, or its first answer is
lost."""
STALE = 3.5
"""How long a second server may be a dead one whose lease is running out [s]."""
GRACE = 1.0
"""How long to wait for the exit of a process of ours whose server has gone [s]: it says more than DDS does."""


class ServerCheck:
    """The check of one name's server; used on the bus's thread.

    Args:
        look: returns who serves the name.
        check: raises UnfitServerError for servers that don't fit.
        connected: makes our client, if there is none yet, and tells whether it is connected. It isn't called before a
            server was found to fit: a client of the wrong type would spoil the name for this process.

    Attributes:
        servers: who was found last, while that is trusted; empty when it has to be looked again.
    """

    def __init__(
        self, look: Callable[[], list[Any]], check: Callable[[list[Any]], None], connected: Callable[[], bool]
    ):
        self._look, self._check, self._connected = look, check, connected
        self.servers: frozenset[bytes] = frozenset()
        self._checked = -math.inf
        self._settled: tuple[frozenset[bytes], float] = (frozenset(), 0.0)

    @property
    def last(self) -> frozenset[bytes]:
        """Who was found last, trusted or not."""
        return self._settled[0]

    def trusted(self, now: float) -> bool:
        """Tell whether the last check still holds at a time [s]."""
        return bool(self.servers) and now - self._checked < TRUST

    def forget(self) -> None:
        """Have the next question looked at anew."""
        self.servers = frozenset()

    def present(self) -> frozenset[bytes]:
        """Return who is there now; when these are others than before, the next question is looked at anew."""
        present = gids_of(self._look())
        if present != self.servers:
            self.forget()
        return present

    def several(self) -> bool:
        """Tell whether more than one serve the name; a dead one counts until its lease is over."""
        return len(self._look()) > 1

    def fits(self, now: float) -> bool:
        """Tell whether there is one fitting server that our client is connected to.

        Raises:
            UnfitServerError: who is there doesn't fit.
        """
        if self.trusted(now):
            return self._connected()
        self.forget()
        servers = self._look()
        if not servers:
            return False
        self._check(servers)
        if not self._connected():
            return False
        present = gids_of(servers)
        if present != self._settled[0]:
            self._settled = (present, now)
        if now < self._settled[1] + SETTLE:
            return False
        self.servers, self._checked = present, now
        return True
