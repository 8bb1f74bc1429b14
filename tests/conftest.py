"""What all tests need: that Ctrl-C reaches the programs that they start, and DDS domains that nobody shares."""

import signal
from collections.abc import Iterator
from itertools import count

import pytest

_shifts = count()
"""Each test has another domain than the one before it, whose servers may have been killed a moment ago."""


def pytest_configure() -> None:
    # A shell starts what it puts into the background with SIGINT ignored, and children inherit that. One with a
    # handler begins with the default again.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def domain() -> Iterator[int]:
    """Give a DDS domain that no other test and no run on this machine has, also of other processes."""
    from grip_bt.app.domain import free_domain

    with free_domain(next(_shifts)) as number:
        yield number


@pytest.fixture
def other_domain(domain: int) -> Iterator[int]:
    """Give a second one."""
    from grip_bt.app.domain import free_domain

    with free_domain(next(_shifts)) as number:
        yield number
