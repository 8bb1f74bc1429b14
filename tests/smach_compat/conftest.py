"""Fixtures of the smach tests: quiet, recorded logs, fresh process-wide settings, and no test that can hang."""

import threading

import pytest

import grip_bt.smach_compat as smach
from grip_bt.smach_compat._settings import PROFILES, Settings, settings
from grip_bt.smach_compat.container import Container

LIMIT = 120.0  # [s] far beyond what any machine here takes


class Log(list):
    """Messages as (level, text)."""

    def at(self, level):
        return [text for recorded, text in self if recorded == level]


PROBED = ("userdata", "state", "construction", "execution", "concurrence", "iterator")


def pytest_generate_tests(metafunc):
    """Run the tests of the probes for both versions of upstream, but for those that say which they mean."""
    probes = metafunc.module.__name__.removeprefix("test_smach_") in PROBED
    says = "profile" in metafunc.fixturenames or metafunc.definition.get_closest_marker("noetic")
    if probes and not says:
        metafunc.parametrize("version", PROFILES, indirect=True)


@pytest.fixture(autouse=True)
def version(request, log):
    """Stand in for a version of upstream; noetic where a test doesn't say."""
    settings.profile = getattr(request, "param", "noetic")


@pytest.fixture(autouse=True)
def log(monkeypatch):
    """Collect what smach logs, and put back everything that is one per process."""
    messages = Log()
    for level in ("info", "warn", "debug", "err"):
        monkeypatch.setattr(smach, f"log{level}", lambda text, level=level: messages.append((level, str(text))))
    monkeypatch.setattr(smach, "is_shutdown", lambda: False)
    yield messages
    vars(settings).update(vars(Settings()))
    while Container._construction_stack:
        Container._pop()


@pytest.fixture
def in_time():
    """Return a function that runs another in a thread and fails the test when it doesn't end."""

    def run(work, limit=LIMIT):
        ended = []

        def keep():
            try:
                ended.append((True, work()))
            except BaseException as error:  # noqa: BLE001 - handed to the test
                ended.append((False, error))

        thread = threading.Thread(target=keep, daemon=True)
        thread.start()
        thread.join(limit)
        assert not thread.is_alive(), f"still running after {limit} s"
        succeeded, value = ended[0]
        if not succeeded:
            raise value
        return value

    return run
