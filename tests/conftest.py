"""What all tests need: that Ctrl-C reaches the programs that they start, and DDS domains that nobody shares."""

import gc
import os
import signal
from collections.abc import Iterator
from itertools import count

import pytest
from hypothesis import HealthCheck, settings

# How long an example takes says how busy the machine is, not whether the property holds. The suite looks at the same
# examples each time, so that who changed nothing sees no new failure; `make fuzz` looks at others.
ALIKE = "GRIP_FUZZ_EXAMPLES" not in os.environ
settings.register_profile("grip", deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=ALIKE)
settings.load_profile("grip")
_shifts = count()
"""Each test has another domain than the one before it, whose servers may have been killed a moment ago."""


def pytest_configure() -> None:
    gc.disable()  # until all tests are collected: of what is made until then, nothing goes
    # A shell starts what it puts into the background with SIGINT ignored, `nohup` with SIGHUP ignored, and children
    # inherit that. Those of a process with a handler begin with the default again.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
        signal.signal(signal.SIGHUP, lambda *_: None)


def pytest_collection_finish() -> None:
    """Have each collection while tests run leave out the half a million objects that the tests themselves are."""
    gc.freeze()
    gc.enable()


def pytest_unconfigure() -> None:
    gc.unfreeze()  # libraries that count what is left when the process ends would find all of it


@pytest.fixture(autouse=True)
def own_signals() -> Iterator[None]:
    """Take back the handlers of commands that are run in this process: with theirs, nothing would end it any more."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        if handler is not None and signal.getsignal(number) is not handler:
            signal.signal(number, handler)


@pytest.fixture
def domain() -> Iterator[int]:
    """Give a DDS domain that no other test and no run on this machine has, also of other processes."""
    from grip_bt.ros.environment import free_domain

    with free_domain(next(_shifts)) as number:
        yield number


@pytest.fixture
def other_domain(domain: int) -> Iterator[int]:
    """Give a second one."""
    from grip_bt.ros.environment import free_domain

    with free_domain(next(_shifts)) as number:
        yield number
