"""Large texts are read and checked without the search for garbage that making many objects sets off."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

LARGE = 50_000
"""Characters of a text from which on the search would cost more than a glance."""


@contextmanager
def many_made(text: str) -> Iterator[None]:
    """Make the many objects of a text with the search for cyclic garbage put off until they are there.

    They live on and hold no cycles, yet the collector would walk over all of them again and again while their number
    grows: half of the time that a large file takes. Threads may use this at the same time; the search is on again when
    the first of them is done.
    """
    if len(text) < LARGE or not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
